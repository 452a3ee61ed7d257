// Figures of Petrovic, Henne and Anderson: hair as a volume, and its light.
#include "figures/papers/paper_figures.h"
#include "figures/rendered.h"
#include "grooms/procedural.h"
#include "volume/density.h"
#include "volume/shell.h"
#include "volume/slices.h"

#include <fmt/format.h>

#include <algorithm>

namespace cuticle {

namespace {

// A groom of the figures: the parameters of Shape "groom".
struct VolumeGroom {
    std::string style;
    int strands;
    float widthScale;
};

HairShell ShellOf(const VolumeGroom &which, float cell) {
    GroomParams params = MakeGroomParams("head", which.style);
    params.strands = which.strands;
    params.widthScale = which.widthScale;
    const Groom groom = MakeGroom(params);
    const StrandSet strands = CurvesOf(groom);
    const DenseGrid<float> density = Smoothed(LineDensity(strands, BoxAround(BoundsOf(strands), cell, 5)), 2);
    return MakeShell(density, MedianDensity(density) / 2);
}

// A head of hair from the front and a little from the side, of so many pixels each way.
std::string HeadScene(const VolumeGroom &groom, int side, const std::string &integrator,
                      const std::string &material) {
    return fmt::format(
        "Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0}\n"
        "PixelFilter \"gaussian\"\n"
        "{1}\n"
        "Scale -1 1 1 LookAt 45 2 85  0 -4 0  0 1 0\n"
        "Camera \"perspective\" \"float fov\" 27\n"
        "WorldBegin\n"
        "LightSource \"infinite\" \"rgb L\" [0.35 0.37 0.4]\n"
        "LightSource \"distant\" \"point from\" [-1 0.9 0.8] \"rgb L\" [3 2.9 2.7]\n"
        "AttributeBegin Material \"matte\" \"rgb Kd\" [0.5 0.36 0.3] Shape \"groomhead\" AttributeEnd\n"
        "{2}\n"
        "Shape \"groom\" \"string style\" \"{3}\" \"integer strands\" {4} \"float width_scale\" {5}\n"
        "WorldEnd\n",
        side, integrator, material, groom.style, groom.strands, groom.widthScale);
}

// How long the gradient of a distance is within three cells of the surface.
struct GradientLengths {
    Table table{
        {"cells_from_surface", "vertices", "near_the_medial_set", "mean_deviation", "worst_deviation"}};
    double share95 = 0; // of the vertices away from the medial set, those with a length within 5%
    double mean = 0;
};

// A vertex is near the medial set where the slope changes from one cell to the next: second differences of
// the distance, in cells, of more than an eighth.
GradientLengths MeasureGradients(const DenseGrid<float> &distance) {
    const GridBox &box = distance.box;
    constexpr int kBins = 6; // of one cell, from -3 to 3
    std::array<size_t, kBins> count{}, near{};
    std::array<double, kBins> sum{}, worst{};
    size_t good = 0;
    for (size_t k = 1; k + 1 < box.size[2]; ++k)
        for (size_t j = 1; j + 1 < box.size[1]; ++j)
            for (size_t i = 1; i + 1 < box.size[0]; ++i) {
                const size_t at = box.Index(i, j, k);
                const float s = distance.values[at] / box.cell;
                if (!(std::abs(s) < kBins / 2))
                    continue;
                const auto bin = static_cast<size_t>(std::floor(s) + kBins / 2);
                float bend = 0;
                for (size_t axis = 0; axis < 3; ++axis) {
                    const size_t step = box.Stride(axis);
                    bend = std::max(bend, std::abs(distance.values[at + step] + distance.values[at - step] -
                                                   2 * distance.values[at]) /
                                              box.cell);
                }
                if (bend > 0.125f) {
                    ++near[bin];
                    continue;
                }
                const double off =
                    std::abs(static_cast<double>(GradientAt(distance, {i, j, k}).Length()) - 1);
                ++count[bin];
                sum[bin] += off;
                worst[bin] = std::max(worst[bin], off);
                good += off <= 0.05 ? 1 : 0;
            }
    GradientLengths found;
    double all = 0, total = 0;
    for (size_t b = 0; b < kBins; ++b) {
        const auto n = static_cast<double>(count[b]);
        found.table.Add({static_cast<double>(b) - kBins / 2 + 0.5, n, static_cast<double>(near[b]),
                         sum[b] / n, worst[b]});
        all += n, total += sum[b];
    }
    found.share95 = static_cast<double>(good) / all;
    found.mean = total / all;
    return found;
}

// The triangles of a shell as the statement of a shape.
std::string ShellShape(const SurfaceMesh &mesh) {
    std::string text = "Shape \"trianglemesh\" \"integer indices\" [";
    for (const uint32_t i : mesh.indices)
        fmt::format_to(std::back_inserter(text), "{} ", i);
    text += "] \"point P\" [";
    for (const Point3f &p : mesh.points)
        fmt::format_to(std::back_inserter(text), "{} {} {} ", p.x, p.y, p.z);
    text += "] \"normal N\" [";
    for (const Normal3f &n : mesh.normals)
        fmt::format_to(std::back_inserter(text), "{} {} {} ", n.x, n.y, n.z);
    return text + "]\n";
}

// Finds where the light on hair ends, in columns of a picture of 120: in each of twelve bands of rows between
// two shares of the height, the last place at which the mean luminance, smoothed over a fortieth of the
// width, is a tenth of the brightest; the median of the bands.
double TerminatorOf(const Image &image, double top, double bottom) {
    constexpr size_t kBands = 12;
    std::vector<double> ends;
    const auto width = static_cast<size_t>(image.width), smooth = width / 40;
    const auto row = [&](size_t band) {
        const double share = Lerp(static_cast<double>(band) / kBands, top, bottom);
        return static_cast<size_t>(share * static_cast<double>(image.height));
    };
    for (size_t band = 0; band < kBands; ++band) {
        std::vector<float> light(width);
        for (size_t y = row(band); y < row(band + 1); ++y)
            for (size_t x = 0; x < width; ++x)
                for (size_t k = x < smooth ? 0 : x - smooth / 2; k < std::min(width, x + smooth / 2 + 1); ++k)
                    light[x] += image.RGB(k, y).y();
        const auto peak = std::max_element(light.begin(), light.end());
        const float tenth = *peak / 10;
        size_t end = width - 1;
        while (end > 0 && light[end] < tenth)
            --end;
        if (*peak > 0 && end + 1 < width)
            ends.push_back((static_cast<double>(end) +
                            static_cast<double>((light[end] - tenth) / (light[end] - light[end + 1]))) *
                           120 / static_cast<double>(width));
    }
    if (ends.empty())
        return NAN;
    std::sort(ends.begin(), ends.end());
    return ends[ends.size() / 2];
}

} // namespace

FigureData Petrovic2(const FigureOptions &options) {
    const VolumeGroom groom{"wavy", options.quick ? 3000 : 20000, options.quick ? 12.f : 5.f};
    const HairShell shell = ShellOf(groom, options.quick ? 1.2f : 0.6f);
    const GridBox &box = shell.distance.box;
    const GradientLengths gradients = MeasureGradients(shell.distance);
    const int side = options.quick ? 60 : 480;
    const Image hair = RenderText(
        HeadScene(groom, side, "Integrator \"path\" \"integer maxdepth\" 12",
                  "Material \"hair\" \"float eumelanin\" 0.5 \"float beta_m\" 0.35 \"float beta_n\" 0.5"),
        options.quick ? 1 : 24);
    FigureData data{gradients.table};
    data.plot.columns = 3;
    data.plot.width = 360, data.plot.height = 420;
    const Point3f middle =
        (box.origin + box.Position(box.size[0] - 1, box.size[1] - 1, box.size[2] - 1)) * 0.5f;
    const size_t scale = options.quick ? 1 : 5;
    data.plot.panels.push_back(PicturePanel("a: the hair model", hair));
    for (const size_t axis : {2, 0}) {
        const SlicePicture cut = CutDistance(shell.distance, middle, axis, scale, 2);
        data.plot.panels.push_back(PicturePanel(
            axis == 2 ? "b: S in the plane of the ears" : "c: S in the plane of symmetry", cut.width,
            cut.height, [&](size_t x, size_t y) { return cut.colors[y * cut.width + x]; }));
    }
    data.note = fmt::format("Blue is inside, lines stand 2 cm apart. Within three cells of the shell the "
                            "gradient's length is off by {:.4f} "
                            "in the mean away from the medial set. The paper has its jumps far inside only; "
                            "they reach the shell at "
                            "every dent.",
                            gradients.mean);
    data.checks = {
        {"away from the medial set, share of gradients of length 1 within 5%", gradients.share95, 0.98, 1},
        {"their mean deviation from length 1", gradients.mean, 0, 0.02}};
    return data;
}

// The same hair three times, light from the left: its shell, itself with the shell's normals, and by its own
// tangents alone. Shadows are traced, crossing by crossing.
FigureData Petrovic3(const FigureOptions &options) {
    const VolumeGroom groom{"straight", options.quick ? 4000 : 20000, options.quick ? 10.f : 4.5f};
    const HairShell shell = ShellOf(groom, 0.6f);
    const int side = options.quick ? 120 : 360, spp = options.quick ? 6 : 16;
    const auto render = [&](const std::string &light, const std::string &material, const std::string &shape) {
        return RenderText(
            fmt::format("Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0}\n"
                        "PixelFilter \"gaussian\" Integrator \"hairlight\" {1}\n"
                        "Scale -1 1 1 LookAt 0 2 -92  0 -4 0  0 1 0\n"
                        "Camera \"perspective\" \"float fov\" 27\n"
                        "WorldBegin\n"
                        "LightSource \"distant\" \"point from\" [1 0.35 -0.25] \"rgb L\" [3 3 3]\n"
                        "AttributeBegin Material \"matte\" \"rgb Kd\" [0.5 0.36 0.3] Shape \"groomhead\" "
                        "AttributeEnd\n{2}\n{3}WorldEnd\n",
                        side, light, material, shape),
            spp);
    };
    const std::string hair = fmt::format(
        "Shape \"groom\" \"string style\" \"{}\" \"integer strands\" {} \"float width_scale\" {}\n",
        groom.style, groom.strands, groom.widthScale);
    const std::string kajiyaKay =
        "Material \"hair\" \"string model\" \"kajiya-kay\" \"rgb Kd\" [0.6 0.45 0.3] "
        "\"rgb Ks\" [0.1 0.1 0.1] \"float exponent\" 30";
    const std::string traced = "\"string shadow\" \"traced\" \"float opacity\" 0.03";
    const std::array<Image, 3> pictures = {
        render("", "Material \"matte\" \"rgb Kd\" [0.6 0.45 0.3]", ShellShape(shell.mesh)),
        render(traced + " \"bool shellnormals\" true \"float shellcell\" 0.6", kajiyaKay, hair),
        render(traced, kajiyaKay, hair)};
    constexpr std::array titles = {"a: the shell", "b: hair, by the shell's normals",
                                   "c: hair, Kajiya and Kay"};
    FigureData data{Table({"picture", "terminator_column_of_120"})};
    data.plot.columns = 3;
    data.plot.width = 360, data.plot.height = 400;
    std::array<double, 3> ends{};
    for (size_t i = 0; i < 3; ++i) {
        ends[i] = TerminatorOf(pictures[i], 0.22, 0.42);
        data.table.Add({titles[i], ends[i]});
        data.plot.panels.push_back(PicturePanel(titles[i], pictures[i]));
    }
    data.note = fmt::format("In columns of a picture of 120, the light ends at {:.1f} on the shell, at "
                            "{:.1f} on hair by the shell's "
                            "normals, at {:.1f} on hair by its tangents. The second is not the first to a "
                            "pixel: light that grazes "
                            "the shell passes hair before it meets any.",
                            ends[0], ends[1], ends[2]);
    // The paper sees no difference between a and b, and a light that has receded in c. No bound in pixels
    // follows from that; that b is far nearer to a than c is does.
    const double b = std::abs(ends[1] - ends[0]), c = std::abs(ends[2] - ends[0]);
    data.checks = {{"terminator of c from a's, in columns of 120", c, 4, 120},
                   {"terminator of b from a's, of c's from a's", b / c, 0, 0.5}};
    return data;
}

} // namespace cuticle
