//> Intersect pieces of curve exactly
#pragma once

#include "shapes/curve_set_kernel_ray.h"

namespace cuticle::curve_kernel {
namespace {

//> Recognise the strand that the ray left
// Returns the length of a segment's control polygon, which is no less than the length of the curve.
CUTICLE_INLINE double PolygonLength(const CurvePoint *s) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double d[3] = {double(s[i + 1].p[0]) - s[i].p[0], double(s[i + 1].p[1]) - s[i].p[1],
                             double(s[i + 1].p[2]) - s[i].p[2]};
        sum += __builtin_sqrt(Dot(d, d));
    }
    return sum;
}

// Returns whether a hit is on the strand that the ray left, no farther along it than the ray itself has gone.
// It is asked only of hits nearer than selfDistance. Goes along the strand from the segment that the ray left
// to the one it hit, as long as end meets beginning, and adds up the way. A change of width or group ends
// what is stored as a strand; so where the next segment has points of its own, they are compared.
[[gnu::noinline]] bool IsOwnStrand(const CurveTree &tree, const TraversalRay &r, uint32_t point, double u,
                                   double t) {
    const double farthest = 2 * (t > 0 ? t : 0) + 4 * r.originRadius;
    const bool forward = point > r.originPoint;
    uint32_t at = r.originPoint;
    double way = -(forward ? r.originU : 1 - r.originU) * PolygonLength(tree.points + at);
    if (point == at)
        return __builtin_fabs(u - r.originU) * PolygonLength(tree.points + at) <= farthest;
    uint32_t segment = SegmentAt(tree, at);
    while (at != point) {
        const CurvePoint *s = tree.points + at;
        way += PolygonLength(s);
        if (way > farthest)
            return false;
        const uint32_t second = forward ? segment + 1 : segment; // of two neighbours
        const bool isApart = tree.starts[second / 64].bits >> (second % 64) & 1;
        const CurvePoint *const n = forward ? s + 3 + isApart : s - 3 - isApart;
        for (int c = 0; c < 3; ++c)
            if (!(forward ? s[3].p[c] == n[0].p[c] : s[0].p[c] == n[3].p[c]))
                return false;
        at = static_cast<uint32_t>(n - tree.points);
        segment = forward ? segment + 1 : segment - 1;
    }
    way += (forward ? u : 1 - u) * PolygonLength(tree.points + at);
    return way <= farthest;
}
//<

//> Describe a piece of curve seen along the ray
// A piece in the ray's frame, relative to the ray's origin: a and b across the ray, z along it. Bezier
// control points and, for a and b, also coefficients of the powers of the piece's own parameter s.
struct ProjectedPiece {
    Double4 a, b, z;
    double a1, a2, a3, b1, b2, b3;
    double u0, du; // u = u0 + s du
    const CurvePoint *segment;
    uint32_t point; // the segment's first
};

// The nearest hit so far on this piece.
struct PieceHit {
    double t;
    double u, v;
    bool found;
};
//<

