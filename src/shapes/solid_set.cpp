#include "shapes/solid_set.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "shapes/embree_device.h"

#include <cstring>
#include <mutex>
#include <string>

namespace cuticle {

namespace {

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
    SolidSet::MeshAlpha alpha; // null: the mesh is there everywhere
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
    Vector3d ShadingNormal(uint32_t triangle, const Vector3d &b) const {
        if (mesh.n.empty())
            return {};
        const uint32_t *v = Corners(triangle);
        const Vector3d n =
            Vector3d(mesh.n[v[0]]) * b[0] + Vector3d(mesh.n[v[1]]) * b[1] + Vector3d(mesh.n[v[2]]) * b[2];
        const double length = n.Length();
        return length > 0 && std::isfinite(length) ? n / length : Vector3d();
    }
    // Of a point with these barycentric coordinates.
    Vector3d Point(uint32_t triangle, const Vector3d &b) const {
        const uint32_t *v = Corners(triangle);
        return P(v[0]) * b[0] + P(v[1]) * b[1] + P(v[2]) * b[2];
    }
    void CornerUVs(uint32_t triangle, Vector2<double> uv[3]) const {
        uv[0] = {0, 0}, uv[1] = {1, 0}, uv[2] = {1, 1};
        if (!mesh.uv.empty())
            for (size_t i = 0; i < 3; ++i) {
                const Point2f &corner = mesh.uv[Corners(triangle)[i]];
                uv[i] = {static_cast<double>(corner.x), static_cast<double>(corner.y)};
            }
    }
    Vector2<double> UV(uint32_t triangle, const Vector3d &b) const {
        Vector2<double> uv[3];
        CornerUVs(triangle, uv);
        return uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2];
    }
    // The geometric normal on the side of the shading normal ns, if there is one.
    Vector3d OrientedNormal(const Vector3d &areaNormal, const Vector3d &ns) const {
        const Vector3d n = Normalize(areaNormal);
        const double side = Dot(n, ns);
        return side != 0 ? (side < 0 ? -n : n) : (flipNormals ? -n : n);
    }
};

enum class QuadricKind { Sphere, Disk, Cylinder, Cone, Paraboloid, Hyperboloid };

// Every quadric but the disk is a surface of revolution, x^2 + y^2 = rho(z) with rho(z) = c0 + c1 z + c2 z^2.
struct Quadric {
    QuadricKind kind;
    Affine objectToWorld, worldToObject;
    double radius = 1, innerRadius = 0, height = 0; // of the sphere, the cylinder and the disk
    double c0 = 0, c1 = 0, c2 = 0;
    double zMin = -1, zMax = 1, phiMax = 2 * kPi<double>;
    double thetaMin = kPi<double>, thetaMax = 0; // of the sphere, at zMin and zMax
    double v0 = 0, v1 = 1;                       // of the rest: z where v is 0 and 1
    Vector3d twist0{1, 0, 0}, twist1{1, 0, 0}; // of the hyperboloid: phi = 0 is where these two's mean points
    bool reverseOrientation = false;
    bool empty = false;
    // World radius of a full sphere that is still a sphere in world space, else 0.
    double worldRadius = 0;
    Vector3d center; // world

    Quadric(QuadricKind k, const Transform &t) : kind(k), objectToWorld(t), worldToObject(t.Inverse()) {
        center = objectToWorld.Point({});
    }

    double Rho(double z) const { return c0 + z * (c1 + z * c2); }
    double RhoPrime(double z) const { return c1 + 2 * z * c2; }
    double V(double z) const { return (z - v0) / (v1 - v0); }
    // Where the sweep begins at height z, as a vector across the axis.
    Vector3d SweepStart(double z) const { return twist0 + (twist1 - twist0) * V(z); }

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
    double Phi(const Vector3d &p) const {
        double phi;
        if (kind == QuadricKind::Hyperboloid) {
            const Vector3d s = SweepStart(p.z);
            phi = std::atan2(s.x * p.y - s.y * p.x, s.x * p.x + s.y * p.y);
        } else {
            phi = std::atan2(p.y, p.x);
        }
        return phi < 0 ? phi + 2 * kPi<double> : phi;
    }
    // Puts a point that is nearly on the surface onto it.
    Vector3d Refined(const Vector3d &p) const {
        switch (kind) {
        case QuadricKind::Disk:
            return {p.x, p.y, height};
        case QuadricKind::Sphere:
            return p * (radius / p.Length());
        case QuadricKind::Cylinder: {
            const double s = radius / std::sqrt(p.x * p.x + p.y * p.y);
            return {p.x * s, p.y * s, p.z};
        }
        default: {
            // Newton's step along the gradient; at the tip of a cone there is none.
            const Vector3d g{2 * p.x, 2 * p.y, -RhoPrime(p.z)};
            const double g2 = g.LengthSquared();
            return g2 > 0 ? p - g * ((p.x * p.x + p.y * p.y - Rho(p.z)) / g2) : p;
        }
        }
    }

