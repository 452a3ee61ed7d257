// The directions that Sample_f chooses against the density that Pdf states, by Pearson's chi-squared test.
//
// The cells are the panels of the furnace's quadrature: small on the lobes, large between them. What each
// should hold is integrated in double, 8 x 8 Gauss-Legendre nodes in a cell; the samples are the kernels'
// own.
#include "core/sampling.h"
#include "fibers/every_kernel.h"
#include "fibers/hair.h"
#include "fibers/hair_peaks.h"

#include <boost/math/special_functions/gamma.hpp>
#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

class HairChiSquared : public EveryKernel {};
CUTICLE_WITH_EVERY_KERNEL(HairChiSquared);

struct Case {
    float betaM, betaN, alpha, h;
    double thetaO;
};
const Case kCases[] = {
    {0.05f, 0.05f, 2, 0.3f, 0.4},   {0.05f, 0.3f, 0, -0.7f, -1.2}, {0.1f, 0.05f, 10, 0.9f, 1.5},
    {0.1f, 0.1f, 2, 0, 0},          {0.3f, 0.05f, 2, -0.3f, 1.0},  {0.3f, 0.3f, 2, 0.5f, 0.7},
    {0.3f, 0.3f, 10, 0.99f, -1.56}, {0.3f, 1, 2, -0.9f, 0.2},      {0.6f, 0.1f, 0, 0.2f, -0.8},
    {0.6f, 0.6f, 2, 1, 0.5},        {1, 0.05f, 10, 0.6f, 1.3},     {1, 1, 2, -1, -0.4},
    {0.01f, 0.2f, 2, 0.1f, 0.9},    {0.2f, 0.01f, 2, -0.5f, -0.3},
};
constexpr double kSignificance = 0.01; // that any of all cases and kernels fails by chance

// Samples of a fiber of roughness sampledBetaN against the density of the case.
double PValue(const Case &c, float sampledBetaN, uint64_t seed, int n, size_t *cells) {
    const HairParameters parameters = {c.h,     1.55f,   {0.1f, 0.2f, 0.4f},  c.betaM,
                                       c.betaN, c.alpha, ScaleTilt::RootToTip};
    const HairBSDF hair(c.h, 1.55f, Spectrum(0.1f, 0.2f, 0.4f), c.betaM, sampledBetaN, c.alpha);
    const HairLobes<double> lobes(parameters);
    const Vector3f wo(static_cast<float>(std::sin(c.thetaO)), static_cast<float>(std::cos(c.thetaO) * 0.8),
                      static_cast<float>(std::cos(c.thetaO) * 0.6));
    const HairPeaks peaks(lobes, Vector3d(wo));
    const double from = 0.1, turn = 2 * std::numbers::pi;
    const furnace::Mesh theta = furnace::ThetaMesh(peaks.theta, 1.3),
                        phi = furnace::PhiMesh(peaks.phi, from, 1.3);
    const size_t rows = theta.edges.size() - 1, columns = phi.edges.size() - 1;
    std::vector<double> expected(rows * columns), counted(rows * columns);
    for (size_t i = 0; i < theta.x.size(); ++i)
        for (size_t j = 0; j < phi.x.size(); ++j) {
            const double cosine = std::cos(theta.x[i]);
            const Vector3d wi(std::sin(theta.x[i]), cosine * std::cos(phi.x[j]), cosine * std::sin(phi.x[j]));
            expected[i / furnace::kNodes * columns + j / furnace::kNodes] +=
                n * theta.weight[i] * phi.weight[j] * cosine * lobes.Evaluate(Vector3d(wo), wi).pdf;
        }
    RNG rng(MixBits(seed));
    for (int k = 0; k < n; ++k) {
        Vector3f wi;
        float pdf = 0;
        hair.Sample_f(wo, &wi,
                      {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
        const Vector3d w(wi);
        const double t = std::atan2(w.x, std::hypot(w.y, w.z));
        double p = std::atan2(w.z, w.y);
        p -= turn * std::floor((p - from) / turn);
        const auto cell = [](const std::vector<double> &edges, double x) {
            const auto after = std::upper_bound(edges.begin() + 1, edges.end() - 1, x);
            return static_cast<size_t>(after - edges.begin()) - 1;
        };
        ++counted[cell(theta.edges, t) * columns + cell(phi.edges, p)];
    }
    // Neighbouring cells are pooled until each expects 8.
    double chiSquared = 0, e = 0, o = 0, total = 0;
    *cells = 0;
    for (size_t k = 0; k < expected.size(); ++k) {
        e += expected[k], o += counted[k], total += expected[k];
        if (e >= 8) {
            chiSquared += (o - e) * (o - e) / e;
            ++*cells;
            e = o = 0;
        }
    }
    if (e > 0) // what remains counts as one more cell, if it is not too small to be one
        chiSquared += (o - e) * (o - e) / std::max(e, 1.);
    EXPECT_NEAR(total / n, 1, 1e-5) << "the density must integrate to 1";
    return boost::math::gamma_q(static_cast<double>(*cells - 1) / 2, chiSquared / 2);
}

TEST_P(HairChiSquared, SamplesFollowThePdf) {
    const int n = 200000;
    const double each = kSignificance / static_cast<double>(std::size(kCases) * 3);
    double smallest = 1;
    uint64_t seed = 0;
    for (const Case &c : kCases) {
        size_t cells = 0;
        const double p = PValue(c, c.betaN, ++seed, n, &cells);
        smallest = std::min(smallest, p);
        EXPECT_GT(cells, 100u);
        EXPECT_GT(p, each) << "beta_m " << c.betaM << " beta_n " << c.betaN << " alpha " << c.alpha << " h "
                           << c.h << " theta_o " << c.thetaO << ", n " << n << ", " << cells << " cells";
    }
    std::printf("chi-squared, %s: smallest p %.3g of %zu cases, fails below %.3g\n", GetParam().c_str(),
                smallest, std::size(kCases), each);
}

// The test can fail: it sees a roughness that is 3% off.
TEST(HairChiSquaredPower, SeesThreePercent) {
    const Case c = {0.3f, 0.3f, 2, 0.5f, 0.7};
    size_t cells = 0;
    EXPECT_LT(PValue(c, 0.309f, 1, 200000, &cells), 1e-6);
}

} // namespace
} // namespace cuticle
