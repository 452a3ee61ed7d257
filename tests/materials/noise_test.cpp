// Perlin's noise against what defines it.
#include "materials/noise.h"

#include "core/sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace cuticle {
namespace {

// The gradient at a lattice point, by the noise near it: whole numbers, so that rounding takes away what a
// difference quotient adds.
Vector3d GradientAt(int x, int y, int z) {
    const Point3f p{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    constexpr float h = 1.f / 256;
    const auto slope = [&](const Vector3f &d) {
        return std::round(static_cast<double>(Noise(p + d * h) - Noise(p - d * h)) / (2. / 256) * 10) / 10;
    };
    return {slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
}

TEST(Noise, IsPerlinsPublishedValue) {
    // The value that implementations of Perlin's improved noise are compared by. The two gradients that
    // pbrt-v3 numbers otherwise than Perlin have no part in it.
    EXPECT_NEAR(Noise({3.14f, 42, 7}), 0.13691995878400012, 1e-6);
}

// Noise blends eight planes, one for each corner of the cell, by a polynomial whose slope and curvature
// vanish at the corners. Here in double, with the planes found by measurement.
TEST(Noise, BlendsTheGradientsOfItsCell) {
    RNG rng(1);
    const auto blend = [](double t) { return t * t * t * (10 - 15 * t + 6 * t * t); };
    for (int i = 0; i < 400; ++i) {
        const auto r = [&] { return static_cast<int>(300 * rng.UniformFloat()) - 150; };
        const int x = r(), y = r(), z = r();
        for (int j = 0; j < 10; ++j) {
            const Point3f f{rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()};
            const Point3f p =
                f + Point3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
            double expected = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
                const Vector3d d{static_cast<double>(p.x) - x - a, static_cast<double>(p.y) - y - b,
                                 static_cast<double>(p.z) - z - c};
                const auto weight = [&](double offset, int far) {
                    return far ? blend(offset + 1) : 1 - blend(offset);
                };
                expected += weight(d.x, a) * weight(d.y, b) * weight(d.z, c) *
                            Dot(GradientAt(x + a, y + b, z + c), d);
            }
            ASSERT_NEAR(Noise(p), expected, 2e-6) << p.x << ", " << p.y << ", " << p.z;
        }
    }
}

// The gradients point from a cube's centre to its twelve edges.
TEST(Noise, GradientsAreTwelve) {
    std::set<std::array<double, 3>> met;
    for (int x = 0; x < 16; ++x)
        for (int y = 0; y < 16; ++y)
            for (int z = 0; z < 16; ++z) {
                const Vector3d g = GradientAt(x, y, z);
                ASSERT_EQ(g.LengthSquared(), 2) << x << ", " << y << ", " << z;
                ASSERT_EQ(g.x * g.y * g.z, 0);
                met.insert({g.x, g.y, g.z});
            }
    EXPECT_EQ(met.size(), 12u);
}

TEST(Noise, VanishesOnTheLatticeRepeatsAndStaysInBounds) {
    RNG rng(2);
    for (int i = 0; i < 20000; ++i) {
        const auto r = [&] { return 512 * rng.UniformFloat() - 256; };
        const Point3f p{r(), r(), r()};
        EXPECT_LE(std::abs(Noise(p)), 1);
        const Point3f lattice{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
        EXPECT_EQ(Noise(lattice), 0);
        const Point3f inCell = p - lattice; // exact when the cell's number is added again: multiples of 2^-15
        const auto grid = [](float v) { return std::floor(v * 0x1p12f) * 0x1p-12f; };
        const Point3f q = lattice + Point3f(grid(inCell.x), grid(inCell.y), grid(inCell.z));
        for (const Vector3f &d : {Vector3f(256, 0, 0), Vector3f(0, -256, 0), Vector3f(0, 0, 512)})
            EXPECT_EQ(Noise(q + d), Noise(q));
    }
}

TEST(Noise, AnyCoordinateHasAnAnswer) {
    EXPECT_EQ(Noise({1e30f, -3e38f, 5e9f}), 0); // whole numbers all
    for (const float bad : {std::nanf(""), Infinity, -Infinity}) {
        EXPECT_TRUE(std::isnan(Noise({bad, 0, 0})));
        EXPECT_TRUE(std::isnan(Noise({0, 0, bad})));
        EXPECT_TRUE(std::isnan(FBm({0, bad, 0}, 0.5f, 4)));
        EXPECT_TRUE(std::isnan(Turbulence({0, bad, 0}, 0.5f, 4)));
    }
    EXPECT_EQ(FBm({0.3f, 0.4f, 0.5f}, 0.5f, 0), 0);
    EXPECT_TRUE(std::isfinite(FBm({3, 4.5f, 0.1f}, 0.5f, 100)));
}

} // namespace
} // namespace cuticle
