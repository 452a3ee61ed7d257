// The faults of the printed formulas, measured: what the stable forms are for. Each test would fail if the
// fault were not there, and shows the size that the book quotes.
#include "fibers/hair_as_printed.h"

#include "core/sampling.h"
#include "fibers/hair.h"
#include "fibers/hair_peaks.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

TEST(AsPrinted, BesselSeriesIsShortAndItsLogarithmHalvesATerm) {
    const double series = as_printed::I0(12.) * std::exp(-12.) / I0e(12.) - 1;
    EXPECT_NEAR(series, -0.020, 0.001);
    const double log12 = std::exp(as_printed::LogI0(12.0000001) - 12.0000001) / I0e(12.0000001) - 1;
    EXPECT_NEAR(log12, -0.0057, 0.0002);
    const double log50 = std::exp(as_printed::LogI0(50.) - 50) / I0e(50.) - 1;
    std::printf("relative errors: ten terms of I_0 at 12 %.3f; log I_0 at 12 %.4f, at 50 %.4f\n", series,
                log12, log50);
    EXPECT_NEAR(log50, -0.0013, 0.0001);
}

// The integral of M_p cos theta_i d theta_i with the printed M_p, in T.
template <typename T>
double PrintedMass(T v, double thetaO) {
    const furnace::Mesh mesh = furnace::ThetaMesh({{-thetaO, std::sqrt(static_cast<double>(v))}});
    const T sinO = static_cast<T>(std::sin(thetaO)), cosO = static_cast<T>(std::cos(thetaO));
    double sum = 0;
    for (size_t i = 0; i < mesh.x.size(); ++i)
        sum += mesh.weight[i] * std::cos(mesh.x[i]) *
               static_cast<double>(as_printed::Mp(static_cast<T>(std::cos(mesh.x[i])), cosO,
                                                  static_cast<T>(std::sin(mesh.x[i])), sinO, v));
    return sum;
}

TEST(AsPrinted, MpDoesNotConserveEnergy) {
    double worst = 0;
    for (double theta = -1.5; theta < 1.5; theta += 0.02) // the three variances of the default roughness
        for (const double v : LongitudinalVariance(0.3))
            worst = std::max(worst, std::abs(PrintedMass(v, theta) - 1));
    std::printf("printed M_p at beta_m 0.3: |E - 1| up to %.4f\n", worst);
    EXPECT_GT(worst, 0.01);
    EXPECT_LT(worst, 0.03);
}

TEST(AsPrinted, MpCancelsInBinary32) {
    const auto off = [](float beta) {
        double worst = 0;
        const float v = UnscaledVariance(beta);
        for (int k = 0; k < 2800; ++k) {
            const double theta = -1.4 + 0.001 * k,
                         peak =
                             1 / std::sqrt(2 * std::numbers::pi * static_cast<double>(v)) / std::cos(theta);
            const float s = static_cast<float>(std::sin(theta)), c = static_cast<float>(std::cos(theta));
            worst = std::max(worst, std::abs(static_cast<double>(as_printed::Mp(c, c, -s, s, v)) / peak - 1));
        }
        return worst;
    };
    std::printf("printed M_p in binary32 at beta_m 0.005: peak off by %.3f\n", off(0.005f));
    EXPECT_GT(off(0.005f), 0.01);
    EXPECT_GT(off(1e-4f), 1);
    EXPECT_FALSE(std::isfinite(as_printed::Mp(1.f, 1.f, 0.f, 0.f, 0.f)));
}

// A tilt of theta_i after sampling does not keep cos theta d theta: the albedo of a white fiber leaves 1.
TEST(AsPrinted, TiltOfThetaILosesEnergy) {
    const struct {
        double degrees, albedo;
    } expected[] = {{45, 1.030}, {85, 0.871}, {89, 0.759}, {-45, 0.969}, {-85, 1.17}, {-89, 1.29}};
    const double pi = std::numbers::pi;
    for (const auto &e : expected) {
        const double thetaO = e.degrees * pi / 180;
        const HairLobes<double> lobes({0, 1.55f, {0, 0, 0}, 0.3f, 0.3f, 2, ScaleTilt::RootToTip});
        double m[kLobes] = {};
        const furnace::Mesh mesh = furnace::ThetaMesh({{-thetaO, 0.1}});
        for (size_t p = 0; p < kLobes; ++p)
            for (size_t i = 0; i < mesh.x.size(); ++i) {
                // Pharr's text: theta_i + tilt in M_p, cosine made positive, against theta_o as it is.
                const SinCosine<double> t =
                    Tilted(std::sin(mesh.x[i]), std::cos(mesh.x[i]), lobes.sinTilt[p], lobes.cosTilt[p]);
                m[p] += mesh.weight[i] * std::cos(mesh.x[i]) *
                        Mp(t.cos, std::cos(thetaO), t.sin, std::sin(thetaO), lobes.v[p]);
            }
        double albedo = 0;
        const int n = 500;
        for (int k = 0; k < n; ++k) {
            const HairLobes<double> hair({static_cast<float>(2 * (k + 0.5) / n - 1),
                                          1.55f,
                                          {0, 0, 0},
                                          0.3f,
                                          0.3f,
                                          2,
                                          ScaleTilt::RootToTip});
            const auto ap = hair.Attenuations({std::sin(thetaO), std::cos(thetaO), 0});
            for (size_t p = 0; p < kLobes; ++p)
                albedo += ap[p][0] * m[p] / n;
        }
        std::printf("tilt on theta_i, theta_o %g: albedo %.3f\n", e.degrees, albedo);
        EXPECT_NEAR(albedo, e.albedo, 0.01) << e.degrees;
    }
}

// The printed class, where it works, is the same model: alike to what its series and logarithms miss.
TEST(AsPrinted, AgreesWithTheModelToItsOwnErrors) {
    RNG rng(1);
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
        const float h = 1.9f * rng.UniformFloat() - 0.95f, betaM = 0.2f + 0.6f * rng.UniformFloat(),
                    betaN = 0.2f + 0.6f * rng.UniformFloat();
        const Spectrum sigma(0.3f, 0.6f, 0.9f);
        const as_printed::HairBSDF printed(h, 1.55f, sigma, betaM, betaN, 2, as_printed::Tilt::OnThetaO);
        const HairBSDF exact(h, 1.55f, sigma, betaM, betaN, 2, ScaleTilt::PbrtV3);
        const Vector3f wo = UniformSampleSphere({0.05f + 0.9f * rng.UniformFloat(), rng.UniformFloat()});
        const Vector3f wi = UniformSampleSphere({0.05f + 0.9f * rng.UniformFloat(), rng.UniformFloat()});
        const double pdf = static_cast<double>(exact.Pdf(wo, wi));
        if (pdf > 1e-3) {
            worst = std::max(worst, std::abs(static_cast<double>(printed.Pdf(wo, wi)) / pdf - 1));
            const double f = static_cast<double>(exact.f(wo, wi)[1]);
            worst = std::max(worst, std::abs(static_cast<double>(printed.f(wo, wi)[1]) / f - 1));
        }
    }
    std::printf("printed against exact: at most %.4f\n", worst);
    EXPECT_LT(worst, 0.021);
    EXPECT_GT(worst, 1e-3);
}

} // namespace
} // namespace cuticle
