// Measures what an evaluation and a sample of the hair BSDF cost, set-up included, as at every hit of a path:
// the lanes against the plain model and against the formulas as printed. Prints the ratios at the end.
#include "core/sampling.h"
#include "fibers/hair.h"
#include "fibers/hair_as_printed.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>
#include <vector>

namespace cuticle {
namespace {

struct Query {
    float h, betaM, betaN;
    Vector3f wo, wi;
    std::array<float, 4> u;
};

// Directions all over the sphere, roughnesses about the default, as a renderer's hits bring them.
const std::vector<Query> &Queries() {
    static const std::vector<Query> queries = [] {
        RNG rng(1);
        std::vector<Query> result(1024);
        for (Query &q : result) {
            q.h = 2 * rng.UniformFloat() - 1;
            q.betaM = 0.2f + 0.2f * rng.UniformFloat();
            q.betaN = 0.2f + 0.2f * rng.UniformFloat();
            q.wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            q.wi = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            for (float &u : q.u)
                u = rng.UniformFloat();
        }
        return result;
    }();
    return queries;
}

const Spectrum kBrown(0.84f, 1.39f, 2.74f);

template <typename Hair>
void FAndPdf(benchmark::State &state) {
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        const Hair hair(q.h, 1.55f, kBrown, q.betaM, q.betaN, 2);
        Spectrum f;
        Float pdf = 0;
        if constexpr (requires { hair.FPdf(q.wo, q.wi, &pdf); }) {
            f = hair.FPdf(q.wo, q.wi, &pdf);
        } else {
            f = hair.f(q.wo, q.wi);
            pdf = hair.Pdf(q.wo, q.wi);
        }
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(pdf);
    }
}

template <typename Hair>
void Sample(benchmark::State &state) {
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        const Hair hair(q.h, 1.55f, kBrown, q.betaM, q.betaN, 2);
        Vector3f wi;
        Float pdf = 0;
        Spectrum f = hair.Sample_f(q.wo, &wi, q.u, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(wi);
        benchmark::DoNotOptimize(pdf);
    }
}

void SetUpOnly(benchmark::State &state) {
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        const HairBSDF hair(q.h, 1.55f, kBrown, q.betaM, q.betaN, 2);
        benchmark::DoNotOptimize(&hair);
    }
}

// Shows the table as usual and keeps the times for the ratios.
class Ratios : public benchmark::ConsoleReporter {
  public:
    void ReportRuns(const std::vector<Run> &runs) override {
        ConsoleReporter::ReportRuns(runs);
        for (const Run &run : runs)
            if (run.run_type == Run::RT_Iteration || run.aggregate_name == "median")
                times_[run.run_name.function_name] = run.GetAdjustedCPUTime();
    }
    void Print() {
        for (const char *what : {"f_and_pdf", "sample"})
            for (const std::string &kernel : HairKernelNames()) {
                const auto lanes = times_.find(what + ("/" + kernel));
                const auto printed = times_.find(std::string(what) + "/as_printed");
                if (lanes != times_.end() && printed != times_.end())
                    std::printf(
                        "%-10s %-7s %7.1f ns   %5.2f times as fast as the printed formulas (%.1f ns)\n", what,
                        kernel.c_str(), lanes->second, printed->second / lanes->second, printed->second);
            }
    }

  private:
    std::map<std::string, double> times_;
};

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    using namespace cuticle;
    benchmark::Initialize(&argc, argv);
    for (const std::string &name : HairKernelNames()) {
        const auto with = [name](void (*run)(benchmark::State &)) {
            return [name, run](benchmark::State &state) {
                SetHairKernels(name);
                run(state);
            };
        };
        benchmark::RegisterBenchmark(("set_up/" + name).c_str(), with(SetUpOnly));
        benchmark::RegisterBenchmark(("f_and_pdf/" + name).c_str(), with(FAndPdf<HairBSDF>));
        benchmark::RegisterBenchmark(("sample/" + name).c_str(), with(Sample<HairBSDF>));
    }
    benchmark::RegisterBenchmark("f_and_pdf/as_printed", FAndPdf<as_printed::HairBSDF>);
    benchmark::RegisterBenchmark("sample/as_printed", Sample<as_printed::HairBSDF>);
    Ratios reporter;
    benchmark::RunSpecifiedBenchmarks(&reporter);
    reporter.Print();
}
