// Random numbers, warps and tabulated densities: ranges, densities and limits.
#include "core/sampling.h"

#include "core/error.h"
#include "sampler_ends.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

namespace cuticle {
namespace {

TEST(MixBits, IsABijectionOnSamples) {
    std::set<uint64_t> seen;
    for (uint64_t i = 0; i < 100000; ++i)
        seen.insert(MixBits(i));
    EXPECT_EQ(seen.size(), 100000u);
}

TEST(RNG, StaysBelowOneAndDiffersBetweenStreams) {
    RNG a(1), b(1), c(2), d(1, 7);
    bool differs = false, offsetDiffers = false;
    double sum = 0;
    const int n = 1000000;
    for (int i = 0; i < n; ++i) {
        const float x = a.UniformFloat();
        ASSERT_TRUE(x >= 0 && x <= OneMinusEpsilon);
        ASSERT_EQ(x, b.UniformFloat());
        differs = differs || x != c.UniformFloat();
        offsetDiffers = offsetDiffers || x != d.UniformFloat();
        sum += static_cast<double>(x);
    }
    EXPECT_TRUE(differs && offsetDiffers);
    // 5 standard deviations of the mean of n uniform numbers: 5 / sqrt(12 n).
    EXPECT_NEAR(sum / n, 0.5, 5 / std::sqrt(12. * n));
}

// The bits that a float cannot hold are drawn, those it holds are kept: each half is u's Morton half.
TEST(DemuxFloat, KeepsTheBitsOfU) {
    for (uint32_t i = 0; i < (1u << 16); ++i) {
        const float u = (static_cast<float>(i) + 0.25f) / 65536;
        const Point2f halves = DemuxFloat(u);
        uint32_t odd = 0, even = 0;
        for (uint32_t bit = 0; bit < 8; ++bit) {
            even |= ((i >> (2 * bit)) & 1) << bit;
            odd |= ((i >> (2 * bit + 1)) & 1) << bit;
        }
        ASSERT_EQ(static_cast<uint32_t>(halves.x * 256), even) << u;
        ASSERT_EQ(static_cast<uint32_t>(halves.y * 256), odd) << u;
    }
}

TEST(DemuxFloat, UOfOneAndBeyondStaysInside) {
    for (const float u : {0.f, 1e-45f, 1e-30f, OneMinusEpsilon, 1.f, 2.f, Infinity, -1.f}) {
        const Point2f halves = DemuxFloat(u);
        for (int i = 0; i < 2; ++i)
            EXPECT_TRUE(halves[i] > 0 && halves[i] < 1) << u << " " << halves[i];
    }
    const Point2f nan = DemuxFloat(std::nanf(""));
    EXPECT_TRUE(std::isnan(nan.x) && std::isnan(nan.y));
}

// As printed, a float in [0.5, 1) has 2^12 x 2^11 values. Here the halves of different u fill their cells.
TEST(DemuxFloat, ValuesAreSpreadWithinTheirCells) {
    std::set<float> x;
    const int n = 20000;
    for (int i = 0; i < n; ++i)
        x.insert(DemuxFloat(0.5f + 0.5f * static_cast<float>(i) / n).x);
    EXPECT_GT(x.size(), 15000u) << "of " << n << "; plain bits give at most 4096";
}

TEST(Warps, LieWhereTheyShouldAndKeepMoments) {
    const int n = 512; // n^2 midpoints
    double disk2 = 0, cosine = 0, hemisphere = 0, sphere2 = 0, cone = 0, triangle = 0;
    const float cosMax = 0.9f;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Point2f u{(static_cast<float>(i) + 0.5f) / n, (static_cast<float>(j) + 0.5f) / n};
            const Point2f d = ConcentricSampleDisk(u);
            ASSERT_LE(d.x * d.x + d.y * d.y, 1.000001f);
            disk2 += static_cast<double>(d.x * d.x + d.y * d.y);
            const Vector3f c = CosineSampleHemisphere(u);
            ASSERT_NEAR(c.Length(), 1, 1e-6);
            cosine += static_cast<double>(c.z);
            hemisphere += static_cast<double>(UniformSampleHemisphere(u).z);
            const Vector3f s = UniformSampleSphere(u);
            ASSERT_NEAR(s.Length(), 1, 1e-6);
            sphere2 += static_cast<double>(s.z * s.z);
            const Vector3f inCone = UniformSampleCone(u, cosMax);
            ASSERT_GE(inCone.z, cosMax);
            cone += static_cast<double>(inCone.z);
            const Point2f b = UniformSampleTriangle(u);
            ASSERT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1.000001f);
            triangle += static_cast<double>(b.x);
        }
    const double m = static_cast<double>(n) * n;
    EXPECT_NEAR(disk2 / m, 0.5, 1e-4);
    EXPECT_NEAR(cosine / m, 2. / 3, 1e-4);
    EXPECT_NEAR(hemisphere / m, 0.5, 1e-4);
    EXPECT_NEAR(sphere2 / m, 1. / 3, 1e-4);
    EXPECT_NEAR(cone / m, 0.95, 1e-4);
    EXPECT_NEAR(triangle / m, 1. / 3, 1e-3); // a square root at the edge: the midpoints converge slowly
}

