// The chart of means to light that hair scatters on: errors of pictures against paths, and CPU time, by the
// colour of the hair.
#include "core/clock.h"
#include "figures/charts/charts.h"
#include "figures/charts/peer.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

struct HairColorOfChart {
    std::string name;
    double eumelanin;
};
const HairColorOfChart kHairColors[] = {
    {"black", 8}, {"brown", 1.3}, {"dark blond", 0.3}, {"light blond", 0.05}};

// One way to light hair. To add one: a row here. The first is the reference's.
struct LightingWay {
    std::string name, integrator;
    int color;
    std::vector<int> samples; // per pixel
};
const LightingWay kLightingWays[] = {
    {"path", "\"path\" \"integer maxdepth\" 200", 0, {1, 4, 16}},
    {"direct light", "\"directlighting\"", 1, {16}},
    {"deep shadows", "\"hairlight\" \"string shadow\" \"traced\"", 5, {16}},
    {"dual scattering, traced", "\"dualscattering\"", 2, {16}},
    {"dual scattering, grid", "\"dualscattering\" \"string count\" \"grid\"", 3, {16}},
    {"dual scattering as printed",
     "\"dualscattering\" \"string return\" \"printed\" \"float forwarddensity\" 0.7 \"float "
     "backwarddensity\" "
     "0.7",
     4,
     {16}},
    {"deep shadow maps", "\"hairlight\" \"string shadow\" \"deepmap\"", 6, {16}},
};

// A ball of hair in parallel light from the viewer's left and above.
std::string BallText(const std::string &integrator, double eumelanin, int strands, int pixels) {
    return fmt::format(
        "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 32 "
        "Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0} Sampler \"sobol\" "
        "PixelFilter \"box\" Integrator {1} WorldBegin LightSource \"distant\" "
        "\"point from\" [-1 1 -1] \"point to\" [0 0 0] \"rgb L\" [3 3 3] "
        "Material \"hair\" \"float eumelanin\" {2} Shape \"groom\" \"string kind\" \"ball\" "
        "\"integer strands\" {3} \"integer segments\" 8 \"float width\" {4} WorldEnd",
        pixels, integrator, eumelanin, strands, 0.004 * std::sqrt(20000. / strands));
}

Rendering RenderText(const std::string &text, int spp, uint64_t seed) {
    SceneDescription description = ParseSceneText(AllPlugins(), text, "ball.pbrt");
    const Scene scene(&description, {});
    RenderOptions options;
    options.spp = spp, options.seed = seed;
    RenderStats stats;
    const double start = ProcessCpuSeconds();
    Image image = Render(description, scene, options, &stats);
    return {std::move(image), ProcessCpuSeconds() - start};
}

// Root mean square of differences of means over 8 x 8 pixels, and the mean of the picture, both relative to
// the mean of the reference; all channels.
struct LightingError {
    double blocks, mean;
};
LightingError LightingErrorOf(const Image &image, const Image &reference) {
    constexpr size_t kBlock = 8;
    const auto width = static_cast<size_t>(image.width), height = static_cast<size_t>(image.height);
    double squares = 0, sum = 0, bright = 0, n = 0;
    for (size_t v = 0; v < height; v += kBlock)
        for (size_t u = 0; u < width; u += kBlock)
            for (size_t c = 0; c < 3; ++c) {
                double a = 0, b = 0;
                for (size_t y = v; y < v + kBlock; ++y)
                    for (size_t x = u; x < u + kBlock; ++x)
                        a += double{image.RGB(x, y)[c]}, b += double{reference.RGB(x, y)[c]};
                squares += Sqr(a - b), sum += a, bright += b, ++n;
            }
    return {std::sqrt(squares / n) / (bright / n), sum / bright};
}

} // namespace

FigureData ScatteringChart(const FigureOptions &options) {
    const int pixels = options.quick ? 48 : 96, strands = options.quick ? 4000 : 20000;
    const int referenceSpp = options.quick ? 64 : 512;
    FigureData data{
        Table({"hair", "eumelanin", "way", "spp", "error_of_blocks", "mean_share", "CPU_seconds"})};
    for (const HairColorOfChart &hair : kHairColors) {
        PlotPanel panel;
        panel.title = hair.name;
        panel.x = {.label = "CPU time of the rendering (s)", .log = true};
        panel.y = {.label = "error of 8 x 8 pixels", .log = true};
        const auto render = [&](const LightingWay &way, int spp, uint64_t seed) {
            return RenderText(BallText(way.integrator, hair.eumelanin, strands, pixels), spp, seed);
        };
        const Image reference = render(kLightingWays[0], referenceSpp, 1).image;
        std::vector<double> least;
        for (const LightingWay &way : kLightingWays) {
            PlotSeries line;
            line.label = way.name, line.style = PlotStyle::LinePoints;
            line.color = line.marker = way.color;
            LightingError error{};
            for (const int spp : way.samples) {
                const Rendering r = render(way, spp, 0);
                error = LightingErrorOf(r.image, reference);
                data.table.Add({hair.name, hair.eumelanin, way.name, double(spp), error.blocks, error.mean,
                                r.cpuSeconds});
                line.x.push_back(r.cpuSeconds), line.y.push_back(error.blocks);
            }
            least.push_back(error.blocks);
            if (way.name == "dual scattering, traced")
                data.checks.push_back(
                    {hair.name + ": dual scattering has, of the light of paths,", error.mean, 0.5, 1.1});
            panel.series.push_back(line);
        }
        enum { Path, Direct, DeepShadows, Traced };
        if (hair.eumelanin < 5) // black hair scatters too little on
            data.checks.push_back(
                {hair.name + ": its error is, of direct light's,", least[Traced] / least[Direct], 0, 0.95});
        data.plot.panels.push_back(panel);
    }
    data.plot.width = 900, data.plot.height = 760;
    data.note = fmt::format(
        "{} strands, {} x {} pixels, 16 samples a pixel (path: 1, 4 and 16); the reference: path at {}. "
        "Times are those of all threads, without reading and building the scene.",
        strands, pixels, pixels, referenceSpp);
    return data;
}

} // namespace cuticle
