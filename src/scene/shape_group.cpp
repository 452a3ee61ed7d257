#include "scene/shape_group.h"

namespace cuticle {

bool ShapeGroup::Intersect(Ray ray, const CurveOrigin *origin, ShapeGroupHit *hit) const {
    const bool hitSolid = haveSolids && solids.Intersect(ray, &hit->solid);
    if (hitSolid)
        ray.tMax = hit->solid.t;
    hit->isCurve = haveCurves && (binaryCurves ? binaryCurves->Intersect(ray, origin, &hit->curve)
                                               : curves.Intersect(ray, origin, &hit->curve));
    return hitSolid || hit->isCurve;
}

bool ShapeGroup::Occluded(const Ray &ray, const CurveOrigin *origin) const {
    return OccludedBySolids(ray) || (haveCurves && (binaryCurves ? binaryCurves->Occluded(ray, origin)
                                                                 : curves.Occluded(ray, origin)));
}

Bounds3f ShapeGroup::Bound() const {
    Bounds3f b = solids.WorldBound();
    if (haveCurves)
        b.Extend(binaryCurves ? binaryCurves->WorldBound() : curves.WorldBound());
    return b;
}

size_t ShapeGroup::Curves() const {
    return binaryCurves ? binaryCurves->SegmentCount() : curves.SegmentCount();
}

size_t ShapeGroup::MemoryBytes() const {
    return solids.MemoryBytes() + (binaryCurves ? binaryCurves->MemoryBytes() : curves.MemoryBytes()) +
           strandNormals.size() * sizeof(Vector3f);
}

} // namespace cuticle
