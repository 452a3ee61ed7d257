//> Intersect curves in the lanes of registers
// Compiled once for each instruction set: CUTICLE_KERNEL names the result, CUTICLE_LANES says how many floats
// a register holds. Everything but the table at the end has internal linkage.
#include "shapes/curve_set_kernel_exact.h"

namespace cuticle::curve_kernel {
namespace {

//> Say how many lanes the registers have
constexpr int kLanes = CUTICLE_LANES;
// Boxes come eight at a time; a narrower register takes them in two steps.
constexpr int kBoxLanes = kLanes < kWidth ? kLanes : kWidth;
//<

//> Test the capsules of a leaf
// Returns one bit for each of the leaf's n pieces, from `first` on, whose capsule the ray meets between
// nearest and farthest. All lengths are in the leaf's units.
CUTICLE_INLINE uint32_t IntersectCapsules(const LeafFrame &frame, const unsigned char *numbers, int n,
                                          int first, const TraversalRay &r, float slack) {
    using F = Pack<kLanes>::F;
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
    const F s = Min(Max(-(pa * ea + pb * eb) / (ea * ea + eb * eb + 1e-37f), zero), one);
    const F a = pa + s * ea, b = pb + s * eb;
    //<
    const F front = Min(pc, pc + ec) - radius, back = Max(pc, pc + ec) + radius;
    const auto meets = (a * a + b * b <= radius * radius) & (front <= r.farthestf * frame.units) &
                       (back >= r.nearestf * frame.units);
    return Bits(meets);
}
//<

//> Intersect a leaf
// Returns whether some piece was hit; for any-hit rays the search ends there.
template <bool Any>
CUTICLE_INLINE bool IntersectLeaf(const CurveTree &tree, TraversalRay *r, uint32_t leafRef,
                                  CurveAnswer *answer) {
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
        PieceHit best{r->farthest, 0, 0, false};
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
        answer->segment = SegmentAt(tree, piece >> tree.split);
        //<
    }
    return hit;
}
//<

//> Test the boxes of the children
// Returns one bit for each child that the ray enters; enter[i]: at what distance.
CUTICLE_INLINE uint32_t IntersectBoxes(const CurveNode &node, const TraversalRay &r, float *enter) {
    using F = Pack<kBoxLanes>::F;
    uint32_t bits = 0;
    for (int i = 0; i < kWidth; i += kBoxLanes) {
        F in = Fill<F>(r.nearestf), out = Fill<F>(r.farthestf);
        for (int c = 0; c < 3; ++c) {
            const F lo = Load<F>(node.bounds[r.isNegative[c] ? 3 + c : c] + i);
            const F hi = Load<F>(node.bounds[r.isNegative[c] ? c : 3 + c] + i);
            in = Max<F>((lo - r.of[c]) * r.inverse[c], in);
            out = Min<F>((hi - r.of[c]) * r.inverse[c], out);
        }
        __builtin_memcpy(enter + i, &in, sizeof(in));
        bits |= Bits(in <= out) << i;
    }
    return bits;
}
//<

//> Ask for a child's memory before it is needed
// Most of the children that wait are visited soon after; asked for now, their cache misses overlap.
CUTICLE_INLINE void Prefetch(const CurveTree &tree, uint32_t child) {
    const unsigned char *p = child & kLeafBit ? tree.leaves + kLeafUnit * size_t(child & kLeafPlaceMask)
                                              : reinterpret_cast<const unsigned char *>(tree.nodes + child);
    for (size_t line = 0; line < 4; ++line)
        __builtin_prefetch(p + 64 * line);
}
//<

//> Traverse the tree
// Finds the nearest hit.
CUTICLE_INLINE bool Traverse(const CurveTree &tree, const CurveQuery &query, CurveAnswer *answer) {
    TraversalRay r;
    if (tree.nodes == nullptr || !PrepareRay(tree, query, &r))
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
            const CurveNode &node = tree.nodes[at];
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
CUTICLE_INLINE bool TraverseAny(const CurveTree &tree, const CurveQuery &query) {
    TraversalRay r;
    if (tree.nodes == nullptr || !PrepareRay(tree, query, &r))
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
            const CurveNode &node = tree.nodes[at];
            alignas(64) float enter[kWidth];
            const uint32_t bits = IntersectBoxes(node, r, enter);
            if (bits == 0)
                continue;
            int nearest = __builtin_ctz(bits);
            for (uint32_t rest = bits & (bits - 1); rest != 0; rest &= rest - 1) {
                const int i = __builtin_ctz(rest);
                nearest = enter[i] < enter[nearest] ? i : nearest;
            }
            n += Append(node.child, bits & ~(1u << nearest), waiting + n);
            waiting[n++] = node.child[nearest];
        }
    }
    return false;
}
//<

bool Intersect(const CurveTree &tree, const CurveQuery &query, CurveAnswer *answer) {
    return Traverse(tree, query, answer);
}
bool Occluded(const CurveTree &tree, const CurveQuery &query) { return TraverseAny(tree, query); }

} // namespace

//> Write the kernel's table
extern const CurveKernel CUTICLE_KERNEL;
const CurveKernel CUTICLE_KERNEL = {&Intersect, &Occluded};
//<

} // namespace cuticle::curve_kernel
//<
