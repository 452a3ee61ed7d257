//> Declare the tree over pieces of curves
#pragma once

#include "core/vecmath.h"
#include "shapes/curve_set_kernel.h"

#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace cuticle {

//> Bound by boxes, four floats at a time
// Four floats as one register: x, y, z and a place for a number.
typedef float Float4 __attribute__((vector_size(16)));

// A box is empty until it is extended.
struct PieceBox {
    Float4 lo{Infinity, Infinity, Infinity, Infinity}, hi{-Infinity, -Infinity, -Infinity, -Infinity};
    void Extend(const Float4 &l, const Float4 &h) {
#ifdef __SSE2__
        lo = _mm_min_ps(lo, l); // one instruction, where g++ 12 makes four of a comparison
        hi = _mm_max_ps(hi, h);
#else
        lo = lo < l ? lo : l;
        hi = hi > h ? hi : h;
#endif
    }
    void Extend(const PieceBox &b) { Extend(b.lo, b.hi); }
    // Half the surface; 0 for an empty box.
    float Area() const {
        const Float4 d = hi - lo;
        return d[0] >= 0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0;
    }
};
// A segment, or a piece of one, while the tree is built: its box, and in the fourth place of lo its number.
struct PieceReference {
    Float4 lo, hi;
    uint32_t Number() const { return std::bit_cast<uint32_t>(lo[3]); }
    void SetNumber(uint32_t number) { lo[3] = std::bit_cast<float>(number), hi[3] = 0; }
    Float4 Center() const { // twice the centre; 0 in the fourth place
        Float4 center = lo + hi;
        center[3] = 0; // a number read as a float is a tiny one, which processors multiply slowly
        return center;
    }
};
//<

//> Declare the build of the tree
// Writes the references of all pieces of some segments, boxes and numbers.
using CutSegments = std::function<void(const PieceReference *segments, size_t count, PieceReference *pieces)>;

struct BuiltCurveTree {
    std::vector<curve_kernel::CurveNode> nodes; // [0] is the root
    // The numbers of pieces, leaf by leaf. The place of a leaf's data is for now the index of its first.
    std::vector<uint32_t> pieces;
};
// Builds a tree over the pieces of segments, one or more, of which `cut` makes piecesEach. The tree is the
// same for any number of threads.
BuiltCurveTree BuildCurveTree(std::vector<PieceReference> segments, uint32_t piecesEach,
                              const CutSegments &cut);
//<

} // namespace cuticle
//<