TEST(Warps, DensitiesIntegrateToOne) {
    EXPECT_NEAR(UniformSpherePdf() * 4 * Pi, 1, 1e-6);
    EXPECT_NEAR(UniformHemispherePdf() * 2 * Pi, 1, 1e-6);
    EXPECT_NEAR(UniformConePdf(0.25f) * 2 * Pi * 0.75f, 1, 1e-6);
    double sum = 0;
    for (int i = 0; i < 10000; ++i) // 2 pi times the integral over z
        sum += 2 * std::numbers::pi *
               static_cast<double>(CosineHemispherePdf((static_cast<float>(i) + 0.5f) / 10000)) / 10000;
    EXPECT_NEAR(sum, 1, 1e-6);
    EXPECT_EQ(CosineHemispherePdf(-0.5f), 0);
}

// At the ends of the square every warp answers with a point of its domain, and with a density above 0 but
// where a cosine vanishes.
TEST(Warps, HoldAtTheEnds) {
    ForEachEnd([](const Point2f &u) {
        const Point2f disk = ConcentricSampleDisk(u);
        EXPECT_LE(std::hypot(double{disk.x}, double{disk.y}), 1 + 1e-7) << u;
        const Vector3f cosine = CosineSampleHemisphere(u);
        EXPECT_TRUE(IsUnit(cosine)) << u;
        EXPECT_GE(cosine.z, 0) << u;
        EXPECT_EQ(CosineHemispherePdf(cosine.z) > 0, cosine.z > 0) << u;
        const Vector3f hemisphere = UniformSampleHemisphere(u), sphere = UniformSampleSphere(u);
        EXPECT_TRUE(IsUnit(hemisphere) && IsUnit(sphere)) << u;
        EXPECT_GE(hemisphere.z, 0) << u;
        for (const float cosThetaMax : {-1.f, 0.f, 0.5f, 1 - 0x1p-20f, OneMinusEpsilon, 1.f}) {
            const Vector3f w = UniformSampleCone(u, cosThetaMax);
            EXPECT_TRUE(IsUnit(w)) << u << " " << cosThetaMax;
            EXPECT_TRUE(w.z >= cosThetaMax && w.z <= 1) << u << " " << cosThetaMax;
            EXPECT_GT(UniformConePdf(cosThetaMax), 0);
        }
        const Point2f b = UniformSampleTriangle(u);
        EXPECT_TRUE(b.x >= 0 && b.y >= 0) << u << " " << b;
        EXPECT_GE(1 - double{b.x} - double{b.y}, 0) << u << " " << b;
    });
}

