// The smooth fiber: root counts, caustics and lengths against what optics says.
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"

#include "core/angles.h"
#include "core/sampling.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

// At normal incidence eta' is eta.
SmoothFiber<double> AtNormalIncidence(double eta) { return {1, eta}; }

TEST(SmoothFiber, BravaisIndex) {
    for (const double theta : {0., 0.3, 1., 1.5}) {
        const SmoothFiber<double> fiber(std::cos(theta), 1.55);
        EXPECT_NEAR(fiber.etaPrime, std::sqrt(1.55 * 1.55 - Sqr(std::sin(theta))) / std::cos(theta),
                    1e-12 * fiber.etaPrime);
    }
    // eta' = 2, where the glints merge, is reached at 46.9 degrees.
    EXPECT_NEAR(SmoothFiber<double>(std::cos(46.9 * kDegree), 1.55).etaPrime, 2, 2e-3);
}

// The two effective indices of Marschner et al., appendix B, give the reflectance of the plain formula.
TEST(SmoothFiber, FresnelWithTwoIndicesIsFresnel) {
    const double eta = 1.55;
    for (const double theta : {0., 0.4, 1.1, 1.5})
        for (const double gamma : {0., 0.2, 0.9, 1.5, 1.57}) {
            const SmoothFiber<double> fiber(std::cos(theta), eta);
            const double first = fiber.etaPrime, second = eta * eta / first;
            const double cosI = std::cos(gamma), cosT = std::cos(fiber.GammaT(std::sin(gamma)));
            const double s = (cosI - first * cosT) / (cosI + first * cosT);
            const double p = (second * cosI - cosT) / (second * cosI + cosT);
            EXPECT_NEAR(fiber.Attenuation(0, gamma, {0, 0, 0}, SegmentLength::Chord)[0], (s * s + p * p) / 2,
                        1e-13);
        }
}

// Light that leaves at phi came in at the roots: every ray finds itself again, and every root is a ray.
TEST(SmoothFiber, RootsAreThePaths) {
    RNG rng(MixBits(7));
    for (int k = 0; k < 4000; ++k) {
        const int p = k % 6;
        const double theta = 1.55 * static_cast<double>(rng.UniformFloat()),
                     eta = 1.05 + static_cast<double>(rng.UniformFloat()),
                     gamma = kPi<double> * (static_cast<double>(rng.UniformFloat()) - 0.5);
        const SmoothFiber<double> fiber(std::cos(theta), eta);
        const PathRoots<double> roots = fiber.Roots(p, fiber.Phi(p, gamma));
        double nearest = 10;
        for (size_t r = 0; r < roots.count; ++r) {
            nearest = std::min(nearest, std::abs(roots.gamma[r] - gamma));
            const double miss = WrapAngle(fiber.Phi(p, roots.gamma[r]) - fiber.Phi(p, gamma));
            EXPECT_NEAR(std::abs(miss) > 3 ? 2 * kPi<double> - std::abs(miss) : std::abs(miss), 0, 1e-12);
            for (size_t q = 0; q < r; ++q)
                EXPECT_NE(roots.gamma[q], roots.gamma[r]);
        }
        // Near a turning point the root is only known to the root of the precision.
        EXPECT_LT(nearest, 1e-6) << "p " << p << " eta' " << fiber.etaPrime << " gamma " << gamma;
    }
}

TEST(SmoothFiber, ReflectionAndTransmissionRoots) {
    const SmoothFiber<double> fiber = AtNormalIncidence(1.55);
    const double dark = 2 * std::asin(1 / 1.55);
    std::printf("eta' 1.55: TT is dark within %.1f degrees\n", dark / kDegree);
    EXPECT_NEAR(dark / kDegree, 80.4, 0.05);
    for (double phi = -3.1; phi < 3.1; phi += 0.01) {
        EXPECT_EQ(fiber.Roots(0, phi).count, 1u);
        EXPECT_EQ(fiber.Roots(1, phi).count, std::abs(phi) > dark ? 1u : 0u) << phi;
    }
}

// d'Eon et al. 2011, section 5: the h whose TT leaves at phi, with the root over its denominator that our
// text of the paper has lost. Without it some light would meet the fiber beside it, abs(h) > 1.
TEST(SmoothFiber, ClosedFormOfTTNeedsItsRoot) {
    const SmoothFiber<double> fiber = AtNormalIncidence(1.55);
    const double a = 1 / 1.55;
    double asPrinted = 0, most = 0;
    for (double phi = 2 * std::asin(a) + 1e-3; phi < kPi<double>; phi += 0.01) {
        const double h = std::sin(fiber.Roots(1, phi).gamma[0]),
                     squared = 1 + a * a - 2 * a * std::sin(phi / 2);
        EXPECT_NEAR(h, std::cos(phi / 2) / std::sqrt(squared), 1e-13);
        EXPECT_NEAR(std::sin(fiber.Roots(1, -phi).gamma[0]), -h, 1e-13);
        asPrinted = std::max(asPrinted, std::abs(std::cos(phi / 2) / squared - h));
        most = std::max(most, std::cos(phi / 2) / squared);
    }
    std::printf("without the root h is off by up to %.3f and reaches %.3f\n", asPrinted, most);
    EXPECT_GT(asPrinted, 0.1);
    EXPECT_GT(most, 1);
}

