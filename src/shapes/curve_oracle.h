// Finds all places where a ray meets a curve, slowly and surely: the oracle of the intersectors' tests.
#pragma once

#include "shapes/curve.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cuticle::oracle {

using Real = long double;

// A root of C.C' = 0 with the ray inside half the width there. margin: (width / 2 - distance) / (width / 2),
// negative outside; roots with a margin of at least -allowed are reported.
struct Candidate {
    uint32_t segment;
    Real t, u, v;
    Real margin;
    // How much u may be off when F = C.C' is known to within the rounding of doubles: |error of F| / |F'|.
    Real nanTaint;
};

struct Vec2 {
    Real x, y;
};
inline Real Dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }

// The curve in the ray's frame.
struct Seen {
    Vec2 p[4];
    Real z[4];
};

inline Vec2 Point(const Seen &s, Real u) {
    const Real q = 1 - u, w[4] = {q * q * q, 3 * q * q * u, 3 * q * u * u, u * u * u};
    Vec2 r{0, 0};
    for (int i = 0; i < 4; ++i)
        r.x += w[i] * s.p[i].x, r.y += w[i] * s.p[i].y;
    return r;
}
inline Vec2 Velocity(const Seen &s, Real u) {
    const Real q = 1 - u, w[3] = {3 * q * q, 6 * q * u, 3 * u * u};
    Vec2 r{0, 0};
    for (int i = 0; i < 3; ++i)
        r.x += w[i] * (s.p[i + 1].x - s.p[i].x), r.y += w[i] * (s.p[i + 1].y - s.p[i].y);
    return r;
}
inline Vec2 Acceleration(const Seen &s, Real u) {
    const auto second = [&](int i) {
        return Vec2{s.p[i].x - 2 * s.p[i + 1].x + s.p[i + 2].x, s.p[i].y - 2 * s.p[i + 1].y + s.p[i + 2].y};
    };
    const Vec2 a = second(0), b = second(1);
    return {6 * ((1 - u) * a.x + u * b.x), 6 * ((1 - u) * a.y + u * b.y)};
}

// A root at which |C'| is less than this part of its largest value is no hit: the curve stands still.
constexpr Real kStill = 1e-6L;
struct Limits {
    Real speed; // the largest |C'|
    Real jerk;  // the third derivative's length, the same everywhere
    Real reach; // farthest from the ray that a hit can be
};

// Finds the roots in [lo, hi] of F = C.C', by exclusion: an interval is dropped when |F| in its middle
// exceeds what F can change over half of it, and taken for a simple root when F' cannot vanish on it and F
// changes sign. The bounds on C and its derivatives come from their values in the middle, by Taylor. Knows
// nothing of Bernstein polynomials, which the intersector uses.
template <typename Take>
void Isolate(const Seen &s, Real lo, Real hi, const Limits &limits, int depth, const Take &take) {
    const auto f = [&](Real u) { return Dot(Point(s, u), Velocity(s, u)); };
    const auto df = [&](Real u) {
        const Vec2 v = Velocity(s, u);
        return Dot(v, v) + Dot(Point(s, u), Acceleration(s, u));
    };
    const auto size = [](Vec2 v) { return std::sqrt(Dot(v, v)); };
    const Real mid = (lo + hi) / 2, half = (hi - lo) / 2;
    const Real c0 = size(Point(s, mid)), c1 = size(Velocity(s, mid)), c2 = size(Acceleration(s, mid));
    // Bounds of |C''|, |C'| and |C| on the interval, with a little to spare for rounding.
    constexpr Real more = 1 + 1e-12L;
    const Real bend = more * (c2 + limits.jerk * half), speed = more * (c1 + bend * half),
               away = more * (c0 + speed * half);
    if (c0 > limits.reach + speed * half)
        return; // too far from the ray
    if (speed < kStill * limits.speed)
        return; // the curve stands still here: not a hit by definition
    const Real f2 = speed * speed + away * bend,
               f3 = 3 * speed * bend + away * limits.jerk; // of |F'| and |F''|
    if (std::abs(f(mid)) > f2 * half)
        return;
    if (std::abs(df(mid)) > f3 * half) {
        // Monotonic: at most one root, found by bisection.
        Real a = lo, b = hi;
        const bool negative = f(a) < 0;
        if (negative == (f(b) < 0))
            return;
        for (int i = 0; i < 80; ++i) {
            const Real m = (a + b) / 2;
            ((f(m) < 0) == negative ? a : b) = m;
        }
        take((a + b) / 2, std::abs(df((a + b) / 2)));
        return;
    }
    if (depth == 0) {
        take(mid, std::abs(df(mid))); // a root of several, or as good as one
        return;
    }
    Isolate(s, lo, mid, limits, depth - 1, take);
    Isolate(s, mid, hi, limits, depth - 1, take);
}