    // Where the line o + t d meets the whole surface, in order; the number of roots.
    int Roots(const Vector3d &o, const Vector3d &d, double roots[2]) const {
        if (kind == QuadricKind::Disk) {
            if (d.z == 0)
                return 0;
            roots[0] = (height - o.z) / d.z;
            return 1;
        }
        // a t^2 + 2 b t + c = 0
        const double a = d.x * d.x + d.y * d.y - c2 * d.z * d.z;
        const double b = d.x * o.x + d.y * o.y - d.z * RhoPrime(o.z) / 2;
        const double c = o.x * o.x + o.y * o.y - Rho(o.z);
        double root; // of b^2 - a c
        if (b * b > 4 * std::abs(a * c)) {
            root = std::sqrt(b * b - a * c);
        } else {
            // From a far origin b^2 and a c cancel. Measured from the point of the line that is nearest to the
            // surface in the quadratic form, there is only one term.
            if (a == 0)
                return 0;
            const Vector3d q = o - d * (b / a);
            const double square = a * (Rho(q.z) - (q.x * q.x + q.y * q.y));
            if (!(square >= 0))
                return 0;
            root = std::sqrt(square);
        }
        // The root nearer to the origin is c over a times the other, exact to the last bits even for a ray that
        // starts on the surface.
        const double aTimesFar = -b - std::copysign(root, b);
        roots[0] = aTimesFar != 0 ? c / aTimesFar : 0;
        if (a == 0)
            return 1;
        roots[1] = aTimesFar / a;
        if (roots[1] < roots[0])
            std::swap(roots[0], roots[1]);
        return 2;
    }

