// The chart of relative errors of renderings against the CPU time that they take, by integrator, sampler,
// model of a fiber and samples; and that of their product against how many curves there are.
#include "core/clock.h"
#include "fibers/tabulated.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"
#include "figures/charts/peer.h"
#include "images/compare.h"
#include "materials/hair_models.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

namespace cuticle {

namespace {

// One way to render; an empty text stands for what the scene says.
struct Way {
    std::string name, integrator, sampler, model;
    int color;
    PlotDash dash;
    bool denoise = false;
    int maxDepth = 0; // 0: the scene's
};

// A scene that is read and built for one way to render it. Quick pictures are a quarter of the resolution
// each way.
class ReadyScene {
  public:
    ReadyScene(const std::string &file, const Way &way, bool quarter)
        : ReadyScene([&] { return ParseScene(AllPlugins(), file); }, way, quarter) {}
    ReadyScene(const std::function<SceneDescription()> &read, const Way &way, bool quarter)
        : start_(ProcessCpuSeconds()), description_(read()),
          scene_(&description_, {.materials = {.hairModel = way.model}}) {
        if (!way.sampler.empty())
            description_.sampler.type = way.sampler;
        if (!way.integrator.empty())
            options_.integrator = way.integrator;
        options_.quick = quarter;
        options_.film.denoise = way.denoise;
        cpuSeconds_ = ProcessCpuSeconds() - start_;
    }
    // CPU seconds that reading and building took.
    double CpuSeconds() const { return cpuSeconds_; }
    size_t Curves() const { return scene_.Curves(); }
    // cpuSeconds are those of the rendering alone.
    Rendering Picture(int spp, uint64_t seed, bool variance = false) const {
        const double start = ProcessCpuSeconds();
        RenderOptions options = options_;
        options.variance = variance;
        options.seed = seed;
        options.spp = options.quick ? 4 * spp : spp; // quick takes a quarter of the samples
        RenderStats stats;
        WarningLog warnings; // printed once a picture
        const WarningScope scope(&warnings);
        Image image = Render(description_, scene_, options, &stats);
        return {std::move(image), ProcessCpuSeconds() - start};
    }

