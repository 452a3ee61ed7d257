// How much faster the renderer is than the same program with a binary tree, recursive curves and scalar hair, at
// equal settings in one run: build/release/bench_render. The head of the numbers: 50,000 strands, 400,000 segments,
// 256 x 256, 16 samples per pixel, depth 30. CUTICLE_BENCH_SPP sets another number of samples.
#include "core/error.h"
#include "fibers/hair_lanes.h"
#include "render/renderer.h"

#include <benchmark/benchmark.h>

#include <cstdlib>

using namespace cuticle;

namespace {

const char kScene[] = R"(LookAt 62 9 -46 0 -4.5 -1.5 0 1 0 Camera "perspective" "float fov" 33
Film "image" "integer xresolution" 256 "integer yresolution" 256
Sampler "halton" "integer pixelsamples" 16 Integrator "path" "integer maxdepth" 30
WorldBegin LightSource "infinite" "rgb L" [.4 .45 .5]
LightSource "distant" "point from" [2 3 -4] "point to" [0 0 0] "rgb L" [3 3 2.8]
Material "matte" Shape "groomhead" Material "hair" "float eumelanin" 0.3
Shape "groom" "string style" "straight" "integer strands" 50000 "integer segments" 8 "integer seed" 1
WorldEnd)";

int Samples() {
    const char *text = std::getenv("CUTICLE_BENCH_SPP");
    return text ? std::max(1, std::atoi(text)) : 16;
}

// Mean seconds of what has been measured, for the ratio in the last row.
double seconds[2] = {};
int runs[2] = {};

void RenderHead(benchmark::State &state) {
    const bool plain = state.range(0) == 1;
    static const std::string best = CurrentHairKernels().name;
    SetHairKernels(plain ? "scalar" : best);
    SceneDescription description = ParseSceneText(kScene, "benchmark");
    SceneOptions sceneOptions;
    sceneOptions.binaryCurves = plain;
    const Scene scene(&description, sceneOptions);
    RenderOptions options;
    options.spp = Samples();
    options.progress = false;
    RenderStats stats;
    for (auto _ : state) {
        benchmark::DoNotOptimize(Render(description, scene, options, &stats).data.data());
        seconds[plain] += stats.renderSeconds;
        ++runs[plain];
    }
    const double rays = static_cast<double>(stats.rays + stats.shadowRays);
    state.counters["Mrays/s"] = 1e-6 * rays / (seconds[plain] / runs[plain]);
    state.counters["rays"] = rays;
    state.counters["bytes/curve"] =
        static_cast<double>(scene.MemoryBytes()) / static_cast<double>(scene.Curves());
    if (runs[0] > 0 && runs[1] > 0)
        state.counters["plain/ours"] = (seconds[1] / runs[1]) / (seconds[0] / runs[0]);
    state.SetLabel(plain ? "binary tree, recursion, scalar hair" : std::string("ours, ") + scene.Isa());
}
// Ours before and after the other, so that a change of the machine's speed in between is seen
BENCHMARK(RenderHead)->Arg(0)->Arg(1)->Arg(0)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

} // namespace

BENCHMARK_MAIN();
