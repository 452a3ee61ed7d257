// The hair model's laws: one number out of each promise that hair.h makes.
#include "fibers/hair.h"

#include "core/angles.h"
#include "core/error.h"
#include "core/sampling.h"
#include "fibers/every_kernel.h"
#include "fibers/hair_as_printed.h"
#include "fibers/hair_model.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace cuticle {
namespace {

constexpr float kEta = 1.55f;
const float kNaN = std::numeric_limits<float>::quiet_NaN();

class Hair : public EveryKernel {};
CUTICLE_WITH_EVERY_KERNEL(Hair);

Vector3f Direction(double theta, double phi) {
    return {static_cast<float>(std::sin(theta)), static_cast<float>(std::cos(theta) * std::cos(phi)),
            static_cast<float>(std::cos(theta) * std::sin(phi))};
}

bool Sane(const Spectrum &f, float pdf) {
    return f.IsFinite() && f[0] >= 0 && f[1] >= 0 && f[2] >= 0 && std::isfinite(pdf) && pdf >= 0;
}

// Numbers as a sampler draws them, and u = 0 and the largest u among them.
std::array<float, 4> RandomU(RNG &rng) {
    std::array<float, 4> u;
    for (float &x : u) {
        const uint32_t kind = rng.UniformUInt32() % 64;
        x = kind == 0 ? 0.f : kind == 1 ? OneMinusEpsilon : kind == 2 ? 0.5f : rng.UniformFloat();
    }
    return u;
}
Vector3f RandomDirection(RNG &rng) { return UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()}); }

// ---- sampling ---------------------------------------------------------------------------------------------

// Every sample of a fiber that absorbs nothing weighs 1, whatever its lobes and tilts are.
TEST_P(Hair, SamplingWeights) {
    RNG rng(1);
    double worst = 0;
    size_t n = 0;
    for (const float beta : {0.f, 1e-4f, 1e-3f, 0.01f, 0.05f, 0.1f, 0.3f, 0.6f, 1.f})
        for (const float betaN : {0.f, 1e-4f, 1e-3f, 0.01f, 0.1f, 0.3f, 1.f})
            for (const float alpha : {0.f, 2.f, 10.f})
                for (int i = 0; i < 400; ++i, ++n) {
                    const float h = i % 50 == 0 ? 1.f : i % 50 == 1 ? -1.f : 2 * rng.UniformFloat() - 1;
                    const HairBSDF hair(h, kEta, Spectrum(0.f), beta, betaN, alpha);
                    const Vector3f wo = i % 20 == 2 ? Direction(Radians(89.9), i) : RandomDirection(rng);
                    Vector3f wi;
                    float pdf = 0;
                    const Spectrum f =
                        i % 2 == 0
                            ? hair.Sample_f(wo, &wi, RandomU(rng), &pdf)
                            : hair.Sample_f(wo, &wi, Point2f{rng.UniformFloat(), rng.UniformFloat()}, &pdf);
                    ASSERT_GT(pdf, 0) << hair.ToString();
                    const double weight = static_cast<double>(f[0]) * std::abs(static_cast<double>(wi.z)) /
                                          static_cast<double>(pdf);
                    worst = std::max(worst, std::abs(weight - 1));
                    ASSERT_NEAR(weight, 1, 1e-4) << hair.ToString() << " wo " << wo << " wi " << wi;
                }
    std::printf("sampled weights, %s: max |weight - 1| = %.3g, n = %zu\n", GetParam().c_str(), worst, n);
}

// f and pdf of Sample_f are those of the direction that it returns, up to what the rounding of that
// direction, 2e-7, moves: an angle of d changes a logistic by d / s, a longitudinal lobe by d (distance from
// its centre) / v.
TEST_P(Hair, SampleAgreesWithFAndPdf) {
    RNG rng(2);
    for (const float beta : {0.01f, 0.05f, 0.1f, 0.3f, 0.6f, 1.f})
        for (const float betaN : {0.01f, 0.05f, 0.1f, 0.3f, 1.f})
            for (int i = 0; i < 300; ++i) {
                const float h = 2 * rng.UniformFloat() - 1;
                const HairBSDF hair(h, kEta, Spectrum(0.2f, 0.5f, 1.f), beta, betaN, 2);
                const Vector3f wo = RandomDirection(rng);
                Vector3f wi;
                float pdf = 0, again = 0;
                const Spectrum f = hair.Sample_f(
                    wo, &wi, {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()},
                    &pdf);
                ASSERT_NEAR(wi.Length(), 1, 5e-7);
                const Spectrum fAgain = hair.FPdf(wo, wi, &again);
                const double s = AzimuthalScale(static_cast<double>(betaN));
                const double sigma = std::sqrt(UnscaledVariance(static_cast<double>(beta))) / 2;
                const double cosI = std::hypot(static_cast<double>(wi.y), static_cast<double>(wi.z));
                const double bound = 1e-5 + 2e-7 / cosI / s + 2e-7 * 8 / sigma;
                ASSERT_NEAR(pdf / static_cast<double>(again), 1, bound) << hair.ToString() << wo << wi;
                const double inZ = 2e-7 / std::abs(static_cast<double>(wi.z)); // f is divided by |wi.z|
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(f[c] / static_cast<double>(fAgain[c]), 1, bound + inZ)
                        << hair.ToString() << wo << wi;
                ASSERT_EQ(hair.f(wo, wi), fAgain);
                ASSERT_EQ(hair.Pdf(wo, wi), again);
            }
}

