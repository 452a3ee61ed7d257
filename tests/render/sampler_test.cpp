// The sampler's promises: strata, independence of dimensions and pixels, uniformity, and what they buy.
#include "render/sampler.h"

#include "core/error.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <functional>
#include <gtest/gtest.h>
#include <set>

namespace cuticle {
namespace {

constexpr SamplerKind kBoth[] = {SamplerKind::LowDiscrepancy, SamplerKind::Independent};

TEST(Sampler, IsAFunctionOfSeedPixelAndSample) {
    for (const SamplerKind kind : kBoth) {
        PixelSampler a(kind, 16, 5), b(kind, 16, 5), other(kind, 16, 6);
        int same = 0, sameSeed = 0;
        for (int i = 0; i < 200; ++i) {
            a.Start(i, 7, i);
            // b comes from elsewhere and asks in the same order.
            b.Start(100, 100, 3);
            b.Get2D();
            b.Start(i, 7, i);
            other.Start(i, 7, i);
            EXPECT_EQ(a.Get1D(), b.Get1D());
            const Point2f p = a.Get2D(), q = other.Get2D();
            EXPECT_EQ(p, b.Get2D());
            const auto four = a.Get4D();
            EXPECT_EQ(four, b.Get4D());
            same += four[0] == four[2] || p.x == p.y;
            sameSeed += p.x == q.x || p.y == q.y;
        }
        EXPECT_LE(same, 1);
        EXPECT_LE(sameSeed, 1);
    }
}

TEST(Sampler, StaysBelowOne) {
    for (const SamplerKind kind : kBoth) {
        PixelSampler sampler(kind, 1, 0);
        for (int i = 0; i < 300000; ++i) {
            sampler.Start(i % 64, -3, i);
            for (const float v : sampler.Get4D()) {
                ASSERT_GE(v, 0);
                ASSERT_LE(v, OneMinusEpsilon);
            }
        }
    }
}

// A (0,2)-sequence: of the 2^k samples of a set, one lies in each elementary interval of area 2^-k, for every
// shape 2^-a by 2^-(k-a), in every pair of dimensions of every pixel; and the one-dimensional ones likewise.
TEST(Sampler, EveryPairIsStratifiedInElementaryIntervals) {
    for (int pixel = 0; pixel < 40; ++pixel)
        for (int k = 0; k <= 9; ++k)
            for (const int block : {0, 1, 5}) {
                const int n = 1 << k;
                std::vector<std::set<int>> seen(static_cast<size_t>(3 * (k + 1)));
                std::set<int> seen1;
                for (int i = block * n; i < (block + 1) * n; ++i) {
                    PixelSampler sampler(SamplerKind::LowDiscrepancy, n, 99);
                    sampler.Start(pixel, 3 * pixel, i);
                    const Point2f pairs[] = {sampler.Get2D(), {}, {}};
                    const float one = sampler.Get1D();
                    const auto four = sampler.Get4D();
                    const Point2f all[] = {pairs[0], {four[0], four[1]}, {four[2], four[3]}};
                    seen1.insert(static_cast<int>(one * static_cast<float>(n)));
                    for (int d = 0; d < 3; ++d)
                        for (int a = 0; a <= k; ++a) {
                            const int x = static_cast<int>(all[d].x * static_cast<float>(1 << a));
                            const int y = static_cast<int>(all[d].y * static_cast<float>(1 << (k - a)));
                            seen[static_cast<size_t>(d * (k + 1) + a)].insert(x * (1 << (k - a)) + y);
                        }
                }
                ASSERT_EQ(static_cast<int>(seen1.size()), n) << "pixel " << pixel << " block " << block;
                for (const auto &cells : seen)
                    ASSERT_EQ(static_cast<int>(cells.size()), n) << "pixel " << pixel << " block " << block;
            }
}

// Any two dimensions, of one pixel or of neighbours, are uncorrelated over pixels: the sum of the products of
// n centred values has mean 0 and variance n / 144. Significance: 5 standard deviations in each of the 64
// pairs.
TEST(Sampler, DimensionsAndPixelsDoNotKnowEachOther) {
    for (const SamplerKind kind : kBoth) {
        constexpr int kDimensions = 8, kPixels = 150, kSamples = 16;
        double product[kDimensions][kDimensions] = {};
        int n = 0;
        const auto draw = [&](int x, int y, int i) {
            PixelSampler sampler(kind, kSamples, 1);
            sampler.Start(x, y, i);
            std::array<float, kDimensions> v;
            const auto a = sampler.Get4D();
            const Point2f b = sampler.Get2D();
            v = {a[0], a[1], a[2], a[3], b.x, b.y, sampler.Get1D(), sampler.Get1D()};
            return v;
        };
        for (int y = 0; y < kPixels; ++y)
            for (int x = 0; x < kPixels; ++x) {
                // One sample a pixel, so that the strata of a pixel do not enter.
                const int i = (x * 7 + y * 3) % kSamples;
                const auto here = draw(x, y, i), there = draw(x + 1, y, i);
                for (int d = 0; d < kDimensions; ++d)
                    for (int e = 0; e < kDimensions; ++e)
                        // Below the diagonal within the pixel, on it and above with the neighbour.
                        product[d][e] +=
                            (static_cast<double>(here[static_cast<size_t>(d)]) - 0.5) *
                            (static_cast<double>((d > e ? here : there)[static_cast<size_t>(e)]) - 0.5);
                ++n;
            }
        for (int d = 0; d < kDimensions; ++d)
            for (int e = 0; e < kDimensions; ++e)
                EXPECT_LT(std::abs(product[d][e]), 5 * std::sqrt(n / 144.))
                    << "dimensions " << d << ", " << e << " of kind " << static_cast<int>(kind)
                    << ", n = " << n;
    }
}

// Within one pixel, dimensions that are not a pair are as uncorrelated as independent ones: the mean square
// of the correlation of n points is 1/n for those, 1/(n - 1) for strata in random order. (Under a nested
// scramble of the order it is 1.58/n: what this test was written to catch.)
TEST(Sampler, PaddedDimensionsAreUncorrelatedWithinAPixel) {
    constexpr int kPixels = 4000;
    for (const int n : {8, 16, 64, 100, 256}) {
        double sum[3] = {};
        for (int pixel = 0; pixel < kPixels; ++pixel) {
            double product[3] = {};
            for (int i = 0; i < n; ++i) {
                PixelSampler sampler(SamplerKind::LowDiscrepancy, n, 4);
                sampler.Start(pixel % 100, pixel / 100, i);
                const auto v = sampler.Get4D();
                const auto c = [](float x) { return std::sqrt(12.) * (static_cast<double>(x) - 0.5); };
                product[0] += c(v[0]) * c(v[2]);
                product[1] += c(v[0]) * c(v[3]);
                product[2] += c(v[1]) * c(sampler.Get1D());
            }
            for (int k = 0; k < 3; ++k)
                sum[k] += Sqr(product[k] / n);
        }
        // The mean of kPixels squares of nearly normal numbers: relative standard deviation sqrt(2 / kPixels)
        // = 2.2%; 5 of those for each of 15 cases.
        for (const double s : sum)
            EXPECT_NEAR(s / kPixels * n, n / (n - 1.), 5 * std::sqrt(2. / kPixels))
                << kPixels << " pixels, " << n << " samples";
    }
}

// The order of the samples is a permutation, and over many pixels every sample meets every stratum equally
// often. Chi-squared with (n - 1)^2 degrees of freedom, at significance 1e-4 for each n.
TEST(Sampler, EverySampleMeetsEveryStratum) {
    for (const int n : {2, 8, 16, 64}) {
        std::vector<int> counts(static_cast<size_t>(n * n));
        constexpr int kPixels = 20000;
        PixelSampler sampler(SamplerKind::LowDiscrepancy, n, 8);
        for (int pixel = 0; pixel < kPixels; ++pixel)
            for (int i = 0; i < n; ++i) {
                sampler.Start(pixel, 0, i);
                ++counts[static_cast<size_t>(i * n +
                                             static_cast<int>(sampler.Get1D() * static_cast<float>(n)))];
            }
        double chi2 = 0;
        const double expected = static_cast<double>(kPixels) / n;
        for (const int c : counts)
            chi2 += Sqr(c - expected) / expected;
        // Each pixel fills a permutation matrix, whose rows and columns both sum to 1: the statistic has
        // (n - 1)^2 degrees of freedom and is larger by n / (n - 1) than for independent draws.
        const double bound = quantile(boost::math::chi_squared(Sqr(n - 1.)), 1 - 1e-4);
        EXPECT_LT(chi2 * (n - 1) / n, bound) << n << " samples, " << kPixels << " pixels";
    }
}

// Uniform over pixels: chi-squared over 16 x 16 cells of one sample of each of 200 x 200 pixels, at
// significance 1e-4 for each of the 8 tests.
TEST(Sampler, SamplesAreUniformAcrossPixels) {
    const double bound = quantile(boost::math::chi_squared(255), 1 - 1e-4);
    for (const SamplerKind kind : kBoth)
        for (const int index : {0, 1, 7, 1000}) {
            std::array<int, 256> counts{};
            constexpr int kSide = 200;
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    PixelSampler sampler(kind, 4, 12);
                    sampler.Start(x, y, index);
                    sampler.Get1D();
                    const Point2f p = sampler.Get2D();
                    ++counts[static_cast<size_t>(p.x * 16) * 16 + static_cast<size_t>(p.y * 16)];
                }
            constexpr double expected = kSide * kSide / 256.;
            double chi2 = 0;
            for (const int c : counts)
                chi2 += Sqr(c - expected) / expected;
            EXPECT_LT(chi2, bound) << "kind " << static_cast<int>(kind) << " sample " << index;
        }
}

// Mean squared error of a pixel's mean of f over many pixels.
double MeanSquaredError(SamplerKind kind, int spp, const std::function<double(Point2f)> &f, double exact) {
    double sum = 0;
    constexpr int kPixels = 400;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        PixelSampler sampler(kind, spp, 31);
        double mean = 0;
        for (int i = 0; i < spp; ++i) {
            sampler.Start(pixel, 5, i);
            sampler.Get2D();
            mean += f(sampler.Get2D());
        }
        sum += Sqr(mean / spp - exact);
    }
    return sum / kPixels;
}

