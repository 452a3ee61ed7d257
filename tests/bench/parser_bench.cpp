// This benchmark says how fast scene text becomes curves, on one core: bytes_per_second is of scene text,
// items are Shape "curve" statements. The argument is the number of statements. BM_GeneralReader reads the
// same text without the short way for curves.
#include "parser/scene_description.h"
#include "render/plugins.h"

#include <benchmark/benchmark.h>

#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <random>

namespace cuticle {
namespace {

// The style of the statements: Terse has bare widths and 5 digits, Exporter 9 digits and brackets, as
// pbrt-v3's own hair scenes and common exporters write them.
enum class Style { Terse, Exporter };

const std::string &HairText(int64_t count, Style style) {
    static std::map<std::pair<int64_t, Style>, std::string> made;
    std::string &text = made[{count, style}];
    if (!text.empty())
        return text;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-50, 50), step(-1, 1), width(0.005, 0.02);
    text = "WorldBegin\nMaterial \"hair\" \"float eumelanin\" .3\n";
    char line[512];
    for (int64_t i = 0; i < count; ++i) {
        double p[12];
        for (int k = 0; k < 12; ++k)
            p[k] = k < 3 ? place(random) : p[k - 3] + step(random);
        const double w0 = width(random), w1 = 0.5 * w0;
        const char *format =
            style == Style::Terse
                ? "Shape \"curve\" \"point P\" [%.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g] "
                  "\"float width\" %.3g\n"
                : "Shape \"curve\" \"string type\" [ \"cylinder\" ] \"point P\" [ %.6f %.6f %.6f %.6f %.6f "
                  "%.6f %.6f "
                  "%.6f %.6f %.6f %.6f %.6f ] \"float width0\" [ %.6f ] \"float width1\" [ %.6f ]\n";
        const int n = style == Style::Terse
                          ? std::snprintf(line, sizeof line, format, p[0], p[1], p[2], p[3], p[4], p[5], p[6],
                                          p[7], p[8], p[9], p[10], p[11], w0)
                          : std::snprintf(line, sizeof line, format, p[0], p[1], p[2], p[3], p[4], p[5], p[6],
                                          p[7], p[8], p[9], p[10], p[11], w0, w1);
        text.append(line, static_cast<size_t>(n));
    }
    return text += "WorldEnd\n";
}

void Report(benchmark::State &state, const std::string &text, size_t curves, size_t bytes) {
    if (curves != static_cast<size_t>(state.range(0)))
        state.SkipWithError("the text did not give the curves that it holds");
    state.SetItemsProcessed(state.iterations() * state.range(0));
    state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(text.size()));
    state.counters["text_bytes_per_curve"] = static_cast<double>(text.size()) / static_cast<double>(curves);
    state.counters["held_bytes_per_curve"] = static_cast<double>(bytes) / static_cast<double>(curves);
}

void ReadText(benchmark::State &state, Style style, bool fast) {
    const std::string &text = HairText(state.range(0), style);
    ParseOptions options;
    options.fastCurves = fast;
    size_t curves = 0, bytes = 0;
    for (auto _ : state) {
        const SceneDescription scene = ParseSceneText(AllPlugins(), text, "generated", ".", options);
        curves = scene.curves.segments.size();
        bytes = scene.curves.segments.MemoryBytes();
        benchmark::DoNotOptimize(scene.curves.segments.Points());
    }
    Report(state, text, curves, bytes);
}

void BM_Terse(benchmark::State &state) { ReadText(state, Style::Terse, true); }
void BM_Exporter(benchmark::State &state) { ReadText(state, Style::Exporter, true); }
void BM_GeneralReader(benchmark::State &state) { ReadText(state, Style::Exporter, false); }
BENCHMARK(BM_Terse)->Arg(1000000)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Exporter)->Arg(1000000)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_GeneralReader)->Arg(100000)->Unit(benchmark::kMillisecond);

// Reads a file that the system holds in its cache; packed or not.
void ReadFile(benchmark::State &state, bool packed) {
    const std::string &text = HairText(state.range(0), Style::Exporter);
    const std::string path = (std::filesystem::temp_directory_path() /
                              (packed ? "cuticle_parser_bench.pbrt.gz" : "cuticle_parser_bench.pbrt"))
                                 .string();
    gzFile file = gzopen(path.c_str(), packed ? "wb1" : "wbT");
    if (!file ||
        gzwrite(file, text.data(), static_cast<unsigned>(text.size())) != static_cast<int>(text.size()) ||
        gzclose(file) != Z_OK) {
        state.SkipWithError("cannot write a temporary file");
        return;
    }
    size_t curves = 0, bytes = 0;
    for (auto _ : state) {
        const SceneDescription scene = ParseScene(AllPlugins(), path);
        curves = scene.curves.segments.size();
        bytes = scene.curves.segments.MemoryBytes();
    }
    std::filesystem::remove(path);
    Report(state, text, curves, bytes);
}
void BM_File(benchmark::State &state) { ReadFile(state, false); }
void BM_PackedFile(benchmark::State &state) { ReadFile(state, true); }
BENCHMARK(BM_File)->Arg(1000000)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_PackedFile)->Arg(200000)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace cuticle

BENCHMARK_MAIN();
