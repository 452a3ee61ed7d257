//> Intersect curves in the lanes of registers
// One text for all instruction sets: CUTICLE_KERNEL names the result, CUTICLE_LANES says how many floats a register
// holds. Everything but the table at the end has internal linkage.
#include "shapes/curve_set_kernel.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace cuticle::curve_kernel {
namespace {

//> Choose the registers
#define CUTICLE_INLINE [[gnu::always_inline]] inline

constexpr int kLanes = CUTICLE_LANES;

template <int N>
struct Pack {
    typedef float F __attribute__((vector_size(4 * N)));
    typedef int32_t I __attribute__((vector_size(4 * N)));
};
using Lanes = Pack<kLanes>::F;
// Boxes come eight at a time; a narrower register takes them in two steps.
constexpr int kBoxLanes = kLanes < kWidth ? kLanes : kWidth;
using BoxLanes = Pack<kBoxLanes>::F;
// Control points come four at a time.
typedef double Double4 __attribute__((vector_size(32)));

template <typename F>
CUTICLE_INLINE F Load(const float *p) {
    F v;
    __builtin_memcpy(&v, p, sizeof(v));
    return v;
}
// Whole numbers of 16 bits, as floats.
template <typename F>
CUTICLE_INLINE F LoadSmall(const int16_t *p) {
    typedef int16_t Small __attribute__((vector_size(sizeof(F) / 2)));
    Small v;
    __builtin_memcpy(&v, p, sizeof(v));
    return __builtin_convertvector(v, F);
}
#if defined(__AVX2__)
template <>
CUTICLE_INLINE __m256 LoadSmall<__m256>(const int16_t *p) {
    return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i *>(p))));
}
#endif
#if defined(__AVX512F__)
template <>
CUTICLE_INLINE __m512 LoadSmall<__m512>(const int16_t *p) {
    // the forms without a mask warn of their own registers in g++ 12
    const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i *>(p));
    return _mm512_maskz_cvtepi32_ps(0xffff, _mm512_maskz_cvtepi16_epi32(0xffff, v));
}
#endif
//> Multiply pairs of whole numbers
// Of each lane's two numbers of 16 bits, the products with those of `pair`, added up.
template <typename I>
CUTICLE_INLINE I DotPairs(I pairs, int32_t pair) {
    if constexpr (false) {
    }
#if defined(__SSE2__)
    else if constexpr (sizeof(I) == 16)
        return reinterpret_cast<I>(_mm_madd_epi16(reinterpret_cast<__m128i>(pairs), _mm_set1_epi32(pair)));
#endif
#if defined(__AVX2__)
    else if constexpr (sizeof(I) == 32)
        return reinterpret_cast<I>(
            _mm256_madd_epi16(reinterpret_cast<__m256i>(pairs), _mm256_set1_epi32(pair)));
#endif
#if defined(__AVX512BW__)
    else if constexpr (sizeof(I) == 64)
        return reinterpret_cast<I>(
            _mm512_madd_epi16(reinterpret_cast<__m512i>(pairs), _mm512_set1_epi32(pair)));
#endif
    else
        return (pairs << 16 >> 16) * (pair << 16 >> 16) + (pairs >> 16) * (pair >> 16);
}
//<
template <typename F>
CUTICLE_INLINE F Fill(float x) {
    return x - F{};
}
//<

//> Take minimum and maximum
template <typename F>
CUTICLE_INLINE F Least(F a, F b) {
    return a < b ? a : b;
}
template <typename F>
CUTICLE_INLINE F Greatest(F a, F b) {
    return a > b ? a : b;
}
//<