//> Accept a root
// Takes s, where C.C' = 0, for a hit if the ray passes within half the width there, nearer than what was
// found before.
CUTICLE_INLINE void AcceptRoot(const CurveTree &tree, const TraversalRay &r, const ProjectedPiece &p,
                               double s, PieceHit *best) {
    const double a = p.a[0] + s * (p.a1 + s * (p.a2 + s * p.a3));
    const double b = p.b[0] + s * (p.b1 + s * (p.b2 + s * p.b3));
    const double u = p.u0 + s * p.du;
    const double uc = u < 0 ? 0 : u > 1 ? 1 : u;
    double width = (1 - uc) * WidthAt(p.segment[0]) + uc * WidthAt(p.segment[3]);
    //> Narrow a ribbon by its angle to the ray
    const uint32_t ribbon = tree.ribbonOf ? tree.ribbonOf[SegmentAt(tree, p.point)] : kNoRibbon;
    if (ribbon != kNoRibbon) {
        const float *n = tree.ribbonNormals + 6 * size_t(ribbon);
        const double n0[3] = {n[0], n[1], n[2]}, n1[3] = {n[3], n[4], n[5]};
        double cosine = Dot(n0, n1);
        cosine = cosine > 1 ? 1 : cosine < -1 ? -1 : cosine;
        const double angle = __builtin_acos(cosine), sine = __builtin_sin(angle);
        const double w0 = sine > 1e-4 ? __builtin_sin((1 - uc) * angle) / sine : 1 - uc;
        const double w1 = sine > 1e-4 ? __builtin_sin(uc * angle) / sine : uc;
        width *= __builtin_fabs(w0 * Dot(n0, r.z) + w1 * Dot(n1, r.z));
    }
    //<
    const double distance2 = a * a + b * b;
    if (!(distance2 <= 0.25 * width * width && width > 0))
        return;
    //> Refuse a point where the curve stands still
    // Control points that coincide, and cusps, stop the curve. There C.C' = 0 for every ray near by, and none
    // of them is at right angles to anything: the curve would grow round caps.
    const double da = p.a1 + s * (2 * p.a2 + s * 3 * p.a3), db = p.b1 + s * (2 * p.b2 + s * 3 * p.b3);
    double fastest2 = 0;
    for (int i = 0; i < 3; ++i) {
        const double ea = p.a[i + 1] - p.a[i], eb = p.b[i + 1] - p.b[i], e2 = ea * ea + eb * eb;
        fastest2 = e2 > fastest2 ? e2 : fastest2;
    }
    if (!(da * da + db * db > 9e-12 * fastest2))
        return;
    //<
    const double q = 1 - s;
    const double z = q * q * (q * p.z[0] + 3 * s * p.z[1]) + s * s * (3 * q * p.z[2] + s * p.z[3]);
    if (!(z > r.nearest && z < r.farthest && z < best->t))
        return;
    if (z <= r.selfDistance && r.originPoint != kNoPoint && IsOwnStrand(tree, r, p.point, uc, z))
        return;
    const double side = __builtin_copysign(__builtin_sqrt(distance2), a * db - b * da);
    best->t = z;
    best->u = uc;
    best->v = 0.5 + side / width;
    best->found = true;
}
//<

//> Find the one root between two signs
// Returns the root of C.C' in [lo, hi]; rising: it is negative at lo and positive at hi, else the other way
// round. s is the first guess. Newton's method, kept between lo and hi by bisection.
CUTICLE_INLINE double FindRoot(const ProjectedPiece &p, double lo, double hi, bool rising, double s) {
    for (int i = 0; i < 60; ++i) {
        const double a = p.a[0] + s * (p.a1 + s * (p.a2 + s * p.a3));
        const double b = p.b[0] + s * (p.b1 + s * (p.b2 + s * p.b3));
        const double da = p.a1 + s * (2 * p.a2 + s * 3 * p.a3), db = p.b1 + s * (2 * p.b2 + s * 3 * p.b3);
        const double dda = 2 * p.a2 + s * 6 * p.a3, ddb = 2 * p.b2 + s * 6 * p.b3;
        const double f = a * da + b * db, df = da * da + db * db + a * dda + b * ddb;
        if ((f < 0) == rising)
            lo = s;
        else
            hi = s;
        double next = s - f / df;
        if (!(next > lo && next < hi)) {
            if (hi - lo < 1e-14 || f == 0)
                return s;
            next = 0.5 * (lo + hi);
        }
        const double step = next - s;
        s = next;
        // The next step would be about the square of this one, and the distance changes with its square
        // again.
        if (__builtin_fabs(step) < 2e-6)
            break;
    }
    return s;
}
//<

