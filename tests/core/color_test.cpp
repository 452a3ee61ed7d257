// Colour: the observer's table against what is published about it, and the laws of spectra and blackbodies.
#include "core/color.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <string>

using namespace cuticle;

namespace {

// The multi-lobe fit of Wyman, Sloan and Shirley 2013 (JCGT 2(2), the accurate set of its listing): Gaussians
// whose width differs left and right of their peak; 1/width is given.
double Lobe(double lambda, double peak, double left, double right) {
    const double t = (lambda - peak) * (lambda < peak ? left : right);
    return std::exp(-t * t / 2);
}
std::array<double, 3> WymanFit(double l) {
    return {0.362 * Lobe(l, 442.0, 0.0624, 0.0374) + 1.056 * Lobe(l, 599.8, 0.0264, 0.0323) -
                0.065 * Lobe(l, 501.1, 0.0490, 0.0382),
            0.821 * Lobe(l, 568.8, 0.0213, 0.0247) + 0.286 * Lobe(l, 530.9, 0.0613, 0.0322),
            1.217 * Lobe(l, 437.0, 0.0845, 0.0278) + 0.681 * Lobe(l, 459.0, 0.0385, 0.0725)};
}

std::array<double, 2> Chromaticity(const std::array<double, 3> &xyz) {
    const double sum = xyz[0] + xyz[1] + xyz[2];
    return {xyz[0] / sum, xyz[1] / sum};
}

// The chromaticity of a blackbody, through the linear RGB that a scene gets.
std::array<double, 2> BlackbodyChromaticity(double kelvin) {
    return Chromaticity(RGBToXYZ(BlackbodyToRGB(kelvin, 1)));
}

} // namespace

// Published sums of the 5 nm table from 380 to 780 nm: one wrong digit anywhere in there shows.
TEST(Observer, SumsArePublishedOnes) {
    std::array<double, 3> sum{};
    for (int l = 380; l <= 780; l += 5)
        for (size_t c = 0; c < 3; ++c)
            sum[c] += MatchingFunction(l)[c];
    EXPECT_NEAR(sum[0], 21.371524, 2e-6);
    EXPECT_NEAR(sum[1], 21.371327, 2e-6);
    EXPECT_NEAR(sum[2], 21.371540, 2e-6);
}

// The integral of y-bar over 360 to 830 nm is 106.857 (the sum of the 1 nm table: 106.856895).
TEST(Observer, IntegralOfYIsPublishedOne) {
    double integral = 0;
    for (int l = 360; l <= 830; ++l)
        integral += MatchingFunction(l)[1];
    EXPECT_NEAR(integral, 106.856895, 2e-3);
}

// A digit typed wrong in the table leaves the fit, whose own error is at most 0.029 (x), 0.011 (y), 0.073
// (z).
TEST(Observer, EveryRowIsNearTheFitOfWyman) {
    std::array<double, 3> largest{};
    for (int l = 360; l <= 830; l += 5) {
        const auto row = MatchingFunction(l), fit = WymanFit(l);
        for (size_t c = 0; c < 3; ++c)
            largest[c] = std::max(largest[c], std::abs(row[c] - fit[c]));
    }
    EXPECT_LT(largest[0], 0.03);
    EXPECT_LT(largest[1], 0.012);
    EXPECT_LT(largest[2], 0.075);
}

TEST(Observer, IsCubicBetweenRowsAndZeroOutside) {
    EXPECT_EQ(MatchingFunction(555)[1], 1);
    // Published 1 nm values between the rows; the cubic follows them to a few 1e-4.
    EXPECT_NEAR(MatchingFunction(442)[0], 0.3501474, 5e-4);
    EXPECT_NEAR(MatchingFunction(503)[0], 0.002424880, 5e-4);
    EXPECT_NEAR(MatchingFunction(558)[1], 0.9983255, 5e-4);
    EXPECT_NEAR(MatchingFunction(603)[0], 1.0552244, 5e-4);
    EXPECT_EQ(MatchingFunction(359.9)[1], 0);
    EXPECT_EQ(MatchingFunction(830.1)[1], 0);
    EXPECT_EQ(MatchingFunction(std::nan(""))[1], 0);
}

TEST(SampledSpectrum, EqualEnergyIsWhitePointE) {
    const auto xyz = XYZFromSamples({300, 900}, {1, 1});
    EXPECT_NEAR(xyz[1], 1, 1e-12);
    EXPECT_NEAR(Chromaticity(xyz)[0], 1 / 3., 5e-5);
    EXPECT_NEAR(Chromaticity(xyz)[1], 1 / 3., 5e-5);
}

