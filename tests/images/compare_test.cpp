// Comparing pictures: measures with known values, the laws of FLIP, and the error rate of the z-test.
#include "images/compare.h"

#include "core/error.h"
#include "images/flip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>
#include <random>

using namespace cuticle;

namespace {

const std::vector<std::string> rgbNames = {"R", "G", "B"};
const std::vector<std::string> varianceNames = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};

Image Constant(int width, int height, const Spectrum &colour) {
    Image image(width, height, rgbNames);
    for (size_t i = 0; i < image.data.size(); ++i)
        image.data[i] = colour[static_cast<int>(i % 3)];
    return image;
}

// A picture with smooth colours, edges and points.
Image Pattern(int width, int height) {
    Image image(width, height, rgbNames);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool edge = x > width / 2, point = x % 11 == 5 && y % 7 == 3;
            image.At(x, y, 0) = 0.2f + 0.5f * static_cast<float>(x) / static_cast<float>(width);
            image.At(x, y, 1) = edge ? 0.7f : 0.1f;
            image.At(x, y, 2) = point ? 0.9f : 0.4f * static_cast<float>(y) / static_cast<float>(height);
        }
    return image;
}

// The pattern plus noise of a given amplitude; the same noise, only larger, for a larger amplitude.
Image Noisy(const Image &image, float amplitude) {
    Image noisy = image;
    uint32_t state = 12345;
    for (float &v : noisy.data) {
        state = state * 1664525u + 1013904223u;
        v = std::max(0.f, v + amplitude * (static_cast<float>(state >> 8) / 8388608.f - 1));
    }
    return noisy;
}

// FLIP as the paper writes it, plainly: dense two-dimensional kernels, Y Cx Cz with its scales and offset, no
// product of one-dimensional filters. The oracle of FLIP().
class PlainFLIP {
  public:
    using Triple = std::array<double, 3>;

    PlainFLIP(const Image &test, const Image &reference, double pixelsPerDegree)
        : width_(test.width), height_(test.height), ppd_(pixelsPerDegree), test_(Opponent(test)),
          reference_(Opponent(reference)) {}

    double At(int x, int y) const {
        const double largest = std::pow(Distance(Lab({0, 1, 0}), Lab({0, 0, 1})), 0.7);
        const double error = std::pow(Distance(Seen(test_, x, y), Seen(reference_, x, y)), 0.7);
        const double colour = error < 0.4 * largest
                                  ? 0.95 / (0.4 * largest) * error
                                  : 0.95 + 0.05 * (error - 0.4 * largest) / (largest - 0.4 * largest);
        const double edges = std::abs(Feature(test_, x, y, false) - Feature(reference_, x, y, false));
        const double points = std::abs(Feature(test_, x, y, true) - Feature(reference_, x, y, true));
        return std::pow(colour, 1 - std::sqrt(std::max(edges, points) / std::sqrt(2.)));
    }

  private:
    static constexpr Triple white = {0.950428545, 1, 1.088900371};

