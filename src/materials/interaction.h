// Where a ray met the scene: what materials, lights and the integrator need to know of the place.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"
#include "shapes/curve_types.h"

#include <array>

namespace cuticle {

class Material;

// Of a strand that has colours of its own: linear RGB at u = 0 and u = 1 of one curve segment, linear between.
using StrandColors = std::array<Spectrum, 2>;

struct SurfaceInteraction {
    Point3f p;
    Vector3f pError;                    // bound of the rounding error of p, per axis (solids)
    Normal3f n;                         // geometric, unit length
    Vector3f wo;                        // unit, away from the surface, towards where the ray came from
    Frame shading;                      // x along dpdu (of a fiber: root to tip), z the shading normal
    Vector3f dpdu, dpdv;                // of a solid, for bump maps
    Point2f uv;                         // of a curve: v across it, so that h = -1 + 2v
    float t = 0;                        // along the ray that found it
    const Material *material = nullptr; // nullptr: pbrt's material "", which light passes
    int light = -1;                     // of an emitter: index of its light in the scene
    bool isCurve = false;
    CurveOrigin curveOrigin;                    // of a curve: tells a new ray what it starts on
    const StrandColors *strandColors = nullptr; // of a curve whose strand has colours
    Vector3f strandNormal;                      // of a curve whose material asks: see MakeStrandNormals
    uint32_t geometryId = 0, primId = 0;        // of a solid: see SolidHit
    int instance = -1;                          // of an object: which; -1: none, the world's own shapes
};

} // namespace cuticle
