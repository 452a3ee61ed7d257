// Kajiya and Kay's model: its sampling is exact, its energy is what it is.
#include "fibers/kajiya_kay.h"

#include "core/error.h"
#include "fibers/fiber_laws.h"
#include "fibers/gaussian.h"

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

using std::numbers::pi;

TEST(Gaussian, InverseErfInverts) {
    for (int i = -999; i <= 999; ++i) {
        const double x = i / 1000.;
        EXPECT_NEAR(std::erf(InverseErf(x)), x, 2e-15) << x;
        EXPECT_NEAR(std::erf(InverseErf(static_cast<float>(x))), x, 3e-7) << x;
    }
    EXPECT_TRUE(std::isfinite(InverseErf(1.f)));
    EXPECT_TRUE(std::isfinite(InverseErf(-1.)));
}

// The wrapped Gaussian is the plain sum over images, for every width, and keeps its area.
TEST(Gaussian, DetectorIsTheSumOverImages) {
    for (const double beta : {0.01, 0.2, 0.34, 0.36, 1., 1.09, 1.11, 1.5, 3., 8.5, 8.7, 10., 17.5, 100.})
        for (const double x : {0., 0.5, 2., pi, -3., 7., 100.}) {
            double sum = 0;
            const auto images = static_cast<int>(20 + 4 * beta);
            for (int k = -images - 16; k <= images + 16; ++k)
                sum += Gaussian(beta, x - 2 * pi * k);
            EXPECT_NEAR(GaussianDetector(beta, x), sum, 1e-14 * (1 + 1 / beta)) << beta << " " << x;
        }
}

// A detector from 1.1 radians on is a sum of cosines, and only the last digits differ from the sum over
// images in 50 digits. A thousand degrees see the same everywhere: the first cosine is 2 exp(-beta^2 / 2) of
// the mean, 2e-66.
TEST(Gaussian, WideDetectorIsEvenLight) {
    using Digits = boost::multiprecision::cpp_bin_float_50;
    const Digits turn = 2 * boost::math::constants::pi<Digits>();
    for (const double beta : {1.1, 1.3, 2., 4., 8.3, 17.453292519943295})
        for (const double x : {0., 0.3, 1., 1.7, 2.5, 3., pi, -0.001, -2., -3.14}) {
            Digits sum = 0;
            const int images = 3 + static_cast<int>(2 * beta); // of 12 widths
            for (int k = -images; k <= images; ++k)
                sum += exp(-pow((x - turn * k) / beta, 2) / 2);
            const auto exact = static_cast<double>(sum / (beta * sqrt(turn)));
            EXPECT_NEAR(GaussianDetector(beta, x), exact, 2.5e-16) << beta << " " << x;
            EXPECT_NEAR(GaussianDetector(static_cast<float>(beta), static_cast<float>(x)), exact, 1.2e-7)
                << beta << " " << x;
        }
    for (const double beta : {17.453292519943295, 1e3, 1e100, 1e300})
        EXPECT_EQ(GaussianDetector(beta, 1.), 0.5 / pi) << beta;
}

laws::Reference ReferenceOf(const KajiyaKay<double> &model) {
    return [model](const Vector3d &wo, const Vector3d &wi) { return model.Evaluate(wo, wi); };
}

TEST(KajiyaKay, SamplesFollowThePdf) {
    const int n = 100000;
    const double significance = 0.01;
    struct Case {
        float kd, ks, exponent;
        double theta;
    };
    const Case cases[] = {{1, 0, 50, 0.4},           {0, 1, 50, 0},     {0.5f, 0.5f, 0, -0.7},
                          {0.3f, 0.1f, 1000, 1.2},   {0, 1, 5, -1.4},   {0, 1, 2, 1.55},
                          {0.2f, 0.7f, 200, 1.5707}, {0, 1, 1e5f, 0.9}, {0.4f, 1, 20, -1.},
                          {0, 2, 0.05f, 0.3}};
    uint64_t seed = 0;
    double smallest = 1, largest = 0;
    for (const Case &c : cases) {
        const KajiyaKayBSDF bsdf(Spectrum(c.kd), Spectrum(c.ks), c.exponent);
        const std::array<double, 3> kd{c.kd, c.kd, c.kd}, ks{c.ks, c.ks, c.ks};
        const double width = 1 / std::sqrt(std::max(1., static_cast<double>(c.exponent)));
        const laws::SampleTest result =
            laws::ChiSquared(bsdf, ReferenceOf(KajiyaKay<double>(kd, ks, c.exponent)),
                             laws::Direction(c.theta, 0.6), {{{-c.theta, width}}, {}}, ++seed, n);
        EXPECT_GT(result.p, significance / std::size(cases))
            << bsdf.ToString() << " theta " << c.theta << " n " << n;
        EXPECT_NEAR(result.pdf, 1, 1e-6) << bsdf.ToString() << " theta " << c.theta;
        EXPECT_LT(result.worstMismatch, 2e-3) << bsdf.ToString();
        smallest = std::min(smallest, result.p), largest = std::max(largest, result.largestWeight);
        // cos^n x <= exp(-n x^2 / 2), and the normalisation of the highlight is that of the Gaussian but for
        // a factor near 1; of a flat lobe the factor is pi / 2, and half of a Gaussian may lie beyond the
        // pole.
        EXPECT_LT(result.largestWeight, 2 * (c.kd + c.ks)) << bsdf.ToString() << " theta " << c.theta;
    }
    std::printf("Kajiya-Kay: smallest p %.3g of %zu cases, largest weight %.3g\n", smallest, std::size(cases),
                largest);
}