// Radiance reflected from a sky that varies, estimated with importance sampling and uniformly: both within
// four standard errors of their difference.
TEST_P(Hair, ImportanceAgreesWithUniformSampling) {
    const int side = 24, n = side * side * side * side;
    for (const float beta : {0.25f, 0.4f, 0.6f, 0.9f}) {
        const Vector3f wo = Direction(0.4 + static_cast<double>(beta), 1);
        double sum[2] = {}, squares[2] = {};
        RNG rng(5);
        for (int i = 0; i < n; ++i) {
            // Four strata, one for each number.
            std::array<float, 4> u;
            int rest = i;
            for (float &x : u)
                x = (static_cast<float>(rest % side) + rng.UniformFloat()) / side, rest /= side;
            const float h = 2 * rng.UniformFloat() - 1;
            const HairBSDF hair(h, kEta, Spectrum(0.25f), beta, beta, 2);
            const auto sky = [](const Vector3f &w) { return static_cast<double>(1 + w.x + w.z * w.z); };
            Vector3f wi;
            float pdf = 0;
            const Spectrum f = hair.Sample_f(wo, &wi, u, &pdf);
            const double importance =
                pdf > 0 ? static_cast<double>(f[1] * std::abs(wi.z) / pdf) * sky(wi) : 0;
            const Vector3f uniform = UniformSampleSphere({u[0], u[1]});
            const double plain = static_cast<double>(hair.f(wo, uniform)[1] * std::abs(uniform.z)) * 4 *
                                 std::numbers::pi * sky(uniform);
            sum[0] += importance, squares[0] += importance * importance;
            sum[1] += plain, squares[1] += plain * plain;
        }
        double mean[2], variance[2];
        for (int k = 0; k < 2; ++k)
            mean[k] = sum[k] / n, variance[k] = (squares[k] / n - mean[k] * mean[k]) / n;
        EXPECT_NEAR(mean[0], mean[1], 4 * std::sqrt(variance[0] + variance[1]))
            << "beta " << beta << " n " << n;
        EXPECT_LT(std::sqrt(variance[0]) / mean[0], 2e-3) << "too noisy to test anything";
        EXPECT_LT(std::sqrt(variance[1]) / mean[1], 2e-2) << "too noisy to test anything";
        if (beta < 0.5f) { // a wide lobe under a smooth sky is as well served uniformly
            EXPECT_LT(variance[0], variance[1]) << "importance sampling must pay";
        }
    }
}

// ---- accuracy ---------------------------------------------------------------------------------------------

template <typename T>
typename HairLobes<T>::Value Evaluate(const HairParameters &parameters, const Vector3f &wo,
                                      const Vector3f &wi) {
    return HairLobes<T>(parameters).Evaluate(Vector3<T>(wo), Vector3<T>(wi));
}

// The lanes against long double, at the same binary32 directions, for values down to 1e-6 of a uniform
// scatterer.
TEST_P(Hair, KernelsAgreeWithLongDouble) {
    RNG rng(7);
    double worst = 0;
    std::string where;
    const int n = 100000;
    int used = 0;
    for (int i = 0; i < n; ++i) {
        const HairParameters parameters = {
            2 * rng.UniformFloat() - 1,
            1.1f + rng.UniformFloat(),
            {rng.UniformFloat(), 3 * rng.UniformFloat(), 0.1f * rng.UniformFloat()},
            0.1f + 0.9f * rng.UniformFloat(),
            0.1f + 0.9f * rng.UniformFloat(),
            20 * rng.UniformFloat() - 10,
            ScaleTilt::RootToTip};
        const Vector3f wo = RandomDirection(rng), wi = RandomDirection(rng);
        const HairLobes<long double>::Value exact = Evaluate<long double>(parameters, wo, wi);
        HairSetup setup;
        CurrentHairKernels().setUp(parameters, setup);
        const HairValue value = CurrentHairKernels().evaluate(setup, wo, wi);
        if (exact.pdf < 1e-6L)
            continue;
        ++used;
        double error = std::abs(static_cast<double>(static_cast<long double>(value.pdf) / exact.pdf - 1));
        for (size_t c = 0; c < 3; ++c)
            error = std::max(error, std::abs(static_cast<double>(
                                        static_cast<long double>(value.fCos[c]) / exact.fCos[c] - 1)));
        if (!(error <= worst))
            worst = error, where = HairBSDF(parameters.h, parameters.eta, Spectrum(0.f), parameters.betaM,
                                            parameters.betaN, parameters.alpha)
                                       .ToString();
    }
    std::printf("%s against long double: max relative error %.3g over %d of %d values\n", GetParam().c_str(),
                worst, used, n);
    EXPECT_GT(used, n / 2);
    EXPECT_LE(worst, 2e-5) << where;
}

