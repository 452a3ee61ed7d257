#include "shapes/solid_set.h"

#include "core/error.h"
#include "core/sampling.h"

#include <atomic>
#include <cstring>
#include <embree3/rtcore.h>
#include <mutex>
#include <string>
#include <tbb/task_arena.h>

namespace cuticle {

namespace {

// Coordinates beyond this are refused: Embree's traversal multiplies differences of them.
constexpr float kLargestCoordinate = 1e18f;

bool IsUsable(const Point3f &p) {
    // Written so that NaN fails.
    return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
           std::abs(p.z) <= kLargestCoordinate;
}

Vector3f Abs(const Vector3f &v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

// What rounding a point from double to float may cost, with room for the last bits of the double.
Vector3f RoundingError(const Vector3d &p) {
    const auto error = [](double x) { return static_cast<float>(std::abs(x) * 0x1.01p-24); };
    return {error(p.x), error(p.y), error(p.z)};
}

// The upper three rows of an affine matrix, in double.
struct Affine {
    double m[3][4];
    explicit Affine(const Transform &t) {
        const Transform::Matrix &src = t.M();
        for (size_t i = 0; i < 3; ++i)
            for (size_t j = 0; j < 4; ++j)
                m[i][j] = src[i][j] / src[3][3];
    }
    Vector3d Point(const Vector3d &p) const { return Vector(p) + Vector3d(m[0][3], m[1][3], m[2][3]); }
    Vector3d Vector(const Vector3d &v) const {
        return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
    }
    // By the transpose: the normal transformation of the inverse.
    Vector3d Transposed(const Vector3d &n) const {
        return {m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z, m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
                m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z};
    }
};

struct Mesh {
    TriangleMesh mesh;
    std::vector<uint32_t> original; // the triangle's number as given; empty if none was dropped
    bool flipNormals = false;
    // For sampling, made when first asked for.
    mutable std::once_flag once;
    mutable std::unique_ptr<Distribution1D> byArea;
    mutable double area = 0;

    uint32_t Triangles() const { return static_cast<uint32_t>(mesh.indices.size() / 3); }
    const uint32_t *Corners(uint32_t triangle) const { return &mesh.indices[3 * size_t{triangle}]; }
    Vector3d P(uint32_t vertex) const { return Vector3d(mesh.p[vertex]); }
    Vector3d AreaNormal(uint32_t triangle) const {
        const uint32_t *v = Corners(triangle);
        const Vector3d p0 = P(v[0]);
        return Cross(P(v[1]) - p0, P(v[2]) - p0);
    }
    float TriangleArea(uint32_t triangle) const {
        return static_cast<float>(AreaNormal(triangle).Length() / 2);
    }
    void PrepareSampling() const {
        std::call_once(once, [this] {
            std::vector<float> areas(Triangles());
            for (uint32_t i = 0; i < Triangles(); ++i)
                area += static_cast<double>(areas[i] = TriangleArea(i));
            if (area > 0)
                byArea = std::make_unique<Distribution1D>(areas.data(), static_cast<int>(areas.size()));
        });
    }
    // The interpolated vertex normal, or zero where there is none.
    Vector3d ShadingNormal(uint32_t triangle, const double b[3]) const {
        if (mesh.n.empty())
            return {};
        const uint32_t *v = Corners(triangle);
        const Vector3d n =
            Vector3d(mesh.n[v[0]]) * b[0] + Vector3d(mesh.n[v[1]]) * b[1] + Vector3d(mesh.n[v[2]]) * b[2];
        const double length = n.Length();
        return length > 0 && std::isfinite(length) ? n / length : Vector3d();
    }
    // The geometric normal on the side of the shading normal ns, if there is one.
    Vector3d OrientedNormal(const Vector3d &areaNormal, const Vector3d &ns) const {
        const Vector3d n = Normalize(areaNormal);
        const double side = Dot(n, ns);
        return side != 0 ? (side < 0 ? -n : n) : (flipNormals ? -n : n);
    }
};

enum class QuadricKind { Sphere, Disk, Cylinder };

struct Quadric {
    QuadricKind kind;
    Affine objectToWorld, worldToObject;
    double radius = 1, innerRadius = 0, height = 0;
    double zMin = -1, zMax = 1, phiMax = 2 * kPi<double>;
    double thetaMin = kPi<double>, thetaMax = 0; // of the sphere, at zMin and zMax
    bool reverseOrientation = false;
    bool empty = false;
    // World radius of a full sphere that is still a sphere in world space, else 0.
    double worldRadius = 0;
    Vector3d center; // world

    Quadric(QuadricKind k, const Transform &t) : kind(k), objectToWorld(t), worldToObject(t.Inverse()) {
        center = objectToWorld.Point({});
    }

    bool Clipped(const Vector3d &p) const {
        if (kind != QuadricKind::Disk && (p.z < zMin || p.z > zMax))
            return true;
        if (kind == QuadricKind::Disk) {
            const double r2 = p.x * p.x + p.y * p.y;
            if (!(r2 <= radius * radius && r2 >= innerRadius * innerRadius))
                return true;
        }
        return phiMax < 2 * kPi<double> && Phi(p) > phiMax;
    }
    static double Phi(const Vector3d &p) {
        const double phi = std::atan2(p.y, p.x);
        return phi < 0 ? phi + 2 * kPi<double> : phi;
    }
    // Puts a point that is nearly on the surface onto it.
    Vector3d Refined(const Vector3d &p) const {
        if (kind == QuadricKind::Disk)
            return {p.x, p.y, height};
        if (kind == QuadricKind::Sphere)
            return p * (radius / p.Length());
        const double s = radius / std::sqrt(p.x * p.x + p.y * p.y);
        return {p.x * s, p.y * s, p.z};
    }

    // The nearest hit with t in (tMin, tMax), in object space.
    bool Intersect(const Ray &ray, double tMin, double tMax, double *t, Vector3d *pObject) const {
        const Vector3d o = worldToObject.Point(Vector3d(ray.o)), d = worldToObject.Vector(Vector3d(ray.d));
        double roots[2];
        int n = 0;
        if (kind == QuadricKind::Disk) {
            if (d.z != 0)
                roots[n++] = (height - o.z) / d.z;
        } else {
            // Solve a t^2 + 2 b t + c = 0, measured from the point of the ray nearest to the axis or centre,
            // so that far origins do not cancel: there c is r^2 less the squared distance of the line.
            const bool sphere = kind == QuadricKind::Sphere;
            const double a = d.x * d.x + d.y * d.y + (sphere ? d.z * d.z : 0);
            if (!(a > 0))
                return false;
            const double tNear = -(d.x * o.x + d.y * o.y + (sphere ? d.z * o.z : 0)) / a;
            const Vector3d q = o + d * tNear;
            const double rest = radius * radius - (q.x * q.x + q.y * q.y + (sphere ? q.z * q.z : 0));
            if (!(rest >= 0))
                return false;
            const double half = std::sqrt(rest / a);
            // The root nearer to the origin is c / (a times the other one), exact to the last bits even for a
            // ray that starts on the surface.
            const double c = o.x * o.x + o.y * o.y + (sphere ? o.z * o.z : 0) - radius * radius;
            const double far = tNear + std::copysign(half, tNear);
            const double near = far != 0 ? c / (a * far) : 0;
            roots[n++] = std::min(near, far);
            roots[n++] = std::max(near, far);
        }
        for (int i = 0; i < n; ++i) {
            if (!(roots[i] > tMin && roots[i] < tMax))
                continue;
            const Vector3d p = Refined(o + d * roots[i]);
            if (Clipped(p))
                continue;
            *t = roots[i];
            *pObject = p;
            return true;
        }
        return false;
    }

    // Outward (the disk: +z), in object space.
    Vector3d ObjectNormal(const Vector3d &p) const {
        if (kind == QuadricKind::Disk)
            return {0, 0, 1};
        if (kind == QuadricKind::Sphere)
            return p / radius;
        return {p.x / radius, p.y / radius, 0};
    }
    // pbrt-v3 flips the cross product of dpdu and dpdv by reverseOrientation ^ transformSwapsHandedness. In
    // world space a mirror turns that product inward, so this is the outward normal, flipped by
    // reverseOrientation alone.
    Vector3d WorldNormal(const Vector3d &pObject) const {
        const Vector3d n = Normalize(worldToObject.Transposed(ObjectNormal(pObject)));
        return reverseOrientation ? -n : n;
    }

    void FillHit(const Vector3d &p, SolidHit *hit) const {
        const Vector3d world = objectToWorld.Point(p);
        hit->p = Point3f(world);
        hit->pError = RoundingError(world) + TransformError(p);
        const Vector3d n = WorldNormal(p);
        hit->n = hit->ns = Normal3f(n);
        const double r = std::sqrt(p.x * p.x + p.y * p.y);
        Vector3d dpdu{-phiMax * p.y, phiMax * p.x, 0}, dpdv;
        double v = 0;
        switch (kind) {
        case QuadricKind::Sphere: {
            const double theta = std::atan2(r, p.z);
            v = (theta - thetaMin) / (thetaMax - thetaMin);
            const double cosPhi = r > 0 ? p.x / r : 1, sinPhi = r > 0 ? p.y / r : 0;
            dpdv = Vector3d(p.z * cosPhi, p.z * sinPhi, -r) * (thetaMax - thetaMin);
            break;
        }
        case QuadricKind::Disk:
            v = 1 - (r - innerRadius) / (radius - innerRadius);
            dpdv = r > 0 ? Vector3d(p.x, p.y, 0) * ((innerRadius - radius) / r) : Vector3d();
            break;
        case QuadricKind::Cylinder:
            v = (p.z - zMin) / (zMax - zMin);
            dpdv = {0, 0, zMax - zMin};
            break;
        }
        hit->uv = {static_cast<float>(std::clamp(Phi(p) / phiMax, 0., 1.)),
                   static_cast<float>(std::clamp(v, 0., 1.))};
        hit->dpdu = Vector3f(objectToWorld.Vector(dpdu));
        hit->dpdv = Vector3f(objectToWorld.Vector(dpdv));
        // The poles of a sphere, the centre of a disk.
        if (!(Cross(hit->dpdu, hit->dpdv).LengthSquared() > 0))
            CoordinateSystem(hit->n, &hit->dpdu, &hit->dpdv);
    }
    // What the double-precision transformation itself rounds off: matters far from the origin only.
    Vector3f TransformError(const Vector3d &p) const {
        const auto row = [&](const double *m) {
            return static_cast<float>(0x1p-50 * (std::abs(m[0] * p.x) + std::abs(m[1] * p.y) +
                                                 std::abs(m[2] * p.z) + std::abs(m[3])));
        };
        return {row(objectToWorld.m[0]), row(objectToWorld.m[1]), row(objectToWorld.m[2])};
    }

    double ObjectArea() const {
        switch (kind) {
        case QuadricKind::Disk:
            return phiMax / 2 * (radius * radius - innerRadius * innerRadius);
        case QuadricKind::Sphere:
        case QuadricKind::Cylinder:
            break;
        }
        return phiMax * radius * (zMax - zMin);
    }
    // Uniform over the surface in object space.
    Vector3d SampleObject(double u0, double u1) const {
        const double phi = u0 * phiMax;
        double r = radius, z = Lerp(u1, zMin, zMax);
        if (kind == QuadricKind::Disk) {
            r = std::sqrt(Lerp(u1, innerRadius * innerRadius, radius * radius));
            z = height;
        } else if (kind == QuadricKind::Sphere) {
            r = std::sqrt(std::max(0., (radius - z) * (radius + z)));
        }
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
    // World area per object area at p.
    double Stretch(const Vector3d &p) const {
        Vector3d s, t;
        CoordinateSystem(ObjectNormal(p), &s, &t);
        return Cross(objectToWorld.Vector(s), objectToWorld.Vector(t)).Length();
    }
    double WorldArea() const {
        if (empty)
            return 0;
        // The stretch varies over the surface unless the transformation is a similarity; midpoint rule.
        constexpr int kSteps = 64;
        double sum = 0;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j)
                sum += Stretch(SampleObject((i + 0.5) / kSteps, (j + 0.5) / kSteps));
        return ObjectArea() * sum / (kSteps * kSteps);
    }
    // 1 - cos of half the angle that the sphere subtends from ref; 0 unless ref is outside a full sphere.
    double ConeSize(const Point3f &ref) const {
        const double d2 = (center - Vector3d(ref)).LengthSquared(), r2 = worldRadius * worldRadius;
        if (!(worldRadius > 0 && d2 > r2))
            return 0;
        const double sin2 = r2 / d2;
        return sin2 / (1 + std::sqrt(1 - sin2));
    }

    Bounds3f WorldBounds() const {
        const double z0 = kind == QuadricKind::Disk ? height : zMin,
                     z1 = kind == QuadricKind::Disk ? height : zMax;
        Bounds3f b;
        if (worldRadius > 0) {
            const Vector3d r(worldRadius, worldRadius, worldRadius);
            b.Extend(Point3f(center - r));
            b.Extend(Point3f(center + r));
        } else {
            for (int i = 0; i < 8; ++i)
                b.Extend(Point3f(objectToWorld.Point(
                    {i & 1 ? radius : -radius, i & 2 ? radius : -radius, i & 4 ? z1 : z0})));
        }
        // Outward by what rounding may have cost.
        const Vector3f pad = (Max(Abs(b.pMin), Abs(b.pMax)) + b.Diagonal()) * 1e-6f;
        b.pMin -= pad;
        b.pMax += pad;
        return b;
    }
};

// For callbacks: the geometry's own record beside where the nearest hit goes.
struct HitContext {
    RTCIntersectContext base; // first, so that Embree's pointer is ours
    Vector3d pObject;
    double t = 0;
};

void QuadricBounds(const RTCBoundsFunctionArguments *args) {
    const Bounds3f b = static_cast<const Quadric *>(args->geometryUserPtr)->WorldBounds();
    *args->bounds_o = {b.pMin.x, b.pMin.y, b.pMin.z, 0, b.pMax.x, b.pMax.y, b.pMax.z, 0};
}

Ray FromEmbree(const RTCRay &r) {
    return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tnear, r.tfar};
}

// Embree 3 calls single-ray queries with N = 1.
void QuadricIntersect(const RTCIntersectFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    const auto *quadric = static_cast<const Quadric *>(args->geometryUserPtr);
    auto *rayHit = reinterpret_cast<RTCRayHit *>(args->rayhit);
    auto *context = reinterpret_cast<HitContext *>(args->context);
    const Ray ray = FromEmbree(rayHit->ray);
    double t;
    Vector3d p;
    if (!quadric->Intersect(ray, static_cast<double>(ray.tMin), static_cast<double>(ray.tMax), &t, &p))
        return;
    const auto tFloat = static_cast<float>(t);
    if (!(tFloat < ray.tMax))
        return;
    rayHit->ray.tfar = tFloat;
    rayHit->hit.geomID = args->geomID;
    rayHit->hit.primID = 0;
    rayHit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    context->pObject = p;
    context->t = t;
}

void QuadricOccluded(const RTCOccludedFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    auto *embreeRay = reinterpret_cast<RTCRay *>(args->ray);
    const Ray ray = FromEmbree(*embreeRay);
    double t;
    Vector3d p;
    if (static_cast<const Quadric *>(args->geometryUserPtr)
            ->Intersect(ray, static_cast<double>(ray.tMin), static_cast<double>(ray.tMax), &t, &p))
        embreeRay->tfar = -Infinity;
}

// Where a ray meets the plane of a triangle, and the barycentric coordinates there, in double.
struct PlaneHit {
    double t;
    double b[3];
    Vector3d areaNormal;
};
PlaneHit MeetPlane(const Mesh &mesh, uint32_t triangle, const Ray &ray) {
    const uint32_t *v = mesh.Corners(triangle);
    const Vector3d p0 = mesh.P(v[0]), e1 = mesh.P(v[1]) - p0, e2 = mesh.P(v[2]) - p0;
    const Vector3d o(ray.o), d(ray.d), s = o - p0, n = Cross(e1, e2);
    PlaneHit hit{};
    hit.areaNormal = n;
    const double det = -Dot(d, n);
    hit.t = Dot(s, n) / det;
    const Vector3d q = Cross(s, d);
    const double b1 = Dot(e2, q) / det, b2 = -Dot(e1, q) / det;
    // Embree decides who owns a point on an edge; here the point is only kept inside.
    hit.b[1] = std::clamp(b1, 0., 1.);
    hit.b[2] = std::clamp(b2, 0., 1. - hit.b[1]);
    hit.b[0] = 1 - hit.b[1] - hit.b[2];
    return hit;
}

// Embree finds t in single precision, with an error that grows with the triangle and its thinness. A
// candidate counts only if the plane really lies beyond the ray's start; so an origin that OffsetRayOrigin
// put on the right side of a triangle never meets it again, however long and thin it is.
void MeshFilter(const RTCFilterFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    const auto *mesh = static_cast<const Mesh *>(args->geometryUserPtr);
    const Ray ray = FromEmbree(*reinterpret_cast<const RTCRay *>(args->ray));
    const uint32_t triangle = RTCHitN_primID(args->hit, 1, 0);
    const PlaneHit hit = MeetPlane(*mesh, triangle, ray);
    if (!(hit.t > static_cast<double>(ray.tMin)))
        args->valid[0] = 0;
}

struct Geometry {
    uint32_t shapeId = 0;
    std::unique_ptr<Mesh> mesh;
    std::unique_ptr<Quadric> quadric;
};

bool MemoryMonitor(void *counter, ssize_t bytes, bool) {
    static_cast<std::atomic<ssize_t> *>(counter)->fetch_add(bytes, std::memory_order_relaxed);
    return true;
}

// Turns a density per area into one per solid angle; 0 or infinity where the surface is seen edge-on.
float SolidAnglePdf(float pdfArea, const Point3f &ref, const Point3f &p, const Normal3f &n) {
    const Vector3d w = Vector3d(p) - Vector3d(ref);
    const double d2 = w.LengthSquared(), cosTimesD = std::abs(Dot(w, Vector3d(n)));
    return static_cast<float>(static_cast<double>(pdfArea) * d2 * std::sqrt(d2) / cosTimesD);
}

} // namespace

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
    std::atomic<ssize_t> embreeBytes{0};
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<Geometry> geometries;
    Bounds3f bound;
    bool committed = false;