    // The nearest hit with t in (tMin, tMax), in object space.
    bool Intersect(const Ray &ray, double tMin, double tMax, double *t, Vector3d *pObject) const {
        const Vector3d o = worldToObject.Point(Vector3d(ray.o)), d = worldToObject.Vector(Vector3d(ray.d));
        double roots[2];
        const int n = Roots(o, d, roots);
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

    // The side of pbrt-v3's cross product of dpdu and dpdv, in object space and of unit length: outward; of the disk
    // +z; of a hyperboloid swept downward inward. At the tip of a cone: along its axis.
    Vector3d ObjectNormal(const Vector3d &p) const {
        switch (kind) {
        case QuadricKind::Disk:
            return {0, 0, 1};
        case QuadricKind::Sphere:
            return p / radius;
        case QuadricKind::Cylinder:
            return {p.x / radius, p.y / radius, 0};
        default: {
            const Vector3d g{p.x, p.y, -RhoPrime(p.z) / 2};
            const double length = std::copysign(g.Length(), v1 - v0);
            return length != 0 ? g / length : Vector3d(0, 0, 1);
        }
        }
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
        case QuadricKind::Cone:
        case QuadricKind::Paraboloid:
        case QuadricKind::Hyperboloid: {
            v = V(p.z);
            // Along the profile r(z), r r' = rho' / 2, and around the axis as the start of the sweep turns.
            const Vector3d s = SweepStart(p.z), e = twist1 - twist0;
            const double turn = (s.x * e.y - s.y * e.x) / (s.x * s.x + s.y * s.y);
            const double along = (v1 - v0) * RhoPrime(p.z) / (2 * r * r);
            dpdv = {p.x * along - p.y * turn, p.y * along + p.x * turn, v1 - v0};
            break;
        }
        }
        hit->uv = {static_cast<float>(std::clamp(Phi(p) / phiMax, 0., 1.)),
                   static_cast<float>(std::clamp(v, 0., 1.))};
        hit->dpdu = Vector3f(objectToWorld.Vector(dpdu));
        hit->dpdv = Vector3f(objectToWorld.Vector(dpdv));
        // The poles of a sphere, the centre of a disk, the tip of a cone.
        if (!(Cross(hit->dpdu, hit->dpdv).LengthSquared() > 0) || !IsFinite(hit->dpdv))
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

    // Where SampleObject's points lie, per object area.
    double ObjectDensity(const Vector3d &p) const {
        switch (kind) {
        case QuadricKind::Disk:
            return 2 / (phiMax * (radius * radius - innerRadius * innerRadius));
        case QuadricKind::Sphere:
        case QuadricKind::Cylinder:
            return 1 / (phiMax * radius * (zMax - zMin));
        case QuadricKind::Cone:
            return 2 / (phiMax * Slant(0) * (zMax - zMin));
        case QuadricKind::Paraboloid:
            return 3 * std::abs(c1) / (2 * phiMax * std::abs(Cube(Slant(zMax)) - Cube(Slant(zMin))));
        case QuadricKind::Hyperboloid:
            return 1 / (phiMax * Slant(p.z) * (zMax - zMin));
        }
        return 0;
    }
    static double Cube(double x) { return x * x * x; }
    // Area per dz and dphi: r sqrt(1 + r'^2).
    double Slant(double z) const { return std::sqrt(std::max(0., Rho(z) + Sqr(RhoPrime(z) / 2))); }
    // A point of the surface in object space, uniform over its area; of a hyperboloid, uniform in z and phi instead.
    // False: where a hyperboloid of two sheets has its gap.
    bool SampleObject(double u0, double u1, Vector3d *p) const {
        double phi = u0 * phiMax, r = radius, z = Lerp(u1, zMin, zMax);
        switch (kind) {
        case QuadricKind::Disk:
            r = std::sqrt(Lerp(u1, innerRadius * innerRadius, radius * radius));
            z = height;
            break;
        case QuadricKind::Sphere:
            r = std::sqrt(std::max(0., (radius - z) * (radius + z)));
            break;
        case QuadricKind::Cylinder:
            break;
        case QuadricKind::Cone: // area grows with the square of the distance from the tip
            z = zMax * (1 - std::sqrt(1 - u1));
            r = radius * std::sqrt(1 - u1);
            break;
        case QuadricKind::Paraboloid: // area grows with the cube of the slant, whose square is linear in z
            z = (Sqr(std::cbrt(Lerp(u1, Cube(Slant(zMin)), Cube(Slant(zMax))))) - Sqr(c1 / 2)) / c1;
            r = std::sqrt(std::max(0., Rho(z)));
            break;
        case QuadricKind::Hyperboloid: {
            const Vector3d s = SweepStart(z);
            phi += std::atan2(s.y, s.x);
            if (!(Rho(z) > 0))
                return false;
            r = std::sqrt(Rho(z));
            break;
        }
        }
        *p = {r * std::cos(phi), r * std::sin(phi), z};
        return true;
    }
    double AreaDensity(const Vector3d &p) const { return ObjectDensity(p) / Stretch(p); }
    // World area per object area at p.
    double Stretch(const Vector3d &p) const {
        Vector3d s, t;
        CoordinateSystem(ObjectNormal(p), &s, &t);
        return Cross(objectToWorld.Vector(s), objectToWorld.Vector(t)).Length();
    }
    double WorldArea() const {
        if (empty)
            return 0;
        // The mean of 1 / density over the samples; midpoint rule.
        constexpr int kSteps = 16;
        double sum = 0;
        Vector3d p;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j)
                if (SampleObject((i + 0.5) / kSteps, (j + 0.5) / kSteps, &p))
                    sum += 1 / AreaDensity(p);
        return sum / (kSteps * kSteps);
    }
    // 1 - cos of half the angle that the sphere subtends from ref; 0 unless ref is outside a full sphere.
    double ConeSize(const Point3f &ref) const {
        const double d2 = (center - Vector3d(ref)).LengthSquared(), r2 = worldRadius * worldRadius;
        if (!(worldRadius > 0 && d2 > r2))
            return 0;
        const double sin2 = r2 / d2;
        return sin2 / (1 + std::sqrt(1 - sin2));
    }

