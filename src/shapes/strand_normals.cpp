#include "shapes/strand_normals.h"

#include "core/sampling.h"
#include "shapes/curve.h"

namespace cuticle {

namespace {

// A point of a strand and its direction there.
struct StrandPoint {
    Vector3d p, tangent; // tangent of unit length
};
StrandPoint PointOfStrand(const CurveSegment &segment, double u) {
    Vector3d cp[4], derivative;
    for (size_t i = 0; i < 4; ++i)
        cp[i] = Vector3d(segment.cp[i]);
    const Vector3d p = EvalBezier(cp, u, &derivative);
    if (!(derivative.LengthSquared() > 0))
        derivative = cp[3] - cp[0]; // where the curve stands still, its chord
    if (!(derivative.LengthSquared() > 0))
        derivative = {1, 0, 0};
    return {p, Normalize(derivative)};
}

// Returns the part of v at right angles to a unit tangent, scaled to unit length; any direction across where
// there is none.
Vector3d Across(const Vector3d &v, const Vector3d &tangent) {
    const Vector3d across = v - tangent * Dot(v, tangent);
    if (across.LengthSquared() > 1e-12)
        return Normalize(across);
    Vector3d x, y;
    CoordinateSystem(tangent, &x, &y);
    return x;
}

// Returns v mirrored at the plane across d, whose length is not 0.
Vector3d Mirrored(const Vector3d &v, const Vector3d &d) {
    return v - d * (2 * Dot(d, v) / d.LengthSquared());
}

// Two reflections carry the frame at one place to the other: one at the plane between the places, one that
// brings the tangents together.
Vector3d Carried(const Vector3d &normal, const StrandPoint &from, const StrandPoint &to) {
    const Vector3d chord = to.p - from.p;
    if (!(chord.LengthSquared() > 0))
        return Across(normal, to.tangent);
    const Vector3d mirrored = Mirrored(from.tangent, chord);
    const Vector3d between = to.tangent - mirrored, once = Mirrored(normal, chord);
    return Across(between.LengthSquared() > 0 ? Mirrored(once, between) : once, to.tangent);
}

bool Continues(const CurveSegment &before, const CurveSegment &next) {
    const double gap = (Vector3d(next.cp[0]) - Vector3d(before.cp[3])).LengthSquared();
    return before.group == next.group && gap <= Sqr(0.05 * next.width[0]);
}

Vector3d RandomAcross(const Vector3d &tangent, uint64_t strand) {
    Vector3d x, y;
    CoordinateSystem(tangent, &x, &y);
    const double angle = 2 * kPi<double> * static_cast<double>(MixBits(strand + 1) >> 11) * 0x1p-53;
    return x * std::cos(angle) + y * std::sin(angle);
}

} // namespace

std::vector<Vector3f> MakeStrandNormals(const CurveList &segments) {
    std::vector<Vector3f> normals;
    normals.reserve(segments.size());
    Vector3d atEnd;
    uint64_t strand = 0;
    CurveSegment before;
    for (const CurveSegment &segment : segments) {
        const StrandPoint start = PointOfStrand(segment, 0);
        const bool joined = !normals.empty() && Continues(before, segment);
        const Vector3d normal = joined ? Across(atEnd, start.tangent) : RandomAcross(start.tangent, strand++);
        atEnd = Carried(normal, start, PointOfStrand(segment, 1));
        normals.emplace_back(normal);
        before = segment;
    }
    return normals;
}

Vector3f StrandNormal(const CurveSegment &segment, const Vector3f &start, float u, const Vector3f &tangent) {
    StrandPoint here = PointOfStrand(segment, u);
    here.tangent = Vector3d(tangent);
    return Vector3f(Carried(Vector3d(start), PointOfStrand(segment, 0), here));
}

} // namespace cuticle
