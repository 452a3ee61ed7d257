#include "shapes/quadric.h"

#include "core/error.h"
#include "core/rounding.h"
#include "shapes/solid_set.h"

#include <cmath>

namespace cuticle {
namespace {

double Cube(double x) { return x * x * x; }

void RequireFinite(QuadricKind kind, const Transform &t, std::initializer_list<float> parameters) {
    for (const float v : parameters)
        if (!std::isfinite(v))
            throw Error("{}: a parameter is not finite", QuadricName(kind));
    if (t.IsSingular())
        throw Error("{}: its transformation has no inverse", QuadricName(kind));
    const auto &m = t.M();
    if (m[3][0] != 0 || m[3][1] != 0 || m[3][2] != 0)
        throw Error("{}: its transformation is not affine (last row of the matrix)", QuadricName(kind));
}

// Finds pbrt-v3's hyperboloid: the quadric x^2 + y^2 = c0 + c2 z^2 through the circles of b and of a point
// further along the line from a to b. A point where that has no solution is passed over, as pbrt-v3 does;
// pbrt-v3 also passes over c0 = 0, for ever.
bool ThroughTwoCircles(const Vector3d &a, const Vector3d &b, double *c0, double *c2) {
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

} // namespace

AffineMatrix::AffineMatrix(const Transform &t) {
    const Transform::Matrix &src = t.M();
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 4; ++j)
            m[i][j] = src[i][j] / src[3][3];
}

const char *QuadricName(QuadricKind kind) {
    switch (kind) {
    case QuadricKind::Sphere:
        return "sphere";
    case QuadricKind::Disk:
        return "disk";
    case QuadricKind::Cylinder:
        return "cylinder";
    case QuadricKind::Cone:
        return "cone";
    case QuadricKind::Paraboloid:
        return "paraboloid";
    case QuadricKind::Hyperboloid:
        return "hyperboloid";
    }
    return "";
}

// --- makers ----------------------------------------------------------------------------

Quadric::Quadric(QuadricKind k, const Transform &t, float phiMaxDegrees, bool reverse)
    : kind(k), objectToWorld_(t), worldToObject_(t.Inverse()),
      phiMax_(double(std::clamp(phiMaxDegrees, 0.f, 360.f)) * kPi<double> / 180),
      reverseOrientation_(reverse), center_(objectToWorld_.Point({})) {}

void Quadric::MarkEmpty() {
    empty |= !(phiMax_ > 0 && MaxRadius() > 0 &&
               (kind == QuadricKind::Disk ? radius_ > innerRadius_ : zMax_ > zMin_));
}

Quadric Quadric::MakeSphere(const Transform &objectToWorld, float radius, float zMin, float zMax,
                            float phiMax, bool reverseOrientation) {
    RequireFinite(QuadricKind::Sphere, objectToWorld, {radius, zMin, zMax, phiMax});
    Quadric q(QuadricKind::Sphere, objectToWorld, phiMax, reverseOrientation);
    q.radius_ = std::max(radius, 0.f);
    q.zMin_ = std::clamp<double>(std::min(zMin, zMax), -q.radius_, q.radius_);
    q.zMax_ = std::clamp<double>(std::max(zMin, zMax), -q.radius_, q.radius_);
    q.c0_ = Sqr(q.radius_);
    q.c2_ = -1;
    if (q.radius_ > 0) {
        q.thetaMin_ = std::acos(q.zMin_ / q.radius_);
        q.thetaMax_ = std::acos(q.zMax_ / q.radius_);
    }
    // A full sphere under a similarity stays one: the columns are orthogonal and of one length.
    const auto &m = q.objectToWorld_.m;
    const Vector3d x{m[0][0], m[1][0], m[2][0]}, y{m[0][1], m[1][1], m[2][1]}, z{m[0][2], m[1][2], m[2][2]};
    const double s2 = x.LengthSquared(), tolerance = 1e-6 * s2;
    if (q.zMin_ == -q.radius_ && q.zMax_ == q.radius_ && phiMax >= 360 &&
        std::abs(y.LengthSquared() - s2) <= tolerance && std::abs(z.LengthSquared() - s2) <= tolerance &&
        std::abs(Dot(x, y)) <= tolerance && std::abs(Dot(y, z)) <= tolerance &&
        std::abs(Dot(z, x)) <= tolerance)
        q.worldRadius_ = q.radius_ * std::sqrt(s2);
    q.MarkEmpty();
    return q;
}

Quadric Quadric::MakeDisk(const Transform &objectToWorld, float height, float radius, float innerRadius,
                          float phiMax, bool reverseOrientation) {
    RequireFinite(QuadricKind::Disk, objectToWorld, {height, radius, innerRadius, phiMax});
    Quadric q(QuadricKind::Disk, objectToWorld, phiMax, reverseOrientation);
    q.height_ = height;
    q.radius_ = std::max(radius, 0.f);
    q.innerRadius_ = std::max(innerRadius, 0.f);
    q.MarkEmpty();
    return q;
}

Quadric Quadric::MakeCylinder(const Transform &objectToWorld, float radius, float zMin, float zMax,
                              float phiMax, bool reverseOrientation) {
    RequireFinite(QuadricKind::Cylinder, objectToWorld, {radius, zMin, zMax, phiMax});
    Quadric q(QuadricKind::Cylinder, objectToWorld, phiMax, reverseOrientation);
    q.radius_ = std::max(radius, 0.f);
    q.zMin_ = std::min(zMin, zMax);
    q.zMax_ = std::max(zMin, zMax);
    q.c0_ = Sqr(q.radius_);
    q.MarkEmpty();
    return q;
}

Quadric Quadric::MakeCone(const Transform &objectToWorld, float radius, float height, float phiMax,
                          bool reverseOrientation) {
    RequireFinite(QuadricKind::Cone, objectToWorld, {radius, height, phiMax});
    Quadric q(QuadricKind::Cone, objectToWorld, phiMax, reverseOrientation);
    q.radius_ = std::max(radius, 0.f);
    q.zMin_ = q.v0_ = 0;
    q.zMax_ = q.v1_ = std::max(height, 0.f);
    if (height > 0) {
        const double slope = q.radius_ / q.zMax_;
        q.c0_ = Sqr(q.radius_);
        q.c1_ = -2 * q.radius_ * slope;
        q.c2_ = Sqr(slope);
    }
    q.MarkEmpty();
    return q;
}

Quadric Quadric::MakeParaboloid(const Transform &objectToWorld, float radius, float zMin, float zMax,
                                float phiMax, bool reverseOrientation) {
    RequireFinite(QuadricKind::Paraboloid, objectToWorld, {radius, zMin, zMax, phiMax});
    Quadric q(QuadricKind::Paraboloid, objectToWorld, phiMax, reverseOrientation);
    q.zMin_ = q.v0_ = std::min(zMin, zMax);
    q.zMax_ = q.v1_ = std::max(zMin, zMax);
    if (q.zMax_ > 0)
        q.zMin_ = std::max(q.zMin_, 0.); // where the surface is
    if (q.zMax_ != 0)
        q.c1_ = Sqr(double(radius)) / q.zMax_;
    q.MarkEmpty();
    return q;
}

Quadric Quadric::MakeHyperboloid(const Transform &objectToWorld, const Point3f &p1, const Point3f &p2,
                                 float phiMax, bool reverseOrientation) {
    RequireFinite(QuadricKind::Hyperboloid, objectToWorld, {p1.x, p1.y, p1.z, p2.x, p2.y, p2.z, phiMax});
    Quadric q(QuadricKind::Hyperboloid, objectToWorld, phiMax, reverseOrientation);
    // pbrt-v3 swaps them like this, which turns u, v and the normal round.
    Vector3d a(p1), b(p2);
    if (p2.z == 0)
        std::swap(a, b);
    q.v0_ = a.z, q.v1_ = b.z;
    q.zMin_ = std::min(a.z, b.z);
    q.zMax_ = std::max(a.z, b.z);
    q.twist0_ = {a.x, a.y, 0};
    q.twist1_ = {b.x, b.y, 0};
    const bool usable = a.z != b.z && std::max(q.twist0_.LengthSquared(), q.twist1_.LengthSquared()) > 0 &&
                        ThroughTwoCircles(a, b, &q.c0_, &q.c2_);
    q.empty = !usable;
    // The segment's own sweep has a term in z, unless its middle is its point nearest to the axis.
    if (usable) {
        const double middle = (a.z + b.z) / 2;
        const double swept = q.SweepStart(middle).LengthSquared(), drawn = q.Rho(middle);
        if (std::abs(swept - drawn) > 1e-4 * std::max(swept, std::abs(drawn)))
            Warning(
                "hyperboloid that is not swept",
                "hyperboloid: the segment from p1 to p2, turned about the axis, is not symmetric in z, which "
                "pbrt-v3's equation is; drawn is pbrt-v3's surface, not the segment's");
    }
    q.MarkEmpty();
    return q;
}

// --- intersection ----------------------------------------------------------------------

bool Quadric::Clipped(const Vector3d &p) const {
    if (kind != QuadricKind::Disk && (p.z < zMin_ || p.z > zMax_))
        return true;
    if (kind == QuadricKind::Disk) {
        const double r2 = p.x * p.x + p.y * p.y;
        if (!(r2 <= radius_ * radius_ && r2 >= innerRadius_ * innerRadius_))
            return true;
    }
    return phiMax_ < 2 * kPi<double> && Phi(p) > phiMax_;
}

double Quadric::Phi(const Vector3d &p) const {
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
Vector3d Quadric::Refined(const Vector3d &p) const {
    switch (kind) {
    case QuadricKind::Disk:
        return {p.x, p.y, height_};
    case QuadricKind::Sphere:
        return p * (radius_ / p.Length());
    case QuadricKind::Cylinder: {
        const double s = radius_ / std::sqrt(p.x * p.x + p.y * p.y);
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

// Finds where the line o + t d meets the whole surface, in order of t; returns the number of roots.
int Quadric::Roots(const Vector3d &o, const Vector3d &d, double roots[2]) const {
    if (kind == QuadricKind::Disk) {
        if (d.z == 0)
            return 0;
        roots[0] = (height_ - o.z) / d.z;
        return 1;
    }
    // a t^2 + 2 b t + c = 0
    const double a = d.x * d.x + d.y * d.y - c2_ * d.z * d.z;
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

bool Quadric::Intersect(const Ray &ray, double tMin, double tMax, double *t, Vector3d *pObject) const {
    const Vector3d o = worldToObject_.Point(Vector3d(ray.o)), d = worldToObject_.Vector(Vector3d(ray.d));
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

// --- the surface at a hit --------------------------------------------------------------

// Returns the side of pbrt-v3's cross product of dpdu and dpdv, in object space and of unit length: outward;
// of the disk +z; of a hyperboloid swept downward inward. At the tip of a cone: along its axis.
Vector3d Quadric::ObjectNormal(const Vector3d &p) const {
    switch (kind) {
    case QuadricKind::Disk:
        return {0, 0, 1};
    case QuadricKind::Sphere:
        return p / radius_;
    case QuadricKind::Cylinder:
        return {p.x / radius_, p.y / radius_, 0};
    default: {
        const Vector3d g{p.x, p.y, -RhoPrime(p.z) / 2};
        const double length = std::copysign(g.Length(), v1_ - v0_);
        return length != 0 ? g / length : Vector3d(0, 0, 1);
    }
    }
}
// pbrt-v3 flips the cross product of dpdu and dpdv by reverseOrientation ^ transformSwapsHandedness. In world
// space a mirror turns that product inward, so this is the outward normal, flipped by reverseOrientation
// alone.
Vector3d Quadric::WorldNormal(const Vector3d &pObject) const {
    const Vector3d n = Normalize(worldToObject_.Transposed(ObjectNormal(pObject)));
    return reverseOrientation_ ? -n : n;
}

// Bounds what the double-precision transformation itself rounds off, which matters far from the origin only.
Vector3f Quadric::TransformError(const Vector3d &p) const {
    const auto row = [&](const double *m) {
        return static_cast<float>(
            0x1p-50 * (std::abs(m[0] * p.x) + std::abs(m[1] * p.y) + std::abs(m[2] * p.z) + std::abs(m[3])));
    };
    return {row(objectToWorld_.m[0]), row(objectToWorld_.m[1]), row(objectToWorld_.m[2])};
}

void Quadric::FillHit(const Vector3d &p, SolidHit *hit) const {
    const Vector3d world = objectToWorld_.Point(p);
    hit->p = Point3f(world);
    hit->pError = RoundingError(world) + TransformError(p);
    hit->n = hit->ns = Normal3f(WorldNormal(p));
    const double r = std::sqrt(p.x * p.x + p.y * p.y);
    Vector3d dpdu{-phiMax_ * p.y, phiMax_ * p.x, 0}, dpdv;
    double v = 0;
    switch (kind) {
    case QuadricKind::Sphere: {
        const double theta = std::atan2(r, p.z);
        v = (theta - thetaMin_) / (thetaMax_ - thetaMin_);
        const double cosPhi = r > 0 ? p.x / r : 1, sinPhi = r > 0 ? p.y / r : 0;
        dpdv = Vector3d(p.z * cosPhi, p.z * sinPhi, -r) * (thetaMax_ - thetaMin_);
        break;
    }
    case QuadricKind::Disk:
        v = 1 - (r - innerRadius_) / (radius_ - innerRadius_);
        dpdv = r > 0 ? Vector3d(p.x, p.y, 0) * ((innerRadius_ - radius_) / r) : Vector3d();
        break;
    case QuadricKind::Cylinder:
        v = (p.z - zMin_) / (zMax_ - zMin_);
        dpdv = {0, 0, zMax_ - zMin_};
        break;
    case QuadricKind::Cone:
    case QuadricKind::Paraboloid:
    case QuadricKind::Hyperboloid: {
        v = V(p.z);
        // Along the profile r(z), r r' = rho' / 2, and around the axis as the start of the sweep turns.
        const Vector3d s = SweepStart(p.z), e = twist1_ - twist0_;
        const double turn = (s.x * e.y - s.y * e.x) / (s.x * s.x + s.y * s.y);
        const double along = (v1_ - v0_) * RhoPrime(p.z) / (2 * r * r);
        dpdv = {p.x * along - p.y * turn, p.y * along + p.x * turn, v1_ - v0_};
        break;
    }
    }
    hit->uv = {static_cast<float>(std::clamp(Phi(p) / phiMax_, 0., 1.)),
               static_cast<float>(std::clamp(v, 0., 1.))};
    hit->dpdu = Vector3f(objectToWorld_.Vector(dpdu));
    hit->dpdv = Vector3f(objectToWorld_.Vector(dpdv));
    // The poles of a sphere, the centre of a disk, the tip of a cone.
    if (!(Cross(hit->dpdu, hit->dpdv).LengthSquared() > 0) || !IsFinite(hit->dpdv))
        CoordinateSystem(hit->n, &hit->dpdu, &hit->dpdv);
}

// --- sampling --------------------------------------------------------------------------

// The density per object area of SampleObject's points.
double Quadric::ObjectDensity(const Vector3d &p) const {
    switch (kind) {
    case QuadricKind::Disk:
        return 2 / (phiMax_ * (radius_ * radius_ - innerRadius_ * innerRadius_));
    case QuadricKind::Sphere:
    case QuadricKind::Cylinder:
        return 1 / (phiMax_ * radius_ * (zMax_ - zMin_));
    case QuadricKind::Cone:
        return 2 / (phiMax_ * Slant(0) * (zMax_ - zMin_));
    case QuadricKind::Paraboloid:
        return 3 * std::abs(c1_) / (2 * phiMax_ * std::abs(Cube(Slant(zMax_)) - Cube(Slant(zMin_))));
    case QuadricKind::Hyperboloid:
        return 1 / (phiMax_ * Slant(p.z) * (zMax_ - zMin_));
    }
    return 0;
}
// Area per dz and dphi: r sqrt(1 + r'^2).
double Quadric::Slant(double z) const { return std::sqrt(std::max(0., Rho(z) + Sqr(RhoPrime(z) / 2))); }

// Finds a point of the surface in object space, uniform over its area; of a hyperboloid, uniform in z and phi
// instead. False where a hyperboloid of two sheets has its gap.
bool Quadric::SampleObject(double u0, double u1, Vector3d *p) const {
    double phi = u0 * phiMax_, r = radius_, z = Lerp(u1, zMin_, zMax_);
    switch (kind) {
    case QuadricKind::Disk:
        r = std::sqrt(Lerp(u1, innerRadius_ * innerRadius_, radius_ * radius_));
        z = height_;
        break;
    case QuadricKind::Sphere:
        r = std::sqrt(std::max(0., (radius_ - z) * (radius_ + z)));
        break;
    case QuadricKind::Cylinder:
        break;
    case QuadricKind::Cone: // area grows with the square of the distance from the tip
        z = zMax_ * (1 - std::sqrt(1 - u1));
        r = radius_ * std::sqrt(1 - u1);
        break;
    case QuadricKind::Paraboloid: // area grows with the cube of the slant, whose square is linear in z
        z = (Sqr(std::cbrt(Lerp(u1, Cube(Slant(zMin_)), Cube(Slant(zMax_))))) - Sqr(c1_ / 2)) / c1_;
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

// World area per object area at p.
double Quadric::Stretch(const Vector3d &p) const {
    Vector3d s, t;
    CoordinateSystem(ObjectNormal(p), &s, &t);
    return Cross(objectToWorld_.Vector(s), objectToWorld_.Vector(t)).Length();
}

double Quadric::WorldArea() const {
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

// Chooses a place by area, in the quadric's coordinates (*p) and in the world's; the density is left to the
// caller.
bool Quadric::SamplePlace(const Point2f &u, Vector3d *p, ShapeSample *sample) const {
    if (empty || !SampleObject(u.x, u.y, p))
        return false;
    const Vector3d world = objectToWorld_.Point(*p);
    sample->p = Point3f(world);
    sample->pError = RoundingError(world) + TransformError(*p);
    sample->n = Normal3f(WorldNormal(*p));
    return true;
}

bool Quadric::Sample(const Point2f &u, ShapeSample *sample) const {
    Vector3d p;
    if (!SamplePlace(u, &p, sample))
        return false;
    sample->pdf = static_cast<float>(AreaDensity(p));
    return sample->pdf > 0 && std::isfinite(sample->pdf);
}

// A place from which the surface is looked at. One that is on it as far as rounded coordinates tell is put
// onto it, in double: else half of the points of a sphere would see it from outside, and the other half from
// inside.
struct Quadric::Viewer {
    Vector3d p;      // in world space
    bool onSurface;  // or on what would be the surface if it were not cut off
    double cone = 0; // 1 - cos of half the angle that a full sphere subtends, seen from outside; else 0
};
Quadric::Viewer Quadric::ViewerAt(const Point3f &ref) const {
    const Vector3d world(ref), p = worldToObject_.Point(world), q = Refined(p);
    // Twice what rounding to single precision moves a point, and what the transformations round off. All
    // coordinates together move it off the surface: each by itself may have to move farther than it was
    // rounded to come back along the normal.
    const Vector3d rounding = Abs(world) * 0x1p-23, n = ObjectNormal(q);
    double reach = 0;
    for (int i = 0; i < 3; ++i) {
        const double *row = worldToObject_.m[i];
        const double bound = std::abs(row[0]) * rounding.x + std::abs(row[1]) * rounding.y +
                             std::abs(row[2]) * rounding.z + 0x1p-48 * (std::abs(row[3]) + std::abs(q[i]));
        reach += std::abs(n[i]) * bound;
    }
    Viewer viewer{world, std::abs(Dot(q - p, n)) <= reach}; // false for NaN: the centre of a sphere
    if (viewer.onSurface)
        viewer.p = objectToWorld_.Point(q);
    const double d2 = (center_ - world).LengthSquared(), r2 = worldRadius_ * worldRadius_;
    if (worldRadius_ > 0 && !viewer.onSurface && d2 > r2) {
        const double sin2 = r2 / d2;
        viewer.cone = sin2 / (1 + std::sqrt(1 - sin2));
    }
    return viewer;
}

// Looks at a point p of the surface, in object space; fills in what a sample says of it (or nothing, if
// null). Returns the density per steradian of points that are sampled by area; 0 where none are taken.
float Quadric::SeenDensity(const Viewer &viewer, const Vector3d &p, ShapeSample *sample) const {
    // From its own plane a disk is a line. Where the height above it is all rounding, no point is taken.
    if (viewer.onSurface && kind == QuadricKind::Disk)
        return 0;
    return SolidAngleDensity(AreaDensity(p), objectToWorld_.Point(p) - viewer.p, WorldNormal(p), sample);
}

bool Quadric::Sample(const Point3f &ref, const Point2f &u, ShapeSample *sample) const {
    const Viewer viewer = ViewerAt(ref);
    if (viewer.cone > 0)
        return SampleCone(viewer, u, sample);
    Vector3d p;
    if (!SamplePlace(u, &p, sample))
        return false;
    sample->pdf = SeenDensity(viewer, p, sample);
    return sample->pdf > 0;
}

float Quadric::Pdf(const Point3f &ref, const Point3f &world) const {
    const Viewer viewer = ViewerAt(ref);
    if (viewer.cone > 0)
        return static_cast<float>(1 / (2 * kPi<double> * viewer.cone));
    return SeenDensity(viewer, Refined(worldToObject_.Point(Vector3d(world))), nullptr);
}

// Uniform in the cone: 1 - cos theta is uniform in [0, cone].
bool Quadric::SampleCone(const Viewer &viewer, const Point2f &u, ShapeSample *sample) const {
    const double x = u.x * viewer.cone, cosTheta = 1 - x, sin2 = x * (2 - x);
    const double phi = 2 * kPi<double> * u.y;
    const Vector3d toCenter = center_ - viewer.p;
    const double dc2 = toCenter.LengthSquared(), dc = std::sqrt(dc2);
    Vector3d s, t;
    const Vector3d axis = toCenter / dc;
    CoordinateSystem(axis, &s, &t);
    const double sinTheta = std::sqrt(sin2);
    const Vector3d w = s * (sinTheta * std::cos(phi)) + t * (sinTheta * std::sin(phi)) + axis * cosTheta;
    const double r2 = worldRadius_ * worldRadius_;
    const double distance = dc * cosTheta - std::sqrt(std::max(0., r2 - dc2 * sin2));
    // Onto the sphere, against the rounding near the limb.
    const Vector3d n = Normalize(viewer.p + w * distance - center_);
    const Vector3d p = center_ + n * worldRadius_;
    sample->p = Point3f(p);
    sample->pError = RoundingError(p);
    sample->n = Normal3f(reverseOrientation_ ? -n : n);
    sample->pdf = static_cast<float>(1 / (2 * kPi<double> * viewer.cone));
    sample->wi = Vector3f(w);
    sample->distance = static_cast<float>(distance);
    // From outside the sphere's outer side is seen, up to the limb.
    const double cosine = std::max(-Dot(n, w), 1e-30);
    sample->cosine = static_cast<float>(reverseOrientation_ ? -cosine : cosine);
    return std::isfinite(sample->pdf);
}

// --- bounds ----------------------------------------------------------------------------

double Quadric::MaxRadius() const {
    if (kind == QuadricKind::Disk)
        return radius_;
    double rho = std::max(Rho(zMin_), Rho(zMax_));
    if (const double z = -c1_ / (2 * c2_); z > zMin_ && z < zMax_)
        rho = std::max(rho, Rho(z));
    return std::sqrt(std::max(rho, 0.));
}

Bounds3f Quadric::WorldBounds() const {
    const double z0 = kind == QuadricKind::Disk ? height_ : zMin_,
                 z1 = kind == QuadricKind::Disk ? height_ : zMax_;
    Bounds3f b;
    if (worldRadius_ > 0) {
        const Vector3d r(worldRadius_, worldRadius_, worldRadius_);
        b.Extend(Point3f(center_ - r));
        b.Extend(Point3f(center_ + r));
    } else {
        const double r = MaxRadius();
        for (int i = 0; i < 8; ++i)
            b.Extend(Point3f(objectToWorld_.Point({i & 1 ? r : -r, i & 2 ? r : -r, i & 4 ? z1 : z0})));
    }
    // Outward by what rounding may have cost.
    const Vector3f pad = (Max(Abs(b.pMin), Abs(b.pMax)) + b.Diagonal()) * 1e-6f;
    b.pMin -= pad;
    b.pMax += pad;
    return b;
}

} // namespace cuticle