// A tilt of any finite size gives every set of kernels the value of long double, within what rounding the
// lobe's angle to a float of half a turn moves it, 2^-25 turns, beside the rounding of the directions.
TEST_P(Hair, HugeTiltsAreTheSameInEveryKernel) {
    RNG rng(11);
    double worst = 0, worstSample = 0;
    for (int i = 0; i < 30000; ++i) {
        float alpha = 1e2f * std::exp(rng.UniformFloat() * std::log(3.4e36f));
        if (i % 16 == 0)
            alpha = std::array{
                100.f, 359.99997f, 360.f, 45.f, 3.4e38f, std::numeric_limits<float>::max()}[i / 16 % 6];
        const HairParameters parameters = {2 * rng.UniformFloat() - 1,
                                           1.1f + rng.UniformFloat(),
                                           {0.3f, 0.1f, 1},
                                           0.1f + 0.9f * rng.UniformFloat(),
                                           0.1f + 0.9f * rng.UniformFloat(),
                                           i % 2 ? alpha : -alpha,
                                           i % 3 ? ScaleTilt::RootToTip : ScaleTilt::PbrtV3};
        const double sigma = std::sqrt(UnscaledVariance(double{parameters.betaM})) / 2;
        const double turned = 2 * std::numbers::pi * 0x1p-25 * 6 / sigma; // six widths from a lobe's centre
        const Vector3f wo = RandomDirection(rng);
        const auto error = [&](const HairValue &value, const Vector3f &wi) {
            EXPECT_TRUE(Sane(Spectrum(value.fCos[0], value.fCos[1], value.fCos[2]), value.pdf)) << alpha;
            const HairLobes<long double>::Value exact = Evaluate<long double>(parameters, wo, wi);
            if (exact.pdf < 1e-6L)
                return 0.;
            double e = std::abs(double(value.pdf / exact.pdf) - 1);
            for (size_t c = 0; c < 3; ++c)
                e = std::max(e, std::abs(double(value.fCos[c] / exact.fCos[c]) - 1));
            return e;
        };
        HairSetup setup;
        CurrentHairKernels().setUp(parameters, setup);
        Vector3f wi = RandomDirection(rng);
        worst = std::max(worst, error(CurrentHairKernels().evaluate(setup, wo, wi), wi) / (2e-5 + turned));
        const HairValue value = CurrentHairKernels().sample(setup, wo, RandomU(rng), &wi);
        ASSERT_NEAR(wi.Length(), 1, 1e-6) << alpha;
        const double cosI = std::hypot(double{wi.y}, double{wi.z}),
                     s = AzimuthalScale(double{parameters.betaN});
        const double moved = 2e-7 / cosI / s + 2e-7 * 8 / sigma; // as in SampleAgreesWithFAndPdf
        worstSample = std::max(worstSample, error(value, wi) / (2e-5 + turned + moved));
    }
    std::printf("%s, huge tilts: error %.3f of its bound, of samples %.3f\n", GetParam().c_str(), worst,
                worstSample);
    EXPECT_LE(worst, 1);
    EXPECT_LE(worstSample, 1);
}

// Narrow lobes: relative to what moving a direction by its own rounding, 6e-8, does to the value.
TEST_P(Hair, NarrowLobesAreAsGoodAsTheirDirections) {
    RNG rng(8);
    double worst = 0;
    for (int i = 0; i < 30000; ++i) {
        const float betaM = std::pow(10.f, -4 + 3 * rng.UniformFloat()),
                    betaN = std::pow(10.f, -4 + 3 * rng.UniformFloat());
        const HairParameters parameters = {
            2 * rng.UniformFloat() - 1, kEta, {0.1f, 0.2f, 0.3f}, betaM, betaN, 2, ScaleTilt::RootToTip};
        const Vector3f wo = Direction(Radians(160. * static_cast<double>(rng.UniformFloat()) - 80), 7.);
        HairSetup setup;
        CurrentHairKernels().setUp(parameters, setup);
        Vector3f wi;
        CurrentHairKernels().sample(
            setup, wo,
            {rng.UniformFloat(), rng.UniformFloat(), 0.02f + rng.UniformFloat(), rng.UniformFloat()}, &wi);
        const HairValue value = CurrentHairKernels().evaluate(setup, wo, wi);
        const double exact = static_cast<double>(Evaluate<long double>(parameters, wo, wi).pdf);
        const double cosI = std::hypot(static_cast<double>(wi.y), static_cast<double>(wi.z));
        const double cosO = std::hypot(static_cast<double>(wo.y), static_cast<double>(wo.z));
        const double sigma =
            std::sqrt(std::max(UnscaledVariance(static_cast<double>(betaM)) / 4, kMinV<double>));
        const double movement =
            6e-8 / std::min(cosI, cosO) / AzimuthalScale(static_cast<double>(betaN)) + 6e-8 * 4 / sigma;
        worst = std::max(worst, std::abs(static_cast<double>(value.pdf) / exact - 1) / (1e-6 + movement));
    }
    std::printf("%s, narrow lobes: error at most %.2f times the effect of one rounding\n", GetParam().c_str(),
                worst);
    EXPECT_LE(worst, 8);
}

