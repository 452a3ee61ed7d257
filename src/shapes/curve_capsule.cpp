//> Define the pieces of a curve and their capsules
#include "shapes/curve_capsule.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

//> Find the pieces of a segment
// The new control point i is the blossom at 3 - i times u0 and i times u1, and a blossom is linear in the old
// points.
void PieceMatrix(double u0, double u1, double *columns) {
    for (size_t out = 0; out < 4; ++out) {
        std::array<double, 4> weight{1, 0, 0, 0}; // Bernstein weights, one argument after another
        for (size_t step = 0; step < 3; ++step) {
            const double u = step < 3 - out ? u0 : u1;
            std::array<double, 4> next{};
            for (size_t i = 0; i <= step; ++i) {
                next[i] += (1 - u) * weight[i];
                next[i + 1] += u * weight[i];
            }
            weight = next;
        }
        for (size_t in = 0; in < 4; ++in)
            columns[4 * in + out] = weight[in];
    }
}

PieceShape ShapeOfPiece(const CurveSegment &segment, const double *columns, double u0, double u1) {
    PieceShape shape;
    for (size_t out = 0; out < 4; ++out) {
        shape.p[out] = Vector3d();
        for (size_t in = 0; in < 4; ++in)
            shape.p[out] += Vector3d(segment.cp[in]) * columns[4 * in + out];
    }
    const auto width = [&](double u) {
        return Lerp<double>(std::clamp(u, 0., 1.), segment.width[0], segment.width[1]);
    };
    shape.radius = 0.5 * std::max({width(u0), width(u1), 0.});
    return shape;
}
//<

namespace {
//> Bound how far a piece strays from its chord
// The distance to a line segment is a convex function, so a curve point's is at most the Bernstein mean of
// those of the control points: the ends' are 0, and the inner two weigh at most 3/4 together.
double DistanceToChord(const Vector3d &p, const Vector3d &a, const Vector3d &b) {
    const Vector3d e = b - a;
    const double e2 = e.LengthSquared();
    const double s = e2 > 0 ? std::clamp(Dot(p - a, e) / e2, 0., 1.) : 0.;
    return (p - (a + e * s)).Length();
}
double StrayFromChord(const PieceShape &shape) {
    return 0.75 * std::max(DistanceToChord(shape.p[1], shape.p[0], shape.p[3]),
                           DistanceToChord(shape.p[2], shape.p[0], shape.p[3]));
}
//<

//> Find a capsule that holds a piece
// Returns the length of the longest control point after the cubic was halved `halvings` times: an upper
// bound, and with two halvings a close one, of the longest vector of the curve itself.
double MaxLength(const std::array<Vector3d, 4> &c, int halvings) {
    if (halvings == 0)
        return std::sqrt(std::max(
            {c[0].LengthSquared(), c[1].LengthSquared(), c[2].LengthSquared(), c[3].LengthSquared()}));
    const Vector3d a = (c[0] + c[1]) * 0.5, m = (c[1] + c[2]) * 0.5, b = (c[2] + c[3]) * 0.5;
    const Vector3d am = (a + m) * 0.5, mb = (m + b) * 0.5, mid = (am + mb) * 0.5;
    return std::max(MaxLength({c[0], a, am, mid}, halvings - 1), MaxLength({mid, mb, b, c[3]}, halvings - 1));
}
//<
} // namespace

//> Find a capsule that holds a piece
CurveCapsule CapsuleOf(const PieceShape &shape) {
    const Vector3d &p = shape.p[0], e = shape.p[3] - p;
    const double e2 = e.LengthSquared();
    const Vector3d q1 = shape.p[1] - p, q2 = shape.p[2] - p;
    const double s1 = Dot(q1, e), s2 = Dot(q2, e);
    //> Leave the axis on the chord where the piece overshoots it
    if (!(e2 > 0 && s1 >= 0 && s1 <= e2 && s2 >= 0 && s2 <= e2))
        return {p, e, shape.radius + StrayFromChord(shape)};
    //<
    //> Move the axis to the middle of the bow
    const Vector3d off1 = q1 - e * (s1 / e2), off2 = q2 - e * (s2 / e2);
    const Vector3d shift = (off1 + off2) * (3. / 16);
    return {p + shift, e,
            shape.radius +
                MaxLength({Vector3d() - shift, off1 - shift, off2 - shift, Vector3d() - shift}, 2)};
    //<
}
CurveCapsule CapsuleOf(const CurveSegment &segment, double u0, double u1) {
    double columns[16];
    PieceMatrix(u0, u1, columns);
    return CapsuleOf(ShapeOfPiece(segment, columns, u0, u1));
}
//<

} // namespace cuticle
//<