// Owen's scramble brings the variance of a smooth integrand down as n^-3 (but for logarithms) on powers of
// two, against n^-1; at other counts there is still a clear gain.
TEST(Sampler, ConvergesFasterThanRandom) {
    const auto smooth = [](Point2f p) {
        return std::exp(static_cast<double>(p.x)) * std::cos(2 * static_cast<double>(p.y));
    };
    const double exact = (std::exp(1.) - 1) * std::sin(2.) / 2;
    const double random256 = MeanSquaredError(SamplerKind::Independent, 256, smooth, exact);
    const double owen256 = MeanSquaredError(SamplerKind::LowDiscrepancy, 256, smooth, exact);
    const double owen16 = MeanSquaredError(SamplerKind::LowDiscrepancy, 16, smooth, exact);
    EXPECT_GT(random256 / owen256, 1000) << "gain in variance over random at 256";
    const double rate = std::log2(owen16 / owen256) / 4;
    EXPECT_GT(rate, 2.5) << "exponent of the variance's decay from 16 to 256";
    for (const int spp : {3, 7, 100, 200}) {
        const double gain = MeanSquaredError(SamplerKind::Independent, spp, smooth, exact) /
                            MeanSquaredError(SamplerKind::LowDiscrepancy, spp, smooth, exact);
        EXPECT_GT(gain, 1.2) << "gain in variance over random at " << spp;
    }
    // A discontinuity is worth less, but not nothing.
    const auto edge = [](Point2f p) { return p.x + 0.7f * p.y < 0.8f ? 1. : 0.; };
    const double area = (0.8 * 0.8 / 2 - 0.1 * 0.1 / 2) / 0.7;
    EXPECT_GT(MeanSquaredError(SamplerKind::Independent, 256, edge, area) /
                  MeanSquaredError(SamplerKind::LowDiscrepancy, 256, edge, area),
              8);
}