// A short constant extends beyond its ends, and where a sample is added on a line nothing changes.
TEST(SampledSpectrum, IsLinearBetweenSamplesAndConstantBeyond) {
    const auto one = XYZFromSamples({555}, {2});
    EXPECT_NEAR(one[1], 2, 1e-12);
    const auto line = XYZFromSamples({400, 700}, {0, 3}),
               split = XYZFromSamples({400, 433.3, 600, 700}, {0, 0.333, 2, 3});
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(line[c], split[c], 1e-12);
    // Order does not matter
    const auto shuffled = XYZFromSamples({700, 433.3, 400, 600}, {3, 0.333, 0, 2});
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(shuffled[c], split[c], 1e-12);
}

TEST(SampledSpectrum, IsAdditive) {
    const std::vector<double> l = {410.5, 480, 533.25, 610, 777}, a = {1, 0.5, 3, 0, 2},
                              b = {0, 4, 1, 1, 0.25};
    std::vector<double> sum;
    for (size_t i = 0; i < l.size(); ++i)
        sum.push_back(a[i] + 2 * b[i]);
    const auto xa = XYZFromSamples(l, a), xb = XYZFromSamples(l, b), xs = XYZFromSamples(l, sum);
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(xs[c], xa[c] + 2 * xb[c], 1e-12);
}

// The two values of a step at one wavelength: all the light is on one side of 555 nm, and the sides add up.
TEST(SampledSpectrum, StepsAtOneWavelength) {
    const auto low = XYZFromSamples({400, 555, 555, 700}, {1, 1, 0, 0});
    const auto high = XYZFromSamples({400, 555, 555, 700}, {0, 0, 1, 1});
    EXPECT_NEAR(low[1] + high[1], 1, 1e-12);
    EXPECT_GT(low[1], 0.4);
    EXPECT_GT(high[1], 0.4);
    EXPECT_GT(low[2], 100 * high[2]);
}

TEST(SampledSpectrum, BadInputIsAnError) {
    const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
    EXPECT_THROW(SpectrumFromSamples({}, {}), Error);
    EXPECT_THROW(SpectrumFromSamples({500, 600}, {1}), Error);
    EXPECT_THROW(SpectrumFromSamples({500, nan}, {1, 1}), Error);
    EXPECT_THROW(SpectrumFromSamples({500, 600}, {1, infinity}), Error);
}

TEST(Blackbody, ChromaticitiesArePublishedOnes) {
    // Illuminant A is the 2856 K radiator (CIE: 0.44758, 0.40745); 6500 K on the Planckian locus is (0.3135,
    // 0.3237).
    EXPECT_NEAR(BlackbodyChromaticity(2856)[0], 0.44758, 2e-4);
    EXPECT_NEAR(BlackbodyChromaticity(2856)[1], 0.40745, 2e-4);
    EXPECT_NEAR(BlackbodyChromaticity(6500)[0], 0.3135, 2e-4);
    EXPECT_NEAR(BlackbodyChromaticity(6500)[1], 0.3237, 2e-4);
    EXPECT_NEAR(BlackbodyChromaticity(10000)[0], 0.2807, 2e-4);
    EXPECT_NEAR(BlackbodyChromaticity(10000)[1], 0.2884, 2e-4);
}

// Y is near and below 1 where Planck's maximum lies within the visible range, and the scale multiplies.
TEST(Blackbody, MaximumIsOneTimesScale) {
    const double y = RGBToXYZ(BlackbodyToRGB(5200, 1))[1]; // peak at 557 nm
    EXPECT_LT(y, 1);
    EXPECT_GT(y, 0.97);
    EXPECT_NEAR(RGBToXYZ(BlackbodyToRGB(5200, 7))[1], 7 * y, 1e-5);
}

TEST(Blackbody, ColdBodiesAreBlackAndHotOnesFinite) {
    for (const double kelvin : {1e-3, 1., 10., 100.})
        EXPECT_TRUE(BlackbodyToRGB(kelvin, 1).IsFinite()) << kelvin;
    EXPECT_TRUE(BlackbodyToRGB(1, 1).IsBlack());
    EXPECT_TRUE(BlackbodyToRGB(1e9, 1).IsFinite());
    EXPECT_THROW(BlackbodyToRGB(0, 1), Error);
    EXPECT_THROW(BlackbodyToRGB(-5, 1), Error);
    EXPECT_THROW(BlackbodyToRGB(std::nan(""), 1), Error);
    EXPECT_THROW(BlackbodyToRGB(std::numeric_limits<double>::infinity(), 1), Error);
    EXPECT_THROW(BlackbodyToRGB(5000, std::nan("")), Error);
}

