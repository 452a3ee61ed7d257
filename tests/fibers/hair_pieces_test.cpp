// The pieces of the hair model, each by itself: angles, refraction, the trimmed logistic, the share of the
// last lobe.
#include "core/angles.h"
#include "core/error.h"
#include "core/sampling.h"
#include "fibers/hair_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace cuticle {
namespace {

constexpr float kEta = 1.55f;

TEST(HairModel, WrapsAnglesByRounding) {
    for (const double x : {0., 3., -3., 3.2, -3.2, 10., -10., 1e6}) {
        const double wrapped = WrapAngle(x);
        EXPECT_LE(std::abs(wrapped), std::numbers::pi);
        EXPECT_NEAR(std::sin(wrapped), std::sin(x), 1e-9) << x;
        EXPECT_NEAR(std::cos(wrapped), std::cos(x), 1e-9) << x;
    }
    EXPECT_TRUE(std::isnan(WrapAngle(std::numeric_limits<double>::infinity())));
    EXPECT_TRUE(std::isnan(WrapAngle(std::numeric_limits<float>::quiet_NaN())));
}
// The lobes turned as complex numbers are those turned by angles.
TEST(HairModel, TurnsOnTheCircleArePhi) {
    for (double h = -0.95; h < 1; h += 0.1)
        for (const double theta : {0., 0.8, 1.5}) {
            const Refraction<double> r =
                Refract(std::cos(theta), h, std::sqrt(1 - h * h), 1.55, 1.55 * 1.55 - 1);
            const PhiInPlane<double> turn = TurnsOfPaths(h, std::sqrt(1 - h * h), r);
            for (int p = 0; p < 3; ++p) {
                const double phi = Phi(p, std::asin(h), std::asin(r.SinGammaT()));
                const double c = turn.cos[static_cast<size_t>(p)], s = turn.sin[static_cast<size_t>(p)];
                EXPECT_NEAR(c / std::hypot(c, s), std::cos(phi), 1e-14);
                EXPECT_NEAR(s / std::hypot(c, s), std::sin(phi), 1e-14);
            }
        }
}
// The text's own formulas for refraction, where they hold.
TEST(HairModel, RefractionIsTheTextsInOtherTerms) {
    const double eta = 1.55, sigma = 0.7;
    for (double h = -0.9; h < 1; h += 0.2)
        for (double theta = -1.5; theta < 1.5; theta += 0.3) {
            const Refraction<double> r =
                Refract(std::cos(theta), h, std::sqrt(1 - h * h), eta, eta * eta - 1);
            const double etaPrime = std::sqrt(eta * eta - Sqr(std::sin(theta))) / std::cos(theta);
            const double cosThetaT = std::sqrt(1 - Sqr(std::sin(theta) / eta));
            EXPECT_NEAR(r.SinGammaT(), h / etaPrime, 1e-14);
            EXPECT_NEAR(r.length, 2 * std::sqrt(1 - Sqr(h / etaPrime)) / cosThetaT, 1e-13);
            const double t = std::exp(-sigma * r.length);
            const FresnelPair<double> f = Fresnel(r.cosIncident, r.t, eta);
            EXPECT_NEAR(f.f + f.oneMinusF, 1, 1e-14);
            const std::array<double, kLobes> ap = Ap(f.f, f.oneMinusF, t, 1 - t);
            EXPECT_NEAR(ap[2], Sqr(1 - f.f) * f.f * t * t, 1e-14);
            double rest = 0, term = Sqr(1 - f.f) * f.f * f.f * t * t * t;
            for (int p = 3; p < 3000; ++p)
                rest += term, term *= f.f * t;
            EXPECT_NEAR(ap[3], rest, 1e-13);
        }
}
// facts: at beta_n = 1 the logistic holds a third of its mass inside +-pi; trimmed it holds all.
TEST(HairModel, LogisticAtBetaNOneIsTrimmed) {
    const double s = AzimuthalScale(1.);
    EXPECT_NEAR(1 - LogisticTail(s), 0.35, 0.005);
    const int n = 100000;
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += TrimmedLogistic((2 * (i + 0.5) / n - 1) * std::numbers::pi, s, -std::numbers::pi,
                               std::numbers::pi);
    EXPECT_NEAR(sum * 2 * std::numbers::pi / n, 1, 1e-9);
}
TEST(HairModel, SampledLogisticInvertsItsDistribution) {
    for (const double s : {kMinS<double>, 0.01, 0.3, 4.28})
        for (const double u : {1e-9, 0.01, 0.3, 0.5, 0.7, 0.999, 1 - 1e-9}) {
            const double x = SampleTrimmedLogistic(u, s, LogisticTail(s));
            const double pi = std::numbers::pi;
            const double below =
                (LogisticCDF(x, s) - LogisticCDF(-pi, s)) / (LogisticCDF(pi, s) - LogisticCDF(-pi, s));
            EXPECT_NEAR(below, u, 1e-12) << s;
        }
    EXPECT_FLOAT_EQ(SampleTrimmedLogistic(0.f, 4.28f, LogisticTail(4.28f)), -Pi);
}
// facts, row 12: what one lobe for all p >= 3 holds of a white fiber, over its width.
TEST(HairModel, ShareOfTheLastLobe) {
    const struct { double degrees, share; } expected[] = {{0, 0.008}, {60, 0.027}, {85, 0.14}};
    for (const auto &e : expected) {
        double sum = 0;
        const int n = 2000;
        for (int i = 0; i < n; ++i) {
            const HairLobes<double> hair({static_cast<float>(2 * (i + 0.5) / n - 1),
                                          kEta,
                                          {0, 0, 0},
                                          0.3f,
                                          0.3f,
                                          2,
                                          ScaleTilt::RootToTip});
            sum +=
                hair.Attenuations({std::sin(Radians(e.degrees)), std::cos(Radians(e.degrees)), 0})[3][0] / n;
        }
        std::printf("p >= 3 at %g degrees: %.4f\n", e.degrees, sum);
        EXPECT_NEAR(sum / e.share, 1, 0.1) << e.degrees;
    }
}
// facts, row 16: A depends on theta_o alone, so the model is not reciprocal. How much is a number to know.
TEST(HairModel, AttenuationIsNotReciprocal) {
    const HairLobes<double> hair({0, kEta, {1, 1, 1}, 0.3f, 0.3f, 0, ScaleTilt::RootToTip});
    const double ratio = hair.Attenuations({std::sin(Radians(60.)), std::cos(Radians(60.)), 0})[1][0] /
                         hair.Attenuations({0, 1, 0})[1][0];
    std::printf("A_TT at 60 degrees over A_TT at 0: %.3f\n", ratio);
    EXPECT_NEAR(ratio, 0.59, 0.005);
}

} // namespace
} // namespace cuticle
