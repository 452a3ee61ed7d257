// ShapeGroup: the shapes that are stored once, those of the world or those of one object definition.
#pragma once

#include "materials/material.h"
#include "shapes/curve_set.h"
#include "shapes/solid_set.h"

#include <optional>
#include <vector>

namespace cuticle {

// The nearest hit in a ShapeGroup.
struct ShapeGroupHit {
    bool isCurve = false;
    CurveHit curve;   // of a curve
    SolidPoint solid; // of anything else
    float T() const { return isCurve ? curve.t : solid.t; }
};

// Solids and curves in one coordinate system: the world's, or the object's own. SceneBuilder fills it.
struct ShapeGroup {
    struct SolidInfo {
        const Material *material = nullptr; // nullptr: the solid is drawn because it emits
        int light = -1;                     // index of its light in the scene; -1: it emits nothing
    };
    SolidSet solids;
    std::vector<SolidInfo> solidInfos; // by shape id of the solids
    CurveSet curves;
    std::optional<BinaryCurveBvh> binaryCurves; // instead of curves, where SceneOptions ask for it
    std::vector<Vector3f> strandNormals;        // by segment; empty where no material asks for them
    bool haveSolids = false, haveCurves = false;

    // The nearest hit with t in (ray.tMin, ray.tMax). origin: where on one of these curves the ray starts,
    // else nullptr.
    bool Intersect(Ray ray, const CurveOrigin *origin, ShapeGroupHit *hit) const;
    bool Occluded(const Ray &ray, const CurveOrigin *origin) const;
    bool OccludedBySolids(const Ray &ray) const { return haveSolids && solids.Occluded(ray); }
    CurveSegment Segment(uint32_t i) const {
        return binaryCurves ? binaryCurves->Segment(i) : curves.Segment(i);
    }
    Bounds3f Bound() const;
    size_t Curves() const; // segments
    size_t MemoryBytes() const;
};

} // namespace cuticle
