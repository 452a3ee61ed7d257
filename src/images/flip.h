//> Say what FLIP measures
#pragma once

#include "images/planes.h"

#include <vector>

namespace cuticle {

// Computes the FLIP of each pixel, 0 (same) to 1, row by row from the top: Andersson, Nilsson,
// Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
// Images", of the pictures as a screen shows them (linear values clamped to [0, 1], no exposure). Infinite
// values are white or black; a pixel that is NaN is magenta, as WriteImage shows it. pixelsPerDegree
// describes the viewer (CompareOptions) and must be in (0, 10000]. Throws Error otherwise, and when the sizes
// differ or a picture is empty.
std::vector<float> FLIP(const Image &test, const Image &reference, double pixelsPerDegree = 67);
// Computes the same of planes of one size.
std::vector<float> FLIP(const Planes &test, const Planes &reference, double pixelsPerDegree);

} // namespace cuticle
//<