    double MaxRadius() const {
        if (kind == QuadricKind::Disk)
            return radius;
        double rho = std::max(Rho(zMin), Rho(zMax));
        if (const double z = -c1 / (2 * c2); z > zMin && z < zMax)
            rho = std::max(rho, Rho(z));
        return std::sqrt(std::max(rho, 0.));
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
            const double r = MaxRadius();
            for (int i = 0; i < 8; ++i)
                b.Extend(Point3f(objectToWorld.Point({i & 1 ? r : -r, i & 2 ? r : -r, i & 4 ? z1 : z0})));
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
    Vector3d p;               // as in SolidPoint
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
    if (static_cast<const Quadric *>(args->geometryUserPtr)
            ->Intersect(ray, static_cast<double>(ray.tMin), static_cast<double>(ray.tMax), &t, &p))
        embreeRay->tfar = -Infinity;
}

// Where a ray meets the plane of a triangle, and the barycentric coordinates there, in double.
struct PlaneHit {
    double t;
    Vector3d b;
};
PlaneHit IntersectPlane(const Mesh &mesh, uint32_t triangle, const Ray &ray) {
    const uint32_t *v = mesh.Corners(triangle);
    const Vector3d p0 = mesh.P(v[0]), e1 = mesh.P(v[1]) - p0, e2 = mesh.P(v[2]) - p0;
    const Vector3d o(ray.o), d(ray.d), s = o - p0, n = Cross(e1, e2);
    const double det = -Dot(d, n);
    const Vector3d q = Cross(s, d);
    const double b1 = Dot(e2, q) / det, b2 = -Dot(e1, q) / det;
    // Embree decides who owns a point on an edge; here the point is only kept inside.
    const double inside1 = std::clamp(b1, 0., 1.), inside2 = std::clamp(b2, 0., 1. - inside1);
    return {Dot(s, n) / det, {1 - inside1 - inside2, inside1, inside2}};
}

// Embree finds t in single precision, with an error that grows with the triangle and its thinness. A
// candidate counts only if the plane really lies beyond the ray's start; so an origin that OffsetRayOrigin
// put on the right side of a triangle never meets it again, however long and thin it is.
// Holes are left out here as well.
template <bool Shadow>
void MeshFilter(const RTCFilterFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    const auto *mesh = static_cast<const Mesh *>(args->geometryUserPtr);
    const Ray ray = FromEmbree(*reinterpret_cast<const RTCRay *>(args->ray));
    const uint32_t triangle = RTCHitN_primID(args->hit, 1, 0);
    const PlaneHit hit = IntersectPlane(*mesh, triangle, ray);
    if (!(hit.t > static_cast<double>(ray.tMin))) {
        args->valid[0] = 0;
        return;
    }
    if (mesh->alpha) {
        const Vector2<double> uv = mesh->UV(triangle, hit.b);
        if (!mesh->alpha(Point3f(mesh->Point(triangle, hit.b)),
                         {static_cast<float>(uv.x), static_cast<float>(uv.y)}, Shadow)) {
            args->valid[0] = 0;
            return;
        }
    }
    if constexpr (!Shadow) { // what is accepted is the nearest so far
        auto *context = reinterpret_cast<HitContext *>(args->context);
        context->p = hit.b;
        context->t = hit.t;
    }
}

struct Geometry {
    uint32_t shapeId = 0;
    std::unique_ptr<Mesh> mesh;
    std::unique_ptr<Quadric> quadric;
};

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
    std::shared_ptr<EmbreeDevice> device = EmbreeDevice::Shared();
    RTCScene scene = nullptr;
    ptrdiff_t embreeBytes = 0;
    std::vector<Geometry> geometries;
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

uint32_t SolidSet::AddMesh(TriangleMesh given, uint32_t shapeId, bool flipNormals, MeshAlpha alpha) {
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
    mesh->alpha = std::move(alpha);
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
        } else if (!IsWithinReach(m.p[v[0]]) || !IsWithinReach(m.p[v[1]]) || !IsWithinReach(m.p[v[2]])) {
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
        const EmbreeMemoryScope scope(*impl_->device, &impl_->embreeBytes);
        // Embree reads 16 bytes for each vertex of 12: one spare behind the last.
        m.p.reserve(m.p.size() + 1);
        RTCGeometry geometry = rtcNewGeometry(*impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m.p.data(), 0,
                                   sizeof(Point3f), m.p.size());
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m.indices.data(), 0,
                                   3 * sizeof(uint32_t), kept);
        rtcSetGeometryUserData(geometry, mesh.get());
        rtcSetGeometryIntersectFilterFunction(geometry, MeshFilter<false>);
        rtcSetGeometryOccludedFilterFunction(geometry, MeshFilter<true>);
        impl_->Attach(geometry, id);
    }
    impl_->geometries.push_back({shapeId, std::move(mesh), nullptr});
    impl_->committed = false;
    return id;
}