  private:
    double start_;
    SceneDescription description_;
    Scene scene_;
    RenderOptions options_;
    double cpuSeconds_ = 0;
};

// Makes a logarithmic axis reach a little beyond these numbers.
void Stretch(PlotAxis *axis, const std::vector<double> &values) {
    for (const double v : values)
        if (v > 0 && std::isfinite(v)) {
            axis->min = std::min(axis->min.value_or(v / 1.2), v / 1.2);
            axis->max = std::max(axis->max.value_or(v * 1.2), v * 1.2);
        }
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The pictures that a run of the chart renders. To add a way: push it in PlanOf, behind the four that the
// laws name.
struct RenderPlan {
    bool quarter; // pictures of a quarter of the resolution each way
    std::vector<Way> ways;
    std::vector<std::string> scenes;
    std::vector<int> samples; // per pixel, of one way
    int rounds;
    int ReferenceSamples() const { return 16 * samples.back(); }
};

// Other renderers make whole pictures; among ourselves small ones show the same, sooner. Our models stay
// among themselves: each has a reference of its own.
RenderPlan PlanOf(const FigureOptions &options) {
    RenderPlan plan;
    plan.quarter = options.peers.empty();
    plan.ways = {
        {"path", "path", "", "", 0, PlotDash::Solid},
        {"path, random sampler", "path", "random", "", 5, PlotDash::Dashed},
        {"directlighting", "directlighting", "", "", 1, PlotDash::Solid},
        {"path, denoised", "path", "", "", 2, PlotDash::Solid, true},
    };
    constexpr std::array modelColors = {3, 4, 6, 7, 2};
    size_t models = 0;
    for (const std::string_view model : HairModelNames())
        if (model != "chiang" && plan.quarter && !options.quick)
            plan.ways.push_back({"path, " + std::string(model), "path", "", std::string(model),
                                 modelColors[models++ % modelColors.size()], PlotDash::DashDot});
    plan.scenes = {"head-wavy", "fur-ball"};
    plan.samples = {2, 4, 8, 16}; // denoising needs two
    plan.rounds = 2;
    if (options.quick)
        plan.scenes = {"curve-types"}, plan.samples = {2, 4, 8}, plan.rounds = 1;
    return plan;
}

// Error and CPU time of every way to render one scene, and number of samples.
struct RenderMeasurement {
    std::vector<double> setUp;                         // seconds before rendering, of a way
    std::vector<std::vector<double>> rendering, error; // of a way and a number of samples
    Image reference;                                   // of the first way
};
RenderMeasurement MeasureWays(const std::string &file, const RenderPlan &plan) {
    const size_t ways = plan.ways.size(), n = plan.samples.size();
    RenderMeasurement m;
    m.setUp.assign(ways, kInfinity);
    m.rendering.assign(ways, std::vector<double>(n, kInfinity));
    m.error = m.rendering;
    // Each model's own picture is its reference; integrators and samplers are held against path's.
    std::vector<Image> references;
    for (int round = 0; round < plan.rounds; ++round)
        for (size_t w = 0; w < ways; ++w) {
            FiberTable::Cached({}, 1); // a table held for the next scene is let go: each pays for its own
            const ReadyScene ready(file, plan.ways[w], plan.quarter);
            m.setUp[w] = std::min(m.setUp[w], ready.CpuSeconds());
            if (round == 0) {
                const bool own = references.empty() || !plan.ways[w].model.empty();
                references.push_back(own ? ready.Picture(plan.ReferenceSamples(), 1).image : references[0]);
            }
            for (size_t k = 0; k < n; ++k) {
                const Rendering r = ready.Picture(plan.samples[k], 0);
                m.rendering[w][k] = std::min(m.rendering[w][k], r.cpuSeconds);
                m.error[w][k] = Compare(r.image, references[w]).relativeMSE;
            }
        }
    m.reference = std::move(references[0]);
    return m;
}

// Fills the table and draws a line for each way, and a point for each peer's picture; the front is that of
// the ways with the scene's own model.
void AddScene(const std::string &scene, const RenderPlan &plan, const RenderMeasurement &m,
              const std::vector<Peer> &peers, std::span<const Rendering> peerPictures, FigureData *data) {
    PlotPanel panel;
    panel.title = scene;
    panel.right = 0.6;
    panel.x = {.label = "CPU time of all threads (s)", .log = true};
    panel.y = {.label = "relative MSE", .log = true};
    std::vector<CostPoint> points;
    for (size_t w = 0; w < plan.ways.size(); ++w) {
        const Way &way = plan.ways[w];
        PlotSeries line;
        line.label = way.name;
        line.style = PlotStyle::LinePoints;
        line.color = way.color, line.marker = way.color % 7, line.dash = way.dash;
        for (size_t k = 0; k < plan.samples.size(); ++k) {
            const double s = m.setUp[w] + m.rendering[w][k], e = m.error[w][k];
            data->table.Add({scene, way.name, double(plan.samples[k]), e, s, m.setUp[w]});
            line.x.push_back(s), line.y.push_back(e);
            if (way.model.empty())
                points.push_back({way.name, s, e, way.color});
        }
        panel.series.push_back(line);
    }
    for (size_t i = 0; i < peers.size(); ++i) {
        const double s = peerPictures[i].cpuSeconds;
        const Comparison comparison = Compare(peerPictures[i].image, m.reference);
        if (comparison.badPixels > 0)
            data->note += fmt::format("{} has {} of {}'s pixels that are no numbers, which are left out. ",
                                      PlainText(peers[i].name), comparison.badPixels, scene);
        data->table.Add({scene, peers[i].name, NAN, comparison.relativeMSE, s, NAN});
        PlotSeries point;
        point.label = PlainText(peers[i].name);
        point.style = PlotStyle::Points;
        point.x = {s}, point.y = {comparison.relativeMSE};
        points.push_back({peers[i].name, s, comparison.relativeMSE, 0});
        panel.series.push_back(point);
    }
    panel.series.push_back(ParetoSteps(points, 0, kInfinity));
    for (const PlotSeries &series : panel.series) {
        Stretch(&panel.x, series.x);
        Stretch(&panel.y, series.y);
    }
    data->plot.panels.push_back(panel);
}

// The laws of one scene; the ways are those of PlanOf.
void AddLaws(const std::string &scene, const RenderPlan &plan, const RenderMeasurement &m,
             std::vector<FigureCheck> *checks) {
    enum { Path, RandomSampler, DirectLighting, Denoised };
    const auto last = [&m](size_t way) { return m.error[way].back(); };
    // The error of independent samples falls as 1 / spp: the slope of the logarithms, by the ends.
    const double decades = std::log(double(plan.samples.back()) / plan.samples.front());
    checks->push_back({scene + ": with random samples the exponent of the error in spp is",
                       std::log(last(RandomSampler) / m.error[RandomSampler][0]) / decades, -1.3, -0.7});
    checks->push_back({scene + ": the scene's sampler has, of the random one's error,",
                       last(Path) / last(RandomSampler), 0, 1.1});
    checks->push_back({scene + ": denoised, few samples have of the error of path's",
                       m.error[Denoised][0] / m.error[Path][0], 0, 1});
    checks->push_back({scene + ": direct light alone differs at most samples by more than path does, times",
                       last(DirectLighting) / last(Path), 1, kInfinity});
}

} // namespace

FigureData RenderChart(const FigureOptions &options) {
    const RenderPlan plan = PlanOf(options);
    FigureData data{
        Table({"scene", "way", "spp", "relative_MSE", "CPU_seconds", "CPU_seconds_before_rendering"})};
    data.plot.width = 900, data.plot.height = 420;
    const auto fileOf = [&](const std::string &scene) { return options.scenes + "/" + scene + ".pbrt"; };
    // Peers first, since they may fail. Each runs once.
    std::vector<Rendering> peerPictures;
    for (const std::string &scene : plan.scenes)
        for (const Peer &peer : options.peers)
            peerPictures.push_back(RenderPeer(peer, fileOf(scene)));
    for (size_t i = 0; i < plan.scenes.size(); ++i) {
        const RenderMeasurement m = MeasureWays(fileOf(plan.scenes[i]), plan);
        const size_t peers = options.peers.size();
        AddScene(plan.scenes[i], plan, m, options.peers, std::span(peerPictures).subspan(i * peers, peers),
                 &data);
        AddLaws(plan.scenes[i], plan, m, &data.checks);
    }
    data.note += fmt::format(
        "References: path at {} samples, another seed; each model against its own. The front is "
        "that of the scene's own model. Smallest times of {}.{}",
        plan.ReferenceSamples(), plan.rounds == 1 ? "1 run" : fmt::format("{} runs in turn", plan.rounds),
        plan.quarter ? " Pictures of a quarter of the scene's resolution each way." : "");
    return data;
}

// --- efficiency ------------------------------------------------------------------------------------------

namespace {

// A ball of hair under a lamp and a dim sky, its hairs the thinner the more there are.
SceneDescription ReadBall(int segments, int pixels) {
    constexpr int kSegmentsOfAStrand = 8;
    const int strands = segments / kSegmentsOfAStrand;
    return ParseSceneText(
        AllPlugins(),
        fmt::format(
            "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 30 "
            "Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0} Sampler \"sobol\" "
            "PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 30 WorldBegin "
            "LightSource \"infinite\" \"rgb L\" [.15 .17 .2] AttributeBegin "
            "AreaLightSource \"diffuse\" \"rgb L\" [40 38 35] Translate 3 4 -3 "
            "Shape \"sphere\" \"float radius\" .5 AttributeEnd Material \"hair\" \"float eumelanin\" .3 "
            "Shape \"groom\" \"string kind\" \"ball\" \"integer strands\" {1} \"integer segments\" {2} "
            "\"float width\" {3} WorldEnd",
            pixels, strands, kSegmentsOfAStrand, 0.004 * std::sqrt(50000. / strands)),
        "ball.pbrt");
}

// Relative mean square errors by pixel and by blocks of 8 x 8, without what the reference's own noise adds.
constexpr double kEpsilon = 0.01; // keeps black pixels from deciding
struct PictureErrors {
    double pixels = 0, blocks = 0;
};
PictureErrors ErrorsOf(const Image &image, const Image &reference) {
    constexpr size_t kBlock = 8;
    const auto width = static_cast<size_t>(image.width), height = static_cast<size_t>(image.height);
    PictureErrors errors;
    double pixels = 0, blocks = 0;
    for (size_t v = 0; v + kBlock <= height; v += kBlock)
        for (size_t u = 0; u + kBlock <= width; u += kBlock)
            for (size_t c = 0; c < 3; ++c) {
                double off = 0, bright = 0, noise = 0;
                for (size_t y = v; y < v + kBlock; ++y)
                    for (size_t x = u; x < u + kBlock; ++x) {
                        const double t{reference.At(x, y, c)}, d = double{image.At(x, y, c)} - t;
                        const double n{reference.At(x, y, c + 3)};
                        errors.pixels += (d * d - n) / (t * t + kEpsilon);
                        off += d, bright += t, noise += n;
                        ++pixels;
                    }
                constexpr double kPixels = kBlock * kBlock;
                errors.blocks += (off * off - noise) / (bright * bright + kPixels * kPixels * kEpsilon);
                ++blocks;
            }
    return {std::max(errors.pixels / pixels, 1e-9), std::max(errors.blocks / blocks, 1e-9)};
}

// A scene of the chart of efficiency. file: empty for a ball.
struct EfficiencyScene {
    std::string name, file;
    int segments = 0;
};

const Way kEfficiencyWays[] = {
    {"path", "path", "", "", 0, PlotDash::Solid},
    {"path, denoised", "path", "", "", 2, PlotDash::Solid, true},
    {"path of depth 3", "path", "", "", 5, PlotDash::Dashed, false, 3},
};

} // namespace

FigureData EfficiencyChart(const FigureOptions &options) {
    const int pixels = options.quick ? 64 : 96, spp = 16, referenceSpp = 16 * spp;
    std::vector<EfficiencyScene> scenes;
    for (int segments = options.quick ? 10000 : 1000; segments <= (options.quick ? 10000 : 1000000);
         segments *= 10)
        scenes.push_back({fmt::format("ball of {}", segments), "", segments});
    if (!options.quick)
        for (const char *name : {"quickstart", "head-wavy", "fur-ball"})
            scenes.push_back({name, options.scenes + "/" + name + ".pbrt"});
    FigureData data{
        Table({"scene", "segments", "way", "relative_MSE", "relative_MSE_of_blocks", "CPU_seconds"})};
    std::array<PlotPanel, 2> panels;
    panels[0].title = "pixels", panels[1].title = "means of 8 x 8 pixels";
    for (PlotPanel &panel : panels) {
        panel.legend = "top left"; // the shipped scenes stand at the right
        panel.x = {.label = "curve segments", .log = true};
        panel.y = {.label = "relative MSE x CPU time (s)", .log = true};
    }
    std::vector<PlotSeries> lines(2 * std::size(kEfficiencyWays)), points = lines;
    for (const EfficiencyScene &scene : scenes) {
        Image reference;
        std::array<PictureErrors, std::size(kEfficiencyWays)> errors;
        for (size_t w = 0; w < std::size(kEfficiencyWays); ++w) {
            const Way &way = kEfficiencyWays[w];
            const ReadyScene ready(
                [&] {
                    SceneDescription d = scene.file.empty() ? ReadBall(scene.segments, pixels)
                                                            : ParseScene(AllPlugins(), scene.file);
                    if (way.maxDepth > 0)
                        for (Param &p : d.integrator.params.params)
                            if (p.name == "maxdepth")
                                p.numbers = {double(way.maxDepth)};
                    return d;
                },
                way, !scene.file.empty());
            if (w == 0)
                reference = ready.Picture(referenceSpp, 1, true).image;
            const Rendering rendering = ready.Picture(spp, 0);
            errors[w] = ErrorsOf(rendering.image, reference);
            data.table.Add({scene.name, double(ready.Curves()), way.name, errors[w].pixels, errors[w].blocks,
                            rendering.cpuSeconds});
            for (size_t panel = 0; panel < 2; ++panel) {
                PlotSeries &series = (scene.file.empty() ? lines : points)[2 * w + panel];
                series.x.push_back(double(ready.Curves()));
                series.y.push_back((panel ? errors[w].blocks : errors[w].pixels) * rendering.cpuSeconds);
            }
        }
        data.checks.push_back({scene.name + ": denoised, a pixel's error is of path's",
                               errors[1].pixels / errors[0].pixels, 0, 0.5});
        data.checks.push_back({scene.name + ": denoised, a block's error is of path's",
                               errors[1].blocks / errors[0].blocks, 0, options.quick ? 1.5 : 1.25});
    }
    for (size_t w = 0; w < std::size(kEfficiencyWays); ++w)
        for (size_t panel = 0; panel < 2; ++panel)
            for (PlotSeries *series : {&lines[2 * w + panel], &points[2 * w + panel]}) {
                if (series->x.empty())
                    continue;
                const bool isBall = series == &lines[2 * w + panel];
                series->style = isBall ? PlotStyle::LinePoints : PlotStyle::Points;
                series->label = isBall ? kEfficiencyWays[w].name : "";
                series->color = kEfficiencyWays[w].color, series->marker = kEfficiencyWays[w].color % 7;
                series->dash = kEfficiencyWays[w].dash;
                Stretch(&panels[panel].x, series->x);
                Stretch(&panels[panel].y, series->y);
                panels[panel].series.push_back(*series);
            }
    data.plot.width = 900, data.plot.height = 420;
    data.plot.panels.assign(panels.begin(), panels.end());
    data.note = fmt::format(
        "{} samples per pixel; references: path at {}, another seed, their noise taken off. Time of "
        "the rendering alone, all threads.{}",
        spp, referenceSpp,
        options.quick
            ? ""
            : " Single points: quickstart, head-wavy and fur-ball, a quarter of their size each way.");
    return data;
}

} // namespace cuticle
