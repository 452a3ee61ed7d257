//> Declare pictures of cuts through a distance
#pragma once

#include "core/color.h"
#include "volume/grid.h"

#include <vector>

namespace cuticle {

// A picture: linear RGB, rows from the top.
struct SlicePicture {
    size_t width = 0, height = 0;
    std::vector<Spectrum> colors;
};

// Cuts a signed distance by the plane through `at` that is perpendicular to an axis (0: x, seen from +x with
// y up; 1: y, seen from +y with z down; 2: z, seen from +z with y up), with `scale` (>= 1) pixels a cell.
// Inside is blue, outside is orange, each paler with the distance; the surface is a black band, and a line
// stands at every `step` of distance (> 0).
SlicePicture CutDistance(const DenseGrid<float> &distance, const Point3f &at, size_t axis, size_t scale,
                         float step);

// Pictures beside each other, centred in height, on white.
SlicePicture SideBySide(const std::vector<SlicePicture> &pictures, size_t gap);

} // namespace cuticle
//<