    static Triple XYZ(const Triple &c) {
        return {10135552. / 24577794 * c[0] + 8788810. / 24577794 * c[1] + 4435075. / 24577794 * c[2],
                2613072. / 12288897 * c[0] + 8788810. / 12288897 * c[1] + 887015. / 12288897 * c[2],
                1425312. / 73733382 * c[0] + 8788810. / 73733382 * c[1] + 70074185. / 73733382 * c[2]};
    }
    std::vector<Triple> Opponent(const Image &image) const {
        std::vector<Triple> result;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                const Spectrum rgb = image.RGB(x, y).Clamp(0, 1);
                const Triple c = XYZ({rgb[0], rgb[1], rgb[2]});
                result.push_back({116 * c[1] / white[1] - 16, 500 * (c[0] / white[0] - c[1] / white[1]),
                                  200 * (c[1] / white[1] - c[2] / white[2])});
            }
        return result;
    }
    const Triple &Pixel(const std::vector<Triple> &p, int x, int y) const {
        return p[static_cast<size_t>(std::clamp(y, 0, height_ - 1) * width_ + std::clamp(x, 0, width_ - 1))];
    }
    Triple Seen(const std::vector<Triple> &picture, int x, int y) const {
        const double parameters[3][4] = {
            {1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
        const int r =
            static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi<double> * kPi<double>)) * ppd_));
        Triple blurred{};
        for (size_t c = 0; c < 3; ++c) {
            const auto &[a1, b1, a2, b2] = parameters[c];
            double sum = 0, weights = 0;
            for (int j = -r; j <= r; ++j)
                for (int i = -r; i <= r; ++i) {
                    const double z = (i * i + j * j) / (ppd_ * ppd_), pi = kPi<double>;
                    const double g = a1 * std::sqrt(pi / b1) * std::exp(-pi * pi * z / b1) +
                                     a2 * std::sqrt(pi / b2) * std::exp(-pi * pi * z / b2);
                    sum += g * Pixel(picture, x + i, y + j)[c], weights += g;
                }
            blurred[c] = sum / weights;
        }
        // Back to linear RGB by the published inverse, rounded to 9 decimals there
        const double yRelative = (blurred[0] + 16) / 116;
        const Triple v = {white[0] * (yRelative + blurred[1] / 500), yRelative,
                          white[2] * (yRelative - blurred[2] / 200)};
        const double m[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                {-0.969224334, 1.875930071, 0.041554224},
                                {0.055639423, -0.204011202, 1.057148933}};
        Triple rgb{};
        for (size_t i = 0; i < 3; ++i)
            rgb[i] = std::clamp(m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2], 0., 1.);
        return Lab(rgb);
    }
    static Triple Lab(const Triple &rgb) {
        const Triple c = XYZ(rgb);
        Triple f{};
        for (size_t i = 0; i < 3; ++i) {
            const double t = c[i] / white[i], d = 6. / 29;
            f[i] = t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4. / 29;
        }
        const double lightness = 116 * f[1] - 16;
        return {lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])};
    }
    static double Distance(const Triple &a, const Triple &b) {
        return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
    }
    double Feature(const std::vector<Triple> &picture, int x, int y, bool points) const {
        const double sd = 0.5 * 0.082 * ppd_;
        const int r = static_cast<int>(std::ceil(3 * sd));
        const auto kernel = [&](int i, int j) {
            const double g = std::exp(-(i * i + j * j) / (2 * sd * sd));
            return points ? (i * i / (sd * sd) - 1) * g : -i * g;
        };
        double positive = 0, negative = 0;
        for (int j = -r; j <= r; ++j)
            for (int i = -r; i <= r; ++i)
                (kernel(i, j) > 0 ? positive : negative) += std::abs(kernel(i, j));
        double gx = 0, gy = 0;
        for (int j = -r; j <= r; ++j)
            for (int i = -r; i <= r; ++i) {
                const double k = kernel(i, j) / (kernel(i, j) > 0 ? positive : negative);
                gx += k * (Pixel(picture, x + i, y + j)[0] + 16) / 116;
                gy += k * (Pixel(picture, x + j, y + i)[0] + 16) / 116;
            }
        return std::hypot(gx, gy);
    }

    int width_, height_;
    double ppd_;
    std::vector<Triple> test_, reference_;
};

// The quantile of the standard normal distribution, by bisection of erfc.
double NormalQuantile(double p) {
    double low = -10, high = 10;
    for (int i = 0; i < 80; ++i) {
        const double middle = (low + high) / 2;
        (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? low : high) = middle;
    }
    return (low + high) / 2;
}

} // namespace

TEST(Compare, IdenticalPicturesDoNotDiffer) {
    const Image image = Pattern(31, 17);
    const Comparison c = Compare(image, image);
    EXPECT_TRUE(c.Valid());
    EXPECT_EQ(c.mse, 0);
    EXPECT_EQ(c.relativeMSE, 0);
    EXPECT_EQ(c.meanDifference, 0);
    EXPECT_EQ(c.p99Difference, 0);
    EXPECT_EQ(c.flip, 0);
    EXPECT_FALSE(c.zTest);
}

TEST(Compare, KnownValues) {
    const Comparison c = Compare(Constant(8, 4, {0.5f, 1, 2}), Constant(8, 4, {0.25f, 1, 4}));
    EXPECT_NEAR(c.mse, (0.0625 + 0 + 4) / 3, 1e-12);
    EXPECT_NEAR(c.relativeMSE, (0.0625 / 0.0725 + 4 / 16.01) / 3, 1e-12);
    EXPECT_NEAR(c.meanDifference, (0.25 + 0 + 2) / 3, 1e-12);
    EXPECT_EQ(c.p99Difference, 2);
    EXPECT_EQ(c.width, 8);
    EXPECT_EQ(c.flipMap.size(), 32u);
    // The reference's values stand below: the measure is not symmetric
    const Comparison swapped = Compare(Constant(8, 4, {0.25f, 1, 4}), Constant(8, 4, {0.5f, 1, 2}));
    EXPECT_NEAR(swapped.relativeMSE, (0.0625 / 0.26 + 4 / 4.01) / 3, 1e-12);
}