TEST(PowerHeuristic, LimitsAndComplement) {
    EXPECT_EQ(PowerHeuristic(Infinity, 1), 1);
    EXPECT_EQ(PowerHeuristic(1, Infinity), 0);
    EXPECT_EQ(PowerHeuristic(Infinity, Infinity), 0.5f);
    EXPECT_EQ(PowerHeuristic(0, 0), 0);
    EXPECT_EQ(PowerHeuristic(0, 5), 0);
    EXPECT_EQ(PowerHeuristic(5, 0), 1);
    EXPECT_TRUE(std::isnan(PowerHeuristic(std::nanf(""), 1)));
    EXPECT_TRUE(std::isnan(PowerHeuristic(1, std::nanf(""))));
    EXPECT_TRUE(std::isnan(PowerHeuristic(0, std::nanf(""))));
    for (float a = 1e-30f; a < 1e30f; a *= 7)
        for (float b = 1e-30f; b < 1e30f; b *= 11) {
            const float w = PowerHeuristic(a, b);
            ASSERT_TRUE(w >= 0 && w <= 1) << a << " " << b;
            ASSERT_NEAR(w + PowerHeuristic(b, a), 1, 1e-6) << a << " " << b;
        }
}

TEST(Distribution1D, ZeroFunctionIsUniform) {
    const std::vector<float> zero(5, 0.f);
    const Distribution1D d(zero.data(), 5);
    EXPECT_EQ(d.Integral(), 0);
    float pdf = 0;
    EXPECT_NEAR(d.SampleContinuous(0.3f, &pdf), 0.3, 1e-6);
    EXPECT_EQ(pdf, 1);
    EXPECT_NEAR(d.DiscretePDF(2), 0.2, 1e-7);
}

TEST(Distribution1D, NeverChoosesCellsOfZero) {
    const std::vector<float> f = {0, 0, 1, 0, 3, 0, 0};
    const Distribution1D d(f.data(), 7);
    int counts[7] = {};
    const int n = 100000;
    for (int i = 0; i <= n; ++i) {
        float probability = 0, remapped = 0;
        const float u = std::min(static_cast<float>(i) / n, OneMinusEpsilon);
        const size_t cell = d.SampleDiscrete(u, &probability, &remapped);
        ASSERT_TRUE(cell == 2 || cell == 4) << u;
        ASSERT_TRUE(remapped >= 0 && remapped < 1);
        ASSERT_FLOAT_EQ(probability, cell == 2 ? 0.25f : 0.75f);
        ++counts[cell];
    }
    EXPECT_NEAR(counts[2] / static_cast<double>(n), 0.25, 1e-4);
    EXPECT_NEAR(d.Integral(), 4. / 7, 1e-6);
    EXPECT_EQ(d.Pdf(-1), 0);
    EXPECT_EQ(d.Pdf(2), 0);
    EXPECT_FLOAT_EQ(d.Pdf(0.6f), 7 * 0.75f);
}

