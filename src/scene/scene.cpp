#include "scene/scene.h"

#include "shapes/strand_normals.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

// Orthonormal frame: z = ns, x = dp/du projected onto the tangent plane (any axis where nothing is left of
// it).
Frame ShadingFrame(const Vector3f &dpdu, const Vector3f &ns) {
    Vector3f x = dpdu - ns * Dot(ns, dpdu), y;
    if (x.LengthSquared() > 0)
        x = Normalize(x);
    else
        CoordinateSystem(ns, &x, &y);
    return {x, Cross(ns, x), ns};
}

// The error bound of an object's point in the world: its error under the transformation, and the rounding to
// single precision on the way into the object and out of it.
Vector3f ErrorInWorld(const Transform &toWorld, const Point3f &object, const Vector3f &error,
                      const Point3f &world) {
    const auto &m = toWorld.M();
    Vector3f e;
    for (int row = 0; row < 3; ++row) {
        double sum = 0;
        for (int c = 0; c < 3; ++c)
            sum += std::abs(m[row][c]) * (double{error[c]} + 0x1p-23 * double{std::abs(object[c])});
        e[row] = static_cast<float>(sum + 0x1p-23 * double{std::abs(world[row])});
    }
    return e;
}

// Transforms a hit in an object to the world. The tangent of a curve stays exact and its normal is made
// perpendicular to the tangent. A mirroring transformation swaps left and right across a fiber.
void ToWorld(const Transform &toWorld, SurfaceInteraction *si) {
    const Point3f object = si->p;
    si->p = toWorld.Point(object);
    si->pError = ErrorInWorld(toWorld, object, si->pError, si->p);
    si->n = Normalize(toWorld.Normal(si->n));
    si->dpdu = toWorld.Vector(si->dpdu);
    si->dpdv = toWorld.Vector(si->dpdv);
    if (!si->isCurve) {
        si->shading = ShadingFrame(si->dpdu, Normalize(toWorld.Normal(si->shading.z)));
        return;
    }
    si->width *= toWorld.Vector(si->shading.y).Length();
    const Vector3f tangent = Normalize(toWorld.Vector(si->shading.x));
    const auto across = [&](const Vector3f &v) { return Normalize(v - tangent * Dot(v, tangent)); };
    si->n = across(si->n);
    si->shading = {tangent, Cross(si->n, tangent), si->n};
    if (si->strandRoot)
        si->strandRoot = toWorld.Point(*si->strandRoot);
    if (si->strandNormal.LengthSquared() > 0)
        si->strandNormal = across(toWorld.Vector(si->strandNormal));
    if (toWorld.SwapsHandedness()) {
        si->uv.y = 1 - si->uv.y;
        si->flipped = !si->flipped;
    }
}

} // namespace

const StrandColors *Scene::StrandColorsOf(uint32_t group, uint32_t segment) const {
    const auto found = strandColors_.find(group);
    if (found == strandColors_.end())
        return nullptr;
    const StrandColorRun &run = found->second;
    const size_t i = run.colors.size() == 1 ? 0 : segment - run.firstSegment;
    DCHECK_LT(i, run.colors.size());
    return &run.colors[i];
}