// 99% of 300 differences 0, 1, ... 299 are no larger than number 297 of the sorted ones, which is 296.
TEST(Compare, PercentileIsByRank) {
    Image a(100, 1, rgbNames);
    const Image b(100, 1, rgbNames);
    for (size_t i = 0; i < 300; ++i)
        a.data[i * 7 % 300] = static_cast<float>(i);
    EXPECT_EQ(Compare(a, b).p99Difference, 296);
    // One value is its own percentile
    Image single(1, 1, {"Y"});
    single.data[0] = 3;
    EXPECT_EQ(Compare(single, Image(1, 1, {"Y"})).p99Difference, 3);
}

TEST(Compare, GreyAndColourCompare) {
    Image grey(4, 4, {"Y"});
    for (float &v : grey.data)
        v = 0.5f;
    EXPECT_EQ(Compare(grey, Constant(4, 4, Spectrum(0.5f))).mse, 0);
}

TEST(Compare, PixelsThatAreNoNumbersAreCountedAndFail) {
    for (const float broken : {std::nanf(""), Infinity, -Infinity}) {
        Image image = Pattern(9, 9);
        image.At(2, 3, 1) = broken;
        for (const auto &[a, b] :
             {std::pair(image, Pattern(9, 9)), std::pair(Pattern(9, 9), image), std::pair(image, image)}) {
            const Comparison c = Compare(a, b);
            EXPECT_EQ(c.badPixels, 1u);
            EXPECT_FALSE(c.Valid());
            EXPECT_EQ(c.mse, 0); // over the others
            EXPECT_TRUE(std::isfinite(c.flip));
        }
    }
    // Every pixel bad: nothing is known, and that is not zero
    const Image bad = Constant(3, 3, Spectrum(std::nanf("")));
    EXPECT_EQ(Compare(bad, bad).badPixels, 9u);
    EXPECT_TRUE(std::isnan(Compare(bad, bad).mse));
    EXPECT_TRUE(std::isnan(Compare(bad, bad).p99Difference));
}

TEST(Compare, MismatchIsAnError) {
    EXPECT_THROW(Compare(Pattern(4, 5), Pattern(5, 4)), Error);
    EXPECT_THROW(Compare(Image(), Image()), Error);
    EXPECT_THROW(FLIP(Pattern(4, 5), Pattern(4, 6)), Error);
    EXPECT_THROW(FLIP(Pattern(4, 5), Pattern(4, 5), 0), Error);
    EXPECT_THROW(FLIP(Pattern(4, 5), Pattern(4, 5), std::nan("")), Error);
    EXPECT_THROW(ErrorImage(Pattern(4, 5), Pattern(4, 5), Comparison()), Error);
}

// L* of white is 100, so HyAB is 100; 100^0.7 = 25.119. Green and blue: L*a*b* (87.737, -86.185, 83.181) and
// (32.303, 79.197, -107.864); Hunt-adjusted HyAB 203.31, to the 0.7 41.28. 0.95 + 0.05 (25.119 - 16.512) /
// 24.768.
TEST(FLIP, BlackAgainstWhite) {
    const auto map = FLIP(Constant(40, 30, Spectrum(0)), Constant(40, 30, Spectrum(1)));
    for (const float v : map)
        ASSERT_NEAR(v, 0.96738, 2e-5);
}

TEST(FLIP, GreenAgainstBlueIsTheLargest) {
    for (const float v : FLIP(Constant(8, 8, {0, 1, 0}), Constant(8, 8, {0, 0, 1})))
        ASSERT_NEAR(v, 1, 1e-6);
}