TEST(HairModel, ScalarTypesAgreeToTheirPrecision) {
    RNG rng(9);
    double worstFloat = 0, worstDouble = 0;
    for (int i = 0; i < 20000; ++i) {
        const HairParameters parameters = {
            2 * rng.UniformFloat() - 1,       kEta, {0.1f, 0.5f, 2.f},   0.1f + 0.9f * rng.UniformFloat(),
            0.1f + 0.9f * rng.UniformFloat(), 2,    ScaleTilt::RootToTip};
        const Vector3f wo = RandomDirection(rng), wi = RandomDirection(rng);
        const long double exact = Evaluate<long double>(parameters, wo, wi).pdf;
        if (exact < 1e-6L)
            continue;
        worstFloat = std::max(
            worstFloat, static_cast<double>(std::abs(Evaluate<float>(parameters, wo, wi).pdf / exact - 1)));
        worstDouble = std::max(
            worstDouble, static_cast<double>(std::abs(Evaluate<double>(parameters, wo, wi).pdf / exact - 1)));
    }
    std::printf("against long double: float %.3g, double %.3g\n", worstFloat, worstDouble);
    EXPECT_LE(worstFloat, 2e-5);
    EXPECT_LE(worstDouble, 2e-14);
}

// ---- the scales -------------------------------------------------------------------------------------------

// Finds theta_i at which f cos of a black fiber, all of it R, peaks: at theta_i + theta_o = -2 alpha, toward
// the root.
double PeakOfR(ScaleTilt tilt, double thetaO, float alpha) {
    const HairBSDF hair(0, kEta, Spectrum(1e4f), 0.02f, 0.3f, alpha, tilt);
    double best = 0, at = 0;
    for (double thetaI = -1.4; thetaI < 1.4; thetaI += 1e-4) {
        float pdf = 0;
        hair.FPdf(Direction(thetaO, 1), Direction(thetaI, 1), &pdf);
        if (static_cast<double>(pdf) > best)
            best = static_cast<double>(pdf), at = thetaI;
    }
    return at;
}
TEST_P(Hair, ScalesTiltTheHighlightTowardTheRoot) {
    for (const double thetaO : {-0.7, 0., 0.5})
        for (const float alpha : {2.f, 10.f}) {
            const double shift = 2 * Radians(static_cast<double>(alpha));
            EXPECT_NEAR(PeakOfR(ScaleTilt::RootToTip, thetaO, alpha) + thetaO, -shift, 1e-3);
            EXPECT_NEAR(PeakOfR(ScaleTilt::PbrtV3, thetaO, alpha) + thetaO, shift, 1e-3);
        }
}
TEST(HairModel, ScalesTiltTTAndTRTTowardTheTip) {
    const HairLobes<double> hair({0, kEta, {0, 0, 0}, 0.05f, 0.3f, 3, ScaleTilt::RootToTip});
    const double thetaO = 0.2;
    for (const size_t p : {0u, 1u, 2u, 3u}) {
        double best = 0, at = 0;
        for (double thetaI = -1; thetaI < 1; thetaI += 1e-4) {
            const double m =
                hair.Longitudinal(p, std::sin(thetaO), std::cos(thetaO), std::sin(thetaI), std::cos(thetaI));
            if (m > best)
                best = m, at = thetaI;
        }
        const double expected[] = {-6, 3, 12, 0};
        EXPECT_NEAR(at + thetaO, Radians(expected[p]), 3e-3)
            << p; // near 0.2 the peak of a wide lobe lies a little further out
    }
}
// Pharr's text gives alpha in degrees and its listing takes the sine of that number. R is turned by 2 alpha:
// the listing read literally would turn it by 2 radians for each degree.
TEST(HairModel, AlphaIsInDegrees) {
    for (const float alpha : {2.f, 3.f, 30.f}) {
        const HairLobes<double> hair({0, kEta, {0, 0, 0}, 0.3f, 0.3f, alpha, ScaleTilt::RootToTip});
        const double degrees = static_cast<double>(alpha);
        EXPECT_NEAR(std::abs(hair.sinTilt[0]), std::sin(2 * degrees * kPi<double> / 180), 1e-12);
        EXPECT_NEAR(hair.cosTilt[0], std::cos(2 * degrees * kPi<double> / 180), 1e-12);
        EXPECT_GT(std::abs(std::abs(hair.sinTilt[0]) - std::abs(std::sin(2 * degrees))), 0.1);
    }
}
TEST(HairModel, AlphaOfManyTurnsIsReduced) {
    for (const float alpha : {3.f, -40.f}) {
        const HairLobes<double> a({0, kEta, {0, 0, 0}, 0.3f, 0.3f, alpha, ScaleTilt::RootToTip});
        const HairLobes<double> b({0, kEta, {0, 0, 0}, 0.3f, 0.3f, alpha + 3600, ScaleTilt::RootToTip});
        for (size_t p = 0; p < kLobes; ++p) {
            EXPECT_NEAR(a.sinTilt[p], b.sinTilt[p], 1e-12);
            EXPECT_NEAR(a.cosTilt[p], b.cosTilt[p], 1e-12);
        }
    }
}

