// What a ray met on a set of curves, and the numbers that a scene hands the set.
#pragma once

#include "core/vecmath.h"

#include <vector>

namespace cuticle {

// Flat always faces the ray, Ribbon has its own normals, Cylinder is flat for intersection but shaded round.
enum class CurveType : uint8_t { Flat, Cylinder, Ribbon };

// One cubic Bezier segment in world space. Widths are full widths (diameters) at u = 0 and 1, linear between.
// group: index into the scene's curve groups (type, material, light).
struct CurveSegment {
    Point3f cp[4];
    float width[2];
    uint32_t group = 0;
};

// Unit normals of a ribbon at u = 0 and u = 1.
struct RibbonNormals {
    Normal3f n[2];
};

// Where a ray met a curve: u along the segment, v in [0, 1] across it, h = -1 + 2v.
struct CurveHit {
    float t = 0;
    float u = 0, v = 0;
    uint32_t segment = 0;
};

} // namespace cuticle
