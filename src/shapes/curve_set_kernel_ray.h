//> Make a ray ready for the kernel
#pragma once

#include "core/lanes.h"
#include "shapes/curve_set_kernel.h"

namespace cuticle::curve_kernel {
namespace {

using namespace lanes;

// Control points come four at a time.
typedef double Double4 __attribute__((vector_size(32)));

//> Describe a ray made ready
// A ray with all that does not change during the traversal; only farthest does.
struct TraversalRay {
    // In double precision: the ray's own origin, a frame whose z is its direction, and the length of the
    // direction. Along the ray everything is measured in distances, which are t times that length.
    double o[3], x[3], y[3], z[3];
    double length;
    double nearest, farthest; // distances between which a hit counts
    // In single precision, for boxes and capsules: the origin moved up to the bounds, by `shift`.
    float of[3], xf[3], yf[3], zf[3], inverse[3];
    int isNegative[3];
    double shift;
    // The axes x, y, z in kAxisUnits, as pairs of 16 bits: the first two components, the third and 0, 0 and
    // the third.
    int32_t pairs[3][3];
    float nearestf, farthestf;
    // The first point of the segment that it starts on, or kNoPoint.
    uint32_t originPoint;
    double originU, selfDistance, originRadius;
};

CUTICLE_INLINE double Dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
CUTICLE_INLINE float RoundDown(double x) { return static_cast<float>(x - 4e-7 * __builtin_fabs(x)); }
CUTICLE_INLINE float RoundUp(double x) { return static_cast<float>(x + 4e-7 * __builtin_fabs(x)); }
//<

//> Read the words of a segment
// Returns the width at a segment's first or last point.
CUTICLE_INLINE float WidthAt(const CurvePoint &end) {
    float width;
    __builtin_memcpy(&width, &end.word, sizeof width);
    return width;
}
// Returns the number of the segment that begins at a point.
CUTICLE_INLINE uint32_t SegmentAt(const CurveTree &tree, uint32_t point) {
    return (point - tree.points[point + 1].word) / 3;
}
//<

//> Find how far a ray must go to be clear of the hair it leaves
// Returns a distance in world units. The ray starts on a ribbon through the hair's axis, at most a radius r
// from it, and has left the hair, seen as a tube, after r / sin(theta), theta between ray and hair. The
// ribbon that the new ray sees passes through the same axis: the ray meets it within that distance, and this
// is the false hit to be ignored.
CUTICLE_INLINE double SelfDistance(const CurveTree &tree, const CurveQuery &query, const double *z,
                                   double *radius) {
    const CurvePoint *s = tree.points + query.originPoint;
    const double u = query.originU;
    double tangent[3];
    for (int c = 0; c < 3; ++c) {
        const double d0 = double(s[1].p[c]) - s[0].p[c], d1 = double(s[2].p[c]) - s[1].p[c],
                     d2 = double(s[3].p[c]) - s[2].p[c];
        tangent[c] = (1 - u) * ((1 - u) * d0 + 2 * u * d1) + u * u * d2;
    }
    const double length2 = Dot(tangent, tangent), along = Dot(tangent, z);
    const double sin2 = length2 > 0 ? 1 - along * along / length2 : 1;
    *radius = 0.5 * ((1 - u) * WidthAt(s[0]) + u * WidthAt(s[3]));
    return tree.selfReach * *radius / __builtin_sqrt(sin2 > 1e-8 ? sin2 : 1e-8);
}
//<

//> Make the ray ready
// Returns false where the ray meets nothing.
CUTICLE_INLINE bool PrepareRay(const CurveTree &tree, const CurveQuery &q, TraversalRay *r) {
    double d2 = 0;
    for (int c = 0; c < 3; ++c) {
        r->o[c] = q.o[c];
        d2 += double(q.d[c]) * q.d[c];
    }
    r->length = __builtin_sqrt(d2);
    if (!(d2 > 0 && d2 < 1e300 && __builtin_fabs(r->o[0] + r->o[1] + r->o[2]) < 1e300 && q.tMin < q.tMax))
        return false;
    const double perLength = 1 / r->length;
    for (int c = 0; c < 3; ++c)
        r->z[c] = q.d[c] * perLength;
    // The frame of Duff et al. 2017 (Building an Orthonormal Basis, Revisited).
    const double sign = r->z[2] < 0 ? -1 : 1, a = -1 / (sign + r->z[2]), b = r->z[0] * r->z[1] * a;
    r->x[0] = 1 + sign * r->z[0] * r->z[0] * a, r->x[1] = sign * b, r->x[2] = -sign * r->z[0];
    r->y[0] = b, r->y[1] = sign + r->z[1] * r->z[1] * a, r->y[2] = -r->z[1];

    //> Clip it to the bounds and move its origin there
    double enter = 0, leave = 1e300;
    r->nearest = q.tMin * r->length;
    r->farthest = q.tMax * r->length;
    enter = r->nearest;
    leave = r->farthest;
    for (int c = 0; c < 3; ++c) {
        const double d = __builtin_fabs(r->z[c]) > 1e-20 ? r->z[c] : __builtin_copysign(1e-20, r->z[c]);
        const double inverse = 1 / d;
        const bool negative = d < 0;
        const double in = (tree.bounds[negative ? 3 + c : c] - r->o[c]) * inverse;
        const double out = (tree.bounds[negative ? c : 3 + c] - r->o[c]) * inverse;
        enter = in > enter ? in : enter;
        leave = out < leave ? out : leave;
        r->inverse[c] = static_cast<float>(inverse);
        r->isNegative[c] = negative;
    }
    if (!(enter <= leave))
        return false;
    r->shift = enter;
    for (int c = 0; c < 3; ++c) {
        r->of[c] = static_cast<float>(r->o[c] + enter * r->z[c]);
        r->xf[c] = static_cast<float>(r->x[c]);
        r->yf[c] = static_cast<float>(r->y[c]);
        r->zf[c] = static_cast<float>(r->z[c]);
    }
    r->nearestf = RoundDown(r->nearest - r->shift) - tree.slack;
    r->farthestf = RoundUp(leave - r->shift) + tree.slack;
    //<

    //> Round its frame to whole numbers
    const double *const axes[3] = {r->x, r->y, r->z};
    for (int i = 0; i < 3; ++i) {
        // made positive, as conversion cuts off what follows the point
        const Double4 units =
            Double4{axes[i][0], axes[i][1], axes[i][2], 0} * kAxisUnits + (kAxisUnits + 0.5);
        const Pack<4>::I whole = __builtin_convertvector(units, Pack<4>::I) - kAxisUnits;
        r->pairs[i][0] = (whole[0] & 0xffff) | (whole[1] & 0xffff) << 16;
        r->pairs[i][1] = whole[2] & 0xffff;
        r->pairs[i][2] = (whole[2] & 0xffff) << 16;
    }
    //<

    r->originPoint = q.originPoint;
    r->originU = q.originU;
    r->selfDistance = r->originRadius = 0;
    if (q.originPoint != kNoPoint)
        r->selfDistance = SelfDistance(tree, q, r->z, &r->originRadius);
    return true;
}
//<

} // namespace
} // namespace cuticle::curve_kernel
//<
