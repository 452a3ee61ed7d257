// The chart of ways to intersect rays with hair: the paper's recursion, the curve set, Embree's curves.
#include "core/clock.h"
#include "core/isa.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"
#include "figures/charts/curve_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

namespace cuticle {

namespace {

// Colours of the methods.
enum IntersectorFamily { Set = 0, Recursion = 1, EmbreeFlat = 4, EmbreeRound = 3 };

// A way to find the nearest hit of a ray.
struct Intersector {
    std::string name;
    IntersectorFamily family;
    std::function<bool(const CurveTask &, CurveHit *)> intersect;
};

template <class Tree>
Intersector OurTree(const std::string &name, IntersectorFamily family,
                    const std::shared_ptr<const Tree> &tree) {
    return {name, family, [tree](const CurveTask &task, CurveHit *hit) {
                return tree->Intersect(task.ray, task.bounce ? &task.origin : nullptr, hit);
            }};
}
Intersector EmbreeTree(const std::string &name, IntersectorFamily family,
                       const std::shared_ptr<const EmbreeCurves> &tree) {
    return {name, family,
            [tree](const CurveTask &task, CurveHit *hit) { return tree->Intersect(task, hit); }};
}

// All intersectors of these curves; to add one: push it here. `widest` becomes the curve set with the widest
// registers of this machine.
std::vector<Intersector> IntersectorsOf(const std::vector<CurveSegment> &segments,
                                        std::shared_ptr<const CurveSet> *widest) {
    const std::vector<CurveType> types = {CurveType::Flat};
    const std::unordered_map<uint32_t, RibbonNormals> noNormals;
    std::vector<Intersector> all;
    for (const InstructionSet isa : SupportedIsas()) {
        CurveSetOptions set;
        set.isa = IsaName(isa);
        const auto tree = std::make_shared<const CurveSet>(segments, types, noNormals, set);
        all.push_back(OurTree("curve set, " + set.isa, Set, tree));
        *widest = *widest ? *widest : tree;
    }
    const auto recursion = [&](const std::string &name, int splitDepth, int maxDepth) {
        all.push_back(OurTree(
            "recursion, " + name, Recursion,
            std::make_shared<const BinaryCurveBvh>(segments, types, noNormals, splitDepth, maxDepth)));
    };
    for (const int depth : {0, 1, 2, 3})
        recursion(fmt::format("depth {}", depth), 0, depth);
    recursion("until straight", 0, 10);
    recursion("split in 8, until straight", 3, 10); // pbrt-v3's default
    for (const int rate : {1, 4, 16})
        all.push_back(EmbreeTree(
            fmt::format("Embree flat, rate {}", rate), EmbreeFlat,
            std::make_shared<const EmbreeCurves>(segments, EmbreeCurves::Flat, static_cast<float>(rate))));
    all.push_back(EmbreeTree("Embree round", EmbreeRound,
                             std::make_shared<const EmbreeCurves>(segments, EmbreeCurves::Round, 0.f)));
    return all;
}

// CPU microseconds of a ray, of each intersector, over the first of the tasks.
std::vector<double> RayTimes(const std::vector<Intersector> &all, const std::vector<CurveTask> &tasks,
                             size_t rays, int rounds) {
    rays = std::min(rays, tasks.size());
    std::vector<std::function<void()>> jobs;
    jobs.reserve(all.size());
    for (const Intersector &m : all)
        jobs.push_back([&m, &tasks, rays] {
            CurveHit hit;
            for (size_t i = 0; i < rays; ++i)
                Keep(m.intersect(tasks[i], &hit));
        });
    std::vector<double> times = TimeInTurns(jobs, rounds);
    for (double &t : times)
        t *= 1e6 / static_cast<double>(rays);
    return times;
}

} // namespace

FigureData CurvesChart(const FigureOptions &options) {
    const bool quick = options.quick;
    const std::vector<CurveSegment> segments = HairBall(quick ? 3000 : 50000);
    std::shared_ptr<const CurveSet> widest;
    const std::vector<Intersector> all = IntersectorsOf(segments, &widest);
    const CurveTasks tasks = MakeCurveTasks(*widest, quick ? 60 : 400);
    const std::vector<CurveTruth> truths = FindCurveTruths(segments, tasks.bounce, quick ? 1000 : 20000);
    const std::vector<double> times = RayTimes(all, tasks.bounce, quick ? 2000 : 40000, quick ? 2 : 7);

    FigureData data{
        Table({"method", "rays", "missed", "invented", "other_hair", "v_error_median", "v_error_p99",
               "t_error_median_radii", "t_error_p99_radii", "us_per_ray", "Mrays_per_s"})};
    std::vector<CostPoint> wrong, vError, tError;
    for (size_t k = 0; k < all.size(); ++k) {
        const auto &[name, family, intersect] = all[k];
        const bool embree = family == EmbreeFlat || family == EmbreeRound;
        const CurveAccuracy a = CompareWithTruth(segments, truths, embree, intersect);
        const auto v = [&a](double share) { return CurveAccuracy::Percentile(a.vError, share); };
        const auto t = [&a](double share) { return CurveAccuracy::Percentile(a.tError, share); };
        data.table.Add({name, double(a.rays), double(a.missed), double(a.invented), double(a.otherHair),
                        v(0.5), v(0.99), t(0.5), t(0.99), times[k], 1 / times[k]});
        wrong.push_back({name, times[k], a.WrongShare(), family});
        vError.push_back({name, times[k], v(0.99), family});
        tError.push_back({name, times[k], t(0.99), family});
    }
    const char *const cost = "CPU time of a ray (µs), 1 / (Mrays/s)";
    const double halfOfOne = 0.5 / static_cast<double>(truths.size());
    data.plot.width = 900, data.plot.height = 440;
    data.plot.panels = {
        CostPanel("rays with a wrong answer", cost, "share", wrong, halfOfOne, 1),
        CostPanel("place across the hair", cost, "error of v, 99th percentile", vError, 1e-8, 1),
        CostPanel("distance", cost, "error of t in radii, 99th percentile", tError, 1e-8, 10)};
    data.checks = {
        {"the curve set's share of wrong answers is at most", wrong[0].error, 0, 1e-4},
        {"the curve set's v is off by at most (99th percentile)", vError[0].error, 0, 1e-6},
        {"the curve set's t is off by at most (radii, 99th percentile)", tError[0].error, 0, 1e-3},
    };
    data.note = fmt::format("{} segments, {} rays compared; no wrong answer at all is drawn at half of one. "
                            "Embree's round curves are tubes, whose v is another quantity.",
                            segments.size(), truths.size());
    return data;
}

namespace {

// The cost of one intersector at one size of the ball.
struct GrowthPoint {
    double closest, any; // CPU microseconds of a ray
    double bytes, build; // of a segment: memory, and CPU microseconds to build
};
struct GrowthOfBall {
    double segments, hitShare;
    GrowthPoint set, embree;
};

GrowthOfBall MeasureGrowth(size_t strands, size_t rays, int rounds) {
    // Strands are thinner as there are more, so that a ray goes as far whatever their number.
    const std::vector<CurveSegment> segments = HairBall(strands, 15000.f / static_cast<float>(strands));
    const auto n = static_cast<double>(segments.size());
    CurveList list(segments);
    double start = ProcessCpuSeconds();
    const CurveSet set(std::move(list), {CurveType::Flat});
    GrowthOfBall growth{n, 0, {}, {}};
    growth.set.build = 1e6 * (ProcessCpuSeconds() - start) / n;
    growth.set.bytes = static_cast<double>(set.MemoryBytes()) / n;
    const EmbreeCurves embree(segments, EmbreeCurves::Flat, 4);
    growth.embree.build = 1e6 * embree.BuildSeconds() / n;
    growth.embree.bytes = embree.Bytes() / n;

    CurveTasks tasks = MakeCurveTasks(set, 200);
    std::vector<CurveTask> &bounces = tasks.bounce;
    bounces.resize(std::min(bounces.size(), rays));
    const auto job = [&bounces](const auto &trace) {
        return [&bounces, trace] {
            for (const CurveTask &task : bounces)
                Keep(trace(task));
        };
    };
    CurveHit hit;
    const std::vector<double> seconds =
        TimeInTurns({job([&](const CurveTask &task) { return set.Intersect(task.ray, &task.origin, &hit); }),
                     job([&](const CurveTask &task) { return set.Occluded(task.ray, &task.origin); }),
                     job([&](const CurveTask &task) { return embree.Intersect(task, &hit); }),
                     job([&](const CurveTask &task) { return embree.Occluded(task); })},
                    rounds);
    const double perRay = 1e6 / static_cast<double>(bounces.size());
    growth.set.closest = seconds[0] * perRay, growth.set.any = seconds[1] * perRay;
    growth.embree.closest = seconds[2] * perRay, growth.embree.any = seconds[3] * perRay;
    size_t hits = 0;
    for (const CurveTask &task : bounces)
        hits += set.Occluded(task.ray, &task.origin);
    growth.hitShare = static_cast<double>(hits) / static_cast<double>(bounces.size());
    return growth;
}

// The power of the number of segments with which a time grows over the last decade that was measured.
double LastExponent(const std::vector<GrowthOfBall> &sizes, GrowthPoint GrowthOfBall::*method) {
    const GrowthOfBall &a = sizes[sizes.size() - 2], &b = sizes.back();
    return std::log((b.*method).closest / (a.*method).closest) / std::log(b.segments / a.segments);
}

PlotSeries GrowthSeries(const std::string &label, int color, PlotDash dash,
                        const std::vector<GrowthOfBall> &sizes,
                        const std::function<double(const GrowthOfBall &)> &value) {
    PlotSeries series;
    series.label = label, series.color = color, series.dash = dash, series.style = PlotStyle::LinePoints;
    series.marker = 0;
    for (const GrowthOfBall &g : sizes)
        series.x.push_back(g.segments), series.y.push_back(value(g));
    return series;
}

} // namespace

FigureData GrowthChart(const FigureOptions &options) {
    std::vector<GrowthOfBall> sizes;
    for (size_t strands = 125; strands <= (options.quick ? 12500 : 1250000); strands *= 10)
        sizes.push_back(MeasureGrowth(strands, options.quick ? 2000 : 20000, options.quick ? 2 : 5));

    FigureData data{Table({"segments", "method", "hit_share", "us_per_ray_closest", "us_per_ray_any",
                           "bytes_per_segment", "build_cpu_us_per_segment"})};
    const auto row = [&](const GrowthOfBall &g, const char *name, const GrowthPoint &p) {
        data.table.Add({g.segments, name, g.hitShare, p.closest, p.any, p.bytes, p.build});
    };
    for (const GrowthOfBall &g : sizes) {
        row(g, "curve set", g.set);
        row(g, "Embree flat", g.embree);
    }
    PlotPanel time, memory;
    time.title = "time of a ray";
    time.x = memory.x = {.label = "segments", .log = true, .min = 1000};
    time.y = {.label = "CPU time of a ray (µs)", .log = true};
    time.legend = "top left", memory.legend = "bottom right";
    memory.title = "memory";
    memory.y = {.label = "bytes a segment", .min = 0};
    for (const auto &[name, color, method] :
         {std::tuple("curve set", int(Set), &GrowthOfBall::set),
          std::tuple("Embree flat, rate 4", int(EmbreeFlat), &GrowthOfBall::embree)}) {
        time.series.push_back(GrowthSeries(name, color, PlotDash::Solid, sizes,
                                           [m = method](const GrowthOfBall &g) { return (g.*m).closest; }));
        time.series.push_back(GrowthSeries("", color, PlotDash::Dashed, sizes,
                                           [m = method](const GrowthOfBall &g) { return (g.*m).any; }));
        memory.series.push_back(GrowthSeries(name, color, PlotDash::Solid, sizes,
                                             [m = method](const GrowthOfBall &g) { return (g.*m).bytes; }));
    }
    data.plot.width = 560, data.plot.height = 400, data.plot.columns = 2;
    data.plot.panels = {time, memory};

    const auto [least, most] =
        std::minmax_element(sizes.begin(), sizes.end(), [](const GrowthOfBall &a, const GrowthOfBall &b) {
            return a.hitShare < b.hitShare;
        });
    data.checks = {
        {"a segment of the largest ball takes at most (bytes, with a large page to spare)",
         sizes.back().set.bytes, 48, 110 + 2097152 / sizes.back().segments},
        {"the share of rays that hit differs between balls by at most", most->hitShare - least->hitShare, 0,
         0.1},
    };
    data.note = fmt::format(
        "Over the last tenfold the time of a ray grows as the number of segments to the power {:.2f}, "
        "Embree's as {:.2f}; to build takes {:.2g} times Embree's CPU time.",
        LastExponent(sizes, &GrowthOfBall::set), LastExponent(sizes, &GrowthOfBall::embree),
        sizes.back().set.build / sizes.back().embree.build);
    return data;
}

} // namespace cuticle
