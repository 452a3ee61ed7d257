//> Say how two pictures are compared
#pragma once

#include "images/image.h"

#include <optional>
#include <vector>

namespace cuticle {

//> List what is asked of the comparison
struct CompareOptions {
    double epsilon = 0.01;           // of the relative error, in units of the reference squared; > 0
    double pixelsPerDegree = 67;     // of the viewer of FLIP: a 4K screen 0.7 m wide seen from 0.7 m; > 0
    double alpha = 0.01;             // probability that the z-test rejects any pixel of two right pictures
    int block = 1;                   // the z-test takes the means of blocks of this side, in pixels
    double allowedRejected = 0.0025; // fraction of pixels that may be rejected all the same
};
//<

//> Test each pixel against its variance
// The z-test asks whether chance explains the differences. It needs both pictures to carry "variance.R",
// "variance.G", "variance.B", the variances of their pixels' means: then every pixel's difference has a
// z-score, and chance alone would reject a picture of n values with probability alpha.
struct ZTest {
    size_t values = 0;           // n: pixels (or blocks) times three channels
    double level = 0;            // significance of each single test, Sidak's 1 - (1 - alpha)^(1/n)
    size_t rejectedPixels = 0;   // (or blocks) with at least one channel beyond that level
    double rejectedFraction = 0; // of the pixels
    double bias = 0;             // of R, G, B the largest |sum of differences| in its standard deviations
    bool passed = false;         // rejectedFraction <= allowedRejected
};
//<

//> Hold every measure of the difference
// Means are over pixels and over R, G, B in linear values; grey pictures count as R = G = B. Pixels where
// either picture (or its variance) is not a finite number are left out of all means, counted, and fail the
// comparison.
struct Comparison {
    int width = 0, height = 0;
    size_t badPixels = 0;       // not finite in either picture, or of negative variance
    double mse = 0;             // mean of (a - b)^2, b the reference
    double relativeMSE = 0;     // mean of (a - b)^2 / (b^2 + epsilon); nothing is trimmed
    double meanDifference = 0;  // mean of |a - b|
    double p99Difference = 0;   // 99% of all |a - b| are no larger
    double flip = 0;            // mean of LDR-FLIP, 0 (same) to 1
    std::optional<ZTest> zTest; // absent where a picture has no variance
    std::vector<float> flipMap; // FLIP of each pixel, row by row from the top
    bool Valid() const { return badPixels == 0 && width > 0; }
};
//<

//> Offer the comparison
// Throws Error when the sizes differ or a picture is empty.
Comparison Compare(const Image &test, const Image &reference, const CompareOptions &options = {});

// A picture of the differences: R, G, B as a ramp from black by red and yellow to white over FLIP from 0 to
// 1, for the eye; channels "flip" and "difference.R", .G, .B (test - reference) for numbers, kept in .exr.
Image ErrorImage(const Image &test, const Image &reference, const Comparison &comparison);
//<

} // namespace cuticle
//<