//> Count the changes of sign
// Counts them in the six Bernstein coefficients of C.C'. There are no more roots, and fewer by an even number
// (Descartes).
CUTICLE_INLINE int SignChanges(const double *f) {
    uint32_t negative = 0, positive = 0;
    for (int i = 0; i < 6; ++i) {
        negative |= (f[i] < 0 ? 1u : 0u) << i;
        positive |= (f[i] > 0 ? 1u : 0u) << i;
    }
    if (negative == 0 || positive == 0)
        return 0;
    if ((negative | positive) == 63)
        return __builtin_popcount((negative ^ (negative >> 1)) & 31);
    int changes = 0, last = 0;
    for (int i = 0; i < 6; ++i) {
        const int sign = f[i] > 0 ? 1 : f[i] < 0 ? -1 : 0;
        changes += sign * last < 0;
        last = sign != 0 ? sign : last;
    }
    return changes;
}
//<

//> Find all roots where there may be several
// Serves a piece seen nearly along itself, or bent round the ray: halves it until each part has one root or
// none, or is out of reach. This is rare, so it is written for safety.
[[gnu::noinline]] void FindSeveralRoots(const CurveTree &tree, const TraversalRay &r, const ProjectedPiece &p,
                                        const double *coefficients, PieceHit *best) {
    struct Part {
        double f[6], lo, hi;
    };
    constexpr int kMaxParts = 34;
    Part stack[kMaxParts + 2];
    int top = 0;
    for (int i = 0; i < 6; ++i)
        stack[0].f[i] = coefficients[i];
    stack[0].lo = 0, stack[0].hi = 1;
    top = 1;

    //> Bound the reach of the piece
    double speed = 0;
    for (int i = 0; i < 3; ++i) {
        const double da = p.a[i + 1] - p.a[i], db = p.b[i + 1] - p.b[i], d2 = da * da + db * db;
        speed = d2 > speed ? d2 : speed;
    }
    speed = 3 * __builtin_sqrt(speed);
    const double width0 = WidthAt(p.segment[0]), width1 = WidthAt(p.segment[3]);
    const double radius = 0.5 * (width0 > width1 ? width0 : width1);
    //<

    while (top > 0) {
        const Part part = stack[--top];
        const int changes = SignChanges(part.f);
        if (changes == 0)
            continue;
        const double half = 0.5 * (part.hi - part.lo), mid = part.lo + half;
        if (changes == 1) {
            //> Find the one root of a part
            // The first coefficient that is not 0 has the sign on the left.
            int first = 0;
            while (part.f[first] == 0)
                ++first;
            AcceptRoot(tree, r, p, FindRoot(p, part.lo, part.hi, part.f[first] < 0, mid), best);
            continue;
            //<
        }
        //> Leave out a part that is out of the ray's reach
        const double a = p.a[0] + mid * (p.a1 + mid * (p.a2 + mid * p.a3));
        const double b = p.b[0] + mid * (p.b1 + mid * (p.b2 + mid * p.b3));
        const double reach = radius + speed * half;
        if (a * a + b * b > reach * reach)
            continue;
        //<
        if (half < 1e-10 || top + 2 > kMaxParts) {
            AcceptRoot(tree, r, p, mid, best);
            continue;
        }
        //> Halve the part by de Casteljau's algorithm
        Part &left = stack[top], &right = stack[top + 1];
        double f[6];
        for (int i = 0; i < 6; ++i)
            f[i] = part.f[i];
        for (int i = 0; i < 6; ++i) {
            left.f[i] = f[0];
            right.f[5 - i] = f[5 - i];
            for (int j = 0; j < 5 - i; ++j)
                f[j] = 0.5 * (f[j] + f[j + 1]);
        }
        left.lo = part.lo, left.hi = right.lo = mid, right.hi = part.hi;
        top += 2;
        if (left.f[5] == 0) // a root at the cut would be seen by neither half
            AcceptRoot(tree, r, p, mid, best);
        //<
    }
}
//<

