// This benchmark says how much faster the renderer is than the same program with a binary tree, recursive
// curves and scalar hair, at equal settings in one run; and than that with pbrt-v3's estimate of direct
// light, which traces a ray of its own for each direction that the BSDF proposes (the same expected picture).
// The scene is a head of 50,000 strands, 400,000 segments, 256 x 256, 16 samples per pixel, depth 30;
// CUTICLE_BENCH_SPP sets another number of samples.
#include "core/error.h"
#include "fibers/hair_lanes.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <benchmark/benchmark.h>

#include <cstdlib>

using namespace cuticle;

namespace {

// The configurations
enum Configuration { Ours, Plain, PlainPbrt };
const char *const kLabel[] = {"ours, ", "binary tree, recursion, scalar hair",
                              "binary tree, recursion, scalar hair, a separate ray for BSDF sampling"};

const char kScene[] = R"(LookAt 62 9 -46 0 -4.5 -1.5 0 1 0 Camera "perspective" "float fov" 33
Film "image" "integer xresolution" 256 "integer yresolution" 256
Sampler "halton" "integer pixelsamples" 16
Integrator "path" "integer maxdepth" 30 "bool separatelightray" "SEPARATE"
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
double seconds[3] = {};
int runs[3] = {};

void RenderHead(benchmark::State &state) {
    const auto who = static_cast<Configuration>(state.range(0));
    const bool plain = who != Ours;
    static const std::string best = CurrentHairKernels().name;
    SetHairKernels(plain ? "scalar" : best);
    std::string text = kScene;
    text.replace(text.find("SEPARATE"), 8, who == PlainPbrt ? "true" : "false");
    SceneDescription description = ParseSceneText(AllPlugins(), text, "benchmark");
    SceneOptions sceneOptions;
    sceneOptions.binaryCurves = plain;
    const Scene scene(&description, sceneOptions);
    RenderOptions options;
    options.spp = Samples();
    RenderStats stats;
    for (auto _ : state) {
        benchmark::DoNotOptimize(Render(description, scene, options, &stats).data.data());
        seconds[who] += stats.renderSeconds;
        ++runs[who];
    }
    const double rays = static_cast<double>(stats.rays + stats.shadowRays);
    state.counters["Mrays/s"] = 1e-6 * rays / (seconds[who] / runs[who]);
    state.counters["rays"] = rays;
    state.counters["bytes/curve"] =
        static_cast<double>(scene.MemoryBytes()) / static_cast<double>(scene.Curves());
    // This one against the mean of ours so far
    if (runs[Ours] > 0)
        state.counters["times ours"] = (seconds[who] / runs[who]) / (seconds[Ours] / runs[Ours]);
    state.SetLabel(who == Ours ? kLabel[who] + std::string(scene.Isa()) : kLabel[who]);
}
// Ours before and after each other, so that a change of the machine's speed in between is seen
BENCHMARK(RenderHead)
    ->Arg(Ours)
    ->Arg(Plain)
    ->Arg(Ours)
    ->Arg(PlainPbrt)
    ->Arg(Ours)
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();

} // namespace

BENCHMARK_MAIN();
