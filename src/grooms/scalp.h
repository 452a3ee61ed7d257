//> Declare the scalp
// The scalp: where hair grows on the head of head_shape.h, and how densely.
#pragma once

#include "core/vecmath.h"

#include <cstddef>
#include <vector>

namespace cuticle {

// A point of the scalp: where, the normal there, and how strongly hair grows, 0 to 1.
struct ScalpPoint {
    Point3f p;
    Normal3f n;
    float density = 0;
};

// The hairline: 1 well inside the scalp, 0 outside, a soft edge of some millimetres between.
float HairDensity(const Point3f &p);

// Picks points on the scalp in proportion to area times density (more around the crown); stratified input
// gives stratified roots. The hairline is kept to the size of the cells that density is tabulated in, 3 mm.
class Scalp {
  public:
    Scalp();
    // u, v in [0, 1).
    ScalpPoint Sample(float u, float v) const;
    float Area() const { return area_; } // cm^2, weighted by density

  private:
    static constexpr size_t kAzimuth = 192, kHeight = 128;
    Point3f SurfaceAlong(float azimuth, float cosine) const;
    std::vector<float> rowCdf_;    // over heights
    std::vector<float> columnCdf_; // per row, over azimuths
    float area_ = 0;
};

} // namespace cuticle
//<
