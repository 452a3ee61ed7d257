// I0e against 50-digit values of Boost.Math.
#include "core/special.h"

#include <boost/math/special_functions/bessel.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

namespace cuticle {
namespace {

using Big = boost::multiprecision::cpp_bin_float_50;

Big ExactI0e(const Big &x) { return boost::math::cyl_bessel_i(0, x) * exp(-x); }

// 0, the neighbourhood of every seam of the implementations, and a dense logarithmic sweep.
std::vector<float> Arguments(float largest) {
    std::vector<float> xs{0.f, 1e-30f, 1e-6f};
    for (const float seam : {5.f, 8.f, 12.f, 30.f})
        for (int k = -3; k <= 3; ++k)
            xs.push_back(seam * (1 + 1.2e-7f * static_cast<float>(k)));
    for (float x = 1e-3f; x < largest; x *= 1.013f)
        xs.push_back(x);
    return xs;
}

template <typename T>
double MaxRelativeError(float *at) {
    double worst = 0;
    for (const float x : Arguments(5e4f)) {
        const Big exact = ExactI0e(Big(x));
        const double error = static_cast<double>(abs(Big(I0e(static_cast<T>(x))) / exact - 1));
        if (!(error <= worst)) // a NaN counts as worst of all
            worst = error, *at = x;
    }
    return worst;
}

TEST(I0e, AgreesWithFiftyDigits) {
    float at = 0;
    const double inFloat = MaxRelativeError<float>(&at);
    std::printf("I0e: max relative error float %.3g at x = %g\n", inFloat, static_cast<double>(at));
    EXPECT_LE(inFloat, 3e-7) << "at x = " << at;
    const double inDouble = MaxRelativeError<double>(&at);
    std::printf("I0e: max relative error double %.3g at x = %g\n", inDouble, static_cast<double>(at));
    EXPECT_LE(inDouble, 2e-15) << "at x = " << at;
    const double inLongDouble = MaxRelativeError<long double>(&at);
    std::printf("I0e: max relative error long double %.3g at x = %g\n", inLongDouble,
                static_cast<double>(at));
    EXPECT_LE(inLongDouble, 1e-18) << "at x = " << at;
}

// Boost does not reach so far: I0e(x) sqrt(2 pi x) = 1 + 1/(8x) + ..., up to the largest argument that a lobe
// asks for.
TEST(I0e, LargeArguments) {
    for (float x = 5e4f; x < 1e30f; x *= 1.9f) {
        const double expected = (1 + 0.125 / x + 9 / 128. / x / x) / std::sqrt(2 * std::numbers::pi * x);
        EXPECT_NEAR(static_cast<double>(I0e(x)) / expected, 1, 3e-7) << x;
        EXPECT_NEAR(I0e(static_cast<double>(x)) / expected, 1, 1e-14) << x;
    }
    EXPECT_EQ(I0e(std::numeric_limits<float>::infinity()), 0);
    EXPECT_TRUE(std::isnan(I0e(std::numeric_limits<float>::quiet_NaN())));
    EXPECT_TRUE(std::isnan(I0e(std::numeric_limits<double>::quiet_NaN())));
}

// A Bessel function between two probability distributions may not step: E changes by M's step at the seam.
TEST(I0e, FallsWithoutStepsInFloat) {
    float before = I0e(0.f);
    for (float x = 1e-3f; x < 1e3f; x += 1e-3f * (1 + x)) {
        const float now = I0e(x);
        ASSERT_LT(now, before) << "I0e must fall at x = " << x;
        before = now;
    }
}

} // namespace
} // namespace cuticle