// An orthonormal frame whose z is the ray's direction: x is at right angles to the axis that d is least
// along.
struct RayFrame {
    explicit RayFrame(const Vector3f &direction) {
        Real length2 = 0;
        for (int c = 0; c < 3; ++c)
            d[c] = direction[c], length2 += d[c] * d[c];
        length = std::sqrt(length2);
        for (Real &c : d)
            c /= length;
        int least = std::abs(d[0]) < std::abs(d[1]) ? 0 : 1;
        if (std::abs(d[2]) < std::abs(d[least]))
            least = 2;
        Real norm = 0;
        for (int c = 0; c < 3; ++c) {
            x[c] = (c == least ? 1 : 0) - d[least] * d[c];
            norm += x[c] * x[c];
        }
        for (Real &c : x)
            c /= std::sqrt(norm);
        for (int c = 0; c < 3; ++c)
            y[c] = d[(c + 1) % 3] * x[(c + 2) % 3] - d[(c + 2) % 3] * x[(c + 1) % 3];
    }
    // Moves a curve into the frame, relative to the ray's origin; returns the control points' largest
    // distance from the ray.
    Real Move(const CurveSegment &segment, const Point3f &origin, Seen *s) const {
        Real reach = 0;
        for (int i = 0; i < 4; ++i) {
            Real p[3];
            for (int c = 0; c < 3; ++c)
                p[c] = Real(segment.cp[i][c]) - Real(origin[c]);
            s->p[i] = {p[0] * x[0] + p[1] * x[1] + p[2] * x[2], p[0] * y[0] + p[1] * y[1] + p[2] * y[2]};
            s->z[i] = p[0] * d[0] + p[1] * d[1] + p[2] * d[2];
            reach = std::max(reach, std::sqrt(Dot(s->p[i], s->p[i])));
        }
        return reach;
    }
    Real d[3], x[3], y[3];
    Real length; // of the ray's direction
};

// Returns whether the hull of the control points is farther from the ray than radius, on one side of it.
inline bool OutOfReach(const Seen &s, Real radius) {
    for (int axis = 0; axis < 2; ++axis) {
        Real lowest = INFINITY, highest = -INFINITY;
        for (const Vec2 &p : s.p) {
            const Real c = axis == 0 ? p.x : p.y;
            lowest = std::min(lowest, c), highest = std::max(highest, c);
        }
        if (lowest > radius || highest < -radius)
            return true;
    }
    return false;
}

// Returns the part of a ribbon's width that a ray with unit direction d sees at u in [0, 1]: the cosine
// between d and the normal, on the great arc between its two.
inline Real SeenShare(const RibbonNormals &normals, Real u, const Real d[3]) {
    Real n0[3], n1[3], cosine = 0;
    for (int c = 0; c < 3; ++c) {
        n0[c] = normals.n[0][c], n1[c] = normals.n[1][c];
        cosine += n0[c] * n1[c];
    }
    const Real angle = std::acos(std::clamp(cosine, Real(-1), Real(1))), sine = std::sin(angle);
    Real along = 0;
    for (int c = 0; c < 3; ++c)
        along +=
            d[c] * (sine > 1e-4L ? (n0[c] * std::sin((1 - u) * angle) + n1[c] * std::sin(u * angle)) / sine
                                 : n0[c] * (1 - u) + n1[c] * u);
    return std::abs(along);
}

// Appends every candidate of one segment with u in [-ends, 1 + ends]; t is not restricted.
inline void FindAll(const CurveSegment &segment, uint32_t index, const RibbonNormals *normals, const Ray &ray,
                    Real ends, Real allowed, std::vector<Candidate> *out) {
    const RayFrame frame(ray.d);
    Seen s;
    const Real reach = frame.Move(segment, ray.o, &s);
    const Real radius = Real(std::max(segment.width[0], segment.width[1])) / 2;
    if (OutOfReach(s, radius * 1.01L))
        return;
    Real speed = 0;
    for (int i = 0; i < 3; ++i) {
        const Vec2 v{s.p[i + 1].x - s.p[i].x, s.p[i + 1].y - s.p[i].y};
        speed = std::max(speed, 3 * std::sqrt(Dot(v, v)));
    }
    const Vec2 a0 = Acceleration(s, 0), a1 = Acceleration(s, 1), jump{a1.x - a0.x, a1.y - a0.y};
    const Limits limits{speed, std::sqrt(Dot(jump, jump)), radius * 1.001L};
    // Rounding of F in double precision.
    const Real noise = 1e-15L * (reach + std::abs(s.z[0])) * speed;
    if (!(speed > 0))
        return;

    Isolate(s, -ends, 1 + ends, limits, 30, [&](Real u, Real slope) {
        const Real uc = std::clamp(u, Real(0), Real(1));
        Real width = (1 - uc) * segment.width[0] + uc * segment.width[1];
        if (normals)
            width *= SeenShare(*normals, uc, frame.d);
        const Vec2 p = Point(s, u), v = Velocity(s, u);
        const Real distance = std::sqrt(Dot(p, p)), margin = 1 - 2 * distance / width;
        const Real still = std::sqrt(Dot(v, v)) / (kStill * speed);
        if (!(width > 0) || margin < -allowed || still < 0.1L)
            return;
        const Real q = 1 - u;
        const Real z =
            q * q * q * s.z[0] + 3 * q * q * u * s.z[1] + 3 * q * u * u * s.z[2] + u * u * u * s.z[3];
        const Real side = p.x * v.y - p.y * v.x;
        // y = d x x, so x, y, d are right-handed and v grows to the left of the tangent, as pbrt-v3 has it.
        out->push_back({index, z / frame.length, u, Real(0.5) + std::copysign(distance, side) / width, margin,
                        slope > 0 && still > 10 ? noise / slope : Real(1)});
    });
}

} // namespace cuticle::oracle
