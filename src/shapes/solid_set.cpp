#include "shapes/solid_set.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/rounding.h"
#include "shapes/embree.h"
#include "shapes/embree_device.h"
#include "shapes/quadric.h"
#include "shapes/triangle_mesh.h"

#include <cmath>

namespace cuticle {

namespace {

// Beside Embree's own record of a query, where the callbacks put the nearest hit in double.
struct HitContext {
    EmbreeContext base; // first, so that Embree's pointer is ours
    Vector3d p;         // as in SolidPoint
    double t = 0;
};

void QuadricBounds(const RTCBoundsFunctionArguments *args) {
    const Bounds3f b = static_cast<const Quadric *>(args->geometryUserPtr)->WorldBounds();
    *args->bounds_o = {b.pMin.x, b.pMin.y, b.pMin.z, 0, b.pMax.x, b.pMax.y, b.pMax.z, 0};
}

Ray FromEmbree(const RTCRay &r) {
    return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tnear, r.tfar};
}
RTCRay ToEmbree(const Ray &ray) {
    return {ray.o.x,     ray.o.y, ray.o.z, std::max(ray.tMin, 0.f), ray.d.x, ray.d.y, ray.d.z, 0, ray.tMax,
            0xffffffffu, 0,       0};
}

// Embree calls the callbacks of single rays with N = 1.
void QuadricIntersect(const RTCIntersectFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    const auto *quadric = static_cast<const Quadric *>(args->geometryUserPtr);
    auto *rayHit = reinterpret_cast<RTCRayHit *>(args->rayhit);
    auto *context = reinterpret_cast<HitContext *>(args->context);
    const Ray ray = FromEmbree(rayHit->ray);
    double t;
    Vector3d p;
    if (!quadric->Intersect(ray, ray.tMin, ray.tMax, &t, &p))
        return;
    const auto tFloat = static_cast<float>(t);
    if (!(tFloat < ray.tMax))
        return;
    rayHit->ray.tfar = tFloat;
    rayHit->hit.geomID = args->geomID;
    rayHit->hit.primID = 0;
    rayHit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    context->p = p;
    context->t = t;
}

void QuadricOccluded(const RTCOccludedFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    auto *embreeRay = reinterpret_cast<RTCRay *>(args->ray);
    const Ray ray = FromEmbree(*embreeRay);
    double t;
    Vector3d p;
    if (static_cast<const Quadric *>(args->geometryUserPtr)->Intersect(ray, ray.tMin, ray.tMax, &t, &p))
        embreeRay->tfar = -Infinity;
}

// Accepts or rejects a hit that Embree has found. Embree finds t in single precision, with an error that
// grows with the triangle and its thinness. A candidate counts only if the plane really lies beyond the ray's
// start; so an origin that OffsetRayOrigin put on the right side of a triangle never meets it again, however
// long and thin it is. Holes are left out here as well.
template <bool shadow>
void MeshFilter(const RTCFilterFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    const auto *mesh = static_cast<const TracedMesh *>(args->geometryUserPtr);
    const Ray ray = FromEmbree(*reinterpret_cast<const RTCRay *>(args->ray));
    const uint32_t triangle = RTCHitN_primID(args->hit, 1, 0);
    const TracedMesh::PlaneHit hit = mesh->IntersectPlane(triangle, ray);
    if (!(hit.t > ray.tMin) || !mesh->IsThere(triangle, hit.b, shadow)) {
        args->valid[0] = 0;
        return;
    }
    if constexpr (!shadow) { // what is accepted is the nearest so far
        auto *context = reinterpret_cast<HitContext *>(args->context);
        context->p = hit.b;
        context->t = hit.t;
    }
}

// One of the two is there.
struct SolidGeometry {
    uint32_t shapeId = 0;
    std::unique_ptr<TracedMesh> mesh;
    std::unique_ptr<Quadric> quadric;
};

} // namespace

float SolidAngleDensity(double pdfArea, const Vector3d &way, double height, ShapeSample *sample) {
    const double d2 = way.LengthSquared(), d = std::sqrt(d2);
    const auto pdf = static_cast<float>(pdfArea * d2 * d / std::abs(height));
    if (!(pdf > 0 && std::isfinite(pdf)))
        return 0;
    if (sample) {
        sample->wi = Vector3f(way / d);
        sample->distance = static_cast<float>(d);
        sample->cosine = static_cast<float>(height / d);
    }
    return pdf;
}
float SolidAngleDensity(double pdfArea, const Vector3d &way, const Vector3d &n, ShapeSample *sample) {
    return SolidAngleDensity(pdfArea, way, -Dot(way, n), sample);
}

Point3f OffsetRayOrigin(const Point3f &p, const Vector3f &pError, const Normal3f &n, const Vector3f &w) {
    const float d = Dot(Abs(n), pError);
    const Vector3f offset = n * (Dot(w, n) < 0 ? -d : d);
    Point3f po = p + offset;
    for (int i = 0; i < 3; ++i)
        if (offset[i] != 0)
            po[i] = std::nextafter(po[i], offset[i] > 0 ? Infinity : -Infinity);
    return po;
}

