//> Compare two pictures
#include "images/compare.h"

#include "core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace cuticle {

namespace {

//> Collect the colours of a picture
// One plane of doubles for each of three channels, row by row from the top.
struct Planes {
    int width = 0, height = 0;
    std::array<std::vector<double>, 3> channel;
    size_t Size() const { return channel[0].size(); }
};

Planes ToPlanes(const Image &image) {
    Planes planes{image.width, image.height, {}};
    for (auto &c : planes.channel)
        c.reserve(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const Spectrum rgb = image.RGB(x, y);
            for (int c = 0; c < 3; ++c)
                planes.channel[static_cast<size_t>(c)].push_back(rgb[c]);
        }
    return planes;
}
//<

//> Collect the variances of a picture's pixels
std::optional<Planes> Variances(const Image &image) {
    Planes planes{image.width, image.height, {}};
    constexpr std::array<const char *, 3> names = {"variance.R", "variance.G", "variance.B"};
    for (size_t c = 0; c < 3; ++c) {
        const int index = image.ChannelIndex(names[c]);
        if (index < 0)
            return std::nullopt;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                planes.channel[c].push_back(image.At(x, y, static_cast<size_t>(index)));
    }
    return planes;
}
//<

//> Find the pixels that are no numbers
// Written so that NaN fails each condition. A pixel is bad as a whole: one broken channel shows a broken sample.
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
// Means over blocks of side * side pixels, leaving bad ones out; of variances (power 2) the variances of these means.
// A block of bad pixels is NaN.
Planes AverageBlocks(const Planes &planes, const std::vector<char> &bad, int side, double power) {
    Planes blocks{(planes.width + side - 1) / side, (planes.height + side - 1) / side, {}};
    std::vector<double> counts(static_cast<size_t>(blocks.width) * static_cast<size_t>(blocks.height));
    for (auto &channel : blocks.channel)
        channel.resize(counts.size());
    for (size_t i = 0; i < planes.Size(); ++i) {
        const size_t width = static_cast<size_t>(planes.width), s = static_cast<size_t>(side);
        const size_t block = i / width / s * static_cast<size_t>(blocks.width) + i % width / s;
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
    // Of n independent tests at level s, one at least rejects with probability 1 - (1 - s)^n. Solve for the level at
    // which this is alpha (Sidak 1967), with the logarithms that keep s of 1e-9.
    test.level =
        test.values > 0 ? -std::expm1(std::log1p(-options.alpha) / static_cast<double>(test.values)) : 0;
    //<
    std::array<double, 3> sum{}, variances{}; // over the picture, of differences and of their variances
    for (size_t i = 0; i < a.Size(); ++i) {
        bool rejected = false;
        for (size_t c = 0; c < 3 && !bad[i]; ++c) {
            //> Find how likely so large a difference is by chance
            // Both means are taken for normal, of the variances that the renderer measured. Pictures are stored in
            // binary32, so that even a pixel without variance may be off by its last bits.
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
    // What is too small to see in any pixel shows in the sum of all: the bias of the whole picture, in its standard
    // deviations.
    for (size_t c = 0; c < 3; ++c)
        if (variances[c] > 0)
            test.bias = std::max(test.bias, std::abs(sum[c]) / std::sqrt(variances[c]));
    //<
    //> Judge the picture by the fraction that is rejected
    // A variance measured from a few samples is itself uncertain, most where bright paths are rare: a few rejected
    // pixels are forgiven (0.25%, as in Mitsuba 3's tests of its renderings), a wrong region is not.
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
    const Planes blockA = AverageBlocks(a, bad, options.block, 1);
    std::vector<char> badBlocks(blockA.Size());
    for (size_t i = 0; i < badBlocks.size(); ++i)
        badBlocks[i] = std::isnan(blockA.channel[0][i]);
    return TestDifferences(blockA, AverageBlocks(b, bad, options.block, 1),
                           AverageBlocks(varianceA, bad, options.block, 2),
                           AverageBlocks(varianceB, bad, options.block, 2), badBlocks, options);
}
//<

//> Compute FLIP, the difference that a viewer sees
// Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
// Images". One pipeline compares colours after blurring as the eye does at the viewing distance, another
// compares edges and points; the second amplifies the first.
//> Go between the colour spaces of FLIP
// Linear sRGB to XYZ relative to white: each row of the matrix is divided by its sum, so that white is (1, 1, 1).
using Triple = std::array<double, 3>;

constexpr std::array<Triple, 3> toXYZ = {{{10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
                                          {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
                                          {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}}};
constexpr double RowSum(size_t row) { return toXYZ[row][0] + toXYZ[row][1] + toXYZ[row][2]; }

Triple ToRelativeXYZ(const Triple &rgb) {
    Triple xyz{};
    for (size_t r = 0; r < 3; ++r)
        for (size_t c = 0; c < 3; ++c)
            xyz[r] += toXYZ[r][c] / RowSum(r) * rgb[c];
    return xyz;
}
//<

//> Solve for the colour that has a given XYZ
// The inverse by cofactors (Cramer's rule), which keeps it consistent with the matrix above to the last bits.
Triple FromRelativeXYZ(const Triple &relative) {
    const auto &m = toXYZ;
    const Triple xyz = {relative[0] * RowSum(0), relative[1] * RowSum(1), relative[2] * RowSum(2)};
    const auto determinant = [](const Triple &r0, const Triple &r1, const Triple &r2) {
        return r0[0] * (r1[1] * r2[2] - r1[2] * r2[1]) - r0[1] * (r1[0] * r2[2] - r1[2] * r2[0]) +
               r0[2] * (r1[0] * r2[1] - r1[1] * r2[0]);
    };
    const double whole = determinant(m[0], m[1], m[2]);
    Triple rgb{};
    for (size_t c = 0; c < 3; ++c) {
        std::array<Triple, 3> replaced = m;
        for (size_t r = 0; r < 3; ++r)
            replaced[r][c] = xyz[r];
        rgb[c] = determinant(replaced[0], replaced[1], replaced[2]) / whole;
    }
    return rgb;
}
//<

//> Compare two colours in Hunt-adjusted L*a*b*
// L*a*b* is nearly uniform to the eye; colours that are dark look less colourful (Hunt), so a* and b* are scaled by
// L* / 100. HyAB adds the difference in lightness to the distance in colour: better than Euclid where differences
// are large.
Triple HuntLab(const Triple &rgb) {
    const auto f = [](double t) {
        constexpr double delta = 6. / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4. / 29;
    };
    const Triple xyz = ToRelativeXYZ(rgb);
    const double x = f(xyz[0]), y = f(xyz[1]), z = f(xyz[2]);
    const double lightness = 116 * y - 16;
    return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

double HyAB(const Triple &a, const Triple &b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}
//<

//> Filter a plane by rows and by columns
// Every filter of FLIP is a product of a function of x and one of y. Both kernels have the same odd length; beyond
// the picture its border goes on.
std::vector<double> Convolve(const std::vector<double> &plane, int width, int height,
                             const std::vector<double> &kernelX, const std::vector<double> &kernelY) {
    const int radius = static_cast<int>(kernelX.size() / 2);
    std::vector<double> rows(plane.size()), result(plane.size());
    const double *centreX = kernelX.data() + radius, *centreY = kernelY.data() + radius;
    const auto at = [&](int x, int y) {
        return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int k = -radius; k <= radius; ++k)
                rows[at(x, y)] += centreX[k] * plane[at(std::clamp(x + k, 0, width - 1), y)];
    for (int y = 0; y < height; ++y)
        for (int k = -radius; k <= radius; ++k) {
            const double weight = centreY[k];
            const int from = std::clamp(y + k, 0, height - 1);
            for (int x = 0; x < width; ++x)
                result[at(x, y)] += weight * rows[at(x, from)];
        }
    return result;
}
//<

//> Blur as the eye does
// The contrast sensitivity of each opponent channel is a sum of Gaussians in frequency, so its filter is one of
// Gaussians in space: a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees (Johnson and Fairchild's form). Parameters
// (a_1, b_1, a_2, b_2) of the paper's table 1: achromatic, red-green, blue-yellow; the window is three standard
// deviations of the widest.
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> sensitivities = {
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

std::vector<double> BlurPlane(const std::vector<double> &plane, int width, int height, const Sensitivity &s,
                              double pixelsPerDegree) {
    const int radius =
        static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * Sqr(kPi<double>))) * pixelsPerDegree));
    //> Blur by each Gaussian and add the two by their mass
    std::vector<double> result(plane.size());
    double total = 0;
    for (const auto &[a, b] : {std::pair(s.a1, s.b1), std::pair(s.a2, s.b2)}) {
        if (a == 0)
            continue;
        std::vector<double> kernel;
        double mass = 0;
        for (int k = -radius; k <= radius; ++k) {
            kernel.push_back(std::exp(-Sqr(kPi<double> * k / pixelsPerDegree) / b));
            mass += kernel.back();
        }
        const double height0 = a * std::sqrt(kPi<double> / b);
        const auto blurred = Convolve(plane, width, height, kernel, kernel);
        for (size_t i = 0; i < plane.size(); ++i)
            result[i] += height0 * blurred[i];
        total += height0 * mass * mass;
    }
    for (double &v : result)
        v /= total;
    return result;
    //<
}
//<

//> Turn a picture into what is seen of its colours
// The opponent space Y Cx Cz is linear in XYZ, so that a blur there mixes light; its scale and offset leave a normalised
// blur unchanged and are left out.
std::vector<Triple> SeenColours(const Planes &xyz, double pixelsPerDegree) {
    const size_t n = xyz.Size();
    std::array<std::vector<double>, 3> opponent;
    for (size_t i = 0; i < n; ++i) {
        const double x = xyz.channel[0][i], y = xyz.channel[1][i], z = xyz.channel[2][i];
        opponent[0].push_back(y), opponent[1].push_back(x - y), opponent[2].push_back(y - z);
    }
    for (size_t c = 0; c < 3; ++c)
        opponent[c] = BlurPlane(opponent[c], xyz.width, xyz.height, sensitivities[c], pixelsPerDegree);
    std::vector<Triple> seen(n);
    for (size_t i = 0; i < n; ++i) {
        const double y = opponent[0][i];
        Triple rgb = FromRelativeXYZ({y + opponent[1][i], y, y - opponent[2][i]});
        for (double &v : rgb)
            v = std::clamp(v, 0., 1.);
        seen[i] = HuntLab(rgb);
    }
    return seen;
}
//<

//> Bring colour differences to $[0, 1]$
// After a power q_c = 0.7, the largest difference there is, green against blue, becomes 1; the lower 40% of the
// range (p_c) take 95% of the result (p_t), since larger differences are all simply large.
double ColourError(const Triple &a, const Triple &b) {
    constexpr double qc = 0.7, pc = 0.4, pt = 0.95;
    static const double largest = std::pow(HyAB(HuntLab({0, 1, 0}), HuntLab({0, 0, 1})), qc);
    const double error = std::pow(HyAB(a, b), qc), knee = pc * largest;
    return error < knee ? pt / knee * error : std::min(1., pt + (error - knee) / (largest - knee) * (1 - pt));
}
//<

//> Find edges and points
// First (edges) and second (points) derivatives of a Gaussian of standard deviation w/2, w = 0.082 degrees, whose
// positive and negative weights are scaled to sums of +1 and -1. The strength is the length of the two responses, by
// x and by y.
std::vector<double> FeatureStrength(const std::vector<double> &luminance, int width, int height,
                                    double pixelsPerDegree, bool points) {
    const double deviation = 0.5 * 0.082 * pixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    std::vector<double> smooth, derivative;
    double mass = 0, positive = 0, negative = 0;
    for (int k = -radius; k <= radius; ++k) {
        const double g = std::exp(-Sqr(k / deviation) / 2);
        smooth.push_back(g), mass += g;
        derivative.push_back(points ? (Sqr(k / deviation) - 1) * g : -k * g);
        (derivative.back() > 0 ? positive : negative) += std::abs(derivative.back());
    }
    for (double &v : smooth)
        v /= mass;
    for (double &v : derivative)
        v /= v > 0 ? positive : negative;
    std::vector<double> strength = Convolve(luminance, width, height, derivative, smooth);
    const std::vector<double> byY = Convolve(luminance, width, height, smooth, derivative);
    for (size_t i = 0; i < strength.size(); ++i)
        strength[i] = std::hypot(strength[i], byY[i]);
    return strength;
}
//<

//> Clamp to what a screen shows
Planes ToScreen(const Planes &rgb) {
    Planes xyz{rgb.width, rgb.height, {}};
    for (size_t i = 0; i < rgb.Size(); ++i) {
        Triple colour = {rgb.channel[0][i], rgb.channel[1][i], rgb.channel[2][i]};
        if (std::isnan(colour[0]) || std::isnan(colour[1]) || std::isnan(colour[2]))
            colour = {1, 0, 1}; // shown, never hidden; Compare() counts it besides
        for (double &v : colour)
            v = std::clamp(v, 0., 1.);
        colour = ToRelativeXYZ(colour);
        for (size_t c = 0; c < 3; ++c)
            xyz.channel[c].push_back(colour[c]);
    }
    return xyz;
}
//<

//> Combine the errors of colours and features
// A difference in an edge or a point, as strong as its square root, raises the colour error by lowering its
// exponent: with no difference in colour nothing is seen, whatever the features.
std::vector<float> FLIPOfPlanes(const Planes &testColours, const Planes &referenceColours,
                                double pixelsPerDegree) {
    const Planes test = ToScreen(testColours), reference = ToScreen(referenceColours);
    const int width = test.width, height = test.height;
    const auto seenTest = SeenColours(test, pixelsPerDegree),
               seenReference = SeenColours(reference, pixelsPerDegree);
    std::vector<double> feature(test.Size());
    for (const bool points : {false, true}) {
        const auto a = FeatureStrength(test.channel[1], width, height, pixelsPerDegree, points);
        const auto b = FeatureStrength(reference.channel[1], width, height, pixelsPerDegree, points);
        for (size_t i = 0; i < feature.size(); ++i)
            feature[i] = std::max(feature[i], std::abs(a[i] - b[i]));
    }
    std::vector<float> flip(test.Size());
    for (size_t i = 0; i < flip.size(); ++i) {
        const double colourError = ColourError(seenTest[i], seenReference[i]);
        const double featureError = std::min(1., std::sqrt(feature[i] / std::numbers::sqrt2));
        flip[i] = colourError == 0 ? 0 : static_cast<float>(std::pow(colourError, 1 - featureError));
    }
    return flip;
}
//<
//<

//> Refuse pictures that do not match
void CheckSizes(const Image &test, const Image &reference) {
    const auto size = [](const Image &i) {
        return std::to_string(i.width) + " x " + std::to_string(i.height);
    };
    if (test.width != reference.width || test.height != reference.height)
        throw Error("pictures of " + size(test) + " and " + size(reference) + " pixels cannot be compared");
    if (test.width <= 0 || test.height <= 0 || test.channels.empty() || reference.channels.empty())
        throw Error("a picture without pixels cannot be compared");
}

void CheckPixelsPerDegree(double pixelsPerDegree) {
    if (!(pixelsPerDegree > 0 && pixelsPerDegree <= 10000))
        throw Error("FLIP needs between 0 and 10000 pixels per degree");
}
//<

} // namespace

//> Put the comparison together
Comparison Compare(const Image &test, const Image &reference, const CompareOptions &options) {
    CheckSizes(test, reference);
    CheckPixelsPerDegree(options.pixelsPerDegree);
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
    result.flipMap = FLIPOfPlanes(a, b, options.pixelsPerDegree);
    for (const float v : result.flipMap)
        result.flip += v / static_cast<double>(result.flipMap.size());
    return result;
}

std::vector<float> FLIP(const Image &test, const Image &reference, double pixelsPerDegree) {
    CheckSizes(test, reference);
    CheckPixelsPerDegree(pixelsPerDegree);
    return FLIPOfPlanes(ToPlanes(test), ToPlanes(reference), pixelsPerDegree);
}
//<

//> Show where the pictures differ
Image ErrorImage(const Image &test, const Image &reference, const Comparison &comparison) {
    CheckSizes(test, reference);
    if (comparison.flipMap.size() != static_cast<size_t>(test.width) * static_cast<size_t>(test.height))
        throw Error("the comparison is not one of these pictures");
    Image image(test.width, test.height,
                {"R", "G", "B", "flip", "difference.R", "difference.G", "difference.B"});
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const size_t i =
                static_cast<size_t>(y) * static_cast<size_t>(image.width) + static_cast<size_t>(x);
            const float flip = comparison.flipMap[i];
            const Spectrum difference = test.RGB(x, y) - reference.RGB(x, y);
            image.At(x, y, 3) = flip;
            for (int c = 0; c < 3; ++c) {
                // The ramp is even to the eye, so it is one of encoded values
                image.At(x, y, static_cast<size_t>(c)) =
                    SRGBToLinear(std::clamp(3 * flip - static_cast<float>(c), 0.f, 1.f));
                image.At(x, y, static_cast<size_t>(c) + 4) = difference[c];
            }
        }
    return image;
}
//<

} // namespace cuticle
//<