// Fills si in the coordinates of the shapes, which are those of the ray.
void Scene::Describe(const ShapeGroup &shapes, const Ray &ray, const ShapeGroupHit &hit,
                     SurfaceInteraction *si) const {
    si->t = hit.T();
    si->isCurve = hit.isCurve;
    si->strandColors = nullptr;
    si->strandNormal = {};
    si->strandRoot.reset();
    if (hit.isCurve) {
        const CurveHit &curve = hit.curve;
        const CurveSurface s = shapes.binaryCurves ? shapes.binaryCurves->Surface(ray, curve)
                                                   : shapes.curves.Surface(ray, curve);
        const CurveSegment segment = shapes.Segment(curve.segment);
        si->p = s.p;
        si->width = s.seen;
        // pbrt-v3's bound, in the coordinates that the curve is stored in: twice the width that the ray sees.
        const float error = pbrtV3Offset_ ? 2 * s.seen : s.pError;
        si->pError = {error, error, error};
        si->n = s.n;
        si->uv = {segment.part.AlongStrand(s.uv.x), s.uv.y};
        si->shading = {s.tangent, Cross(s.n, s.tangent), s.n};
        DCHECK_LT(segment.group, curveMaterials_.size());
        si->material = curveMaterials_[segment.group];
        si->flipped = curveFlipped_[segment.group];
        si->light = -1;
        si->curveOrigin = {curve.segment, curve.u};
        si->strandColors = strandColors_.empty() ? nullptr : StrandColorsOf(segment.group, curve.segment);
        if (strandRoots_ && segment.part.index <= curve.segment) {
            // The segments of a strand follow one another, but where some were left out
            const CurveSegment first = shapes.Segment(curve.segment - segment.part.index);
            if (first.part.index == 0 && first.group == segment.group)
                si->strandRoot = first.cp[0];
        }
        if (!shapes.strandNormals.empty())
            si->strandNormal = StrandNormal(segment, shapes.strandNormals[curve.segment], curve.u, s.tangent);
        return;
    }
    const SolidHit solid = shapes.solids.Describe(hit.solid);
    si->p = solid.p;
    si->pError = solid.pError;
    si->n = solid.n;
    si->uv = solid.uv;
    si->dpdu = solid.dpdu;
    si->dpdv = solid.dpdv;
    si->shading = ShadingFrame(solid.dpdu, solid.ns);
    DCHECK_LT(solid.shapeId, shapes.solidInfos.size());
    si->material = shapes.solidInfos[solid.shapeId].material;
    si->light = shapes.solidInfos[solid.shapeId].light;
    si->geometryId = solid.geometryId;
    si->primId = solid.primId;
}

// A ray that traverses the instances, and its nearest hit so far.
struct Scene::InstanceQuery {
    const Scene &scene;
    const SceneRay &ray;
    ShapeGroupHit hit = {};
    Ray objectRay = {};
    int instance = -1;

    const CurveOrigin *Origin(uint32_t i) const {
        return ray.fromCurve && ray.instance == static_cast<int>(i) ? &ray.origin : nullptr;
    }
};

float Scene::IntersectInstance(void *query, uint32_t instance, const Ray &ray) {
    auto &q = *static_cast<InstanceQuery *>(query);
    ShapeGroupHit hit;
    if (!q.scene.objectOf_[instance]->Intersect(ray, q.Origin(instance), &hit))
        return -1;
    q.hit = hit, q.objectRay = ray, q.instance = static_cast<int>(instance);
    return hit.T();
}

float Scene::OccludedInstance(void *query, uint32_t instance, const Ray &ray) {
    const auto &q = *static_cast<InstanceQuery *>(query);
    return q.scene.objectOf_[instance]->Occluded(ray, q.Origin(instance)) ? 0.f : -1.f;
}

bool Scene::Intersect(const SceneRay &sceneRay, SurfaceInteraction *si) const {
    Ray ray = sceneRay.ray;
    ShapeGroupHit hit;
    const CurveOrigin *origin = sceneRay.fromCurve && sceneRay.instance < 0 ? &sceneRay.origin : nullptr;
    const bool hitWorld = world_.Intersect(ray, origin, &hit);
    si->instance = -1;
    if (instances_.Size() > 0) {
        if (hitWorld)
            ray.tMax = hit.T();
        InstanceQuery query{*this, sceneRay};
        if (instances_.Intersect(ray, IntersectInstance, &query)) {
            const auto instance = static_cast<uint32_t>(query.instance);
            Describe(*objectOf_[instance], query.objectRay, query.hit, si);
            ToWorld(instances_.ObjectToWorld(instance), si);
            si->instance = query.instance;
            si->wo = -sceneRay.ray.d;
            return true;
        }
    }
    if (!hitWorld)
        return false;
    Describe(world_, sceneRay.ray, hit, si);
    si->wo = -sceneRay.ray.d;
    return true;
}