//> Turn masks into bits
// One bit for each lane whose mask is set.
template <typename I>
CUTICLE_INLINE uint32_t Bits(I mask) {
    if constexpr (false) {
    }
#if defined(__SSE2__)
    else if constexpr (sizeof(I) == 16)
        return static_cast<uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#endif
#if defined(__AVX__)
    else if constexpr (sizeof(I) == 32)
        return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#endif
#if defined(__AVX512F__)
    else if constexpr (sizeof(I) == 64)
        return _mm512_cmplt_epi32_mask(reinterpret_cast<__m512i>(mask), _mm512_setzero_si512());
#endif
    else {
        uint32_t bits = 0;
        for (unsigned i = 0; i < sizeof(I) / 4; ++i)
            bits |= (mask[i] != 0 ? 1u : 0u) << i;
        return bits;
    }
}
//<

//> Take minimum and maximum
#if defined(__SSE2__)
template <>
CUTICLE_INLINE __m128 Least(__m128 a, __m128 b) {
    return _mm_min_ps(a, b);
}
template <>
CUTICLE_INLINE __m128 Greatest(__m128 a, __m128 b) {
    return _mm_max_ps(a, b);
}
#endif
#if defined(__AVX__)
template <>
CUTICLE_INLINE __m256 Least(__m256 a, __m256 b) {
    return _mm256_min_ps(a, b);
}
template <>
CUTICLE_INLINE __m256 Greatest(__m256 a, __m256 b) {
    return _mm256_max_ps(a, b);
}
#endif
#if defined(__AVX512F__)
template <>
CUTICLE_INLINE __m512 Least(__m512 a, __m512 b) {
    return _mm512_maskz_min_ps(0xffff, a, b); // the form without a mask warns of its own register in g++ 12
}
template <>
CUTICLE_INLINE __m512 Greatest(__m512 a, __m512 b) {
    return _mm512_maskz_max_ps(0xffff, a, b);
}
#endif
//<

//> Describe a ray made ready
struct TraversalRay {
    // In double precision: the ray's own origin, a frame whose z is its direction, and the length of the direction.
    // Along the ray everything is measured in distances, which are t times that length.
    double o[3], x[3], y[3], z[3];
    double length;
    double nearest, farthest; // between which a hit may lie; farthest shrinks
    // In single precision, for boxes and capsules: the origin moved up to the bounds, by `shift`.
    float of[3], xf[3], yf[3], zf[3], inverse[3];
    int isNegative[3];
    double shift;
    // The axes x, y, z in kAxisUnits, as pairs of 16 bits: the first two components, the third and 0, 0 and the third.
    int32_t pairs[3][3];
    float nearestf, farthestf;
    // Where it starts on a curve.
    uint32_t originSegment;
    double originU, selfDistance, originRadius;
};

CUTICLE_INLINE double Dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
CUTICLE_INLINE float RoundDown(double x) { return static_cast<float>(x - 4e-7 * __builtin_fabs(x)); }
CUTICLE_INLINE float RoundUp(double x) { return static_cast<float>(x + 4e-7 * __builtin_fabs(x)); }
//<

//> Find how far a ray must go to be clear of the hair it leaves
// The ray starts on a ribbon through the hair's axis, at most a radius r from it, and has left the hair, seen as a tube,
// after r / sin(theta), theta between ray and hair. The ribbon that the new ray sees passes through the same axis: the
// ray meets it within that distance, and this is the false hit to be ignored.
CUTICLE_INLINE double SelfDistance(const Tree &tree, const Query &query, const double *z, double *radius) {
    const float *s = tree.segments + kSegmentWords * query.originSegment;
    const double u = query.originU;
    double tangent[3];
    for (int c = 0; c < 3; ++c) {
        const double d0 = double(s[3 + c]) - s[c], d1 = double(s[6 + c]) - s[3 + c],
                     d2 = double(s[9 + c]) - s[6 + c];
        tangent[c] = (1 - u) * ((1 - u) * d0 + 2 * u * d1) + u * u * d2;
    }
    const double length2 = Dot(tangent, tangent), along = Dot(tangent, z);
    const double sin2 = length2 > 0 ? 1 - along * along / length2 : 1;
    *radius = 0.5 * ((1 - u) * s[12] + u * s[13]);
    return tree.selfReach * *radius / __builtin_sqrt(sin2 > 1e-8 ? sin2 : 1e-8);
}
//<