//> Intersect one piece
CUTICLE_INLINE void IntersectPiece(const CurveTree &tree, const TraversalRay &r, uint32_t piece,
                                   PieceHit *best) {
    ProjectedPiece p;
    p.point = piece >> tree.split;
    const CurvePoint *s = tree.points + p.point;
    p.segment = s;
    const uint32_t part = piece & ((1u << tree.split) - 1);
    const double share = 1.0 / (1 << tree.split);
    p.u0 = part * share - kPieceSlack;
    p.du = share + 2 * kPieceSlack;

    //> Move the segment into the ray's frame
    const Double4 cx = Double4{s[0].p[0], s[1].p[0], s[2].p[0], s[3].p[0]} - r.o[0];
    const Double4 cy = Double4{s[0].p[1], s[1].p[1], s[2].p[1], s[3].p[1]} - r.o[1];
    const Double4 cz = Double4{s[0].p[2], s[1].p[2], s[2].p[2], s[3].p[2]} - r.o[2];
    const Double4 a = cx * r.x[0] + cy * r.x[1] + cz * r.x[2];
    const Double4 b = cx * r.y[0] + cy * r.y[1] + cz * r.y[2];
    const Double4 z = cx * r.z[0] + cy * r.z[1] + cz * r.z[2];
    //<

    //> Cut the piece out of it
    const double *m = tree.pieceMatrix + 16 * part;
    Double4 column[4];
    __builtin_memcpy(column, m, sizeof(column));
    p.a = column[0] * a[0] + column[1] * a[1] + column[2] * a[2] + column[3] * a[3];
    p.b = column[0] * b[0] + column[1] * b[1] + column[2] * b[2] + column[3] * b[3];
    p.z = column[0] * z[0] + column[1] * z[1] + column[2] * z[2] + column[3] * z[3];
    //<

    //> Compute the Bernstein coefficients of $C \cdot C'$
    double pa[4], pb[4], da[3], db[3];
    for (int i = 0; i < 4; ++i)
        pa[i] = p.a[i], pb[i] = p.b[i];
    for (int i = 0; i < 3; ++i)
        da[i] = pa[i + 1] - pa[i], db[i] = pb[i + 1] - pb[i];
    const auto dot = [&](int i, int j) __attribute__((always_inline)) {
        return pa[i] * da[j] + pb[i] * db[j];
    };
    const double f[6] = {dot(0, 0),
                         0.2 * (2 * dot(0, 1) + 3 * dot(1, 0)),
                         0.1 * (dot(0, 2) + 6 * dot(1, 1) + 3 * dot(2, 0)),
                         0.1 * (3 * dot(1, 2) + 6 * dot(2, 1) + dot(3, 0)),
                         0.2 * (3 * dot(2, 2) + 2 * dot(3, 1)),
                         dot(3, 2)};
    const int changes = SignChanges(f);
    if (changes == 0)
        return;
    //<

    //> Write the piece as powers of $s$
    p.a1 = 3 * da[0], p.a2 = 3 * (da[1] - da[0]), p.a3 = pa[3] - pa[0] - 3 * (pa[2] - pa[1]);
    p.b1 = 3 * db[0], p.b2 = 3 * (db[1] - db[0]), p.b3 = pb[3] - pb[0] - 3 * (pb[2] - pb[1]);
    //<

    if (changes > 1) {
        FindSeveralRoots(tree, r, p, f, best);
        return;
    }
    //> Find one root from the chord's nearest point
    const double ea = pa[3] - pa[0], eb = pb[3] - pb[0], e2 = ea * ea + eb * eb;
    double guess = -(pa[0] * ea + pb[0] * eb) / e2;
    guess = guess > 0 ? (guess < 1 ? guess : 1) : 0;
    AcceptRoot(tree, r, p, FindRoot(p, 0, 1, f[0] < 0 || (f[0] == 0 && f[5] > 0), guess), best);
    //<
}
//<

} // namespace
} // namespace cuticle::curve_kernel
//<