TEST(FLIP, AgreesWithThePlainForm) {
    const Image reference = Pattern(26, 19), test = Noisy(reference, 0.2f);
    for (const double ppd : {20., 67.}) {
        const auto map = FLIP(test, reference, ppd);
        const PlainFLIP plain(test, reference, ppd);
        double largest = 0;
        for (int y = 0; y < 19; y += 3)
            for (int x = 0; x < 26; ++x)
                largest = std::max(largest, std::abs(map[static_cast<size_t>(y * 26 + x)] - plain.At(x, y)));
        EXPECT_LT(largest, 2e-6) << "at " << ppd << " pixels per degree";
    }
}

TEST(FLIP, IsSymmetricAndBounded) {
    const Image a = Pattern(40, 25), b = Noisy(a, 1.5f);
    const auto ab = FLIP(a, b), ba = FLIP(b, a);
    for (size_t i = 0; i < ab.size(); ++i) {
        ASSERT_EQ(ab[i], ba[i]);
        ASSERT_GE(ab[i], 0);
        ASSERT_LE(ab[i], 1);
    }
}

TEST(FLIP, GrowsWithNoise) {
    const Image reference = Pattern(64, 48);
    double previous = 0;
    for (const float amplitude : {0.003f, 0.01f, 0.03f, 0.1f, 0.3f}) {
        const double flip = Compare(Noisy(reference, amplitude), reference).flip;
        EXPECT_GT(flip, 1.2 * previous) << "amplitude " << amplitude;
        previous = flip;
    }
    EXPECT_LT(previous, 1);
}

// A fine checkerboard is its mean seen from far away, and is not from near.
TEST(FLIP, DistanceHidesFineDetail) {
    Image checker = Constant(64, 64, Spectrum(0));
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (size_t c = 0; c < 3; ++c)
                checker.At(x, y, c) = (x + y) % 2 ? 0.6f : 0.4f;
    const Image grey = Constant(64, 64, Spectrum(0.5f));
    double previous = 1;
    for (const double ppd : {10., 20., 40., 80.}) {
        const auto map = FLIP(checker, grey, ppd);
        const double mean = std::accumulate(map.begin(), map.end(), 0.) / static_cast<double>(map.size());
        EXPECT_LT(mean, previous) << ppd;
        previous = mean;
    }
    EXPECT_LT(previous, 0.05);
}

TEST(FLIP, NaNShowsAsMagenta) {
    Image a = Constant(5, 5, Spectrum(0)), b = a;
    for (size_t c = 0; c < 3; ++c)
        a.At(2, 2, c) = std::nanf(""), b.At(2, 2, c) = c == 1 ? 0.f : 1.f;
    const Image black = Constant(5, 5, Spectrum(0));
    EXPECT_EQ(FLIP(a, black), FLIP(b, black));
    EXPECT_GT(FLIP(a, black)[12], 0.3f);
}

TEST(ZTest, LevelIsSidaks) {
    Image a(20, 10, varianceNames);
    const auto test = Compare(a, a).zTest;
    ASSERT_TRUE(test);
    EXPECT_EQ(test->values, 600u);
    EXPECT_NEAR(1 - std::pow(1 - test->level, 600), 0.01, 1e-12);
    EXPECT_TRUE(test->passed);
    EXPECT_EQ(test->rejectedPixels, 0u);
    // One picture without variances: no test
    EXPECT_FALSE(Compare(a, Image(20, 10, rgbNames)).zTest);
}

// Differences whose z-scores are the quantiles of the normal distribution pass; the same, twice as wide, do
// not.
TEST(ZTest, PassesTheNormalDistribution) {
    const size_t n = 64 * 64 * 3;
    for (const double width : {1., 2.}) {
        Image a(64, 64, varianceNames), b = a;
        for (size_t i = 0; i < n; ++i) {
            const size_t shuffled = i * 7919 % n;
            const double sigma = 0.01 + 0.001 * static_cast<double>(i % 17);
            const double z =
                width * NormalQuantile((static_cast<double>(shuffled) + 0.5) / static_cast<double>(n));
            const size_t at = i / 3 * 6 + i % 3;
            b.data[at] = 0.5f;
            a.data[at] = static_cast<float>(0.5 + z * sigma);
            // Both pictures share the variance
            a.data[at + 3] = static_cast<float>(sigma * sigma * 0.75);
            b.data[at + 3] = static_cast<float>(sigma * sigma * 0.25);
        }
        const auto test = Compare(a, b).zTest;
        ASSERT_TRUE(test);
        EXPECT_EQ(test->passed, width == 1)
            << test->rejectedPixels << " of 4096 pixels rejected, level " << test->level;
        EXPECT_EQ(test->rejectedPixels == 0, width == 1);
    }
}