//> Make the ray ready
// False: it meets nothing.
CUTICLE_INLINE bool Start(const Tree &tree, const Query &q, TraversalRay *r) {
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

    r->originSegment = q.originSegment;
    r->originU = q.originU;
    r->selfDistance = r->originRadius = 0;
    if (q.originSegment < tree.segmentCount)
        r->selfDistance = SelfDistance(tree, q, r->z, &r->originRadius);
    else
        r->originSegment = kNoSegment;
    return true;
}
//<

//> Recognise the strand that the ray left
// The length of a segment's control polygon: no less than the length of the curve.
CUTICLE_INLINE double PolygonLength(const float *s) {
    double sum = 0;
    for (int i = 0; i < 9; i += 3) {
        const double d[3] = {double(s[i + 3]) - s[i], double(s[i + 4]) - s[i + 1],
                             double(s[i + 5]) - s[i + 2]};
        sum += __builtin_sqrt(Dot(d, d));
    }
    return sum;
}

// Asked only of hits nearer than selfDistance. Walks along the strand from the segment that the ray left to the one it
// hit, as long as end meets beginning, and adds up the way.
[[gnu::noinline]] bool IsOwnStrand(const Tree &tree, const TraversalRay &r, uint32_t segment, double u,
                                   double t) {
    const double farthest = 2 * (t > 0 ? t : 0) + 4 * r.originRadius;
    const bool forward = segment > r.originSegment;
    uint32_t at = r.originSegment;
    double way = -(forward ? r.originU : 1 - r.originU) * PolygonLength(tree.segments + kSegmentWords * at);
    if (segment == at)
        return __builtin_fabs(u - r.originU) * PolygonLength(tree.segments + kSegmentWords * at) <= farthest;
    while (at != segment) {
        const float *s = tree.segments + kSegmentWords * at;
        way += PolygonLength(s);
        if (way > farthest)
            return false;
        const uint32_t next = forward ? at + 1 : at - 1;
        const float *n = tree.segments + kSegmentWords * next;
        for (int c = 0; c < 3; ++c)
            if (!(forward ? s[9 + c] == n[c] : s[c] == n[9 + c]))
                return false;
        at = next;
    }
    way += (forward ? u : 1 - u) * PolygonLength(tree.segments + kSegmentWords * at);
    return way <= farthest;
}
//<

//> Describe a piece of curve seen along the ray
// Coordinates in the ray's frame, relative to its origin: across it a and b, along it z. As Bezier control points and,
// for a and b, as powers of the piece's own parameter s.
struct Piece {
    Double4 a, b, z;
    double a1, a2, a3, b1, b2, b3;
    double u0, du; // u = u0 + s du
    const float *segment;
    uint32_t index;
};

// The nearest hit so far on this piece.
struct Best {
    double t;
    double u, v;
    bool found;
};
//<

//> Accept a root
// s: where C.C' = 0. Takes it if the ray passes within half the width there, and nearer than what was found before.
CUTICLE_INLINE void AcceptRoot(const Tree &tree, const TraversalRay &r, const Piece &p, double s,
                               Best *best) {
    const double a = p.a[0] + s * (p.a1 + s * (p.a2 + s * p.a3));
    const double b = p.b[0] + s * (p.b1 + s * (p.b2 + s * p.b3));
    const double u = p.u0 + s * p.du;
    const double uc = u < 0 ? 0 : u > 1 ? 1 : u;
    double width = (1 - uc) * p.segment[12] + uc * p.segment[13];
    //> Narrow a ribbon by its angle to the ray
    if (tree.ribbonOf && tree.ribbonOf[p.index] != kNoRibbon) {
        const float *n = tree.ribbonNormals + 6 * size_t(tree.ribbonOf[p.index]);
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
    // Control points that coincide, and cusps, stop the curve. There C.C' = 0 for every ray near by, and none of them is
    // at right angles to anything: the curve would grow round caps.
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
    if (z <= r.selfDistance && r.originSegment != kNoSegment && IsOwnStrand(tree, r, p.index, uc, z))
        return;
    const double side = __builtin_copysign(__builtin_sqrt(distance2), a * db - b * da);
    best->t = z;
    best->u = uc;
    best->v = 0.5 + side / width;
    best->found = true;
}
//<

//> Find the one root between two signs
// f0: the sign of C.C' at lo; the other at hi. Newton's method, kept between them by bisection.
CUTICLE_INLINE double FindRoot(const Piece &p, double lo, double hi, bool rising, double s) {
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
        // The next step would be about the square of this one, and the distance changes with its square again.
        if (__builtin_fabs(step) < 2e-6)
            break;
    }
    return s;
}
//<

