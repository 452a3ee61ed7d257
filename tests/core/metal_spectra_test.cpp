// The tables of metals against each other, against published colours, and against pbrt-v3's rule of
// integration.
#include "core/metal_spectra.h"

#include "core/error.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

double Interpolated(const MetalSpectrum &s, double lambda) {
    for (size_t i = 0; i + 1 < s.lambda.size(); ++i)
        if (lambda >= s.lambda[i] && lambda <= s.lambda[i + 1])
            return Lerp((lambda - s.lambda[i]) / (s.lambda[i + 1] - s.lambda[i]), s.values[i],
                        s.values[i + 1]);
    return std::nan("");
}

// The reflectance of a smooth surface for light from above.
double Reflectance(std::string_view symbol, double lambda) {
    const double n = Interpolated(*FindMetalSpectrum(symbol, OpticalConstant::Eta), lambda),
                 k = Interpolated(*FindMetalSpectrum(symbol, OpticalConstant::K), lambda);
    return (Sqr(n - 1) + k * k) / (Sqr(n + 1) + k * k);
}

TEST(MetalSpectra, TablesAreSoundAndCoverTheVisible) {
    for (const std::string_view symbol : MetalSymbols())
        for (const OpticalConstant which : {OpticalConstant::Eta, OpticalConstant::K}) {
            const auto s = FindMetalSpectrum(symbol, which);
            ASSERT_TRUE(s) << symbol;
            EXPECT_LE(s->lambda.front(), 360) << symbol;
            EXPECT_GE(s->lambda.back(), 830) << symbol;
            EXPECT_FALSE(s->source.empty());
            for (size_t i = 0; i < s->lambda.size(); ++i) {
                EXPECT_GT(s->values[i], 0) << symbol;
                EXPECT_LT(s->values[i], 10) << symbol;
                if (i > 0) {
                    EXPECT_GT(s->lambda[i], s->lambda[i - 1]) << symbol;
                    // A digit typed wrong is a spike: measured curves do not jump so far in so little
                    EXPECT_LT(std::abs(std::log(s->values[i] / s->values[i - 1])), 0.52)
                        << symbol << " at " << s->lambda[i];
                }
            }
            EXPECT_TRUE(MetalRGB(symbol, which).IsFinite());
        }
}

// A second source for each: other samples, other hands, the reflectance at the same wavelength. Silver, gold,
// aluminium and tungsten from the tables that Luxpop's collection gives (Palik's handbook for nickel and
// tungsten), copper from Johnson and Christy 1972, each read off at the wavelength named. The bounds are how
// far the laboratories lie apart, most for silver, which tarnishes, and at the edge of gold.
TEST(MetalSpectra, OtherMeasurementsAgree) {
    struct Other {
        const char *symbol;
        double lambda, eta, k, tolerance;
    };
    for (const Other &o : {
             Other{"Ag", 459.200653, 0.144, 2.56, 0.06},
             {"Ag", 590.400818, 0.121, 3.66, 0.03},
             {"Al", 413.280579, 0.523, 5.02, 0.005},
             {"Al", 619.920898, 1.30, 7.48, 0.006},
             {"Au", 459.200653, 1.426, 1.846, 0.03},
             {"Au", 527.592224, 0.49175, 2.32625, 0.08},
             {"Au", 652.548279, 0.166, 3.15, 0.03},
             {"W", 527.575012, 3.48, 2.72, 0.005},
             {"W", 459.185028, 3.31, 2.55, 0.005},
             {"W", 652.526001, 3.70, 2.94, 0.005},
             {"Ni", 459.185028, 1.64, 2.71, 0.05},
             {"Ni", 619.900024, 1.93, 3.65, 0.06},
             {"Cu", 450.9, 1.24, 2.397, 0.03},
             {"Cu", 548.6, 1.02, 2.577, 0.03},
             {"Cu", 616.8, 0.30, 3.205, 0.03},
             {"Cu", 704.5, 0.21, 4.205, 0.01},
         })
        EXPECT_NEAR(Reflectance(o.symbol, o.lambda),
                    (Sqr(o.eta - 1) + o.k * o.k) / (Sqr(o.eta + 1) + o.k * o.k), o.tolerance)
            << o.symbol << " at " << o.lambda;
}

// Copper in linear RGB as renderers pass it on (Mitsuba's and Tungsten's tables, made by pbrt's rule).
TEST(MetalSpectra, CopperHasThePublishedColour) {
    const Spectrum eta = MetalRGB("Cu", OpticalConstant::Eta), k = MetalRGB("Cu", OpticalConstant::K);
    const double publishedEta[] = {0.2004376970, 0.9240334304, 1.1022119527},
                 publishedK[] = {3.9129485033, 2.4528477015, 2.1421879552};
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(eta[i], publishedEta[i], 0.004 * 1.1);
        EXPECT_NEAR(k[i], publishedK[i], 0.004 * 3.9);
    }
}

// pbrt-v3 sums the values at 471 whole nm with weights that come to 470/471: ours is larger by that and no
// more.
TEST(MetalSpectra, DifferFromPbrtV3sRuleByItsNormalisation) {
    for (const std::string_view symbol : MetalSymbols()) {
        const auto s = FindMetalSpectrum(symbol, OpticalConstant::K);
        std::array<double, 3> xyz{};
        double sumY = 0;
        for (int l = 360; l <= 830; ++l) {
            const auto bar = MatchingFunction(l);
            sumY += bar[1];
            for (size_t c = 0; c < 3; ++c)
                xyz[c] += Interpolated(*s, l) * bar[c];
        }
        for (double &x : xyz)
            x *= 470 / (471 * sumY);
        const auto ours = XYZFromSamples(s->lambda, s->values);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(ours[c] / xyz[c], 471 / 470., 1e-4) << symbol;
    }
}

TEST(MetalSpectra, AreFoundByTheNamesOfFiles) {
    const auto gold = FindMetalSpectrumByFilename("scenes/spds/Au.eta.spd");
    ASSERT_TRUE(gold);
    EXPECT_EQ(gold->values, FindMetalSpectrum("Au", OpticalConstant::Eta)->values);
    EXPECT_EQ(FindMetalSpectrumByFilename("Au.k.spd")->values,
              FindMetalSpectrum("Au", OpticalConstant::K)->values);
    for (const char *name : {"", "spd", "Au.spd", "au.k.spd", "Au.k", "Xx.k.spd", ".k.spd", "Au.k.spd/"})
        EXPECT_FALSE(FindMetalSpectrumByFilename(name)) << name;
    EXPECT_THROW(MetalRGB("Xx", OpticalConstant::K), Error);
}

} // namespace
} // namespace cuticle
