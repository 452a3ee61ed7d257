// SurfaceInteraction: the point where a ray met the scene, as materials, lights and integrators need it.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"
#include "shapes/curve_types.h"

#include <array>
#include <optional>

namespace cuticle {

class Material;

// The colours of one curve segment of a strand that has its own: linear RGB at u = 0 and u = 1, linear
// between.
using StrandColors = std::array<Spectrum, 2>;

// A point where a texture is looked up: in world space, with the surface's (u, v) there, and on a strand
// that has colours of its own those of its segment; on any strand its root, where a texture asks for it.
struct TexturePoint {
    Point3f p;
    Point2f uv;
    const StrandColors *strandColors = nullptr;
    float segmentU = 0; // where on that segment
    const Point3f *root = nullptr;
};

// Some members are of solids (meshes and quadrics) or of curves only; the others are set for both.
struct SurfaceInteraction {
    Point3f p;                          // world space
    Vector3f pError;                    // bound of the rounding error of p, per axis
    Normal3f n;                         // geometric, unit length
    Vector3f wo;                        // unit length, from p towards the ray's origin
    Frame shading;                      // x along dpdu (fibers: root to tip), z the shading normal
    Vector3f dpdu, dpdv;                // solids: for bump maps
    Point2f uv;                         // curves: u from root to tip, v across it, so that h = -1 + 2v
    float t = 0;                        // distance along the ray
    const Material *material = nullptr; // nullptr: pbrt's material "", which light passes
    int light = -1;                     // index of the emitter's light in the scene; -1: none
    bool isCurve = false;
    bool flipped = false; // curves: ReverseOrientation or a mirroring transformation, not both, holds there
    float width = 0;      // curves: full width as the ray sees it, world space
    CurveOrigin curveOrigin; // curves: tells a ray that leaves p what it starts on
    const StrandColors *strandColors =
        nullptr;                         // curves: of a strand that has colours of its own, else nullptr
    Vector3f strandNormal;               // curves: set where the material asks, see MakeStrandNormals
    std::optional<Point3f> strandRoot;   // curves: world space, set where a texture "strandroot" asks
    uint32_t geometryId = 0, primId = 0; // solids: see SolidHit
    int instance = -1;                   // index of the instance that was hit; -1: the world's own shapes
};

// The point at which textures of a hit are looked up.
inline TexturePoint TexturePointOf(const SurfaceInteraction &si) {
    return {si.p, si.uv, si.strandColors, si.curveOrigin.u, si.strandRoot ? &*si.strandRoot : nullptr};
}

} // namespace cuticle
