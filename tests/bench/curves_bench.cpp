// Rays through a ball of hair: the curve set, the plain binary tree and Embree's curves, in one run.
//
// Rays per second are of the CPU time of one thread, build times those of all threads. "camera": primary
// rays; "bounce": random walks from hair to hair, as a path tracer of light hair makes them, the nearest hit
// or any hit. Accuracy is counted against an oracle in extended precision, on the same bounces for all, with
// the same start of the ray.
#include "core/clock.h"
#include "core/isa.h"
#include "figures/charts/curve_rays.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

namespace cuticle {
namespace {

size_t Strands() {
    const char *s = std::getenv("CUTICLE_BENCH_STRANDS");
    return s ? static_cast<size_t>(std::atoll(s)) : 50000;
}

struct World {
    std::vector<CurveSegment> segments = HairBall(Strands());
    std::unique_ptr<CurveSet> set;
    std::unique_ptr<BinaryCurveBvh> binary;
    double setSeconds = 0, binarySeconds = 0; // to build them, CPU time of all threads
    std::vector<CurveTask> camera, bounce;

    World() {
        CurveSetOptions options;
        if (const char *s = std::getenv("CUTICLE_BENCH_SPLIT"))
            options.split = std::atoi(s);
        double start = ProcessCpuSeconds();
        set = std::make_unique<CurveSet>(segments, std::vector<CurveType>{CurveType::Flat},
                                         std::unordered_map<uint32_t, RibbonNormals>(), options);
        setSeconds = ProcessCpuSeconds() - start;
        start = ProcessCpuSeconds();
        binary = std::make_unique<BinaryCurveBvh>(segments, std::vector<CurveType>{CurveType::Flat});
        binarySeconds = ProcessCpuSeconds() - start;

        CurveTasks tasks = MakeCurveTasks(*set);
        camera = std::move(tasks.camera), bounce = std::move(tasks.bounce);
    }
    static World &Get() {
        static World world;
        return world;
    }
};

const EmbreeCurves &Embree(int which) {
    const std::vector<CurveSegment> &segments = World::Get().segments;
    static const EmbreeCurves flat4(segments, EmbreeCurves::Flat, 4);
    static const EmbreeCurves flat16(segments, EmbreeCurves::Flat, 16);
    static const EmbreeCurves round(segments, EmbreeCurves::Round, 0);
    return which == 0 ? flat4 : which == 1 ? flat16 : round;
}

enum Contender { Set, Binary, Flat4, Flat16, Round };
enum RaySort { Camera, Closest, Any };
const char *const kContenderNames[] = {"curve_set", "binary_recursive", "embree_flat4", "embree_flat16",
                                       "embree_round"};
const char *const kRaySortNames[] = {"camera", "bounce_closest", "bounce_any"};

bool Trace(Contender who, RaySort kind, const CurveTask &task, CurveHit *hit) {
    const World &w = World::Get();
    const CurveOrigin *origin = task.bounce ? &task.origin : nullptr;
    if (who == Set)
        return kind == Any ? w.set->Occluded(task.ray, origin) : w.set->Intersect(task.ray, origin, hit);
    if (who == Binary)
        return kind == Any ? w.binary->Occluded(task.ray, origin)
                           : w.binary->Intersect(task.ray, origin, hit);
    const EmbreeCurves &e = Embree(who - Flat4);
    return kind == Any ? e.Occluded(task) : e.Intersect(task, hit);
}

void BM_Rays(benchmark::State &state, Contender who, RaySort kind) {
    const std::vector<CurveTask> &tasks = kind == Camera ? World::Get().camera : World::Get().bounce;
    CurveHit hit;
    size_t i = 0, hits = 0, rays = 0;
    Trace(who, kind, tasks[0], &hit); // builds what is built on first use
    for (auto _ : state) {
        for (int k = 0; k < 1000; ++k) {
            hits += Trace(who, kind, tasks[i], &hit);
            i = i + 1 < tasks.size() ? i + 1 : 0;
        }
        rays += 1000;
    }
    benchmark::DoNotOptimize(hit);
    state.counters["Mrays/s"] =
        benchmark::Counter(static_cast<double>(rays) * 1e-6, benchmark::Counter::kIsRate);
    state.counters["hit%"] = 100 * static_cast<double>(hits) / static_cast<double>(rays);
}

// Counts wrong answers over the bounces, all with the same start of the ray and no origin.
void BM_Accuracy(benchmark::State &state, Contender who) {
    const World &w = World::Get();
    static const std::vector<CurveTruth> truths = FindCurveTruths(w.segments, w.bounce, 20000);
    CurveAccuracy a;
    for (auto _ : state)
        a = CompareWithTruth(w.segments, truths, who >= Flat4, [who](const CurveTask &task, CurveHit *hit) {
            return Trace(who, Closest, task, hit);
        });
    state.counters["rays"] = static_cast<double>(a.rays);
    state.counters["missed"] = static_cast<double>(a.missed);
    state.counters["invented"] = static_cast<double>(a.invented);
    state.counters["other_hair"] = static_cast<double>(a.otherHair);
    state.counters["v_median"] = CurveAccuracy::Percentile(a.vError, 0.5);
    state.counters["v_p99"] = CurveAccuracy::Percentile(a.vError, 0.99);
    state.counters["t_p99_radii"] = CurveAccuracy::Percentile(a.tError, 0.99);
}

// Counts how often a bounce meets the hair that it leaves, by the reach of the test that should prevent it;
// and how often it meets something else than with the default reach when the ray instead starts so many radii
// out.
void BM_SelfHits(benchmark::State &state, float reach, bool offset) {
    const World &w = World::Get();
    CurveSetOptions options;
    options.selfReach = reach;
    const CurveSet set(w.segments, {CurveType::Flat}, {}, options);
    const size_t stride = std::max<size_t>(1, w.bounce.size() / 100000);
    size_t rays = 0, own = 0, ownNear = 0, differs = 0;
    for (auto _ : state)
        for (size_t i = 0; i < w.bounce.size(); i += stride) {
            CurveTask task = w.bounce[i];
            CurveHit hit, standard;
            const bool expected = w.set->Intersect(task.ray, &task.origin, &standard);
            if (offset)
                task.ray.tMin = task.clear / 1.5f * reach;
            const bool found = set.Intersect(task.ray, offset ? nullptr : &task.origin, &hit);
            ++rays;
            const bool same =
                found && hit.segment / kSegmentsPerStrand == task.origin.segment / kSegmentsPerStrand;
            own += same;
            ownNear += same && hit.t < 2 * task.clear;
            differs +=
                found != expected || (found && (hit.segment != standard.segment || hit.t != standard.t));
        }
    const double n = static_cast<double>(rays);
    state.counters["rays"] = n;
    state.counters["own_hair%"] = 100 * static_cast<double>(own) / n;
    state.counters["own_hair_near%"] = 100 * static_cast<double>(ownNear) / n;
    state.counters["differs%"] = 100 * static_cast<double>(differs) / n;
}

void BM_Memory(benchmark::State &state, Contender who) {
    const World &w = World::Get();
    const double n = static_cast<double>(w.segments.size());
    for (auto _ : state) {
        const double bytes = who == Set      ? static_cast<double>(w.set->MemoryBytes())
                             : who == Binary ? static_cast<double>(w.binary->MemoryBytes())
                                             : static_cast<double>(Embree(who - Flat4).Bytes()) + 60 * n;
        state.counters["bytes/curve"] = bytes / n;
        state.counters["build_cpu_s"] = who == Set      ? w.setSeconds
                                        : who == Binary ? w.binarySeconds
                                                        : Embree(who - Flat4).BuildSeconds();
    }
}

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    using namespace cuticle;
    benchmark::Initialize(&argc, argv);
    std::printf("%zu strands of %zu segments; instruction set %s\n", Strands(), kSegmentsPerStrand,
                IsaName(ChooseIsa()));
    for (const RaySort kind : {Camera, Closest, Any})
        for (const Contender who : {Set, Binary, Flat4, Flat16, Round})
            benchmark::RegisterBenchmark(
                (std::string("rays/") + kRaySortNames[kind] + "/" + kContenderNames[who]).c_str(), BM_Rays,
                who, kind);
    for (const Contender who : {Set, Binary, Flat4, Flat16, Round}) {
        benchmark::RegisterBenchmark((std::string("memory/") + kContenderNames[who]).c_str(), BM_Memory, who)
            ->Iterations(1);
        benchmark::RegisterBenchmark((std::string("accuracy/") + kContenderNames[who]).c_str(), BM_Accuracy,
                                     who)
            ->Iterations(1);
    }
    for (const float reach : {0.f, 0.5f, 1.f, 1.5f, 3.f})
        benchmark::RegisterBenchmark(("self_hits/reach:" + std::to_string(reach).substr(0, 3)).c_str(),
                                     BM_SelfHits, reach, false)
            ->Iterations(1);
    for (const float radii : {0.2f, 1.5f, 4.f, 7.f})
        benchmark::RegisterBenchmark(("self_hits/offset_radii:" + std::to_string(radii).substr(0, 3)).c_str(),
                                     BM_SelfHits, radii, true)
            ->Iterations(1);
    benchmark::RunSpecifiedBenchmarks();
}
