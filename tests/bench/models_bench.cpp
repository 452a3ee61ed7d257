// Measures what an evaluation (value and density) and a sample cost in every model of a fiber, set-up
// included, as at every hit.
#include "core/sampling.h"
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"

#include <benchmark/benchmark.h>

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

constexpr std::array<float, 3> kBrown = {0.84f, 1.39f, 2.74f};
MarschnerParameters Marschners(RootMethod roots, float eccentricity) {
    MarschnerParameters p;
    p.sigmaA = kBrown, p.roots = roots, p.eccentricity = eccentricity;
    return p;
}
DEonParameters DEons(float betaN) {
    DEonParameters p;
    p.sigmaA = kBrown, p.betaN = {betaN, betaN, betaN};
    return p;
}
HairBSDF MakeChiang(const Query &q) { return {q.h, 1.55f, Spectrum(0.84f, 1.39f, 2.74f), 0.3f, 0.3f, 2}; }
KajiyaKayBSDF MakeKajiyaKay(const Query &) { return {Spectrum(0.4f), Spectrum(0.2f), 50}; }
template <RootMethod roots, int percent>
MarschnerBSDF MakeMarschner(const Query &) {
    return MarschnerBSDF(Marschners(roots, static_cast<float>(percent) / 100));
}
template <int degrees>
DEonBSDF MakeDEon(const Query &) {
    return DEonBSDF(DEons(degrees));
}
DEonBSDF MakeDEonNear(const Query &q) {
    DEonParameters p = DEons(10);
    p.h = q.h;
    return DEonBSDF(p);
}
DEonBSDF MakeChiangSixLobes(const Query &q) {
    DEonParameters p = DEons(10);
    p.h = q.h, p.lobes = 6, p.detector = AzimuthalDetector::Logistic;
    p.inclination = AttenuationInclination::Viewer;
    return DEonBSDF(p);
}
TabulatedDEonBSDF MakeTable(const Query &) {
    static const auto table = DEonTable::Cached(DEons(10));
    return {DEons(10), table.get()};
}

template <auto make>
void FAndPdf(benchmark::State &state) {
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        const auto bsdf = make(q);
        Float pdf = 0;
        Spectrum f = bsdf.FPdf(q.wo, q.wi, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(pdf);
    }
}
template <auto make>
void Sample(benchmark::State &state) {
    size_t i = 0;
    for (auto _ : state) {
        const Query &q = Queries()[i++ & 1023];
        const auto bsdf = make(q);
        Vector3f wi;
        Float pdf = 0;
        Spectrum f = bsdf.Sample_f(q.wo, &wi, q.u, &pdf);
        benchmark::DoNotOptimize(f);
        benchmark::DoNotOptimize(wi);
        benchmark::DoNotOptimize(pdf);
    }
}

template <auto make>
void Register(const char *name) {
    benchmark::RegisterBenchmark((std::string(name) + "/f_and_pdf").c_str(), FAndPdf<make>);
    benchmark::RegisterBenchmark((std::string(name) + "/sample").c_str(), Sample<make>);
}

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    using namespace cuticle;
    Register<MakeChiang>("chiang");
    Register<MakeChiangSixLobes>("chiang, six lobes");
    Register<MakeKajiyaKay>("kajiya-kay");
    Register<MakeMarschner<RootMethod::Exact, 100>>("marschner, exact roots");
    Register<MakeMarschner<RootMethod::Cubic, 100>>("marschner, cubic");
    Register<MakeMarschner<RootMethod::PolishedCubic, 100>>("marschner, polished");
    Register<MakeMarschner<RootMethod::Exact, 90>>("marschner, eccentric");
    Register<MakeDEon<20>>("deon, 20 degrees");
    Register<MakeDEon<10>>("deon, 10 degrees");
    Register<MakeDEon<3>>("deon, 3 degrees");
    Register<MakeTable>("deon, table");
    Register<MakeDEonNear>("deon, near");
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