// TRT: 0, 1, 2 or 3 roots. At eta' = 1.55 its paths end at 19.3 degrees, beyond the caustics at 18.6.
TEST(SmoothFiber, TrtRootsAndCaustics) {
    const SmoothFiber<double> fiber = AtNormalIncidence(1.55);
    const double turn = fiber.TurningPoint(2);
    EXPECT_NEAR(Sqr(std::sin(turn)), (4 - 1.55 * 1.55) / 3, 1e-14);
    EXPECT_NEAR(fiber.PhiSlope(2, turn), 0, 1e-13);
    const double caustic = std::abs(WrapAngle(fiber.Phi(2, turn)));
    const double end = std::abs(WrapAngle(fiber.Phi(2, kPi<double> / 2)));
    std::printf("eta' 1.55: TRT ends at %.1f degrees, its caustics are at %.1f\n", end / kDegree,
                caustic / kDegree);
    EXPECT_NEAR(end / kDegree, 19.3, 0.05);
    EXPECT_NEAR(caustic / kDegree, 18.6, 0.1);
    for (double phi = -0.5; phi < 0.5; phi += 0.001) {
        const size_t expected = std::abs(phi) < caustic ? 3 : std::abs(phi) < end ? 1 : 0;
        EXPECT_EQ(fiber.Roots(2, phi).count, expected) << phi / kDegree;
    }
    EXPECT_EQ(fiber.Roots(2, caustic).count, 2u);
    // Past the merger one root at most.
    const SmoothFiber<double> grazing(std::cos(1.), 1.55);
    EXPECT_EQ(grazing.TurningPoint(2), 0);
    for (double phi = -3.1; phi < 3.1; phi += 0.01)
        EXPECT_LE(grazing.Roots(2, phi).count, 1u);
}

// Derivatives against differences.
TEST(SmoothFiber, Derivatives) {
    const SmoothFiber<double> fiber(std::cos(0.6), 1.55);
    for (int p = 0; p < 5; ++p)
        for (const double gamma : {-1.2, -0.3, 0.4, 1.}) {
            const double d = 1e-5;
            EXPECT_NEAR(fiber.PhiSlope(p, gamma),
                        (fiber.Phi(p, gamma + d) - fiber.Phi(p, gamma - d)) / (2 * d), 1e-8);
            const auto phi = [&](double h) { return fiber.Phi(p, std::asin(h)); };
            const double h = std::sin(gamma);
            EXPECT_NEAR(fiber.PhiCurvature(p, h), (phi(h + d) - 2 * phi(h) + phi(h - d)) / (d * d), 1e-3);
        }
}

// A clear fiber loses nothing, at any offset and inclination: the paths before p and the tail from p on.
TEST(SmoothFiber, AttenuationsAddUp) {
    for (const double theta : {0., 0.8, 1.5, 1.5707})
        for (const double gamma : {0., 0.7, 1.5, kPi<double> / 2})
            for (int last = 1; last < 6; ++last) {
                const SmoothFiber<double> fiber(std::cos(theta), 1.55);
                const std::array<double, 3> clear = {0, 0, 0};
                double sum = fiber.Tail(last, gamma, clear, SegmentLength::Chord)[0];
                for (int p = 0; p < last; ++p)
                    sum += fiber.Attenuation(p, gamma, clear, SegmentLength::Chord)[0];
                EXPECT_NEAR(sum, 1, 1e-8) << theta << " " << gamma;
            }
}

// The chord through the middle is the diameter, 2 radii; as printed it is 4.
TEST(SmoothFiber, ChordAndPrintedLength) {
    const SmoothFiber<double> fiber = AtNormalIncidence(1.55);
    const std::array<double, 3> sigma = {1, 0, 0};
    const auto length = [&](double gamma, SegmentLength which) {
        const auto a = fiber.Attenuation(1, gamma, sigma, which);
        return std::log(a[1] / a[0]);
    };
    EXPECT_NEAR(length(0, SegmentLength::Chord), 2, 1e-12);
    EXPECT_NEAR(length(0, SegmentLength::Printed), 4, 1e-12);
    for (const double gamma : {0.3, 0.9, 1.4}) {
        const double gammaT = fiber.GammaT(std::sin(gamma));
        EXPECT_NEAR(length(gamma, SegmentLength::Chord), 2 * std::cos(gammaT), 1e-12);
        EXPECT_NEAR(length(gamma, SegmentLength::Printed), 2 + 2 * std::cos(2 * gammaT), 1e-12);
    }
}

} // namespace
} // namespace cuticle
