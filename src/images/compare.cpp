//> Compare two pictures
#include "images/compare.h"

#include "core/error.h"
#include "images/flip.h"
#include "images/planes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

//> Collect the variances of a picture's pixels
std::optional<Planes> Variances(const Image &image) {
    const size_t width = static_cast<size_t>(image.width), height = static_cast<size_t>(image.height);
    Planes planes{width, height, {}};
    constexpr std::array<const char *, 3> names = {"variance.R", "variance.G", "variance.B"};
    for (size_t c = 0; c < 3; ++c) {
        const int index = image.ChannelIndex(names[c]);
        if (index < 0)
            return std::nullopt;
        for (size_t y = 0; y < height; ++y)
            for (size_t x = 0; x < width; ++x)
                planes.channel[c].push_back(image.At(x, y, static_cast<size_t>(index)));
    }
    return planes;
}
//<

//> Find the pixels that are no numbers
// Written so that NaN fails each condition. A pixel is bad as a whole: one broken channel shows a broken
// sample.
std::vector<char> FindBadPixels(const std::vector<const Planes *> &colours,
                                const std::vector<const Planes *> &variances) {
    std::vector<char> bad(colours[0]->Size(), 0);
    for (size_t i = 0; i < bad.size(); ++i)
        for (size_t c = 0; c < 3; ++c) {
            for (const Planes *p : colours)
                bad[i] |= !std::isfinite(p->channel[c][i]);
            for (const Planes *p : variances)
                bad[i] |= !(p->channel[c][i] >= 0 && std::isfinite(p->channel[c][i]));
        }
    return bad;
}
//<

//> Measure the differences of values
void MeasureValues(const Planes &a, const Planes &b, const std::vector<char> &bad, double epsilon,
                   Comparison *result) {
    std::vector<double> differences;
    double squares = 0, relative = 0, sum = 0;
    for (size_t i = 0; i < a.Size(); ++i)
        for (size_t c = 0; c < 3 && !bad[i]; ++c) {
            const double d = a.channel[c][i] - b.channel[c][i];
            squares += d * d;
            relative += d * d / (Sqr(b.channel[c][i]) + epsilon);
            sum += std::abs(d);
            differences.push_back(std::abs(d));
        }
    //> Take the means, and the 99th percentile by rank
    // With no pixel left the means are 0/0: NaN, which is what is known of them.
    const double n = static_cast<double>(differences.size());
    result->mse = squares / n;
    result->relativeMSE = relative / n;
    result->meanDifference = sum / n;
    if (differences.empty()) {
        result->p99Difference = std::nan("");
        return;
    }
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * n)) - 1;
    std::nth_element(differences.begin(), differences.begin() + rank, differences.end());
    result->p99Difference = differences[static_cast<size_t>(rank)];
    //<
}
//<

//> Average over blocks of pixels
// Means over blocks of side * side pixels, leaving bad ones out; of variances (power 2) the variances of
// these means. A block of bad pixels is NaN.
Planes AverageBlocks(const Planes &planes, const std::vector<char> &bad, size_t side, double power) {
    Planes blocks{(planes.width + side - 1) / side, (planes.height + side - 1) / side, {}};
    std::vector<double> counts(blocks.width * blocks.height);
    for (auto &channel : blocks.channel)
        channel.resize(counts.size());
    for (size_t i = 0; i < planes.Size(); ++i) {
        const size_t block = i / planes.width / side * blocks.width + i % planes.width / side;
        counts[block] += !bad[i];
        for (size_t c = 0; c < 3 && !bad[i]; ++c)
            blocks.channel[c][block] += planes.channel[c][i];
    }
    for (auto &channel : blocks.channel)
        for (size_t i = 0; i < counts.size(); ++i)
            channel[i] /= std::pow(counts[i], power);
    return blocks;
}
//<

