// Measures what an evaluation (value and density) and a sample cost in every model of a fiber, in the forms
// that its row names, set-up included, as at every hit; and what d'Eon's quadrature costs where lobes are too
// narrow for its table.
#include "core/sampling.h"
#include "fibers/deon.h"
#include "fibers/models.h"

#include <benchmark/benchmark.h>

#include <fmt/format.h>

#include <ctime>
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

// Calls run(fiber, query) with the model made at the offset of each query in turn. Returns the ticks of
// std::clock that one call took.
template <typename Run>
double Repeat(benchmark::State &state, const FiberModel &model, const FiberForm &form, Run run) {
    FiberInputs brown;
    brown.sigmaA = {0.84f, 1.39f, 2.74f};
    const PreparedFiber prepared(model, brown, form.own);
    FiberInputs at = prepared.inputs;
    FiberStorage fiber;
    size_t i = 0;
    const std::clock_t start = std::clock();
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        at.h = q.h;
        prepared.maker->Make(at, &fiber);
        run(*fiber.Get(), q);
    }
    return static_cast<double>(std::clock() - start) / static_cast<double>(state.iterations());
}

double FAndPdf(benchmark::State &state, const FiberModel &model, const FiberForm &form) {
    return Repeat(state, model, form, [](const FiberBxDF &fiber, const Query &q) {
        Float pdf = 0;
        Spectrum f = fiber.FPdf(q.wo, q.wi, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(pdf);
    });
}
double Sample(benchmark::State &state, const FiberModel &model, const FiberForm &form) {
    return Repeat(state, model, form, [](const FiberBxDF &fiber, const Query &q) {
        Vector3f wi;
        Float pdf = 0;
        Spectrum f = fiber.Sample_f(q.wo, &wi, q.u, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(wi);
        benchmark::DoNotOptimize(pdf);
    });
}

// Registers d'Eon's model with lobes as narrow around the fiber as a table holds, and with narrower ones, for
// which the quadrature takes over. Each is labelled with its time in units of the table's, in the same run.
void RegisterNarrowLobes() {
    struct Narrow {
        std::string name;
        FiberForm form;
    };
    static std::vector<Narrow> all;
    for (const float width : {DEonTable::kNarrowest, 0.9f, 0.5f, 0.25f}) {
        const bool hasTable = width >= DEonTable::kNarrowest;
        const char *evaluation = hasTable ? "table" : "quadrature";
        all.push_back({fmt::format("deon, {} at {} degrees", evaluation, width),
                       {.own = {{"azimuth_R", width},
                                {"azimuth_TT", width},
                                {"azimuth_TRT", width},
                                {"evaluation", evaluation}}}});
    }
    using Measure = double (*)(benchmark::State &, const FiberModel &, const FiberForm &);
    static const std::pair<const char *, Measure> kinds[] = {{"/f_and_pdf", FAndPdf}, {"/sample", Sample}};
    static double ofTable[2];
    for (size_t i = 0; i < all.size(); ++i)
        for (size_t k = 0; k < 2; ++k)
            benchmark::RegisterBenchmark((all[i].name + kinds[k].first).c_str(), [i, k](benchmark::State &s) {
                const double each = kinds[k].second(s, *FindFiberModel("deon"), all[i].form);
                if (i == 0)
                    ofTable[k] = each;
                else if (ofTable[k] > 0)
                    s.SetLabel(fmt::format("{:.3g} times the table", each / ofTable[k]));
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
    RegisterNarrowLobes();
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