//> Count the changes of sign
// Of the Bernstein coefficients of C.C'. There are no more roots than that, and fewer by an even number (Descartes).
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
// A piece seen nearly along itself, or bent round the ray. Halve until each part has one root or none, or is out of
// reach. Rare, so it is written for safety.
[[gnu::noinline]] void FindSeveralRoots(const Tree &tree, const TraversalRay &r, const Piece &p,
                                        const double *coefficients, Best *best) {
    struct Part {
        double f[6], lo, hi;
    };
    constexpr int kMaxDepth = 34;
    Part stack[kMaxDepth + 2];
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
    const double radius = 0.5 * (p.segment[12] > p.segment[13] ? p.segment[12] : p.segment[13]);
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
        if (half < 1e-10 || top + 2 > kMaxDepth) {
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
CUTICLE_INLINE void IntersectPiece(const Tree &tree, const TraversalRay &r, uint32_t piece, Best *best) {
    Piece p;
    p.index = piece >> tree.split;
    const float *s = tree.segments + kSegmentWords * size_t(p.index);
    p.segment = s;
    const uint32_t part = piece & ((1u << tree.split) - 1);
    const double share = 1.0 / (1 << tree.split);
    p.u0 = part * share - kPieceSlack;
    p.du = share + 2 * kPieceSlack;

    //> Move the segment into the ray's frame
    const Double4 cx = Double4{s[0], s[3], s[6], s[9]} - r.o[0];
    const Double4 cy = Double4{s[1], s[4], s[7], s[10]} - r.o[1];
    const Double4 cz = Double4{s[2], s[5], s[8], s[11]} - r.o[2];
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

//> Test the capsules of a leaf
// One bit for each of the leaf's n pieces, from `first` on, whose capsule the ray meets between nearest and farthest.
// All lengths are in the leaf's units.
CUTICLE_INLINE uint32_t IntersectCapsules(const LeafFrame &frame, const unsigned char *numbers, int n,
                                          int first, const TraversalRay &r, float slack) {
    using F = Lanes;
    using I = Pack<kLanes>::I;
    //> Resolve the axes of the capsules across and along the ray
    I begin, both, extent;
    __builtin_memcpy(&begin, numbers + 4 * first, sizeof(I));
    __builtin_memcpy(&both, numbers + 4 * (n + first), sizeof(I));
    __builtin_memcpy(&extent, numbers + 4 * (2 * n + first), sizeof(I));
    const float d[3] = {frame.origin[0] - r.of[0], frame.origin[1] - r.of[1], frame.origin[2] - r.of[2]};
    const auto beginAlong = [&](int i, const float *axis) __attribute__((always_inline)) {
        const I steps = DotPairs<I>(begin, r.pairs[i][0]) + DotPairs<I>(both, r.pairs[i][1]);
        return __builtin_convertvector(steps, F) +
               (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]) * frame.units;
    };
    const auto extentAlong = [&](int i) __attribute__((always_inline)) {
        return __builtin_convertvector(DotPairs<I>(extent, r.pairs[i][0]) + DotPairs<I>(both, r.pairs[i][2]),
                                       F);
    };
    const F pa = beginAlong(0, r.xf), pb = beginAlong(1, r.yf), pc = beginAlong(2, r.zf);
    const F ea = extentAlong(0), eb = extentAlong(1), ec = extentAlong(2);
    const F steps = LoadSmall<F>(reinterpret_cast<const int16_t *>(numbers + 12 * n) + first);
    const F radius = steps * float(kAxisUnits) + slack * frame.units;
    //<
    //> Find the points nearest to the ray
    const F zero = Fill<F>(0.f), one = Fill<F>(1.f);
    const F s = Least(Greatest(-(pa * ea + pb * eb) / (ea * ea + eb * eb + 1e-37f), zero), one);
    const F a = pa + s * ea, b = pb + s * eb;
    //<
    const F front = Least(pc, pc + ec) - radius, back = Greatest(pc, pc + ec) + radius;
    const auto meets = (a * a + b * b <= radius * radius) & (front <= r.farthestf * frame.units) &
                       (back >= r.nearestf * frame.units);
    return Bits(meets);
}
//<

//> Intersect a leaf
// True: some piece was hit (for any-hit rays the search ends there).
template <bool Any>
CUTICLE_INLINE bool IntersectLeaf(const Tree &tree, TraversalRay *r, uint32_t leafRef, Answer *answer) {
    const int n = static_cast<int>((leafRef >> kLeafCountShift) & 15) + 1;
    const unsigned char *data = tree.leaves + kLeafUnit * size_t(leafRef & kLeafPlaceMask);
    LeafFrame frame;
    __builtin_memcpy(&frame, data, sizeof(frame));
    const unsigned char *pieces = data + sizeof(frame);
    uint32_t bits = 0;
    for (int first = 0; first < n; first += kLanes)
        bits |= IntersectCapsules(frame, pieces + 4 * n, n, first, *r, tree.slack) << first;
    bits &= (2u << (n - 1)) - 1;
    bool hit = false;
    while (bits != 0) {
        const int i = __builtin_ctz(bits);
        bits &= bits - 1;
        uint32_t piece;
        __builtin_memcpy(&piece, pieces + 4 * i, 4);
        Best best{r->farthest, 0, 0, false};
        IntersectPiece(tree, *r, piece, &best);
        if (!best.found)
            continue;
        hit = true;
        if constexpr (Any)
            return true;
        //> Remember the hit and shorten the ray
        r->farthest = best.t;
        r->farthestf = RoundUp(best.t - r->shift) + tree.slack;
        answer->t = static_cast<float>(best.t / r->length);
        answer->u = static_cast<float>(best.u);
        answer->v = static_cast<float>(best.v < 0 ? 0 : best.v > 1 ? 1 : best.v);
        answer->segment = piece >> tree.split;
        //<
    }
    return hit;
}
//<

//> Test the boxes of the children
// One bit for each; enter[i]: where.
CUTICLE_INLINE uint32_t IntersectBoxes(const Node &node, const TraversalRay &r, float *enter) {
    using F = BoxLanes;
    uint32_t bits = 0;
    for (int i = 0; i < kWidth; i += kBoxLanes) {
        F in = Fill<F>(r.nearestf), out = Fill<F>(r.farthestf);
        for (int c = 0; c < 3; ++c) {
            const F lo = Load<F>(node.bounds[r.isNegative[c] ? 3 + c : c] + i);
            const F hi = Load<F>(node.bounds[r.isNegative[c] ? c : 3 + c] + i);
            in = Greatest<F>((lo - r.of[c]) * r.inverse[c], in);
            out = Least<F>((hi - r.of[c]) * r.inverse[c], out);
        }
        __builtin_memcpy(enter + i, &in, sizeof(in));
        bits |= Bits(in <= out) << i;
    }
    return bits;
}
//<

//> Ask for a child's memory before it is needed
// Of the children that wait, most are visited soon after; their cache misses then overlap.
CUTICLE_INLINE void Prefetch(const Tree &tree, uint32_t child) {
    const unsigned char *p = child & kLeafBit ? tree.leaves + kLeafUnit * size_t(child & kLeafPlaceMask)
                                              : reinterpret_cast<const unsigned char *>(tree.nodes + child);
    for (size_t line = 0; line < 4; ++line)
        __builtin_prefetch(p + 64 * line);
}
//<

//> Traverse the tree
// To the nearest hit.
CUTICLE_INLINE bool Traverse(const Tree &tree, const Query &query, Answer *answer) {
    TraversalRay r;
    if (tree.nodes == nullptr || !Start(tree, query, &r))
        return false;
    struct Waiting {
        uint32_t child;
        float enter;
    };
    Waiting stack[kMaxDepth * (kWidth - 1) + 1];
    int top = 0;
    uint32_t at = 0;
    bool hit = false;
    for (;;) {
        if (at & kLeafBit) {
            hit |= IntersectLeaf<false>(tree, &r, at, answer);
        } else {
            //> Enter a node: the nearest child next, the others wait in order
            const Node &node = tree.nodes[at];
            alignas(64) float enter[kWidth];
            uint32_t bits = IntersectBoxes(node, r, enter);
            if (bits != 0) {
                int i = __builtin_ctz(bits);
                bits &= bits - 1;
                Waiting nearest{node.child[i], enter[i]};
                const int bottom = top;
                while (bits != 0) {
                    i = __builtin_ctz(bits);
                    bits &= bits - 1;
                    Waiting next{node.child[i], enter[i]};
                    if (next.enter < nearest.enter) {
                        const Waiting swap = nearest;
                        nearest = next;
                        next = swap;
                    }
                    int place = top++;
                    while (place > bottom && stack[place - 1].enter < next.enter) {
                        stack[place] = stack[place - 1];
                        --place;
                    }
                    stack[place] = next;
                    Prefetch(tree, next.child);
                }
                at = nearest.child;
                continue;
            }
            //<
        }
        //> Take the nearest that waits
        do {
            if (top == 0)
                return hit;
            --top;
        } while (stack[top].enter > r.farthestf);
        at = stack[top].child;
        //<
    }
}
//<

//> Traverse until something is hit
// Appends the children whose bits are set to a list that has room for all; returns how many.
CUTICLE_INLINE int Append(const uint32_t *child, uint32_t bits, uint32_t *list) {
#if defined(__AVX512VL__)
    static_assert(kWidth == 8);
    _mm256_storeu_si256(
        reinterpret_cast<__m256i *>(list),
        _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits),
                                    _mm256_loadu_si256(reinterpret_cast<const __m256i *>(child))));
    return __builtin_popcount(bits);
#else
    int n = 0;
    for (; bits != 0; bits &= bits - 1)
        list[n++] = child[__builtin_ctz(bits)];
    return n;
#endif
}
CUTICLE_INLINE bool TraverseAny(const Tree &tree, const Query &query) {
    TraversalRay r;
    if (tree.nodes == nullptr || !Start(tree, query, &r))
        return false;
    uint32_t waiting[kMaxDepth * (kWidth - 1) + kWidth];
    waiting[0] = 0; // the root
    int n = 1;
    while (n > 0) {
        const uint32_t at = waiting[--n];
        if (at & kLeafBit) {
            if (IntersectLeaf<true>(tree, &r, at, nullptr))
                return true;
        } else {
            float enter[kWidth];
            n += Append(tree.nodes[at].child, IntersectBoxes(tree.nodes[at], r, enter), waiting + n);
        }
    }
    return false;
}
//<

bool Intersect(const Tree &tree, const Query &query, Answer *answer) { return Traverse(tree, query, answer); }
bool Occluded(const Tree &tree, const Query &query) { return TraverseAny(tree, query); }

} // namespace

//> Write the kernel's table
#define CUTICLE_STRING_OF(x) #x
#define CUTICLE_STRING(x) CUTICLE_STRING_OF(x)
extern const Kernel CUTICLE_KERNEL;
const Kernel CUTICLE_KERNEL = {&Intersect, &Occluded, CUTICLE_STRING(CUTICLE_KERNEL_NAME)};
//<

} // namespace cuticle::curve_kernel
//<