struct SolidSet::Impl {
    std::shared_ptr<EmbreeDevice> device = EmbreeDevice::Shared();
    RTCScene scene = nullptr;
    ptrdiff_t embreeBytes = 0;
    std::vector<SolidGeometry> geometries;
    Bounds3f bound;
    bool committed = false;

    Impl() {
        const EmbreeMemoryScope scope(*device, &embreeBytes);
        scene = rtcNewScene(*device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        device->Check("cannot make a scene");
    }
    ~Impl() { rtcReleaseScene(scene); }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    uint32_t NextId() const { return static_cast<uint32_t>(geometries.size()); }
    void Attach(RTCGeometry geometry, uint32_t id) const {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
        device->Check("cannot add a shape");
    }
    uint32_t Add(Quadric quadric, uint32_t shapeId);
    // Whether a ray may meet anything at all.
    bool Accepts(const Ray &ray) const {
        return committed && !geometries.empty() && IsWithinReach(ray.o) && IsWithinReach(Point3f() + ray.d) &&
               ray.d.LengthSquared() > 0 && ray.tMax > ray.tMin && ray.tMax > 0;
    }
};

SolidSet::SolidSet() : impl_(std::make_unique<Impl>()) {}
SolidSet::~SolidSet() = default;
SolidSet::SolidSet(SolidSet &&) noexcept = default;
SolidSet &SolidSet::operator=(SolidSet &&) noexcept = default;

uint32_t SolidSet::AddMesh(TriangleMesh given, uint32_t shapeId, bool flipNormals, MeshAlpha alpha) {
    auto mesh = std::make_unique<TracedMesh>(std::move(given), flipNormals, std::move(alpha));
    impl_->bound.Extend(mesh->WorldBound());
    const uint32_t id = impl_->NextId();
    if (mesh->Triangles() > 0) {
        const EmbreeMemoryScope scope(*impl_->device, &impl_->embreeBytes);
        const TriangleMesh &m = mesh->Shared();
        RTCGeometry geometry = rtcNewGeometry(*impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m.p.data(), 0,
                                   sizeof(Point3f), m.p.size());
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m.indices.data(), 0,
                                   3 * sizeof(uint32_t), mesh->Triangles());
        rtcSetGeometryUserData(geometry, mesh.get());
        rtcSetGeometryIntersectFilterFunction(geometry, MeshFilter<false>);
        rtcSetGeometryOccludedFilterFunction(geometry, MeshFilter<true>);
        impl_->Attach(geometry, id);
    }
    impl_->geometries.push_back({shapeId, std::move(mesh), nullptr});
    impl_->committed = false;
    return id;
}

uint32_t SolidSet::Impl::Add(Quadric given, uint32_t shapeId) {
    const uint32_t id = NextId();
    auto quadric = std::make_unique<Quadric>(given);
    const std::string name = QuadricName(quadric->kind);
    if (quadric->empty) {
        Warning("empty " + name, name + ": its parameters leave no surface; nothing is drawn");
    } else {
        const Bounds3f b = quadric->WorldBounds();
        if (!IsWithinReach(b.pMin) || !IsWithinReach(b.pMax))
            throw Error("{}: its coordinates are not finite or beyond 1e18", name);
        bound.Extend(b);
        const EmbreeMemoryScope scope(*device, &embreeBytes);
        RTCGeometry geometry = rtcNewGeometry(*device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, 1);
        rtcSetGeometryUserData(geometry, quadric.get());
        rtcSetGeometryBoundsFunction(geometry, QuadricBounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, QuadricIntersect);
        rtcSetGeometryOccludedFunction(geometry, QuadricOccluded);
        Attach(geometry, id);
    }
    geometries.push_back({shapeId, nullptr, std::move(quadric)});
    committed = false;
    return id;
}

uint32_t SolidSet::AddSphere(const Transform &objectToWorld, float radius, float zMin, float zMax,
                             float phiMax, uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(Quadric::MakeSphere(objectToWorld, radius, zMin, zMax, phiMax, reverseOrientation),
                      shapeId);
}
uint32_t SolidSet::AddDisk(const Transform &objectToWorld, float height, float radius, float innerRadius,
                           float phiMax, uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(
        Quadric::MakeDisk(objectToWorld, height, radius, innerRadius, phiMax, reverseOrientation), shapeId);
}
uint32_t SolidSet::AddCylinder(const Transform &objectToWorld, float radius, float zMin, float zMax,
                               float phiMax, uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(Quadric::MakeCylinder(objectToWorld, radius, zMin, zMax, phiMax, reverseOrientation),
                      shapeId);
}
uint32_t SolidSet::AddCone(const Transform &objectToWorld, float radius, float height, float phiMax,
                           uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(Quadric::MakeCone(objectToWorld, radius, height, phiMax, reverseOrientation), shapeId);
}
uint32_t SolidSet::AddParaboloid(const Transform &objectToWorld, float radius, float zMin, float zMax,
                                 float phiMax, uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(Quadric::MakeParaboloid(objectToWorld, radius, zMin, zMax, phiMax, reverseOrientation),
                      shapeId);
}
uint32_t SolidSet::AddHyperboloid(const Transform &objectToWorld, const Point3f &p1, const Point3f &p2,
                                  float phiMax, uint32_t shapeId, bool reverseOrientation) {
    return impl_->Add(Quadric::MakeHyperboloid(objectToWorld, p1, p2, phiMax, reverseOrientation), shapeId);
}

