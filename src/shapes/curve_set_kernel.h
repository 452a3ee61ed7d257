//> Declare what the kernels and the curve set share
#pragma once

// The kernels' source is compiled once for each instruction set. Anything inline that it took from a shared
// header could be emitted by all three, and the linker would keep any one of them, for every caller. So this
// header has plain data and declarations only, and the kernels include nothing of the C++ library.
#include <cstddef>
#include <cstdint>

namespace cuticle::curve_kernel {

//> Lay out the nodes of the tree
inline constexpr int kWidth = 8;       // children of a node
inline constexpr int kLeafPieces = 16; // pieces of curve in a leaf, at most
inline constexpr int kMaxDepth = 96;   // of the tree: the build keeps below it

// A child is 0 where there is none, the index of a node, or a leaf: the top bit, four bits of (number of
// pieces - 1), and the place of its data in units of 64 bytes.
inline constexpr uint32_t kLeafBit = 0x80000000u;
inline constexpr int kLeafCountShift = 27;
inline constexpr uint32_t kLeafPlaceMask = (1u << kLeafCountShift) - 1;
inline constexpr size_t kLeafUnit = 64;

// A node has the boxes of its children: bounds[axis] are their lower planes, bounds[3 + axis] the upper ones.
// A missing child is an empty box.
struct alignas(64) CurveNode {
    float bounds[6][kWidth];
    uint32_t child[kWidth];
};
//<

//> Lay out the leaves of the tree
// A leaf with n pieces: its frame, n piece numbers of 32 bits, and in numbers of 16 bits n pairs with x and y
// of where a capsule's axis begins, n pairs with z of that and z of its extent, n pairs with x and y of the
// extent, and n radii; no gap between them. Points are counted from the origin, all in steps. Loads of full
// registers run over the end of an array; the pool ends in kLeafPadding bytes for that. A piece's number is
// its segment's first point times 2^split, plus its place in the segment.
struct LeafFrame {
    float origin[3];
    float units; // in a length of 1; a step is kAxisUnits of them
};
// A unit vector in whole numbers. A point in steps times such a vector is a length in units.
inline constexpr int kAxisUnits = 32767;
inline constexpr size_t kLeafPadding = 64;
inline constexpr size_t LeafBytes(uint32_t n) { return sizeof(LeafFrame) + n * (4 + 3 * 4 + 2); }
//<

//> Lay out the segments
// A strand of n segments, each of which begins where the one before it ends, is 3 n + 1 points. Besides its
// place a point holds a word. Those of a segment's four points are its width at u = 0, the number s of its
// strand, its StrandPart, and its width at u = 1. The segment with the number i begins at point 3 i + s.
struct CurvePoint {
    float p[3];
    uint32_t word;
};
// Says which of 64 segments begin a strand, the lowest bit the first, and how many strands begin before them.
struct StrandStarts {
    uint64_t bits;
    uint32_t before;
};
//<

//> List what a kernel is given
struct CurveTree {
    const CurveNode *nodes = nullptr; // [0] is the root
    const unsigned char *leaves = nullptr;
    const CurvePoint *points = nullptr;
    const StrandStarts *starts = nullptr;
    // For each segment the index of its normals, or kNoRibbon; null: no ribbons at all.
    const uint32_t *ribbonOf = nullptr;
    const float *ribbonNormals = nullptr; // 6 numbers each
    // For each piece of a segment the matrix that takes the segment's control points to those of the piece,
    // slightly lengthened; 16 numbers, column by column.
    const double *pieceMatrix = nullptr;
    int split = 0;                        // pieces of a segment: 2^split
    float bounds[6] = {0, 0, 0, 0, 0, 0}; // of everything, as a node's
    float slack = 0;                      // error of a distance in single precision, anywhere near the bounds
    float selfReach = 0;
};
inline constexpr uint32_t kNoRibbon = 0xffffffffu;
inline constexpr uint32_t kNoPoint = 0xffffffffu;
// How much longer than its share of [0, 1] a piece is at both ends, so that rounding loses no hit at a joint.
inline constexpr double kPieceSlack = 2e-6;

// A ray as the kernels read it.
struct CurveQuery {
    float o[3], d[3];
    float tMin, tMax;
    uint32_t originPoint = kNoPoint; // the first point of the segment that it starts on
    float originU = 0;
};
struct CurveAnswer {
    float t, u, v;
    uint32_t segment;
};
//<

//> Declare a kernel
struct CurveKernel {
    bool (*intersect)(const CurveTree &, const CurveQuery &, CurveAnswer *);
    bool (*occluded)(const CurveTree &, const CurveQuery &);
};
extern const CurveKernel kSse2;
#ifdef CUTICLE_HAVE_X86_KERNELS
extern const CurveKernel kAvx2;
extern const CurveKernel kAvx512;
#endif
//<

} // namespace cuticle::curve_kernel
//<