Entity Named(const std::string &type) {
    Entity entity;
    entity.type = type;
    return entity;
}
void Set(Entity *entity, const std::string &name, int value) {
    Param p;
    p.type = ParamType::Integer;
    p.name = name;
    p.numbers = {static_cast<double>(value)};
    entity->params.params.push_back(std::move(p));
}

TEST(MakeSampler, TakesPbrtsNamesAndCounts) {
    for (const char *name : {"halton", "sobol", "02sequence", "lowdiscrepancy", "maxmindist"}) {
        Entity entity = Named(name);
        EXPECT_EQ(MakeSampler(entity).spp, 16);
        EXPECT_EQ(MakeSampler(entity).kind, SamplerKind::LowDiscrepancy);
        Set(&entity, "pixelsamples", 77);
        EXPECT_EQ(MakeSampler(entity).spp, 77);
    }
    EXPECT_EQ(MakeSampler(Named("random")).kind, SamplerKind::Independent);
    EXPECT_EQ(MakeSampler(Named("random")).spp, 4);
    Entity stratified = Named("stratified");
    EXPECT_EQ(MakeSampler(stratified).spp, 16);
    Set(&stratified, "xsamples", 3);
    Set(&stratified, "ysamples", 5);
    EXPECT_EQ(MakeSampler(stratified).spp, 15);
    for (const int bad : {0, -4}) {
        Entity entity = Named("sobol");
        Set(&entity, "pixelsamples", bad);
        EXPECT_THROW(MakeSampler(entity), Error);
    }
    try {
        MakeSampler(Named("haltom"));
        FAIL() << "an unknown sampler was taken";
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("\"halton\""), std::string::npos) << e.what();
    }
}

} // namespace
} // namespace cuticle