// A sample lies in the cell whose density it states, also where the place is rounded to the cell's border.
TEST(Distributions, HoldAtTheEnds) {
    RNG rng(3);
    for (const size_t n : {size_t{1}, size_t{2}, size_t{3}, size_t{7}, size_t{1000}, size_t{4097}}) {
        std::vector<float> f(n * 3);
        for (float &v : f)
            v = rng.UniformFloat() < 0.3f ? 0 : rng.UniformFloat() * (rng.UniformFloat() < 0.1f ? 1e6f : 1);
        const Distribution1D line(f.data(), n);
        const Distribution2D square(f.data(), n, 3);
        const auto check = [&](float u) {
            float pdf = 0, probability = 0, again = 0;
            size_t cell = 0;
            const float x = line.SampleContinuous(u, &pdf, &cell);
            ASSERT_TRUE(x >= 0 && x < 1) << n << " " << u;
            ASSERT_TRUE(pdf > 0 && std::isfinite(pdf)) << n << " " << u;
            ASSERT_EQ(line.Pdf(x), pdf) << n << " " << u << " cell " << cell << " x " << x;
            ASSERT_EQ(line.SampleDiscrete(u, &probability, &again), cell);
            ASSERT_GT(probability, 0);
            ASSERT_TRUE(again >= 0 && again < 1) << n << " " << u;
        };
        for (const float u : kEndsOfU)
            check(u);
        float below = 0; // the borders of the cells, and the numbers just beside them
        for (size_t i = 0; i < n; ++i) {
            below += line.DiscretePDF(i);
            for (const float u : {std::nextafter(below, 0.f), below, std::nextafter(below, 1.f)})
                if (u < 1)
                    check(u);
        }
        for (int i = 0; i < 20000; ++i)
            check(rng.UniformFloat());
        ForEachEnd([&](const Point2f &u) {
            float pdf = 0;
            const Point2f p = square.SampleContinuous(u, &pdf);
            ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1) << u;
            ASSERT_TRUE(pdf > 0 && std::isfinite(pdf)) << u;
            ASSERT_EQ(square.Pdf(p), pdf) << u;
        });
    }
}

TEST(Distribution1D, HugeAndTinyValues) {
    const std::vector<float> f = {3e38f, 1e-38f, 3e38f};
    const Distribution1D d(f.data(), 3);
    EXPECT_FLOAT_EQ(d.Pdf(0.1f), 1.5f);
    EXPECT_FLOAT_EQ(d.Pdf(0.9f), 1.5f);
}

TEST(Distribution1D, NaNComesBack) {
    const std::vector<float> f = {1, 2};
    const Distribution1D d(f.data(), 2);
    float pdf = 0;
    EXPECT_TRUE(std::isnan(d.SampleContinuous(std::nanf(""), &pdf)));
}

TEST(Distribution1D, RefusesNegativeAndNaN) {
    for (const float bad : {-1.f, std::nanf(""), Infinity}) {
        const std::vector<float> f = {1, bad};
        EXPECT_THROW(Distribution1D(f.data(), 2), Error) << bad;
    }
}

// Stratified samples fill the cells in proportion, and the density returned is the density asked for.
TEST(Distribution2D, SamplesFollowTheDensity) {
    const int nu = 7, nv = 5;
    std::vector<float> f;
    RNG rng(3);
    double total = 0;
    for (int i = 0; i < nu * nv; ++i) {
        f.push_back(i % 4 == 0 ? 0 : rng.UniformFloat());
        total += static_cast<double>(f.back());
    }
    const Distribution2D d(f.data(), nu, nv);
    EXPECT_NEAR(d.Integral(), total / (nu * nv), 1e-6);
    std::vector<double> counts(f.size());
    const int n = 1000;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            float pdf = 0;
            const Point2f p = d.SampleContinuous(
                {(static_cast<float>(i) + 0.5f) / n, (static_cast<float>(j) + 0.5f) / n}, &pdf);
            ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
            ASSERT_GT(pdf, 0);
            const int u = std::min(static_cast<int>(p.x * nu), nu - 1),
                      v = std::min(static_cast<int>(p.y * nv), nv - 1);
            ++counts[static_cast<size_t>(v * nu + u)];
            ASSERT_NEAR(pdf, static_cast<double>(f[static_cast<size_t>(v * nu + u)]) / total * nu * nv, 1e-4);
            ASSERT_FLOAT_EQ(
                pdf, d.Pdf({(static_cast<float>(u) + 0.5f) / nu, (static_cast<float>(v) + 0.5f) / nv}));
        }
    // A million stratified points: each cell is right to about its perimeter in points.
    for (size_t i = 0; i < f.size(); ++i)
        EXPECT_NEAR(counts[i] / n / n, static_cast<double>(f[i]) / total, 3e-3) << i;
}

} // namespace
} // namespace cuticle