//> Test the differences against their variances
ZTest TestDifferences(const Planes &a, const Planes &b, const Planes &varianceA, const Planes &varianceB,
                      const std::vector<char> &bad, const CompareOptions &options) {
    ZTest test;
    size_t pixels = 0;
    for (const char isBad : bad)
        pixels += !isBad;
    test.values = 3 * pixels;
    //> Correct the significance for the number of tests
    // Of n independent tests at level s, one at least rejects with probability 1 - (1 - s)^n. Solve for the
    // level at which this is alpha (Sidak 1967), with the logarithms that keep s of 1e-9.
    test.level =
        test.values > 0 ? -std::expm1(std::log1p(-options.alpha) / static_cast<double>(test.values)) : 0;
    //<
    std::array<double, 3> sum{}, variances{}; // over the picture, of differences and of their variances
    for (size_t i = 0; i < a.Size(); ++i) {
        bool rejected = false;
        for (size_t c = 0; c < 3 && !bad[i]; ++c) {
            //> Find how likely so large a difference is by chance
            // Both means are taken for normal, of the variances that the renderer measured. Pictures are
            // stored in binary32, so that even a pixel without variance may be off by its last bits.
            const double va = a.channel[c][i], vb = b.channel[c][i];
            const double rounding = 1e-6 * std::max(std::abs(va), std::abs(vb));
            const double variance = varianceA.channel[c][i] + varianceB.channel[c][i] + Sqr(rounding);
            const double p = va == vb ? 1 : std::erfc(std::abs(va - vb) / std::sqrt(2 * variance));
            //<
            rejected |= !(p >= test.level);
            sum[c] += va - vb;
            variances[c] += variance;
        }
        test.rejectedPixels += rejected;
    }
    //> Measure the bias of the whole picture
    // What is too small to see in any pixel shows in the sum of all: the bias of the whole picture, in its
    // standard deviations.
    for (size_t c = 0; c < 3; ++c)
        if (variances[c] > 0)
            test.bias = std::max(test.bias, std::abs(sum[c]) / std::sqrt(variances[c]));
    //<
    //> Judge the picture by the fraction that is rejected
    // A variance measured from a few samples is itself uncertain, most where bright paths are rare: a few
    // rejected pixels are forgiven (0.25%, as in Mitsuba 3's tests of its renderings), a wrong region is not.
    test.rejectedFraction =
        pixels > 0 ? static_cast<double>(test.rejectedPixels) / static_cast<double>(pixels) : 0;
    test.passed = pixels > 0 && test.rejectedFraction <= options.allowedRejected;
    //<
    return test;
}
//<

//> Test blocks of pixels where that is asked for
ZTest TestBlocks(const Planes &a, const Planes &b, const Planes &varianceA, const Planes &varianceB,
                 const std::vector<char> &bad, const CompareOptions &options) {
    if (options.block <= 1)
        return TestDifferences(a, b, varianceA, varianceB, bad, options);
    const size_t side = static_cast<size_t>(options.block);
    const Planes blockA = AverageBlocks(a, bad, side, 1);
    std::vector<char> badBlocks(blockA.Size());
    for (size_t i = 0; i < badBlocks.size(); ++i)
        badBlocks[i] = std::isnan(blockA.channel[0][i]);
    return TestDifferences(blockA, AverageBlocks(b, bad, side, 1), AverageBlocks(varianceA, bad, side, 2),
                           AverageBlocks(varianceB, bad, side, 2), badBlocks, options);
}
//<

} // namespace

//> Put the comparison together
Comparison Compare(const Image &test, const Image &reference, const CompareOptions &options) {
    CheckSameSize(test, reference);
    const Planes a = ToPlanes(test), b = ToPlanes(reference);
    const auto varianceA = Variances(test), varianceB = Variances(reference);
    const bool canTest = varianceA && varianceB;
    const std::vector<char> bad =
        canTest ? FindBadPixels({&a, &b}, {&*varianceA, &*varianceB}) : FindBadPixels({&a, &b}, {});
    Comparison result;
    result.width = test.width, result.height = test.height;
    result.badPixels = static_cast<size_t>(std::count(bad.begin(), bad.end(), 1));
    MeasureValues(a, b, bad, options.epsilon, &result);
    if (canTest)
        result.zTest = TestBlocks(a, b, *varianceA, *varianceB, bad, options);
    result.flipMap = FLIP(a, b, options.pixelsPerDegree);
    for (const float v : result.flipMap)
        result.flip += v / static_cast<double>(result.flipMap.size());
    return result;
}
//<

//> Show where the pictures differ
Image ErrorImage(const Image &test, const Image &reference, const Comparison &comparison) {
    CheckSameSize(test, reference);
    if (comparison.flipMap.size() != test.Pixels())
        throw Error("the comparison is not one of these pictures");
    Image image(test.width, test.height,
                {"R", "G", "B", "flip", "difference.R", "difference.G", "difference.B"});
    const size_t width = static_cast<size_t>(image.width), height = static_cast<size_t>(image.height);
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const float flip = comparison.flipMap[y * width + x];
            const Spectrum difference = test.RGB(x, y) - reference.RGB(x, y);
            image.At(x, y, 3) = flip;
            for (size_t c = 0; c < 3; ++c) {
                // The ramp is even to the eye, so it is one of encoded values
                image.At(x, y, c) = SRGBToLinear(std::clamp(3 * flip - static_cast<float>(c), 0.f, 1.f));
                image.At(x, y, c + 4) = difference[c];
            }
        }
    return image;
}
//<

} // namespace cuticle
//<