    Impl() {
        device = rtcNewDevice(nullptr);
        if (!device)
            throw Error("Embree cannot start (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
        rtcSetDeviceMemoryMonitorFunction(device, MemoryMonitor, &embreeBytes);
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    }
    ~Impl() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    void Check(const char *what) const {
        if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
            throw Error(std::string("Embree: ") + what +
                        (error == RTC_ERROR_OUT_OF_MEMORY
                             ? ": out of memory"
                             : ": error " + std::to_string(static_cast<int>(error))));
    }
    uint32_t NextId() const { return static_cast<uint32_t>(geometries.size()); }
    void Attach(RTCGeometry geometry, uint32_t id) const {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
        Check("cannot add a shape");
    }
    uint32_t Add(std::unique_ptr<Quadric> quadric, uint32_t shapeId, const char *name);
    bool Query(const Ray &ray) const {
        return committed && !geometries.empty() && IsFinite(ray.o) && IsFinite(ray.d) &&
               ray.d.LengthSquared() > 0 && ray.tMax > ray.tMin && ray.tMax > 0;
    }
};

SolidSet::SolidSet() : impl_(std::make_unique<Impl>()) {}
SolidSet::~SolidSet() = default;
SolidSet::SolidSet(SolidSet &&) noexcept = default;
SolidSet &SolidSet::operator=(SolidSet &&) noexcept = default;

uint32_t SolidSet::AddMesh(TriangleMesh given, uint32_t shapeId, bool flipNormals) {
    if (given.indices.size() % 3 != 0)
        throw Error("triangle mesh: " + std::to_string(given.indices.size()) +
                    " indices, which is not a multiple of 3");
    if (!given.n.empty() && given.n.size() != given.p.size())
        throw Error("triangle mesh: " + std::to_string(given.n.size()) + " normals for " +
                    std::to_string(given.p.size()) + " vertices");
    if (!given.uv.empty() && given.uv.size() != given.p.size())
        throw Error("triangle mesh: " + std::to_string(given.uv.size()) + " texture coordinates for " +
                    std::to_string(given.p.size()) + " vertices");

    auto mesh = std::make_unique<Mesh>();
    mesh->mesh = std::move(given);
    mesh->flipNormals = flipNormals;
    TriangleMesh &m = mesh->mesh;

    // Keep the triangles that have a meaning.
    size_t outOfRange = 0, notFinite = 0, noArea = 0, kept = 0;
    const size_t triangles = m.indices.size() / 3;
    std::vector<uint32_t> original;
    for (size_t i = 0; i < triangles; ++i) {
        const uint32_t v[3] = {m.indices[3 * i], m.indices[3 * i + 1], m.indices[3 * i + 2]};
        bool good = false;
        if (v[0] >= m.p.size() || v[1] >= m.p.size() || v[2] >= m.p.size()) {
            ++outOfRange;
        } else if (!IsUsable(m.p[v[0]]) || !IsUsable(m.p[v[1]]) || !IsUsable(m.p[v[2]])) {
            ++notFinite;
        } else {
            const Vector3d p0(m.p[v[0]]);
            good = Cross(Vector3d(m.p[v[1]]) - p0, Vector3d(m.p[v[2]]) - p0).LengthSquared() > 0;
            noArea += !good;
        }
        if (!good) {
            if (original.empty())
                for (size_t j = 0; j < kept; ++j)
                    original.push_back(static_cast<uint32_t>(j));
            continue;
        }
        if (kept != i) {
            original.push_back(static_cast<uint32_t>(i));
            std::copy(v, v + 3, m.indices.begin() + static_cast<std::ptrdiff_t>(3 * kept));
        }
        ++kept;
        for (const uint32_t vertex : v)
            impl_->bound.Extend(m.p[vertex]);
    }
    if (kept != triangles) {
        m.indices.resize(3 * kept);
        mesh->original = std::move(original);
        std::string why;
        const auto add = [&](size_t n, const char *text) {
            if (n > 0)
                why += (why.empty() ? "" : ", ") + std::to_string(n) + " " + text;
        };
        add(outOfRange, "with an index out of range");
        add(notFinite, "with a vertex that is not finite");
        add(noArea, "without area");
        Warning("triangles dropped", "triangle mesh: " + std::to_string(triangles - kept) + " of " +
                                         std::to_string(triangles) + " triangles dropped (" + why + ")");
    }

    const uint32_t id = impl_->NextId();
    if (kept > 0) {
        // Embree reads 16 bytes for each vertex of 12: one spare behind the last.
        m.p.reserve(m.p.size() + 1);
        RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m.p.data(), 0,
                                   sizeof(Point3f), m.p.size());
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m.indices.data(), 0,
                                   3 * sizeof(uint32_t), kept);
        rtcSetGeometryUserData(geometry, mesh.get());
        rtcSetGeometryIntersectFilterFunction(geometry, MeshFilter);
        rtcSetGeometryOccludedFilterFunction(geometry, MeshFilter);
        impl_->Attach(geometry, id);
    }
    impl_->geometries.push_back({shapeId, std::move(mesh), nullptr});
    impl_->committed = false;
    return id;
}

