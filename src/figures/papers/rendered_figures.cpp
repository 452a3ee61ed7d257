// The papers' renderings are measured here: the claims of each caption, as numbers of our own pictures.
#include "core/color.h"
#include "figures/papers/paper_figures.h"
#include "figures/rendered.h"

#include <fmt/format.h>

namespace cuticle {

namespace {

std::array<double, 3> Lab(const Spectrum &c) { return XYZToLab(RGBToXYZ(c)); }

} // namespace

// The spheres and the cubes' fronts, in shares of the picture; a sphere's disc is measured within the square
// that it holds.
FigureData MeasurePharr1_20(const FigureOptions &, std::span<const FigurePicture> pictures) {
    const Image &image = pictures[0].image;
    FigureData data{Table({"beta_n", "sphere_r", "sphere_g", "sphere_b", "cube_r", "cube_g", "cube_b",
                           "ciede2000", "luminance_ratio"})};
    data.plot.width = 520, data.plot.height = 560;
    data.plot.panels = {PicturePanel("", image)};
    const std::array<const char *, 2> rows = {"above, β_n = 0.3", "below, β_n = 0.8"};
    for (size_t i = 0; i < 2; ++i) {
        const double y0 = i == 0 ? 0.17 : 0.62;
        const Spectrum sphere = MeanColor(image, {0.18, 0.38, y0, y0 + 0.2}),
                       cube = MeanColor(image, {0.62, 0.82, y0, y0 + 0.2});
        const double difference = CIEDE2000(Lab(sphere), Lab(cube)), ratio = double(cube.y() / sphere.y());
        data.table.Add({i == 0 ? 0.3 : 0.8, double(sphere[0]), double(sphere[1]), double(sphere[2]),
                        double(cube[0]), double(cube[1]), double(cube[2]), difference, ratio});
        data.checks.push_back(
            {fmt::format("CIEDE2000 of cube and sphere, {}", rows[i]), difference, 0, i == 0 ? 6. : 4.});
        data.checks.push_back({fmt::format("luminance of cube over sphere, {}", rows[i]), ratio, 0.9, 1.15});
    }
    data.note = fmt::format(
        "The cubes' fronts differ from the spheres by {:.1f} and {:.1f} (CIEDE2000, of which 1 is "
        "just noticed); the paper sees good agreement. Its caption's σ_a of the upper cube "
        "belongs to a β_n of 0.8; for its 0.3 the fit gives (0.0014, 0.0242, 0.2588), used here.",
        data.table.Number(0, "ciede2000"), data.table.Number(1, "ciede2000"));
    return data;
}

} // namespace cuticle