TEST(ZTest, FindsTheFractionThatIsWrong) {
    Image a(50, 40, varianceNames), b = a;
    for (size_t i = 0; i < a.data.size(); ++i)
        a.data[i] = b.data[i] = i % 6 < 3 ? 1.f : 1e-4f;
    for (int y = 0; y < 10; ++y)
        a.At(y, y, 1) = 1.2f; // 14 standard deviations
    const auto test = Compare(a, b).zTest;
    ASSERT_TRUE(test);
    EXPECT_EQ(test->rejectedPixels, 10u);
    EXPECT_DOUBLE_EQ(test->rejectedFraction, 0.005);
    EXPECT_FALSE(test->passed);
    CompareOptions lenient;
    lenient.allowedRejected = 0.005;
    EXPECT_TRUE(Compare(a, b, lenient).zTest->passed);
}

TEST(ZTest, WithoutVarianceOnlyRoundingIsForgiven) {
    Image a(2, 1, varianceNames), b = a;
    a.At(0, 0, 0) = 1, b.At(0, 0, 0) = std::nextafter(1.f, 2.f);
    EXPECT_EQ(Compare(a, b).zTest->rejectedPixels, 0u);
    b.At(0, 0, 0) = 1.0001f;
    EXPECT_EQ(Compare(a, b).zTest->rejectedPixels, 1u);
    a.At(1, 0, 0) = 1e-30f;
    EXPECT_EQ(Compare(a, b).zTest->rejectedPixels, 2u);
}

TEST(ZTest, BrokenVariancesAreBadPixels) {
    for (const float broken : {-1e-6f, std::nanf(""), Infinity}) {
        Image a(3, 3, varianceNames), b = a;
        b.At(1, 1, 4) = broken;
        const Comparison c = Compare(a, b);
        EXPECT_EQ(c.badPixels, 1u);
        EXPECT_EQ(c.zTest->values, 24u);
        EXPECT_FALSE(c.Valid());
    }
}

// The law that the correction promises: of pictures that differ by chance alone, alpha are rejected. 3000
// pictures of 100 pixels at alpha = 0.2 with a fixed seed; the bound is 4.9 standard deviations of the count
// (1e-6).
TEST(ZTest, RejectsAlphaOfRightPictures) {
    std::mt19937_64 random(1);
    const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
    const int pictures = 3000;
    CompareOptions options;
    options.alpha = 0.2;
    int rejected = 0;
    for (int k = 0; k < pictures; ++k) {
        Image a(10, 10, varianceNames), b = a;
        for (size_t i = 0; i < a.data.size(); ++i)
            if (i % 6 >= 3) {
                a.data[i] = b.data[i] = 0.5f;
                a.data[i - 3] = static_cast<float>(1 + std::sqrt(-2 * std::log(uniform())) *
                                                           std::cos(2 * kPi<double> * uniform()));
                b.data[i - 3] = 1;
            }
        rejected += Compare(a, b, options).zTest->rejectedPixels > 0;
    }
    const double expected = 0.2 * pictures, deviation = std::sqrt(pictures * 0.2 * 0.8);
    EXPECT_NEAR(rejected, expected, 4.9 * deviation)
        << rejected << " of " << pictures << " pictures, significance 1e-6";
}

TEST(ErrorImage, ShowsFLIPAndDifferences) {
    const Image a = Constant(6, 4, Spectrum(1)), b = Constant(6, 4, Spectrum(0));
    Image half = a;
    for (size_t c = 0; c < 3; ++c)
        half.At(5, 3, c) = 0;
    const Comparison same = Compare(a, a), differ = Compare(a, b);
    EXPECT_EQ(ErrorImage(a, a, same).RGB(0, 0), Spectrum(0));
    const Image error = ErrorImage(a, b, differ);
    EXPECT_EQ(error.RGB(0, 0)[0], 1);
    EXPECT_GT(error.RGB(0, 0)[2], 0.5f);
    EXPECT_EQ(error.At(0, 0, static_cast<size_t>(error.ChannelIndex("flip"))), differ.flipMap[0]);
    EXPECT_EQ(error.At(0, 0, static_cast<size_t>(error.ChannelIndex("difference.G"))), 1);
}
