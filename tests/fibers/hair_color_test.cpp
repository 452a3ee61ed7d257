// The absorption that a colour or a concentration of pigment stands for, against the numbers in the papers.
#include "fibers/hair.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace cuticle {
namespace {

TEST(HairColor, SigmaAFromReflectanceIsClamped) {
    for (const float beta : {0.f, 0.3f, 1.f, 5.f, -1.f}) {
        const Spectrum s = HairBSDF::SigmaAFromReflectance(Spectrum(0.f, 1.f, 7.f), beta);
        EXPECT_TRUE(std::isfinite(s[0]) && s[0] > 0);
        EXPECT_EQ(s[1], 0);
        EXPECT_EQ(s[2], 0);
    }
    EXPECT_GT(HairBSDF::SigmaAFromReflectance(Spectrum(-1.f), 0.3f)[0], 0);
    EXPECT_TRUE(HairBSDF::SigmaAFromReflectance(Spectrum(NAN), 0.3f).HasNaNs());
    EXPECT_TRUE(HairBSDF::SigmaAFromReflectance(Spectrum(0.5f), NAN).HasNaNs());
}
// Pharr's figure 1.20. Its upper sigma_a is that of beta_n = 0.8, not of the 0.3 in the caption.
TEST(HairColor, SigmaAFromReflectanceAsInTheText) {
    const Spectrum upper = HairBSDF::SigmaAFromReflectance(Spectrum(0.8f, 0.4f, 0.05f), 0.8f);
    const Spectrum caption = HairBSDF::SigmaAFromReflectance(Spectrum(0.8f, 0.4f, 0.05f), 0.3f);
    const Spectrum lower = HairBSDF::SigmaAFromReflectance(Spectrum(0.2f, 0.8f, 0.3f), 0.8f);
    const float upperText[] = {0.003f, 0.046f, 0.488f}, captionTrue[] = {0.0014f, 0.0242f, 0.2588f},
                lowerText[] = {0.141f, 0.003f, 0.079f};
    std::printf(
        "sigma_a of (0.8, 0.4, 0.05) at beta_n = 0.3: (%.4f, %.4f, %.4f), at 0.8: (%.4f, %.4f, %.4f)\n",
        static_cast<double>(caption[0]), static_cast<double>(caption[1]), static_cast<double>(caption[2]),
        static_cast<double>(upper[0]), static_cast<double>(upper[1]), static_cast<double>(upper[2]));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(upper[c], upperText[c], 6e-4);
        EXPECT_NEAR(caption[c], captionTrue[c], 6e-5);
        EXPECT_NEAR(lower[c], lowerText[c], 6e-4);
    }
}
// Figure 1.10: black is 8 parts of eumelanin, its brown 2.0, not the 1.3 of the text.
TEST(HairColor, SigmaAFromConcentrationAsInTheText) {
    const Spectrum black = HairBSDF::SigmaAFromConcentration(8, 0),
                   brown = HairBSDF::SigmaAFromConcentration(2, 0);
    const float blackText[] = {3.35f, 5.58f, 10.96f}, brownText[] = {0.84f, 1.39f, 2.74f};
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(black[c], blackText[c], 6e-3);
        EXPECT_NEAR(brown[c], brownText[c], 6e-3);
    }
    EXPECT_EQ(HairBSDF::SigmaAFromConcentration(-1, -1), Spectrum(0.f));
    EXPECT_FLOAT_EQ(HairBSDF::SigmaAFromConcentration(0, 2)[1], 0.8f);
}

// The fit inverted, c = exp(-s sqrt(sigma_a)), by plain arithmetic: exercise 10.2 of the book.
TEST(HairColor, TheColourOfABrown) {
    const double b = 0.3, s = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    std::array<double, 3> colour;
    for (size_t c = 0; c < 3; ++c)
        colour[c] = std::exp(-s * std::sqrt(1.3 * std::array{0.419, 0.697, 1.37}[c]));
    std::printf("eumelanin 1.3 at beta_n = 0.3 has the colour (%.4f, %.4f, %.4f)\n", colour[0], colour[1],
                colour[2]);
    const Spectrum sigma = HairBSDF::SigmaAFromReflectance(
        Spectrum(static_cast<float>(colour[0]), static_cast<float>(colour[1]), static_cast<float>(colour[2])),
        0.3f);
    const Spectrum expected = HairBSDF::SigmaAFromConcentration(1.3f, 0);
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(sigma[c] / expected[c], 1, 1e-5);
}

} // namespace
} // namespace cuticle