// ---- the edges of the model -------------------------------------------------------------------------------

// facts: h = +-1 with sigma_a = 0 makes the tail of A_p 0/0.
TEST_P(Hair, HOnTheEdge) {
    for (const float h : {-1.f, 1.f, -2.f, std::nextafter(1.f, 0.f)})
        for (const float sigma : {0.f, 1.f, 1e18f}) {
            const HairBSDF hair(h, kEta, Spectrum(sigma), 0.3f, 0.3f, 2);
            RNG rng(1);
            for (int i = 0; i < 1000; ++i) {
                Vector3f wi;
                float pdf = 0;
                const Vector3f wo = RandomDirection(rng);
                const Spectrum f = hair.Sample_f(wo, &wi, RandomU(rng), &pdf);
                ASSERT_TRUE(Sane(f, pdf) && pdf > 0) << hair.ToString() << wo;
            }
        }
    const auto ap =
        HairLobes<float>({1, kEta, {0, 0, 0}, 0.3f, 0.3f, 2, ScaleTilt::RootToTip}).Attenuations({0, 1, 0});
    EXPECT_FLOAT_EQ(ap[0][0] + ap[1][0] + ap[2][0] + ap[3][0], 1);
    EXPECT_NEAR(ap[0][0], 1, 1e-6) << "at the edge all is reflected";
}

// facts: at cos theta = 0 eta' is infinite, and the azimuth has no meaning.
TEST_P(Hair, GrazingCosThetaZero) {
    const Vector3f along[] = {{1, 0, 0}, {-1, 0, 0}, {1, 0, -0.f}, {1, 1e-30f, 0}, {1, 0, 1e-12f}};
    for (const Vector3f &wo : along)
        for (const float eta : {kEta, 1.f, 0.7f})
            for (const float h : {-1.f, 0.f, 0.4f, 1.f})
                for (const float sigma : {0.f, 1.f})
                    for (const float beta : {0.f, 0.01f, 0.3f, 1.f}) {
                        const HairBSDF hair(h, eta, Spectrum(sigma), beta, beta, 2);
                        RNG rng(3);
                        for (const Vector3f &wi : along) {
                            float pdf = 0;
                            const Spectrum f = hair.FPdf(wo, wi, &pdf);
                            ASSERT_TRUE(Sane(f, pdf)) << hair.ToString() << wo << wi << f << pdf;
                        }
                        for (int i = 0; i < 20; ++i) {
                            Vector3f wi;
                            float pdf = 0;
                            const Spectrum f = hair.Sample_f(wo, &wi, RandomU(rng), &pdf);
                            ASSERT_TRUE(Sane(f, pdf)) << hair.ToString() << wo << wi << f << pdf;
                            if (sigma == 0) {
                                ASSERT_NEAR(f[0] * std::abs(wi.z) / pdf, 1, 1e-4) << hair.ToString() << wo;
                            }
                        }
                    }
}