uint32_t SolidSet::Impl::Add(std::unique_ptr<Quadric> quadric, uint32_t shapeId, const char *name) {
    const uint32_t id = NextId();
    if (!(quadric->ObjectArea() > 0))
        quadric->empty = true;
    if (quadric->empty) {
        Warning(std::string("empty ") + name,
                std::string(name) + ": its parameters leave no surface; nothing is drawn");
    } else {
        const Bounds3f b = quadric->WorldBounds();
        if (!IsUsable(b.pMin) || !IsUsable(b.pMax))
            throw Error(std::string(name) + ": its coordinates are not finite or beyond 1e18");
        bound.Extend(b);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
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

static void RequireFinite(const char *name, const Transform &t, std::initializer_list<float> parameters) {
    for (const float v : parameters)
        if (!std::isfinite(v))
            throw Error(std::string(name) + ": a parameter is not finite");
    if (t.IsSingular())
        throw Error(std::string(name) + ": its transformation has no inverse");
    const auto &m = t.M();
    if (m[3][0] != 0 || m[3][1] != 0 || m[3][2] != 0)
        throw Error(std::string(name) + ": its transformation is not affine (last row of the matrix)");
}

static double SweepRadians(float phiMax) {
    return static_cast<double>(std::clamp(phiMax, 0.f, 360.f)) * kPi<double> / 180;
}

uint32_t SolidSet::AddSphere(const Transform &objectToWorld, float radius, float zMin, float zMax,
                             float phiMax, uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("sphere", objectToWorld, {radius, zMin, zMax, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Sphere, objectToWorld);
    q->radius = static_cast<double>(std::max(radius, 0.f));
    q->zMin = std::clamp(static_cast<double>(std::min(zMin, zMax)), -q->radius, q->radius);
    q->zMax = std::clamp(static_cast<double>(std::max(zMin, zMax)), -q->radius, q->radius);
    q->phiMax = SweepRadians(phiMax);
    if (q->radius > 0) {
        q->thetaMin = std::acos(q->zMin / q->radius);
        q->thetaMax = std::acos(q->zMax / q->radius);
    }
    q->reverseOrientation = reverseOrientation;
    // A full sphere under a similarity stays one: the columns are orthogonal and of one length.
    const auto &m = q->objectToWorld.m;
    const Vector3d x{m[0][0], m[1][0], m[2][0]}, y{m[0][1], m[1][1], m[2][1]}, z{m[0][2], m[1][2], m[2][2]};
    const double s2 = x.LengthSquared(), tolerance = 1e-6 * s2;
    if (q->zMin == -q->radius && q->zMax == q->radius && phiMax >= 360 &&
        std::abs(y.LengthSquared() - s2) <= tolerance && std::abs(z.LengthSquared() - s2) <= tolerance &&
        std::abs(Dot(x, y)) <= tolerance && std::abs(Dot(y, z)) <= tolerance &&
        std::abs(Dot(z, x)) <= tolerance)
        q->worldRadius = q->radius * std::sqrt(s2);
    return impl_->Add(std::move(q), shapeId, "sphere");
}

uint32_t SolidSet::AddDisk(const Transform &objectToWorld, float height, float radius, float innerRadius,
                           float phiMax, uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("disk", objectToWorld, {height, radius, innerRadius, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Disk, objectToWorld);
    q->height = static_cast<double>(height);
    q->radius = static_cast<double>(std::max(radius, 0.f));
    q->innerRadius = static_cast<double>(std::max(innerRadius, 0.f));
    q->phiMax = SweepRadians(phiMax);
    q->reverseOrientation = reverseOrientation;
    return impl_->Add(std::move(q), shapeId, "disk");
}

uint32_t SolidSet::AddCylinder(const Transform &objectToWorld, float radius, float zMin, float zMax,
                               float phiMax, uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("cylinder", objectToWorld, {radius, zMin, zMax, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Cylinder, objectToWorld);
    q->radius = static_cast<double>(std::max(radius, 0.f));
    q->zMin = static_cast<double>(std::min(zMin, zMax));
    q->zMax = static_cast<double>(std::max(zMin, zMax));
    q->phiMax = SweepRadians(phiMax);
    q->reverseOrientation = reverseOrientation;
    return impl_->Add(std::move(q), shapeId, "cylinder");
}

void SolidSet::Commit() {
    // In one thread: where two triangles tie on an edge, the tree decides, and it must not depend on how
    // many threads built it.
    tbb::task_arena one(1);
    one.execute([this] { rtcCommitScene(impl_->scene); });
    impl_->Check("cannot build");
    impl_->committed = true;
}

bool SolidSet::Intersect(const Ray &ray, SolidHit *hit) const {
    if (!impl_->Query(ray))
        return false;
    HitContext context;
    rtcInitIntersectContext(&context.base);
    RTCRayHit rayHit{};
    rayHit.ray = {ray.o.x,  ray.o.y,     ray.o.z, std::max(ray.tMin, 0.f),
                  ray.d.x,  ray.d.y,     ray.d.z, 0,
                  ray.tMax, 0xffffffffu, 0,       0};
    rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->scene, &context.base, &rayHit);
    if (rayHit.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;

    const Geometry &geometry = impl_->geometries[rayHit.hit.geomID];
    hit->shapeId = geometry.shapeId;
    hit->geometryId = rayHit.hit.geomID;
    if (geometry.quadric) {
        hit->primId = 0;
        hit->t = rayHit.ray.tfar;
        geometry.quadric->FillHit(context.pObject, hit);
        return true;
    }

    const Mesh &mesh = *geometry.mesh;
    const uint32_t triangle = rayHit.hit.primID;
    const PlaneHit plane = MeetPlane(mesh, triangle, ray);
    hit->primId = mesh.original.empty() ? triangle : mesh.original[triangle];
    hit->t = std::isfinite(plane.t) ? static_cast<float>(plane.t) : rayHit.ray.tfar;
    const uint32_t *v = mesh.Corners(triangle);
    const Vector3d p0 = mesh.P(v[0]), p1 = mesh.P(v[1]), p2 = mesh.P(v[2]);
    const Vector3d p = p0 * plane.b[0] + p1 * plane.b[1] + p2 * plane.b[2];
    hit->p = Point3f(p);
    hit->pError = RoundingError(p);

    const Vector3d ns = mesh.ShadingNormal(triangle, plane.b);
    const Vector3d n = mesh.OrientedNormal(plane.areaNormal, ns);
    hit->n = Normal3f(n);
    hit->ns = ns.LengthSquared() > 0 ? Normal3f(ns) : hit->n;

    Vector2<double> uv[3] = {{0, 0}, {1, 0}, {1, 1}};
    if (!mesh.mesh.uv.empty())
        for (size_t i = 0; i < 3; ++i)
            uv[i] = {static_cast<double>(mesh.mesh.uv[v[i]].x), static_cast<double>(mesh.mesh.uv[v[i]].y)};
    const Vector2<double> uvHit = uv[0] * plane.b[0] + uv[1] * plane.b[1] + uv[2] * plane.b[2];
    hit->uv = {static_cast<float>(uvHit.x), static_cast<float>(uvHit.y)};
    const Vector2<double> duv02 = uv[0] - uv[2], duv12 = uv[1] - uv[2];
    const Vector3d dp02 = p0 - p2, dp12 = p1 - p2;
    const double det = duv02.x * duv12.y - duv02.y * duv12.x;
    const Vector3d dpdu = (dp02 * duv12.y - dp12 * duv02.y) / det,
                   dpdv = (dp12 * duv02.x - dp02 * duv12.x) / det;
    hit->dpdu = Vector3f(dpdu);
    hit->dpdv = Vector3f(dpdv);
    if (!(Cross(dpdu, dpdv).LengthSquared() > 0) || !IsFinite(hit->dpdu) || !IsFinite(hit->dpdv))
        CoordinateSystem(hit->n, &hit->dpdu, &hit->dpdv);
    return true;
}

bool SolidSet::Occluded(const Ray &ray) const {
    if (!impl_->Query(ray))
        return false;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay r = {ray.o.x,  ray.o.y,     ray.o.z, std::max(ray.tMin, 0.f),
                ray.d.x,  ray.d.y,     ray.d.z, 0,
                ray.tMax, 0xffffffffu, 0,       0};
    rtcOccluded1(impl_->scene, &context, &r);
    return r.tfar < 0;
}

Bounds3f SolidSet::WorldBound() const { return impl_->bound; }
size_t SolidSet::Geometries() const { return impl_->geometries.size(); }

size_t SolidSet::MemoryBytes() const {
    size_t bytes = static_cast<size_t>(std::max<ssize_t>(impl_->embreeBytes, 0)) +
                   impl_->geometries.capacity() * sizeof(Geometry);
    for (const Geometry &g : impl_->geometries) {
        if (g.quadric)
            bytes += sizeof(Quadric);
        if (g.mesh)
            bytes += sizeof(Mesh) + g.mesh->mesh.p.capacity() * sizeof(Point3f) +
                     g.mesh->mesh.n.capacity() * sizeof(Normal3f) +
                     g.mesh->mesh.uv.capacity() * sizeof(Point2f) +
                     (g.mesh->mesh.indices.capacity() + g.mesh->original.capacity()) * sizeof(uint32_t);
    }
    return bytes;
}

float SolidSet::Area(uint32_t geometryId) const {
    const Geometry &g = impl_->geometries[geometryId];
    if (g.quadric)
        return static_cast<float>(g.quadric->WorldArea());
    g.mesh->PrepareSampling();
    return static_cast<float>(g.mesh->area);
}

bool SolidSet::Sample(uint32_t geometryId, const Point2f &u, ShapeSample *sample) const {
    const Geometry &g = impl_->geometries[geometryId];
    if (g.quadric) {
        const Quadric &q = *g.quadric;
        if (q.empty)
            return false;
        const Vector3d p = q.SampleObject(static_cast<double>(u.x), static_cast<double>(u.y));
        const Vector3d world = q.objectToWorld.Point(p);
        sample->p = Point3f(world);
        sample->pError = RoundingError(world) + q.TransformError(p);
        sample->n = Normal3f(q.WorldNormal(p));
        sample->pdf = static_cast<float>(1 / (q.ObjectArea() * q.Stretch(p)));
        return sample->pdf > 0 && std::isfinite(sample->pdf);
    }
    const Mesh &mesh = *g.mesh;
    mesh.PrepareSampling();
    if (!mesh.byArea)
        return false;
    float u0;
    const auto triangle = static_cast<uint32_t>(mesh.byArea->SampleDiscrete(u.x, nullptr, &u0));
    const Point2f b = UniformSampleTriangle({u0, u.y});
    const double bary[3] = {static_cast<double>(b.x), static_cast<double>(b.y),
                            1 - static_cast<double>(b.x) - static_cast<double>(b.y)};
    const uint32_t *v = mesh.Corners(triangle);
    const Vector3d p = mesh.P(v[0]) * bary[0] + mesh.P(v[1]) * bary[1] + mesh.P(v[2]) * bary[2];
    sample->p = Point3f(p);
    sample->pError = RoundingError(p);
    sample->n = Normal3f(mesh.OrientedNormal(mesh.AreaNormal(triangle), mesh.ShadingNormal(triangle, bary)));
    sample->pdf = mesh.byArea->DiscretePDF(static_cast<int>(triangle)) / mesh.TriangleArea(triangle);
    return sample->pdf > 0 && std::isfinite(sample->pdf);
}

bool SolidSet::Sample(uint32_t geometryId, const Point3f &ref, const Point2f &u, ShapeSample *sample) const {
    const Geometry &g = impl_->geometries[geometryId];
    if (g.quadric && !g.quadric->empty) {
        const Quadric &q = *g.quadric;
        if (const double cone = q.ConeSize(ref); cone > 0) {
            // Uniform in the cone: 1 - cos theta is uniform in [0, cone].
            const double x = static_cast<double>(u.x) * cone, cosTheta = 1 - x, sin2 = x * (2 - x);
            const double phi = 2 * kPi<double> * static_cast<double>(u.y);
            const Vector3d toCenter = q.center - Vector3d(ref);
            const double dc2 = toCenter.LengthSquared(), dc = std::sqrt(dc2);
            Vector3d s, t;
            const Vector3d axis = toCenter / dc;
            CoordinateSystem(axis, &s, &t);
            const double sinTheta = std::sqrt(sin2);
            const Vector3d w =
                s * (sinTheta * std::cos(phi)) + t * (sinTheta * std::sin(phi)) + axis * cosTheta;
            const double r2 = q.worldRadius * q.worldRadius;
            const double distance = dc * cosTheta - std::sqrt(std::max(0., r2 - dc2 * sin2));
            // Onto the sphere, against the rounding near the limb.
            Vector3d n = Normalize(Vector3d(ref) + w * distance - q.center);
            const Vector3d p = q.center + n * q.worldRadius;
            sample->p = Point3f(p);
            sample->pError = RoundingError(p);
            sample->n = Normal3f(q.reverseOrientation ? -n : n);
            sample->pdf = static_cast<float>(1 / (2 * kPi<double> * cone));
            return std::isfinite(sample->pdf);
        }
    }
    if (!Sample(geometryId, u, sample))
        return false;
    sample->pdf = SolidAnglePdf(sample->pdf, ref, sample->p, sample->n);
    return sample->pdf > 0 && std::isfinite(sample->pdf);
}

float SolidSet::Pdf(const Point3f &ref, const SolidHit &hit) const {
    const Geometry &g = impl_->geometries[hit.geometryId];
    float pdfArea;
    if (g.quadric) {
        const Quadric &q = *g.quadric;
        if (const double cone = q.ConeSize(ref); cone > 0)
            return static_cast<float>(1 / (2 * kPi<double> * cone));
        const Vector3d p = q.Refined(q.worldToObject.Point(Vector3d(hit.p)));
        pdfArea = static_cast<float>(1 / (q.ObjectArea() * q.Stretch(p)));
    } else {
        const Mesh &mesh = *g.mesh;
        mesh.PrepareSampling();
        uint32_t triangle = hit.primId;
        if (!mesh.original.empty())
            triangle = static_cast<uint32_t>(
                std::lower_bound(mesh.original.begin(), mesh.original.end(), hit.primId) -
                mesh.original.begin());
        if (!mesh.byArea || triangle >= mesh.Triangles())
            return 0;
        pdfArea = mesh.byArea->DiscretePDF(static_cast<int>(triangle)) / mesh.TriangleArea(triangle);
    }
    const float pdf = SolidAnglePdf(pdfArea, ref, hit.p, hit.n);
    // Seen exactly edge-on (or from the surface itself) no sample is taken: Sample returns false there.
    return std::isfinite(pdf) ? pdf : 0;
}

} // namespace cuticle
