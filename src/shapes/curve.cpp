//> Define one curve segment
#include "shapes/curve.h"

#include <array>
#include <cmath>

namespace cuticle {

//> Interpolate between two points
namespace {
template <typename T>
Vector3<T> Lerp3(T t, const Vector3<T> &a, const Vector3<T> &b) {
    return a * (1 - t) + b * t;
}
} // namespace
//<

//> Evaluate a cubic and its derivatives
Vector3d EvalBezier(const Vector3d cp[4], double u, Vector3d *derivative, Vector3d *second) {
    // De Casteljau's algorithm: the last line but one gives the derivative, the one before it the second.
    const Vector3d a[3] = {Lerp3(u, cp[0], cp[1]), Lerp3(u, cp[1], cp[2]), Lerp3(u, cp[2], cp[3])};
    const Vector3d b[2] = {Lerp3(u, a[0], a[1]), Lerp3(u, a[1], a[2])};
    if (derivative)
        *derivative = (b[1] - b[0]) * 3.;
    if (second)
        *second = (a[2] - a[1] * 2. + a[0]) * 6.;
    return Lerp3(u, b[0], b[1]);
}
//<

//> Say which segments can be hit
bool IsUsable(const CurveSegment &s) {
    for (const Point3f &p : s.cp)
        if (!IsWithinReach(p))
            return false;
    if (s.cp[0] == s.cp[1] && s.cp[0] == s.cp[2] && s.cp[0] == s.cp[3])
        return false; // a point has no direction, so nothing is at right angles to it
    const float widest = std::max(s.width[0], s.width[1]);
    return std::isfinite(s.width[0] + s.width[1]) && widest > 0 && widest <= kMaxCoordinate;
}
//<

//> Interpolate the normal of a ribbon
namespace {
Vector3d NormalAlong(const RibbonNormals &normals, double u) {
    const Vector3d n0 = Normalize(Vector3d(normals.n[0])), n1 = Normalize(Vector3d(normals.n[1]));
    const double angle = std::acos(std::clamp(Dot(n0, n1), -1., 1.)), sine = std::sin(angle);
    // Spherical interpolation; normals that are equal or opposite leave no arc to follow, so they are mixed.
    const Vector3d n = sine > 1e-4 ? (n0 * std::sin((1 - u) * angle) + n1 * std::sin(u * angle)) / sine
                                   : n0 * (1. - u) + n1 * u;
    return n.LengthSquared() > 0 ? Normalize(n) : n0;
}
} // namespace
Normal3f RibbonNormal(const RibbonNormals &normals, float u) { return Normal3f(NormalAlong(normals, u)); }
//<

//> Prepare the search
template <typename T>
CurveSearch<T>::CurveSearch(const CurveSegment &segment, const RibbonNormals *normals, const Ray &ray,
                            T flatness, int maxDepth)
    : segment_(segment), normals_(normals), flatness_(flatness), maxDepth_(maxDepth), o_(ray.o) {
    const Vector3<T> d(ray.d);
    length_ = d.Length();
    z_ = d / length_;
    //> Turn the frame so that the curve lies along $x$
    // Its boxes are then narrow. Any frame will do where the ray looks along the curve.
    const Vector3<T> across = Cross(z_, Vector3<T>(segment.cp[3]) - Vector3<T>(segment.cp[0]));
    if (const T l = across.Length(); l > 0) {
        // What rounding left along z counts where the ray looks almost along the curve.
        y_ = across / l;
        y_ = Normalize(y_ - z_ * Dot(y_, z_));
        x_ = Cross(y_, z_);
    } else {
        CoordinateSystem(z_, &x_, &y_);
    }
    //<
    zMin_ = length_ * ray.tMin;
    zMax_ = length_ * ray.tMax;
}
//<

//> Move the curve into the ray's frame
// The ray is now the z axis from the origin, so that only x and y say how near the curve comes to it.
template <typename T>
bool CurveSearch<T>::Intersect(T u0, T u1) {
    Vector3<T> cp[4];
    for (int i = 0; i < 4; ++i) {
        const Vector3<T> p = Vector3<T>(segment_.cp[i]) - o_;
        cp[i] = {Dot(p, x_), Dot(p, y_), Dot(p, z_)};
    }
    //> Cut out the part from $u_0$ to $u_1$
    Vector3<T> part[4];
    for (int i = 0; i < 4; ++i) {
        // The control point i of the part: de Casteljau's algorithm with u1 in i of its three steps, u0 in
        // the others.
        Vector3<T> a[4] = {cp[0], cp[1], cp[2], cp[3]};
        for (int step = 0; step < 3; ++step)
            for (int j = 0; j < 3 - step; ++j)
                a[j] = Lerp3(step < i ? u1 : u0, a[j], a[j + 1]);
        part[i] = a[0];
    }
    //<
    //> Decide how deep to go
    // Halving a cubic quarters its distance from its chord, which second differences bound.
    T bend = 0;
    for (int i = 0; i < 2; ++i) {
        const Vector3<T> d = part[i] - part[i + 1] * T(2) + part[i + 2];
        bend = std::max({bend, std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    }
    const T allowed = flatness_ * std::max(segment_.width[0], segment_.width[1]);
    int depth = 0;
    for (T off = T(1.0607) * bend; off > allowed && depth < maxDepth_; off /= 4)
        ++depth;
    if (flatness_ == 0)
        depth = maxDepth_; // the parts say themselves where to stop
    //<
    //> Say how slow is standing still
    for (int i = 0; i < 3 && flatness_ == 0; ++i)
        still_ = std::max(still_, T(3e-6) * std::hypot(cp[i + 1].x - cp[i].x, cp[i + 1].y - cp[i].y));
    //<
    return Recurse(part, u0, u1, depth);
}
//<

//> Count the places where the ray is square to a part
namespace {
// The places w in [0, 1] of a part of a curve, given by its control points in the ray's frame, where
// F = c . c' / 3 = 0, as far as the six Bernstein coefficients of F tell.
template <typename T>
struct SquarePlaces {
    explicit SquarePlaces(const Vector3<T> cp[4]) {
        //> Multiply the curve by its derivative
        const auto dot = [&](int i, int j) {
            return cp[i].x * (cp[j + 1].x - cp[j].x) + cp[i].y * (cp[j + 1].y - cp[j].y);
        };
        f = {dot(0, 0),
             (2 * dot(0, 1) + 3 * dot(1, 0)) / 5,
             (dot(0, 2) + 6 * dot(1, 1) + 3 * dot(2, 0)) / 10,
             (3 * dot(1, 2) + 6 * dot(2, 1) + dot(3, 0)) / 10,
             (3 * dot(2, 2) + 2 * dot(3, 1)) / 5,
             dot(3, 2)};
        //<
        bool positive = false, negative = false, rises = true, falls = true;
        for (size_t i = 0; i < 6; ++i) {
            positive |= f[i] > 0, negative |= f[i] < 0;
            if (i > 0)
                rises &= f[i] >= f[i - 1], falls &= f[i] <= f[i - 1];
        }
        const bool both = positive && negative; // else F is 0 at an end or nowhere
        one = both ? rises || falls : f[0] == 0 || f[5] == 0;
        none = !both && !one; // so also with NaN
    }
    // Returns the place, where there is one: by bisection, until the interval has no middle any more.
    T Find() const {
        if (f[0] == 0 || f[5] == 0)
            return f[0] == 0 ? T(0) : T(1);
        for (T lo = 0, hi = 1;;) {
            const T middle = (lo + hi) / 2;
            if (!(middle > lo && middle < hi))
                return middle;
            ((At(middle) < 0) == (f[0] < f[5]) ? lo : hi) = middle;
        }
    }
    T At(T w) const {
        std::array<T, 6> a = f; // de Casteljau's algorithm
        for (size_t n = 5; n > 0; --n)
            for (size_t i = 0; i < n; ++i)
                a[i] += w * (a[i + 1] - a[i]);
        return a[0];
    }
    std::array<T, 6> f;
    bool one, none; // if neither, there may be several
};
} // namespace
//<

//> Cut in two until it is straight
template <typename T>
bool CurveSearch<T>::Recurse(const Vector3<T> cp[4], T u0, T u1, int depth) {
    //> Leave out what the ray cannot reach
    // The curve lies in the hull of its control points, and its edge within half the width of it.
    const T radius = T(0.5) * std::max(Lerp(u0, T(segment_.width[0]), T(segment_.width[1])),
                                       Lerp(u1, T(segment_.width[0]), T(segment_.width[1])));
    const Vector3<T> lo = Min(Min(cp[0], cp[1]), Min(cp[2], cp[3]));
    const Vector3<T> hi = Max(Max(cp[0], cp[1]), Max(cp[2], cp[3]));
    if (lo.x > radius || hi.x < -radius || lo.y > radius || hi.y < -radius || lo.z - radius > zMax_ ||
        hi.z + radius < zMin_)
        return false;
    //<
    if (flatness_ == 0) {
        const SquarePlaces<T> places(cp);
        if (places.one)
            return IntersectAt(cp, u0, u1, places.Find());
        if (places.none)
            return false;
        if (depth == 0)
            return IntersectAt(cp, u0, u1, T(0.5)); // two that are too close to tell apart
    } else if (depth == 0) {
        return IntersectLine(cp, u0, u1);
    }

    //> Halve the curve and look at both halves
    const Vector3<T> a = (cp[0] + cp[1]) * T(0.5), m = (cp[1] + cp[2]) * T(0.5), d = (cp[2] + cp[3]) * T(0.5);
    const Vector3<T> b = (a + m) * T(0.5), c = (m + d) * T(0.5), middle = (b + c) * T(0.5);
    const Vector3<T> first[4] = {cp[0], a, b, middle}, second[4] = {middle, c, d, cp[3]};
    const T uMiddle = T(0.5) * (u0 + u1);
    // Both, as either may be the nearer; a hit in the first leaves the second only what lies before it.
    const bool inFirst = Recurse(first, u0, uMiddle, depth - 1);
    const bool inSecond = Recurse(second, uMiddle, u1, depth - 1);
    return inFirst || inSecond;
    //<
}
//<

//> Find how wide the ray sees the curve
template <typename T>
T CurveSearch<T>::WidthSeen(T u) const {
    const T width = Lerp(u, T(segment_.width[0]), T(segment_.width[1]));
    if (!normals_)
        return width;
    // A ribbon turned away from the ray looks narrower.
    return width * std::abs(Dot(Vector3<T>(NormalAlong(*normals_, u)), z_));
}
//<

//> Intersect a straight piece
template <typename T>
bool CurveSearch<T>::IntersectLine(const Vector3<T> cp[4], T u0, T u1) {
    //> Reject a ray that passes beyond the piece's ends
    // The ends are cut at right angles to the curve, so that pieces join without gap or overlap.
    const T before = cp[0].x * (cp[1].x - cp[0].x) + cp[0].y * (cp[1].y - cp[0].y);
    const T behind = cp[3].x * (cp[3].x - cp[2].x) + cp[3].y * (cp[3].y - cp[2].y);
    if (before > 0 || behind < 0)
        return false;
    //<
    //> Find the point of the chord that is nearest to the ray
    const T ex = cp[3].x - cp[0].x, ey = cp[3].y - cp[0].y, length2 = ex * ex + ey * ey;
    if (!(length2 > 0))
        return false;
    return IntersectAt(cp, u0, u1, std::clamp(-(cp[0].x * ex + cp[0].y * ey) / length2, T(0), T(1)));
    //<
}
//<

//> Take the curve's point for a hit
template <typename T>
bool CurveSearch<T>::IntersectAt(const Vector3<T> cp[4], T u0, T u1, T w) {
    const T u = std::clamp(Lerp(w, u0, u1), T(0), T(1));
    //> Take the curve's point there
    const T q = 1 - w;
    const Vector3<T> p = (cp[0] * q + cp[1] * (3 * w)) * (q * q) + (cp[2] * (3 * q) + cp[3] * w) * (w * w);
    const Vector3<T> tangent =
        (cp[1] - cp[0]) * (q * q) + (cp[2] - cp[1]) * (2 * q * w) + (cp[3] - cp[2]) * (w * w);
    const T width = WidthSeen(u);
    const T distance2 = p.x * p.x + p.y * p.y;
    if (!(distance2 <= T(0.25) * width * width && width > 0 && p.z > zMin_ && p.z < zMax_))
        return false;
    //<
    //> Refuse a place where the curve stands still
    // tangent is a third of the derivative by w, which is u1 - u0 times that by u.
    if (flatness_ == 0 && !(3 * std::hypot(tangent.x, tangent.y) > still_ * (u1 - u0)))
        return false;
    //<
    //> Find the side of the curve and the distance from its middle
    // v = 1/2 on the curve itself; it grows to the right of the tangent as seen along the ray.
    const T side = p.x * tangent.y - p.y * tangent.x;
    hitV_ = T(0.5) + std::copysign(std::sqrt(distance2), side) / width;
    hitU_ = u;
    hitZ_ = zMax_ = p.z;
    return true;
    //<
}
template <typename T>
CurveHit CurveSearch<T>::Hit() const {
    return {static_cast<float>(hitZ_ / length_), static_cast<float>(hitU_),
            std::clamp(static_cast<float>(hitV_), 0.f, 1.f), 0};
}
template class CurveSearch<float>;
template class CurveSearch<double>;
//<

//> Define the curve as a shape
Curve::Curve(const CurveSegment &segment, CurveType type, const RibbonNormals *normals)
    : segment_(segment), type_(type == CurveType::Ribbon && !normals ? CurveType::Flat : type),
      normals_(normals ? *normals : RibbonNormals()) {}

bool Curve::Intersect(const Ray &ray, CurveHit *hit, CurveSurface *surface) const {
    if (!IsUsable(segment_))
        return false;
    // Two places closer than 2^-40 in u are taken for one.
    CurveSearch<double> search(segment_, Normals(), ray, 0, 40);
    if (!search.Intersect(0, 1))
        return false;
    const uint32_t index = hit->segment;
    *hit = search.Hit();
    hit->segment = index;
    if (surface)
        *surface = MakeCurveSurface(segment_, type_, Normals(), ray, *hit);
    return true;
}
bool Curve::IntersectP(const Ray &ray) const {
    CurveHit hit;
    return Intersect(ray, &hit);
}
Bounds3f Curve::WorldBound() const {
    Bounds3f b;
    const float radius = 0.5f * std::max({segment_.width[0], segment_.width[1], 0.f});
    for (const Point3f &p : segment_.cp) {
        b.Extend(p - Vector3f(radius, radius, radius));
        b.Extend(p + Vector3f(radius, radius, radius));
    }
    return b;
}
//<

//> Find the surface at a hit
namespace {
//> Find the direction of the curve, also where it stands still
// Control points that fall together stop the curve at its end; its direction there is that of a point close
// by. d: the derivative at u.
Vector3d TangentAt(const Vector3d cp[4], double u, Vector3d d, const Vector3d &rayDirection) {
    for (const double toMiddle : {0., 1e-3, 0.5}) {
        if (toMiddle > 0)
            EvalBezier(cp, Lerp(toMiddle, u, 0.5), &d);
        if (d.LengthSquared() > 1e-30 * (cp[3] - cp[0]).LengthSquared() && d.LengthSquared() > 0)
            return Normalize(d);
    }
    d = cp[3] - cp[0];
    if (d.LengthSquared() > 0)
        return Normalize(d);
    Vector3d s, t;
    CoordinateSystem(rayDirection, &s, &t);
    return s;
}
//<
} // namespace

CurveSurface MakeCurveSurface(const CurveSegment &segment, CurveType type, const RibbonNormals *normals,
                              const Ray &ray, const CurveHit &hit) {
    CurveSurface s;
    const Vector3d cp[4] = {Vector3d(segment.cp[0]), Vector3d(segment.cp[1]), Vector3d(segment.cp[2]),
                            Vector3d(segment.cp[3])};
    const double u = hit.u, v = hit.v;
    const Vector3d z = Normalize(Vector3d(ray.d));
    Vector3d dpdu;
    const Vector3d center = EvalBezier(cp, u, &dpdu);
    const Vector3d tangent = TangentAt(cp, u, dpdu, z);

    //> Span the axes across the curve
    // back: away from the viewer; side: toward growing v. With the tangent they form a frame.
    Vector3d back = z - tangent * Dot(z, tangent);
    if (back.LengthSquared() > 1e-24) {
        back = Normalize(back);
    } else {
        Vector3d other;
        CoordinateSystem(tangent, &back, &other); // seen along itself: any direction across
    }
    const Vector3d side = Cross(back, tangent);
    //<

    const double width = Lerp<double>(u, segment.width[0], segment.width[1]);
    double seen = width;
    Vector3d n = -back, dpdv = side;
    //> Give a ribbon its own normal
    if (type == CurveType::Ribbon && normals) {
        const Vector3d own(RibbonNormal(*normals, hit.u));
        seen = width * std::abs(Dot(own, z));
        const Vector3d across = own - tangent * Dot(own, tangent);
        if (across.LengthSquared() > 1e-24) {
            n = Normalize(across);
            n = Dot(n, z) > 0 ? -n : n;
            dpdv = Cross(tangent, n);
        }
    }
    //<
    //> Shade a cylinder round
    // By pbrt-v3's rotation, which its picture of the three types shows: the normal leans toward v = 0 where
    // v > 1/2. A tube seen from outside would lean the other way.
    if (type == CurveType::Cylinder) {
        const double angle = Lerp(v, -0.5, 0.5) * kPi<double>;
        n = -(back * std::cos(angle) + side * std::sin(angle));
        dpdv = side * std::cos(angle) - back * std::sin(angle);
    }
    //<
    //> Take the point from the curve
    // From the curve rather than along the ray, whose rounding grows with its length.
    const Vector3d p = center + side * ((v - 0.5) * seen);
    s.p = Point3f(p);
    s.pError = 0x1p-22f * std::max({std::abs(s.p.x), std::abs(s.p.y), std::abs(s.p.z)});
    //<
    s.tangent = Vector3f(tangent);
    const double speed = dpdu.Length();
    s.dpdu = Vector3f(tangent * std::max(speed, 1e-30));
    s.dpdv = Vector3f(dpdv * width);
    s.n = Normal3f(n);
    s.uv = {hit.u, hit.v};
    s.h = -1 + 2 * hit.v;
    s.width = static_cast<float>(width);
    s.seen = static_cast<float>(seen);
    return s;
}
//<

//> Count the segments that control points make
size_t CurveSegmentCount(size_t count, CurveBasis basis, int degree, std::string *error) {
    const auto refuse = [&](const std::string &message) {
        if (error)
            *error = message;
        return size_t(0);
    };
    if (degree != 2 && degree != 3)
        return refuse("a curve of degree " + std::to_string(degree) + ": the degree must be 2 or 3");
    const size_t d = static_cast<size_t>(degree);
    const std::string have = std::to_string(count) + " control points for a curve of degree " +
                             std::to_string(degree) +
                             (basis == CurveBasis::Bezier ? " in the Bezier" : " in the B-spline") + " basis";
    if (basis == CurveBasis::Bezier) {
        if (count < d + 1 || (count - 1) % d != 0)
            return refuse(have + ": n * " + std::to_string(d) + " + 1 are needed, n >= 1");
        return (count - 1) / d;
    }
    if (count < d + 1)
        return refuse(have + ": at least " + std::to_string(d + 1) + " are needed");
    return count - d;
}
//<

//> Write one segment as a cubic Bezier
namespace {
using Points = std::array<Vector3d, 4>;
// A quadratic as the cubic that is the same curve: the inner points lie two thirds of the way to the middle
// one.
Points Elevate(const Vector3d &a, const Vector3d &b, const Vector3d &c) {
    return {a, Lerp3(2. / 3, a, b), Lerp3(1. / 3, b, c), c};
}
Points BezierOfSegment(const Point3f *p, CurveBasis basis, int degree) {
    const Vector3d a(p[0]), b(p[1]), c(p[2]), d = degree == 3 ? Vector3d(p[3]) : Vector3d();
    if (basis == CurveBasis::Bezier)
        return degree == 3 ? Points{a, b, c, d} : Elevate(a, b, c);
    // Uniform B-splines, by their blossoms: between knots, where the polygon is cut in two (degree 2) or
    // three.
    if (degree == 2)
        return Elevate(Lerp3(0.5, a, b), b, Lerp3(0.5, b, c));
    const Vector3d inner0 = Lerp3(1. / 3, b, c), inner1 = Lerp3(2. / 3, b, c);
    return {Lerp3(0.5, Lerp3(2. / 3, a, b), inner0), inner0, inner1, Lerp3(0.5, inner1, Lerp3(1. / 3, c, d))};
}
} // namespace
//<

//> Append all segments of a curve
bool AppendCurve(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                 float width1, uint32_t group, CurveList *segments, std::string *error) {
    const size_t n = CurveSegmentCount(count, basis, degree, error);
    if (n == 0)
        return false;
    if (!(std::abs(width0) <= kMaxCoordinate && std::abs(width1) <= kMaxCoordinate)) {
        if (error)
            *error = "the width of a curve must be a number up to 1e18 after the transformation";
        return false;
    }
    width0 = std::max(width0, 0.f), width1 = std::max(width1, 0.f);
    Point3f end;
    for (size_t i = 0; i < n; ++i) {
        const size_t first = basis == CurveBasis::Bezier ? i * static_cast<size_t>(degree) : i;
        const Points cp = BezierOfSegment(points + first, basis, degree);
        // Neighbours meet in the same point to the last bit: CurveList recognises a strand by that.
        const Point3f start = i > 0 ? end : Point3f(cp[0]);
        end = Point3f(cp[3]);
        const auto width = [&](size_t k) {
            return Lerp(static_cast<float>(k) / static_cast<float>(n), width0, width1);
        };
        segments->push_back({{start, Point3f(cp[1]), Point3f(cp[2]), end},
                             {width(i), width(i + 1)},
                             group,
                             StrandPart::Of(i, n)});
    }
    return true;
}
//<

//> Append a ribbon with its normals
bool AppendRibbon(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                  float width1, const Normal3f *normals, size_t normalCount, uint32_t group,
                  CurveList *segments, std::unordered_map<uint32_t, RibbonNormals> *ribbonNormals,
                  std::string *error) {
    const size_t n = CurveSegmentCount(count, basis, degree, error);
    if (n == 0)
        return false;
    std::string message;
    if (normalCount != n + 1)
        message = std::to_string(normalCount) + " normals for a ribbon of " + std::to_string(n) +
                  " segments: " + std::to_string(n + 1) + " are needed";
    for (size_t i = 0; i < normalCount && message.empty(); ++i)
        if (!IsFinite(normals[i]) || !(normals[i].Length() > 0))
            message = "normal " + std::to_string(i) + " of a ribbon has no direction";
    if (!message.empty()) {
        if (error)
            *error = message;
        return false;
    }
    const size_t first = segments->size();
    if (!AppendCurve(points, count, basis, degree, width0, width1, group, segments, error))
        return false;
    for (size_t i = 0; i < n; ++i)
        (*ribbonNormals)[static_cast<uint32_t>(first + i)] = {
            {Normalize(normals[i]), Normalize(normals[i + 1])}};
    return true;
}
//<

} // namespace cuticle
//<