// beta_m = 0 is a cone of standard deviation 2^-15 rad about the mirror direction, and stays one through TT.
TEST_P(Hair, BetaMZeroIsADeltaCone) {
    RNG rng(4);
    const HairBSDF hair(0.3f, kEta, Spectrum(0.f), 0, 0.3f, 0);
    const double thetaO = 0.6;
    double squares = 0;
    const int n = 100000;
    for (int i = 0; i < n; ++i) {
        Vector3f wi;
        float pdf = 0;
        hair.Sample_f(Direction(thetaO, 1), &wi,
                      {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
        const double thetaI = std::atan2(static_cast<double>(wi.x),
                                         std::hypot(static_cast<double>(wi.y), static_cast<double>(wi.z)));
        ASSERT_NEAR(thetaI, -thetaO, 8 * std::sqrt(kMinV<double>));
        squares += Sqr(thetaI + thetaO) / kMinV<double>;
    }
    // The mean square of n normal numbers is 1 +- 5 sqrt(2 / n); the rounding of wo and wi moves it by 1e-3
    // at most.
    EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2. / n) + 1e-3);
}
TEST_P(Hair, BetaNZeroIsANarrowLogistic) {
    RNG rng(5);
    const HairParameters parameters = {0.3f, kEta, {1e6f, 1e6f, 1e6f},  0.3f,
                                       0,    0,    ScaleTilt::RootToTip}; // R alone
    const HairBSDF hair(0.3f, kEta, Spectrum(1e6f), 0.3f, 0, 0);
    double sum = 0;
    const int n = 100000;
    const double phiR = -2 * std::asin(static_cast<double>(parameters.h)), s = kMinS<double>;
    for (int i = 0; i < n; ++i) {
        Vector3f wi;
        float pdf = 0;
        hair.Sample_f(Direction(0.2, 1), &wi,
                      {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
        const double off =
            std::remainder(std::atan2(static_cast<double>(wi.z), static_cast<double>(wi.y)) - 1 - phiR,
                           2 * std::numbers::pi);
        ASSERT_LE(std::abs(off), 40 * s);
        sum += std::abs(off) / s;
    }
    // The mean of |x| of a logistic is 2 ln 2 s, its standard deviation 1.2 s.
    EXPECT_NEAR(sum / n, 2 * std::numbers::ln2, 5 * 1.2 / std::sqrt(static_cast<double>(n)) + 1e-2);
}
// facts: 1 + v log(...) rounds to 1 in narrow lobes. The mean of the sampled cosine's distance from 1 is v.
TEST(HairModel, SampledCosineKeepsNarrowLobes) {
    for (const float v : {kMinV<float>, 1e-7f, 1e-4f, 0.01f, 1.f, 100.f}) {
        double mean = 0;
        const int n = 100000;
        for (int i = 0; i < n; ++i)
            mean -= static_cast<double>(SampleMpCosine((static_cast<float>(i) + 0.5f) / n, v)) / n;
        const double exact = 1 + static_cast<double>(v) - 1 / std::tanh(1 / static_cast<double>(v));
        EXPECT_NEAR(mean / exact, 1, 2e-4) << "v " << v << " n " << n;
        EXPECT_GE(SampleMpCosine(0.f, v), -2.f);
        EXPECT_LE(SampleMpCosine(OneMinusEpsilon, v), 0.f);
    }
}
TEST_P(Hair, EtaOneReflectsNothing) {
    RNG rng(6);
    const HairLobes<float> lobes({0.4f, 1, {0.5f, 0.5f, 0.5f}, 0.3f, 0.3f, 2, ScaleTilt::RootToTip});
    const auto ap = lobes.Attenuations(Direction(0.5, 1));
    EXPECT_EQ(ap[0][0], 0);
    EXPECT_EQ(ap[2][0], 0);
    EXPECT_EQ(ap[3][0], 0);
    // Straight through: a chord of 2 cos gamma radii, longer by 1 / cos theta.
    EXPECT_NEAR(ap[1][0], std::exp(-0.5 * 2 * std::sqrt(1 - 0.16) / std::cos(0.5)), 1e-6);
    for (const float h : {-1.f, 0.f, 1.f}) {
        const HairBSDF hair(h, 1, Spectrum(0.f), 0.3f, 0.3f, 2);
        for (int i = 0; i < 100; ++i) {
            Vector3f wi;
            float pdf = 0;
            const Spectrum f = hair.Sample_f(RandomDirection(rng), &wi, RandomU(rng), &pdf);
            ASSERT_NEAR(f[0] * std::abs(wi.z) / pdf, 1, 1e-4) << hair.ToString();
        }
    }
}
// facts: eta = 1 with large sigma_a: the sum of A_p is 0 and a density would be 0/0.
TEST_P(Hair, EtaOneBlackFiberHasNoDirection) {
    RNG rng(7);
    const HairBSDF hair(0.1f, 1, Spectrum(1e6f), 0.3f, 0.3f, 2);
    for (int i = 0; i < 100; ++i) {
        const Vector3f wo = RandomDirection(rng);
        Vector3f wi;
        float pdf = 1;
        EXPECT_TRUE(hair.Sample_f(wo, &wi, RandomU(rng), &pdf).IsBlack());
        EXPECT_EQ(pdf, 0);
        EXPECT_EQ(hair.Pdf(wo, RandomDirection(rng)), 0);
    }
}
// A fiber thinner than its surroundings: beyond the critical angle all is R, before it energy is kept too.
TEST_P(Hair, EtaBelowOneReflectsTotally) {
    RNG rng(8);
    for (const float eta : {1e-3f, 0.5f, 0.9f, 0.999f})
        for (const double theta : {0., 0.5, 1.5})
            for (const float h : {-1.f, -0.6f, 0.f, 0.95f}) {
                const HairLobes<float> lobes({h, eta, {0, 0, 0}, 0.3f, 0.3f, 2, ScaleTilt::RootToTip});
                const auto ap = lobes.Attenuations(Direction(theta, 1));
                EXPECT_NEAR(ap[0][0] + ap[1][0] + ap[2][0] + ap[3][0], 1, 1e-6);
                const double sinSquared =
                    1 - Sqr(std::cos(theta)) * (1 - static_cast<double>(h) * static_cast<double>(h));
                if (sinSquared > Sqr(static_cast<double>(eta)) * 1.0001) {
                    EXPECT_FLOAT_EQ(ap[0][0], 1) << eta << " " << theta << " " << h;
                }
                const HairBSDF hair(h, eta, Spectrum(0.f), 0.3f, 0.3f, 2);
                for (int i = 0; i < 50; ++i) {
                    Vector3f wi;
                    float pdf = 0;
                    const Spectrum f = hair.Sample_f(Direction(theta, 1), &wi, RandomU(rng), &pdf);
                    ASSERT_NEAR(f[0] * std::abs(wi.z) / pdf, 1, 1e-4) << hair.ToString();
                }
            }
}
// Just inside the critical angle TRT turns by a vector whose square underflows: u near 1 may still choose it.
TEST_P(Hair, NearTotalReflectionDirectionsAreUnit) {
    for (int i = -2000; i < 2000; ++i) {
        const auto x = static_cast<float>(i);
        const float sinO = 1e-3f * (1 + 1e-7f * (x * x * x) * 1e-5f);
        const Vector3f wo = Normalize(Vector3f(sinO, 0.96f, -0.28f));
        for (const float u : {0.f, 0.5f, OneMinusEpsilon}) {
            const HairBSDF hair(0, 1e-3f, Spectrum(8.f, 0.f, 0.6f), 1, 0.5f, 6);
            Vector3f wi;
            float pdf = 0;
            const Spectrum f = hair.Sample_f(wo, &wi, {u, 0.3f, 0.2f, 0.7f}, &pdf);
            ASSERT_TRUE(Sane(f, pdf) && IsFinite(wi)) << sinO << wi;
            ASSERT_NEAR(wi.Length(), 1, 1e-6) << sinO << wi;
        }
    }
}
// facts: u = 0 gave density 0 at beta_n <= 0.1, and a direction that is then lost.
TEST_P(Hair, RandomNumbersAtTheEndsHaveADensity) {
    for (const float beta : {0.f, 0.01f, 0.1f, 0.3f, 1.f})
        for (const float a : {0.f, 0.5f, OneMinusEpsilon, 1.f})
            for (const float b : {0.f, 0.5f, OneMinusEpsilon, 1.f})
                for (const float c : {0.f, 0.5f, OneMinusEpsilon, 1.f})
                    for (const float d : {0.f, 0.5f, OneMinusEpsilon, 1.f}) {
                        const HairBSDF hair(0.3f, kEta, Spectrum(0.1f), beta, beta, 2);
                        Vector3f wi;
                        float pdf = 0;
                        const Spectrum f = hair.Sample_f(Direction(0.3, 1), &wi, {a, b, c, d}, &pdf);
                        ASSERT_TRUE(Sane(f, pdf) && pdf > 0)
                            << a << " " << b << " " << c << " " << d << hair.ToString();
                    }
}
TEST_P(Hair, RoughnessOutOfRangeIsClamped) {
    const Vector3f wo = Direction(0.3, 1), wi = Direction(-0.2, 2);
    const auto f = [&](float m, float n) { return HairBSDF(0.3f, kEta, Spectrum(1.f), m, n, 2).f(wo, wi); };
    EXPECT_EQ(f(1.5f, 2.f), f(1, 1));
    EXPECT_EQ(f(-1, -Infinity), f(0, 0));
    EXPECT_EQ(HairBSDF(0.3f, kEta, Spectrum(-1.f), 0.3f, 0.3f, 2).f(wo, wi),
              HairBSDF(0.3f, kEta, Spectrum(0.f), 0.3f, 0.3f, 2).f(wo, wi));
}
TEST_P(Hair, NaNParametersAreRefused) {
    const Spectrum sigma(1.f);
    EXPECT_THROW(HairBSDF(kNaN, kEta, sigma, 0.3f, 0.3f, 2), Error);
    EXPECT_THROW(HairBSDF(0, kNaN, sigma, 0.3f, 0.3f, 2), Error);
    EXPECT_THROW(HairBSDF(0, Infinity, sigma, 0.3f, 0.3f, 2), Error);
    EXPECT_THROW(HairBSDF(0, kEta, Spectrum(1, kNaN, 1), 0.3f, 0.3f, 2), Error);
    EXPECT_THROW(HairBSDF(0, kEta, sigma, kNaN, 0.3f, 2), Error);
    EXPECT_THROW(HairBSDF(0, kEta, sigma, 0.3f, kNaN, 2), Error);
    EXPECT_THROW(HairBSDF(0, kEta, sigma, 0.3f, 0.3f, kNaN), Error);
    EXPECT_THROW(HairBSDF(0, kEta, sigma, 0.3f, 0.3f, Infinity), Error);
    EXPECT_NO_THROW(HairBSDF(0, kEta, Spectrum(Infinity), 0.3f, 0.3f, 2));
}
// NaN is never turned into a number: it comes back, to be counted.
TEST_P(Hair, NaNDirectionsComeBackAsNaN) {
    const HairBSDF hair(0.3f, kEta, Spectrum(1.f), 0.3f, 0.3f, 2);
    for (const float bad : {kNaN, Infinity})
        for (int axis = 0; axis < 3; ++axis) {
            Vector3f wrong = Direction(0.3, 1);
            wrong[axis] = bad;
            for (const bool first : {true, false}) {
                float pdf = 0;
                const Spectrum f = first ? hair.FPdf(wrong, Direction(0.1, 2), &pdf)
                                         : hair.FPdf(Direction(0.1, 2), wrong, &pdf);
                EXPECT_TRUE(f.HasNaNs() && std::isnan(pdf)) << bad << axis << first << f << pdf;
            }
            Vector3f wi;
            float pdf = 0;
            EXPECT_TRUE(hair.Sample_f(wrong, &wi, {0.1f, 0.2f, 0.3f, 0.4f}, &pdf).HasNaNs());
            EXPECT_TRUE(std::isnan(pdf) && std::isnan(wi.x));
        }
    for (size_t k = 0; k < 4; ++k) {
        std::array<float, 4> u = {0.1f, 0.2f, 0.3f, 0.4f};
        u[k] = kNaN;
        Vector3f wi;
        float pdf = 0;
        EXPECT_TRUE(hair.Sample_f(Direction(0.1, 2), &wi, u, &pdf).HasNaNs());
        EXPECT_TRUE(std::isnan(pdf));
    }
}
// f is finite and its product with |wi.z| smooth where the light lies in the plane of the ribbon.
TEST_P(Hair, LightInThePlaneOfTheRibbon) {
    const HairBSDF hair(0.3f, kEta, Spectrum(0.f), 0.3f, 0.3f, 2);
    const Vector3f wo = Direction(0.2, 0);
    for (const float z : {0.f, -0.f, 1e-40f, 1e-25f, 1e-10f}) {
        float pdf = 0;
        const Vector3f wi(0.6f, 0.8f, z);
        const Spectrum f = hair.FPdf(wo, wi, &pdf);
        EXPECT_TRUE(Sane(f, pdf));
        EXPECT_NEAR(f[0] * std::max(std::abs(z), 1e-20f) / pdf, 1, 1e-4);
    }
}

// No NaN, infinity or negative value over random and edge inputs. CUTICLE_HAIR_INPUTS sets their number: 1e8
// is the full count.
TEST_P(Hair, RandomAndEdgeInputsAreSane) {
    const char *wanted = std::getenv("CUTICLE_HAIR_INPUTS");
    const auto n = static_cast<uint64_t>(wanted ? std::strtod(wanted, nullptr) : 1e6);
    RNG rng(11);
    const auto pick = [&rng](std::initializer_list<float> edges, float low, float high) {
        const uint32_t k = rng.UniformUInt32() % static_cast<uint32_t>(2 * edges.size());
        return k < edges.size() ? *(edges.begin() + k) : low + (high - low) * rng.UniformFloat();
    };
    const auto direction = [&]() {
        switch (rng.UniformUInt32() % 8) {
        case 0: {
            Vector3f w;
            w[static_cast<int>(rng.UniformUInt32() % 3)] = rng.UniformUInt32() % 2 ? 1.f : -1.f;
            return w;
        }
        case 1:
            return Direction(Radians(rng.UniformUInt32() % 2 ? 89.999 : -89.9),
                             static_cast<double>(rng.UniformFloat()) * 7);
        case 2: {
            Vector3f w = RandomDirection(rng);
            w.z = 0;
            return Normalize(w);
        }
        default:
            return RandomDirection(rng);
        }
    };
    for (uint64_t i = 0; i < n; ++i) {
        const float h = pick({-1, 1, 0, 0.9999999f, -0.9999999f}, -1, 1);
        const float eta = pick({1, kEta, 0.5f, 1e-3f, 1e3f, 1.0000001f, 0.9999999f}, 0.5f, 3);
        const Spectrum sigma(pick({0, 1e18f, 1e-30f, 50}, 0, 10), pick({0, 1e18f, Infinity}, 0, 10),
                             pick({0, 100}, 0, 1));
        const HairBSDF hair(h, eta, sigma, pick({0, 1, 1e-4f, 1e-3f, 0.01f}, 0, 1),
                            pick({0, 1, 1e-4f, 1e-3f, 0.01f}, 0, 1), pick({0, 2, 10, 90, -1e30f}, -20, 20),
                            rng.UniformUInt32() % 2 ? ScaleTilt::RootToTip : ScaleTilt::PbrtV3);
        const Vector3f wo = direction();
        Vector3f wi;
        float pdf = 0;
        const std::array<float, 4> u = RandomU(rng);
        Spectrum f = hair.Sample_f(wo, &wi, u, &pdf);
        ASSERT_TRUE(Sane(f, pdf) && IsFinite(wi))
            << i << hair.ToString() << " wo " << wo << " wi " << wi << " f " << f << " pdf " << pdf;
        ASSERT_NEAR(wi.Length(), 1, 1e-6) << i << hair.ToString() << " wo " << wo << " wi " << wi;
        f = hair.FPdf(wo, direction(), &pdf);
        ASSERT_TRUE(Sane(f, pdf)) << i << hair.ToString() << " wo " << wo << " f " << f << " pdf " << pdf;
    }
    std::printf("%s: %llu constructions, samples and evaluations without NaN, infinity or negative value\n",
                GetParam().c_str(), static_cast<unsigned long long>(n));
}

} // namespace
} // namespace cuticle
