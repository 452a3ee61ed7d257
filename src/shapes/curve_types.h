// The records of curves: what a scene hands to a curve set, and what a ray meets there.
#pragma once

#include "core/vecmath.h"

#include <cstdint>
#include <vector>

namespace cuticle {

// Flat always faces the ray, Ribbon has its own normals, Cylinder is flat for intersection but shaded round.
enum class CurveType : uint8_t { Flat, Cylinder, Ribbon };

// Says which part of its strand a segment is: the one with this number, from the root, of `count` that are
// alike. Strands of more than 65535 segments are counted coarsely.
struct StrandPart {
    uint16_t index = 0, count = 1;

    static StrandPart Of(size_t index, size_t count) {
        constexpr size_t most = UINT16_MAX;
        if (count > most)
            index = index * most / count, count = most;
        return {static_cast<uint16_t>(index), static_cast<uint16_t>(count)};
    }
    // Turns u along the segment into u along the strand: 0 at its root, 1 at its tip.
    float AlongStrand(float u) const { return (static_cast<float>(index) + u) / static_cast<float>(count); }
};

// One cubic Bezier segment in world space. Widths are full widths (diameters) at u = 0 and 1, linear between.
// group: index into the scene's curve groups (type, material, light).
struct CurveSegment {
    Point3f cp[4];
    float width[2];
    uint32_t group = 0;
    StrandPart part = {};
};

// The normals of a ribbon at u = 0 and u = 1.
struct RibbonNormals {
    Normal3f n[2];
};

// A hit on a curve: u along the segment, v in [0, 1] across it, h = -1 + 2v.
struct CurveHit {
    float t = 0;
    float u = 0, v = 0;
    uint32_t segment = 0;
};

// The place on a curve where a ray starts. CurveSet needs it so that the ray does not meet the very hair that
// it leaves. It is made from the hit that the path stands on, CurveOrigin{hit.segment, hit.u}; the ray then
// starts at the hit point itself, with no offset.
struct CurveOrigin {
    uint32_t segment = 0;
    float u = 0;
};

// The surface at a hit on a curve, as shading needs it.
struct CurveSurface {
    Point3f p;        // on the ribbon, in the coordinates of the ray
    Vector3f tangent; // unit, from root to tip: the x axis of a fiber's local frame
    Vector3f dpdu;    // dp/du; where the curve stands still, tangent times a tiny length
    Vector3f dpdv;    // dp/dv: across the width, as long as the width, toward growing v
    Normal3f n;       // unit; flat: faces the ray; cylinder: as on a tube; ribbon: its own, faces the ray
    Point2f uv;       // u along the segment, v across it
    float h = 0;      // -1 + 2v
    float width = 0;  // full width at u; a ribbon's is its own, not the narrower one that the ray sees
    float seen = 0;   // full width as the ray sees it
    float pError = 0; // bound of the rounding error of each coordinate of p
};

} // namespace cuticle