void SolidSet::Commit() {
    const EmbreeMemoryScope scope(*impl_->device, &impl_->embreeBytes);
    // In one thread: where two triangles tie on an edge, the tree decides, and it must not depend on how
    // many threads built it.
    OnOneThread([this] { rtcCommitScene(impl_->scene); });
    impl_->device->Check("cannot build");
    impl_->committed = true;
}

bool SolidSet::Intersect(const Ray &ray, SolidPoint *point) const {
    if (!impl_->Accepts(ray))
        return false;
    HitContext context;
    InitEmbreeContext(&context.base);
    RTCRayHit rayHit{};
    rayHit.ray = ToEmbree(ray);
    rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    EmbreeIntersect(impl_->scene, &context.base, &rayHit);
    if (rayHit.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    const bool exact = std::isfinite(context.t) && impl_->geometries[rayHit.hit.geomID].mesh;
    *point = {exact ? static_cast<float>(context.t) : rayHit.ray.tfar, rayHit.hit.geomID, rayHit.hit.primID,
              context.p};
    return true;
}

SolidHit SolidSet::Describe(const SolidPoint &point) const {
    SolidHit hit;
    const SolidGeometry &geometry = impl_->geometries[point.geometryId];
    hit.t = point.t;
    hit.shapeId = geometry.shapeId;
    hit.geometryId = point.geometryId;
    if (geometry.quadric)
        geometry.quadric->FillHit(point.p, &hit);
    else
        geometry.mesh->FillHit(point.triangle, point.p, &hit);
    return hit;
}

bool SolidSet::Intersect(const Ray &ray, SolidHit *hit) const {
    SolidPoint point;
    if (!Intersect(ray, &point))
        return false;
    *hit = Describe(point);
    return true;
}

bool SolidSet::Occluded(const Ray &ray) const {
    if (!impl_->Accepts(ray))
        return false;
    EmbreeContext context;
    InitEmbreeContext(&context);
    RTCRay r = ToEmbree(ray);
    EmbreeOccluded(impl_->scene, &context, &r);
    return r.tfar < 0;
}

Bounds3f SolidSet::WorldBound() const { return impl_->bound; }
size_t SolidSet::Geometries() const { return impl_->geometries.size(); }

size_t SolidSet::MemoryBytes() const {
    size_t bytes = static_cast<size_t>(std::max<ptrdiff_t>(impl_->embreeBytes, 0)) +
                   impl_->geometries.capacity() * sizeof(SolidGeometry);
    for (const SolidGeometry &g : impl_->geometries)
        bytes += g.quadric ? sizeof(Quadric) : g.mesh->MemoryBytes();
    return bytes;
}

float SolidSet::Area(uint32_t geometryId) const {
    const SolidGeometry &g = impl_->geometries[geometryId];
    return static_cast<float>(g.quadric ? g.quadric->WorldArea() : g.mesh->Area());
}

Bounds3f SolidSet::Bound(uint32_t geometryId) const {
    const SolidGeometry &g = impl_->geometries[geometryId];
    if (g.quadric)
        return g.quadric->empty ? Bounds3f() : g.quadric->WorldBounds();
    return g.mesh->WorldBound();
}

void SolidSet::Normals(uint32_t geometryId, Vector3f *axis, float *angle) const {
    const SolidGeometry &g = impl_->geometries[geometryId];
    *axis = {0, 0, 1}, *angle = Pi;
    if (g.mesh)
        return g.mesh->Normals(axis, angle);
    if (g.quadric->kind != QuadricKind::Disk || g.quadric->empty)
        return;
    ShapeSample point;
    if (g.quadric->Sample({0.5f, 0.5f}, &point)) // a disk has one normal
        *axis = Vector3f(point.n), *angle = 0;
}

bool SolidSet::Sample(uint32_t geometryId, const Point2f &u, ShapeSample *sample) const {
    const SolidGeometry &g = impl_->geometries[geometryId];
    return g.quadric ? g.quadric->Sample(u, sample) : g.mesh->Sample(u, sample);
}

bool SolidSet::Sample(uint32_t geometryId, const Point3f &ref, const Point2f &u, ShapeSample *sample) const {
    const SolidGeometry &g = impl_->geometries[geometryId];
    return g.quadric ? g.quadric->Sample(ref, u, sample) : g.mesh->Sample(ref, u, sample);
}

float SolidSet::Pdf(const Point3f &ref, const SolidHit &hit) const {
    const SolidGeometry &g = impl_->geometries[hit.geometryId];
    return g.quadric ? g.quadric->Pdf(ref, hit.p) : g.mesh->Pdf(ref, hit.primId, hit.p);
}

} // namespace cuticle