bool Scene::Occluded(const SceneRay &ray) const {
    if (world_.Occluded(ray.ray, ray.fromCurve && ray.instance < 0 ? &ray.origin : nullptr))
        return true;
    if (instances_.Size() == 0)
        return false;
    InstanceQuery query{*this, ray};
    return instances_.Occluded(ray.ray, OccludedInstance, &query);
}

float Scene::OccludedBySolidsOf(void *query, uint32_t instance, const Ray &ray) {
    const auto &q = *static_cast<InstanceQuery *>(query);
    return q.scene.objectOf_[instance]->OccludedBySolids(ray) ? 0.f : -1.f;
}

bool Scene::OccludedBySolids(const SceneRay &ray) const {
    if (world_.OccludedBySolids(ray.ray))
        return true;
    if (instances_.Size() == 0)
        return false;
    InstanceQuery query{*this, ray};
    return instances_.Occluded(ray.ray, OccludedBySolidsOf, &query);
}

void Scene::ForEachCurve(
    const std::function<void(const CurveSegment &, const Transform *toWorld)> &use) const {
    const auto each = [&](const ShapeGroup &shapes, const Transform *toWorld) {
        for (uint32_t i = 0; i < shapes.Curves(); ++i)
            use(shapes.Segment(i), toWorld);
    };
    each(world_, nullptr);
    for (uint32_t i = 0; i < objectOf_.size(); ++i)
        each(*objectOf_[i], &instances_.ObjectToWorld(i));
}

SceneRay Scene::SpawnRay(const SurfaceInteraction &si, const Vector3f &w) const {
    SceneRay ray;
    ray.ray.d = w;
    ray.fromCurve = si.isCurve && !pbrtV3Offset_;
    ray.origin = si.curveOrigin;
    ray.instance = si.instance;
    ray.ray.o = ray.fromCurve ? si.p : OffsetRayOrigin(si.p, si.pError, si.n, w);
    return ray;
}

SceneRay Scene::SpawnRayTo(const SurfaceInteraction &si, const Vector3f &w, float distance) const {
    SceneRay ray = SpawnRay(si, w);
    ray.ray.tMax = distance;
    if (si.isCurve && pbrtV3Offset_ && std::isfinite(distance)) {
        // The origin is widths away; the point that it looks at stays.
        const Vector3f d = si.p + w * distance - ray.ray.o;
        ray.ray.tMax = d.Length();
        ray.ray.d = ray.ray.tMax > 0 ? d / ray.ray.tMax : w;
    }
    return ray;
}

float Scene::AreaLightPdf(const Point3f &ref, const SurfaceInteraction &si) const {
    SolidHit hit;
    hit.t = si.t;
    hit.p = si.p;
    hit.pError = si.pError;
    hit.n = si.n;
    hit.ns = si.shading.z;
    hit.uv = si.uv;
    hit.geometryId = si.geometryId;
    hit.primId = si.primId;
    return AreaLightAt(si.light).Pdf_Li(ref, hit);
}

Bounds3f Scene::WorldBound() const {
    Bounds3f b = world_.Bound();
    b.Extend(instances_.WorldBound());
    return b;
}

size_t Scene::Curves() const {
    size_t n = world_.Curves();
    for (const auto &object : objects_)
        n += object->Curves();
    return n;
}
size_t Scene::Instances() const { return instances_.Size(); }
size_t Scene::MemoryBytes() const {
    size_t n = world_.MemoryBytes() + instances_.MemoryBytes() + objectOf_.size() * sizeof(void *);
    for (const auto &object : objects_)
        n += object->MemoryBytes();
    return n;
}
const char *Scene::Isa() const { return world_.binaryCurves ? "scalar" : world_.curves.Isa(); }

} // namespace cuticle
