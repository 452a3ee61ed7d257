#include "figures/rendered.h"

#include "core/clock.h"
#include "core/error.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

Image RenderParsed(SceneDescription description, RenderOptions options, int *samples) {
    const Scene scene(&description, {});
    RenderStats stats;
    Image image = Render(description, scene, options, &stats);
    if (stats.nanSamples > 0)
        throw Error("{} samples of a figure were not finite", stats.nanSamples);
    *samples = stats.sppReached;
    return image;
}

} // namespace

FigurePicture RenderScene(const std::string &name, const FigureOptions &options) {
    FigurePicture picture;
    picture.name = name;
    const double start = ProcessCpuSeconds();
    RenderOptions render;
    render.quick = options.quick;
    render.progress = options.progress;
    picture.image = RenderParsed(ParseScene(AllPlugins(), options.scenes + "/" + name + ".pbrt"), render,
                                 &picture.samples);
    picture.cpuSeconds = ProcessCpuSeconds() - start;
    return picture;
}

FigurePicture ReadPicture(const std::string &name, const std::string &folder) {
    FigurePicture picture;
    picture.name = name;
    picture.image = ReadImage(folder + "/" + name + ".exr");
    if (const auto spp = picture.image.attributes.find("spp"); spp != picture.image.attributes.end())
        picture.samples = static_cast<int>(spp->second.number);
    return picture;
}

Image RenderText(const std::string &scene, int spp) {
    RenderOptions options;
    options.spp = spp;
    int samples = 0;
    return RenderParsed(ParseSceneText(AllPlugins(), scene, "figure"), options, &samples);
}

PlotPanel PicturePanel(const std::string &title, size_t width, size_t height,
                       const std::function<Spectrum(size_t x, size_t y)> &color) {
    PlotPanel panel;
    panel.kind = PlotKind::HeatMap;
    panel.title = title;
    PlotHeatMap &map = panel.heatMap;
    map.columns = width, map.rows = height;
    map.xMax = static_cast<double>(width), map.yMax = static_cast<double>(height);
    for (size_t y = height; y-- > 0;)
        for (size_t x = 0; x < width; ++x)
            map.colors.push_back(color(x, y));
    map.isPicture = true;
    return panel;
}
PlotPanel PicturePanel(const std::string &title, const Image &image) {
    return PicturePanel(title, static_cast<size_t>(image.width), static_cast<size_t>(image.height),
                        [&](size_t x, size_t y) { return image.RGB(x, y).Clamp(0, 1); });
}

Spectrum MeanColor(const Image &image, const PictureWindow &window) {
    const auto first = [](double share, int size) {
        return static_cast<size_t>(std::clamp(std::floor(share * size), 0., size - 1.));
    };
    const auto last = [](double share, int size, size_t from) {
        return std::max(from + 1, static_cast<size_t>(std::clamp(std::ceil(share * size), 1., double(size))));
    };
    const size_t x0 = first(window.x0, image.width), x1 = last(window.x1, image.width, x0),
                 y0 = first(window.y0, image.height), y1 = last(window.y1, image.height, y0);
    std::array<double, 3> sum{};
    for (size_t y = y0; y < y1; ++y)
        for (size_t x = x0; x < x1; ++x)
            for (size_t c = 0; c < 3; ++c)
                sum[c] += static_cast<double>(image.RGB(x, y)[c]);
    const auto pixels = static_cast<double>((x1 - x0) * (y1 - y0));
    return Spectrum(static_cast<float>(sum[0] / pixels), static_cast<float>(sum[1] / pixels),
                    static_cast<float>(sum[2] / pixels));
}

} // namespace cuticle
