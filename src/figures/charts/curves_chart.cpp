// Ways to intersect rays with hair: the paper's recursion, the curve set, Embree's curves.
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"
#include "figures/charts/curve_rays.h"

#include <algorithm>
#include <memory>

namespace cuticle {

namespace {

enum Family { Set = 0, Recursion = 1, EmbreeFlat = 4, EmbreeRound = 3 };

struct Method {
    std::string name;
    Family family;
    std::function<bool(const CurveTask &, CurveHit *)> intersect;
};

template <class Tree>
Method OurTree(const std::string &name, Family family, const std::shared_ptr<const Tree> &tree) {
    return {name, family, [tree](const CurveTask &task, CurveHit *hit) {
                return tree->Intersect(task.ray, task.bounce ? &task.origin : nullptr, hit);
            }};
}
Method EmbreeTree(const std::string &name, Family family, const std::shared_ptr<const EmbreeCurves> &tree) {
    return {name, family,
            [tree](const CurveTask &task, CurveHit *hit) { return tree->Intersect(task, hit); }};
}

} // namespace

FigureData CurvesChart(const FigureOptions &options) {
    const std::vector<CurveSegment> segments = HairBall(options.quick ? 3000 : 50000);
    const std::vector<CurveType> types = {CurveType::Flat};

    std::vector<Method> methods;
    std::shared_ptr<const CurveSet> widest;
    for (const char *isa : {"avx512", "avx2", "sse2"})
        if (CurveSetIsaSupported(isa)) {
            CurveSetOptions set;
            set.isa = isa;
            const auto tree = std::make_shared<const CurveSet>(
                segments, types, std::unordered_map<uint32_t, RibbonNormals>(), set);
            methods.push_back(OurTree(std::string("curve set, ") + isa, Set, tree));
            widest = widest ? widest : tree;
        }
    const auto recursion = [&](const std::string &name, int splitDepth, int maxDepth) {
        methods.push_back(OurTree(
            "recursion, " + name, Recursion,
            std::make_shared<const BinaryCurveBvh>(
                segments, types, std::unordered_map<uint32_t, RibbonNormals>(), splitDepth, maxDepth)));
    };
    for (const int depth : {0, 1, 2, 3})
        recursion("depth " + std::to_string(depth), 0, depth);
    recursion("until straight", 0, 10);
    recursion("split in 8, until straight", 3, 10); // pbrt-v3's default
    for (const int rate : {1, 4, 16})
        methods.push_back(EmbreeTree(
            "Embree flat, rate " + std::to_string(rate), EmbreeFlat,
            std::make_shared<const EmbreeCurves>(segments, EmbreeCurves::Flat, static_cast<float>(rate))));
    methods.push_back(EmbreeTree("Embree round", EmbreeRound,
                                 std::make_shared<const EmbreeCurves>(segments, EmbreeCurves::Round, 0.f)));

    const CurveTasks tasks = MakeCurveTasks(*widest, options.quick ? 60 : 400);
    const std::vector<CurveTruth> truths =
        FindCurveTruths(segments, tasks.bounce, options.quick ? 1000 : 20000);

    const size_t timed = std::min<size_t>(tasks.bounce.size(), options.quick ? 2000 : 40000);
    std::vector<std::function<void()>> jobs;
    jobs.reserve(methods.size());
    for (const Method &m : methods)
        jobs.push_back([&m, &tasks, timed] {
            CurveHit hit;
            for (size_t i = 0; i < timed; ++i)
                Keep(m.intersect(tasks.bounce[i], &hit));
        });
    const std::vector<double> seconds = TimeInTurns(jobs, options.quick ? 2 : 7);

    FigureData data{
        Table({"method", "rays", "missed", "invented", "other_hair", "v_error_median", "v_error_p99",
               "t_error_median_radii", "t_error_p99_radii", "us_per_ray", "Mrays_per_s"}),
        {},
        "",
        {}};
    std::vector<CostPoint> wrong, vError, tError;
    for (size_t k = 0; k < methods.size(); ++k) {
        const Method &m = methods[k];
        const bool embree = m.family == EmbreeFlat || m.family == EmbreeRound;
        const CurveAccuracy a = CompareWithTruth(segments, truths, embree, m.intersect);
        const double us = 1e6 * seconds[k] / static_cast<double>(timed);
        const double v99 = CurveAccuracy::Percentile(a.vError, 0.99),
                     t99 = CurveAccuracy::Percentile(a.tError, 0.99);
        const auto count = [](size_t n) { return static_cast<double>(n); };
        data.table.Add({m.name, count(a.rays), count(a.missed), count(a.invented), count(a.otherHair),
                        CurveAccuracy::Percentile(a.vError, 0.5), v99,
                        CurveAccuracy::Percentile(a.tError, 0.5), t99, us, 1 / us});
        wrong.push_back({m.name, us, a.WrongShare(), m.family});
        vError.push_back({m.name, us, v99, m.family});
        tError.push_back({m.name, us, t99, m.family});
    }
    const char *const cost = "time of a ray (µs), 1 / (Mrays/s)";
    const double least = 0.5 / static_cast<double>(truths.size());
    data.plot.width = 900, data.plot.height = 440;
    data.plot.panels = {
        CostPanel("rays with a wrong answer", cost, "share", wrong, least, 1),
        CostPanel("place across the hair", cost, "error of v, 99th percentile", vError, 1e-8, 1),
        CostPanel("distance", cost, "error of t in radii, 99th percentile", tError, 1e-8, 10)};
    data.checks = {
        {"the curve set's share of wrong answers is at most", wrong[0].error, 0, 1e-4},
        {"the curve set's v is off by at most (99th percentile)", vError[0].error, 0, 1e-6},
        {"the curve set's t is off by at most (radii, 99th percentile)", tError[0].error, 0, 1e-3},
    };
    data.note = Printed("%.0f segments, ", static_cast<double>(segments.size())) +
                Printed("%.0f rays compared; no wrong answer at all is drawn at half of one. Embree's round "
                        "curves are tubes, whose v is another quantity.",
                        static_cast<double>(truths.size()));
    return data;
}

} // namespace cuticle