TEST(RGB, XYZRoundTrip) {
    for (const Spectrum &rgb :
         {Spectrum(1, 0, 0), Spectrum(0, 1, 0), Spectrum(0, 0, 1), Spectrum(0.2f, 3, 0.7f)}) {
        const Spectrum back = XYZToRGB(RGBToXYZ(rgb));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(back[c], rgb[c], 1e-5f * 3);
        EXPECT_NEAR(RGBToXYZ(rgb)[1], rgb.y(), 1e-6 * 3);
    }
    // White is D65
    const auto white = Chromaticity(RGBToXYZ(Spectrum(1)));
    EXPECT_NEAR(white[0], 0.3127, 2e-4);
    EXPECT_NEAR(white[1], 0.3290, 2e-4);
}

TEST(SRGB, RoundTripAndKnownValues) {
    for (int i = 0; i <= 1000; ++i) {
        const float v = static_cast<float>(i) / 1000;
        EXPECT_NEAR(SRGBToLinear(LinearToSRGB(v)), v, 2e-6f);
        EXPECT_LE(LinearToSRGB(v), 1.000001f);
    }
    EXPECT_NEAR(LinearToSRGB(0.21404114f), 0.5f, 1e-6f);
    EXPECT_EQ(LinearToSRGB(0), 0);
    EXPECT_TRUE(std::isnan(LinearToSRGB(std::nanf(""))));
    EXPECT_TRUE(std::isnan(SRGBToLinear(std::nanf(""))));
}

// The pairs that Sharma, Wu and Dalal (2005) published to test implementations.
TEST(CIEDE2000, GivesThePublishedDifferences) {
    struct Pair {
        std::array<double, 3> a, b;
        double difference;
    };
    const Pair pairs[] = {
        {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
        {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
        {{50, 0, 0}, {50, -1, 2}, 2.3669},
        {{50, 2.49, -0.001}, {50, -2.49, 0.0009}, 7.1792},
        {{50, 2.49, -0.001}, {50, -2.49, 0.0011}, 7.2195},
        {{50, -0.001, 2.49}, {50, 0.0009, -2.49}, 4.8045},
        {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
        {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
        {{35.0831, -44.1164, 3.7933}, {35.0232, -40.0716, 1.5901}, 1.8645},
        {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
        {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
        {{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
        {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
    };
    for (const Pair &p : pairs) {
        EXPECT_NEAR(CIEDE2000(p.a, p.b), p.difference, 5e-5);
        EXPECT_NEAR(CIEDE2000(p.b, p.a), p.difference, 5e-5) << "symmetric";
        EXPECT_EQ(CIEDE2000(p.a, p.a), 0);
    }
}

TEST(Lab, OfWhiteGreyAndBlack) {
    const std::array<double, 3> white = XYZToLab(RGBToXYZ(Spectrum(1))), black = XYZToLab({0, 0, 0});
    EXPECT_NEAR(white[0], 100, 1e-9);
    EXPECT_NEAR(std::hypot(white[1], white[2]), 0, 1e-9);
    EXPECT_NEAR(black[0], 0, 1e-9);
    // L* = 50 is the grey of 18.4% reflectance.
    EXPECT_NEAR(XYZToLab(RGBToXYZ(Spectrum(0.18418652f)))[0], 50, 1e-3);
}

// The published chromaticity of D65 (CIE 15) is (0.31272, 0.32903).
TEST(IlluminantD65, HasItsChromaticity) {
    std::array<double, 3> xyz = {0, 0, 0};
    for (int lambda = 380; lambda <= 780; ++lambda) {
        const std::array<double, 3> eye = MatchingFunction(lambda);
        for (size_t i = 0; i < 3; ++i)
            xyz[i] += IlluminantD65(lambda) * eye[i];
    }
    EXPECT_NEAR(Chromaticity(xyz)[0], 0.31272, 1e-4);
    EXPECT_NEAR(Chromaticity(xyz)[1], 0.32903, 1e-4);
    EXPECT_EQ(IlluminantD65(560), 100);
    EXPECT_EQ(IlluminantD65(379), 0);
    EXPECT_EQ(IlluminantD65(781), 0);
}