uint32_t SolidSet::Impl::Add(std::unique_ptr<Quadric> quadric, uint32_t shapeId, const char *name) {
    const uint32_t id = NextId();
    quadric->empty |= !(quadric->phiMax > 0 && quadric->MaxRadius() > 0 &&
                        (quadric->kind == QuadricKind::Disk ? quadric->radius > quadric->innerRadius
                                                            : quadric->zMax > quadric->zMin));
    if (quadric->empty) {
        Warning(std::string("empty ") + name,
                std::string(name) + ": its parameters leave no surface; nothing is drawn");
    } else {
        const Bounds3f b = quadric->WorldBounds();
        if (!IsWithinReach(b.pMin) || !IsWithinReach(b.pMax))
            throw Error(std::string(name) + ": its coordinates are not finite or beyond 1e18");
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

// pbrt-v3's hyperboloid: the quadric x^2 + y^2 = c0 + c2 z^2 through the circles of b and of a point further along the
// line from a to b. A point where that has no solution is passed over, as pbrt-v3 does; pbrt-v3 also passes over c0 = 0, for ever.
static bool ThroughTwoCircles(const Vector3d &a, const Vector3d &b, double *c0, double *c2) {
    const auto radius2 = [](const Vector3d &p) { return p.x * p.x + p.y * p.y; };
    Vector3d p = a;
    for (int i = 0; i < 8; ++i) {
        p += (b - a) * 2.;
        *c2 = (radius2(p) - radius2(b)) / (p.z * p.z - b.z * b.z);
        *c0 = radius2(b) - *c2 * b.z * b.z;
        if (std::isfinite(*c2) && radius2(p) > 0)
            return true;
    }
    return false;
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
    q->c0 = Sqr(q->radius);
    q->c2 = -1;
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
    q->c0 = Sqr(q->radius);
    q->reverseOrientation = reverseOrientation;
    return impl_->Add(std::move(q), shapeId, "cylinder");
}

uint32_t SolidSet::AddCone(const Transform &objectToWorld, float radius, float height, float phiMax,
                           uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("cone", objectToWorld, {radius, height, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Cone, objectToWorld);
    q->radius = static_cast<double>(std::max(radius, 0.f));
    q->zMin = q->v0 = 0;
    q->zMax = q->v1 = static_cast<double>(std::max(height, 0.f));
    if (height > 0) {
        const double slope = q->radius / q->zMax;
        q->c0 = Sqr(q->radius);
        q->c1 = -2 * q->radius * slope;
        q->c2 = Sqr(slope);
    }
    q->phiMax = SweepRadians(phiMax);
    q->reverseOrientation = reverseOrientation;
    return impl_->Add(std::move(q), shapeId, "cone");
}

uint32_t SolidSet::AddParaboloid(const Transform &objectToWorld, float radius, float zMin, float zMax,
                                 float phiMax, uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("paraboloid", objectToWorld, {radius, zMin, zMax, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Paraboloid, objectToWorld);
    q->zMin = q->v0 = static_cast<double>(std::min(zMin, zMax));
    q->zMax = q->v1 = static_cast<double>(std::max(zMin, zMax));
    if (q->zMax > 0)
        q->zMin = std::max(q->zMin, 0.); // where the surface is
    if (q->zMax != 0)
        q->c1 = Sqr(static_cast<double>(radius)) / q->zMax;
    q->phiMax = SweepRadians(phiMax);
    q->reverseOrientation = reverseOrientation;
    return impl_->Add(std::move(q), shapeId, "paraboloid");
}

uint32_t SolidSet::AddHyperboloid(const Transform &objectToWorld, const Point3f &p1, const Point3f &p2,
                                  float phiMax, uint32_t shapeId, bool reverseOrientation) {
    RequireFinite("hyperboloid", objectToWorld, {p1.x, p1.y, p1.z, p2.x, p2.y, p2.z, phiMax});
    auto q = std::make_unique<Quadric>(QuadricKind::Hyperboloid, objectToWorld);
    // pbrt-v3 swaps them like this, which turns u, v and the normal round.
    Vector3d a(p1), b(p2);
    if (p2.z == 0)
        std::swap(a, b);
    q->v0 = a.z, q->v1 = b.z;
    q->zMin = std::min(a.z, b.z);
    q->zMax = std::max(a.z, b.z);
    q->twist0 = {a.x, a.y, 0};
    q->twist1 = {b.x, b.y, 0};
    q->phiMax = SweepRadians(phiMax);
    q->reverseOrientation = reverseOrientation;
    const bool usable = a.z != b.z && std::max(q->twist0.LengthSquared(), q->twist1.LengthSquared()) > 0 &&
                        ThroughTwoCircles(a, b, &q->c0, &q->c2);
    q->empty = !usable;
    // The segment's own sweep has a term in z, unless its middle is its point nearest to the axis.
    if (usable) {
        const double middle = (a.z + b.z) / 2;
        const double swept = q->SweepStart(middle).LengthSquared(), drawn = q->Rho(middle);
        if (std::abs(swept - drawn) > 1e-4 * std::max(swept, std::abs(drawn)))
            Warning(
                "hyperboloid that is not swept",
                "hyperboloid: the segment from p1 to p2, turned about the axis, is not symmetric in z, which "
                "pbrt-v3's equation is; drawn is pbrt-v3's surface, not the segment's");
    }
    return impl_->Add(std::move(q), shapeId, "hyperboloid");
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
    const bool exact = std::isfinite(context.t) && impl_->geometries[rayHit.hit.geomID].mesh;
    *point = {exact ? static_cast<float>(context.t) : rayHit.ray.tfar, rayHit.hit.geomID, rayHit.hit.primID,
              context.p};
    return true;
}

SolidHit SolidSet::Describe(const SolidPoint &point) const {
    SolidHit hit;
    const Geometry &geometry = impl_->geometries[point.geometryId];
    hit.t = point.t;
    hit.shapeId = geometry.shapeId;
    hit.geometryId = point.geometryId;
    if (geometry.quadric) {
        geometry.quadric->FillHit(point.p, &hit);
        return hit;
    }

    const Mesh &mesh = *geometry.mesh;
    const uint32_t triangle = point.triangle;
    const Vector3d &b = point.p;
    hit.primId = mesh.original.empty() ? triangle : mesh.original[triangle];
    const uint32_t *v = mesh.Corners(triangle);
    const Vector3d p0 = mesh.P(v[0]), p1 = mesh.P(v[1]), p2 = mesh.P(v[2]);
    const Vector3d p = p0 * b[0] + p1 * b[1] + p2 * b[2];
    hit.p = Point3f(p);
    hit.pError = RoundingError(p);

    const Vector3d ns = mesh.ShadingNormal(triangle, b);
    hit.n = Normal3f(mesh.OrientedNormal(mesh.AreaNormal(triangle), ns));
    hit.ns = ns.LengthSquared() > 0 ? Normal3f(ns) : hit.n;

    Vector2<double> uv[3];
    mesh.CornerUVs(triangle, uv);
    const Vector2<double> uvHit = uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2];
    hit.uv = {static_cast<float>(uvHit.x), static_cast<float>(uvHit.y)};
    const Vector2<double> duv02 = uv[0] - uv[2], duv12 = uv[1] - uv[2];
    const Vector3d dp02 = p0 - p2, dp12 = p1 - p2;
    const double det = duv02.x * duv12.y - duv02.y * duv12.x;
    const Vector3d dpdu = (dp02 * duv12.y - dp12 * duv02.y) / det,
                   dpdv = (dp12 * duv02.x - dp02 * duv12.x) / det;
    hit.dpdu = Vector3f(dpdu);
    hit.dpdv = Vector3f(dpdv);
    if (!(Cross(dpdu, dpdv).LengthSquared() > 0) || !IsFinite(hit.dpdu) || !IsFinite(hit.dpdv))
        CoordinateSystem(hit.n, &hit.dpdu, &hit.dpdv);
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
    size_t bytes = static_cast<size_t>(std::max<ptrdiff_t>(impl_->embreeBytes, 0)) +
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
        Vector3d p;
        if (!q.SampleObject(static_cast<double>(u.x), static_cast<double>(u.y), &p))
            return false;
        const Vector3d world = q.objectToWorld.Point(p);
        sample->p = Point3f(world);
        sample->pError = RoundingError(world) + q.TransformError(p);
        sample->n = Normal3f(q.WorldNormal(p));
        sample->pdf = static_cast<float>(q.AreaDensity(p));
        return sample->pdf > 0 && std::isfinite(sample->pdf);
    }
    const Mesh &mesh = *g.mesh;
    mesh.PrepareSampling();
    if (!mesh.byArea)
        return false;
    float u0;
    const auto triangle = static_cast<uint32_t>(mesh.byArea->SampleDiscrete(u.x, nullptr, &u0));
    const Point2f b = UniformSampleTriangle({u0, u.y});
    const Vector3d bary = {static_cast<double>(b.x), static_cast<double>(b.y),
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
        pdfArea = static_cast<float>(q.AreaDensity(p));
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