double Energy(double kd, double ks, double exponent, double theta) {
    return laws::OverSphere(ReferenceOf(KajiyaKay<double>({kd, kd, kd}, {ks, ks, ks}, exponent)),
                            laws::Direction(theta, 0), {{{-theta, 1 / std::sqrt(exponent + 1)}}, {}})
        .energy[1];
}

// The model conserves no energy, and is known for it. The diffuse term returns Kd from everywhere; the
// highlight Ks square to the fiber and less and less of it towards the ends, in step with the cosine of the
// inclination; so no constant factor mends it.
TEST(KajiyaKay, EnergyIsNotConserved) {
    for (const double theta : {0., 0.5, -1., 1.5})
        EXPECT_NEAR(Energy(0.7, 0, 50, theta), 0.7, 1e-9) << theta;
    for (const double exponent : {0., 1., 7., 50., 1000., 1e5})
        EXPECT_NEAR(Energy(0, 1, exponent, 0), 1, 1e-9) << exponent;
    std::printf("Kajiya-Kay, exponent 100: energy of the highlight at 0, 45, 60, 80, 89 degrees:");
    for (const double degrees : {0., 45., 60., 80., 89.})
        std::printf(" %.4f", Energy(0, 1, 100, degrees * pi / 180));
    std::printf("\n");
    EXPECT_NEAR(Energy(0, 1, 1e5, pi / 3), 0.5, 1e-4);
    EXPECT_LT(Energy(0, 1, 100, 1.5), 0.1);
    // A white fiber, Kd + Ks = 1, darkens towards grazing views.
    EXPECT_LT(Energy(0.2, 0.8, 100, 1.4), 0.4);
}

// The diffuse term is reciprocal as scattering, S = f |cos| / cos theta_i; the highlight is not.
TEST(KajiyaKay, Reciprocity) {
    const auto s = [](const KajiyaKay<double> &m, double o, double i) {
        return m.Evaluate(laws::Direction(o, 0.2), laws::Direction(i, 2)).fCos[0] / std::cos(i);
    };
    const KajiyaKay<double> diffuse({1, 1, 1}, {0, 0, 0}, 10), highlight({0, 0, 0}, {1, 1, 1}, 10);
    EXPECT_NEAR(s(diffuse, 0.3, -1) / s(diffuse, -1, 0.3), 1, 1e-14);
    EXPECT_NEAR(s(highlight, 0.3, -1) / s(highlight, -1, 0.3), std::cos(0.3) / std::cos(1), 1e-12);
}

TEST(KajiyaKay, BadInput) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(KajiyaKayBSDF(Spectrum(nan), Spectrum(0), 1), Error);
    EXPECT_THROW(KajiyaKayBSDF(Spectrum(0), Spectrum(Infinity), 1), Error);
    EXPECT_THROW(KajiyaKayBSDF(Spectrum(0), Spectrum(0), nan), Error);
    const Vector3f wo(0.1f, 0.6f, 0.8f);
    Vector3f wi;
    float pdf = 1;
    EXPECT_TRUE(KajiyaKayBSDF(Spectrum(0), Spectrum(-1), 1)
                    .Sample_f(wo, &wi, {0.5f, 0.5f, 0.5f, 0.5f}, &pdf)
                    .IsBlack());
    EXPECT_EQ(pdf, 0);
    // NaN in a direction comes back as NaN, to be counted.
    EXPECT_TRUE(KajiyaKayBSDF(Spectrum(1), Spectrum(1), 1).f({nan, 0, 1}, {0, 0, 1}).HasNaNs());
    // The ends of the fiber, and extreme exponents, give finite values.
    for (const float n : {0.f, 1e30f})
        for (const Vector3f &w : {Vector3f(1, 0, 0), Vector3f(-1, 0, 0), Vector3f(0, 1, 0)}) {
            const KajiyaKayBSDF bsdf(Spectrum(1), Spectrum(1), n);
            EXPECT_TRUE((bsdf.FPdf(w, {-1, 0, 0}, &pdf) * 1e-20f).IsFinite());
            EXPECT_TRUE(bsdf.Sample_f(w, &wi, {0.9f, 0.f, 1.f, 0.5f}, &pdf).IsFinite()) << n;
        }
}

} // namespace
} // namespace cuticle
