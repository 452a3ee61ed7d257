// Measures what an evaluation (value and density) and a sample cost in every model of a fiber, in the forms
// that its row names, set-up included, as at every hit.
#include "core/sampling.h"
#include "fibers/models.h"

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

namespace cuticle {
namespace {

struct Query {
    Vector3f wo, wi;
    std::array<float, 4> u;
    float h;
};
const std::vector<Query> &Queries() {
    static const std::vector<Query> queries = [] {
        RNG rng(1);
        std::vector<Query> result(1024);
        for (Query &q : result) {
            q.wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            q.wi = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            q.h = 2 * rng.UniformFloat() - 1;
            for (float &u : q.u)
                u = rng.UniformFloat();
        }
        return result;
    }();
    return queries;
}

// Calls run(fiber, query) with the model made at the offset of each query in turn.
template <typename Run>
void Repeat(benchmark::State &state, const FiberModel &model, const FiberForm &form, Run run) {
    FiberInputs brown;
    brown.sigmaA = {0.84f, 1.39f, 2.74f};
    const PreparedFiber prepared(model, brown, form.own);
    FiberInputs at = prepared.inputs;
    FiberStorage fiber;
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        at.h = q.h;
        prepared.maker->Make(at, &fiber);
        run(*fiber.Get(), q);
    }
}

void FAndPdf(benchmark::State &state, const FiberModel &model, const FiberForm &form) {
    Repeat(state, model, form, [](const FiberBxDF &fiber, const Query &q) {
        Float pdf = 0;
        Spectrum f = fiber.FPdf(q.wo, q.wi, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(pdf);
    });
}
void Sample(benchmark::State &state, const FiberModel &model, const FiberForm &form) {
    Repeat(state, model, form, [](const FiberBxDF &fiber, const Query &q) {
        Vector3f wi;
        Float pdf = 0;
        Spectrum f = fiber.Sample_f(q.wo, &wi, q.u, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(wi);
        benchmark::DoNotOptimize(pdf);
    });
}

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    using namespace cuticle;
    for (const FiberModel &model : FiberModels())
        for (const FiberForm &form : model.forms) {
            std::string name(model.name);
            if (!form.name.empty())
                name += ", " + std::string(form.name);
            benchmark::RegisterBenchmark((name + "/f_and_pdf").c_str(),
                                         [&](benchmark::State &s) { FAndPdf(s, model, form); });
            benchmark::RegisterBenchmark((name + "/sample").c_str(),
                                         [&](benchmark::State &s) { Sample(s, model, form); });
        }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
