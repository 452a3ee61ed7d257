//> Define many curves at once
#include "shapes/curve_set.h"

#include "core/error.h"
#include "core/isa.h"
#include "core/large_pages.h"
#include "core/parallel.h"
#include "shapes/curve.h"
#include "shapes/curve_capsule.h"
#include "shapes/curve_set_kernel.h"
#include "shapes/curve_tree.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

namespace cuticle {

using namespace curve_kernel;

static_assert(sizeof(CurveNode) == 256);

namespace {

//> Find the kernel of an instruction set
const CurveKernel *KernelOf(InstructionSet isa) {
    switch (isa) {
#ifdef CUTICLE_HAVE_X86_KERNELS
    case InstructionSet::Avx512:
        return &kAvx512;
    case InstructionSet::Avx2:
        return &kAvx2;
#endif
    default:
        return &kSse2;
    }
}
//<

//> Write a leaf
// Writes frame, piece numbers and capsules to data. Lengths below minLength need not be told apart.
void WriteLeaf(const std::vector<CurveCapsule> &capsules, const std::vector<uint32_t> &pieces,
               double minLength, unsigned char *data) {
    //> Choose the frame of a leaf
    Vector3d lo = capsules[0].p, hi = lo;
    for (const CurveCapsule &capsule : capsules) {
        const Vector3d end = capsule.p + capsule.e;
        lo = Min(lo, Min(capsule.p, end)), hi = Max(hi, Max(capsule.p, end));
    }
    LeafFrame frame;
    for (int c = 0; c < 3; ++c)
        frame.origin[c] = static_cast<float>((lo[c] + hi[c]) / 2);
    const Vector3d origin(frame.origin[0], frame.origin[1], frame.origin[2]);
    double largest = std::max(minLength, 1e-20);
    for (const CurveCapsule &capsule : capsules) {
        const Vector3d p = capsule.p - origin, end = p + capsule.e;
        for (int c = 0; c < 3; ++c)
            largest = std::max({largest, std::abs(p[c]), std::abs(end[c]), std::abs(capsule.e[c])});
        largest = std::max(largest, capsule.radius);
    }
    const double step = largest / 32700; // below 2^15 by more than a radius grows
    frame.units = static_cast<float>(kAxisUnits / step);
    //<
    const size_t n = capsules.size();
    std::memcpy(data, &frame, sizeof frame);
    std::memcpy(data + sizeof frame, pieces.data(), 4 * n);
    unsigned char *numbers = data + sizeof frame + 4 * n;
    const auto put = [&](size_t place, double steps) {
        const auto number = static_cast<int16_t>(steps);
        std::memcpy(numbers + 2 * place, &number, 2);
    };
    for (size_t i = 0; i < n; ++i) {
        const Vector3d p = (capsules[i].p - origin) / step, e = capsules[i].e / step;
        size_t pair = 2 * i;
        for (const auto &[first, second] : {std::pair(p.x, p.y), std::pair(p.z, e.z), std::pair(e.x, e.y)}) {
            put(pair, std::nearbyint(first)), put(pair + 1, std::nearbyint(second));
            pair += 2 * n;
        }
        //> Let the radius make up for rounding
        // Beginning and extent are off by sqrt(3)/2 steps at most, a point of the axis by both: 1.74 steps.
        // The ray's directions are off by half a unit in each of three numbers, sqrt(3)/2 / kAxisUnits as
        // vectors, and no point is farther from the origin than sqrt(3) 32700 steps: that is 1.5 steps in
        // each of two directions, 2.13 in all.
        put(6 * n + i, std::ceil(capsules[i].radius / step + 1.74 + 2.13));
        //<
    }
}
//<

} // namespace

//> List what a curve set holds
// A segment as the kernels read it, in one cache line.
struct alignas(kSegmentWords * sizeof(float)) AlignedSegment {
    CurveSegment segment;
};
struct CurveSet::Data {
    LargePages segmentPages;
    AlignedSegment *segments = nullptr;
    size_t segmentCount = 0;
    std::vector<CurveType> groupTypes;
    std::vector<uint32_t> ribbonOf; // by segment; empty where there are no ribbons
    std::vector<RibbonNormals> ribbonNormals;
    LargePages nodes, leaves;
    std::vector<double> pieceMatrix;
    Bounds3f bounds;
    size_t dropped = 0;
    InstructionSet isa = InstructionSet::Sse2;
    const CurveKernel *kernel = nullptr;
    CurveTree tree;

    void SortRibbons(const std::unordered_map<uint32_t, RibbonNormals> &ribbons);
    std::vector<PieceReference> CutIntoPieces();
    void WriteLeaves(std::vector<CurveNode> *built, const std::vector<PieceReference> &references);
};
//<

//> Keep the ribbons' normals
// Keeps the normals of segments that are ribbons, scaled to unit length; one without direction makes the
// ribbon a flat curve.
void CurveSet::Data::SortRibbons(const std::unordered_map<uint32_t, RibbonNormals> &ribbons) {
    for (const auto &[index, normals] : ribbons) {
        if (index >= segmentCount)
            continue;
        const uint32_t group = segments[index].segment.group;
        const float l0 = normals.n[0].Length(), l1 = normals.n[1].Length();
        if (group >= groupTypes.size() || groupTypes[group] != CurveType::Ribbon || !(l0 > 0 && l1 > 0) ||
            !std::isfinite(l0) || !std::isfinite(l1))
            continue;
        if (ribbonOf.empty())
            ribbonOf.assign(segmentCount, kNoRibbon);
        ribbonOf[index] = static_cast<uint32_t>(ribbonNormals.size());
        ribbonNormals.push_back({{normals.n[0] / l0, normals.n[1] / l1}});
    }
}
//<

//> Cut the segments into pieces
std::vector<PieceReference> CurveSet::Data::CutIntoPieces() {
    const uint32_t pieces = 1u << tree.split;
    for (uint32_t i = 0; i < pieces; ++i) {
        const double share = 1.0 / pieces;
        pieceMatrix.resize(pieceMatrix.size() + 16);
        PieceMatrix(i * share - kPieceSlack, (i + 1) * share + kPieceSlack, &pieceMatrix[16 * size_t(i)]);
    }
    //> Collect the usable segments and the size of the world
    std::vector<uint32_t> usable;
    usable.reserve(segmentCount);
    float largest = 0;
    for (uint32_t i = 0; i < segmentCount; ++i) {
        const CurveSegment &s = segments[i].segment;
        if (!IsUsable(s)) {
            ++dropped;
            continue;
        }
        usable.push_back(i);
        for (const Point3f &p : s.cp)
            largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        largest = std::max({largest, s.width[0], s.width[1]});
    }
    // A distance between two points of the bounds, computed in the ray's frame, has about 20 roundings.
    tree.slack = 2e-6f * largest;
    const float padding = 1e-6f * largest;
    //<

    std::vector<PieceReference> references(usable.size() << tree.split);
    ParallelForRange(usable.size(), 4096, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            for (uint32_t j = 0; j < pieces; ++j) {
                const double u0 = double(j) / pieces - kPieceSlack, u1 = double(j + 1) / pieces + kPieceSlack;
                const PieceShape shape =
                    ShapeOfPiece(segments[usable[i]].segment, &pieceMatrix[16 * size_t(j)], u0, u1);
                const Vector3d lo = Min(Min(shape.p[0], shape.p[1]), Min(shape.p[2], shape.p[3]));
                const Vector3d hi = Max(Max(shape.p[0], shape.p[1]), Max(shape.p[2], shape.p[3]));
                PieceReference &r = references[(i << tree.split) + j];
                for (int c = 0; c < 3; ++c) {
                    r.lo[c] = static_cast<float>(lo[c] - shape.radius) - padding;
                    r.hi[c] = static_cast<float>(hi[c] + shape.radius) + padding;
                }
                r.lo[3] = std::bit_cast<float>(usable[i] << tree.split | j);
                r.hi[3] = 0;
            }
    });
    return references;
}
//<

//> Write the leaves
void CurveSet::Data::WriteLeaves(std::vector<CurveNode> *built,
                                 const std::vector<PieceReference> &references) {
    //> Give each leaf its place
    std::vector<uint32_t> first; // reference of each leaf, in the order of the nodes
    uint32_t place = 0;
    for (CurveNode &node : *built)
        for (uint32_t &c : node.child)
            if (c & kLeafBit) {
                const uint32_t n = ((c >> kLeafCountShift) & 15) + 1;
                first.push_back(c & kLeafPlaceMask);
                c = (c & ~kLeafPlaceMask) | place;
                place += static_cast<uint32_t>((LeafBytes(n) + kLeafUnit - 1) / kLeafUnit);
                if (place > kLeafPlaceMask)
                    throw Error("too many curves for one set");
            }
    leaves = LargePages(place * kLeafUnit + kLeafPadding);
    nodes = LargePages(built->size() * sizeof(CurveNode));
    std::memcpy(nodes.Data(), built->data(), built->size() * sizeof(CurveNode));
    //<

    //> Fill the leaves
    std::vector<uint32_t> firstOfNode(built->size() + 1, 0);
    for (size_t i = 0; i < built->size(); ++i) {
        firstOfNode[i + 1] = firstOfNode[i];
        for (const uint32_t c : (*built)[i].child)
            firstOfNode[i + 1] += c >> 31;
    }
    ParallelForRange(built->size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            uint32_t leaf = firstOfNode[i];
            for (const uint32_t c : (*built)[i].child) {
                if (!(c & kLeafBit))
                    continue;
                const uint32_t n = ((c >> kLeafCountShift) & 15) + 1;
                std::vector<CurveCapsule> capsules(n);
                std::vector<uint32_t> pieces(n);
                for (uint32_t k = 0; k < n; ++k) {
                    const uint32_t piece = pieces[k] = references[first[leaf] + k].Piece();
                    const uint32_t j = piece & ((1u << tree.split) - 1);
                    const double share = 1.0 / (1 << tree.split);
                    const PieceShape shape =
                        ShapeOfPiece(segments[piece >> tree.split].segment, &pieceMatrix[16 * size_t(j)],
                                     j * share - kPieceSlack, (j + 1) * share + kPieceSlack);
                    capsules[k] = CapsuleOf(shape);
                }
                WriteLeaf(capsules, pieces, tree.slack,
                          leaves.Data() + kLeafUnit * size_t(c & kLeafPlaceMask));
                ++leaf;
            }
        }
    });
    //<
}
//<

//> Build the set
namespace {
// Eight pieces for each segment let rays through up to 1.4 times as fast as four, but take 255 bytes a
// segment against 160 and twice the time to build: worth it up to half a million segments.
int DefaultSplit(size_t segments) { return segments > (size_t(1) << 19) ? 2 : 3; }
} // namespace

CurveSet::CurveSet(std::vector<CurveSegment> segments, std::vector<CurveType> groupTypes,
                   const std::unordered_map<uint32_t, RibbonNormals> &ribbons, const CurveSetOptions &options)
    : data_(std::make_unique<Data>()) {
    Data &d = *data_;
    d.isa = ChooseIsa(options.isa);
    d.kernel = KernelOf(d.isa);
    d.segmentCount = segments.size();
    d.segmentPages = LargePages(segments.size() * sizeof(AlignedSegment));
    d.segments = reinterpret_cast<AlignedSegment *>(d.segmentPages.Data());
    for (size_t i = 0; i < segments.size(); ++i)
        std::construct_at(d.segments + i, AlignedSegment{segments[i]});
    segments = {};
    d.groupTypes = std::move(groupTypes);
    d.tree.split = std::clamp(options.split < 0 ? DefaultSplit(d.segmentCount) : options.split, 0, 4);
    d.tree.selfReach = std::max(options.selfReach, 0.f);
    if (d.segmentCount << d.tree.split > kLeafPlaceMask)
        throw Error("too many curves for one set: {}", d.segmentCount);
    d.SortRibbons(ribbons);
    std::vector<PieceReference> references = d.CutIntoPieces();
    if (references.empty())
        return;
    std::vector<CurveNode> built = BuildCurveTree(&references);
    d.WriteLeaves(&built, references);

    //> Hand the tree to the kernel
    PieceBox all;
    for (size_t i = 0; i < kWidth; ++i)
        if (built[0].child[i] != 0)
            all.Extend(Float4{built[0].bounds[0][i], built[0].bounds[1][i], built[0].bounds[2][i], 0},
                       Float4{built[0].bounds[3][i], built[0].bounds[4][i], built[0].bounds[5][i], 0});
    d.bounds.Extend({{all.lo[0], all.lo[1], all.lo[2]}, {all.hi[0], all.hi[1], all.hi[2]}});
    for (int c = 0; c < 3; ++c)
        d.tree.bounds[c] = all.lo[c], d.tree.bounds[3 + c] = all.hi[c];
    d.tree.nodes = reinterpret_cast<const CurveNode *>(d.nodes.Data());
    d.tree.leaves = d.leaves.Data();
    d.tree.segments = reinterpret_cast<const float *>(d.segments);
    d.tree.segmentCount = static_cast<uint32_t>(d.segmentCount);
    d.tree.pieceMatrix = d.pieceMatrix.data();
    if (!d.ribbonOf.empty()) {
        d.tree.ribbonOf = d.ribbonOf.data();
        d.tree.ribbonNormals = &d.ribbonNormals[0].n[0].x;
    }
    //<
}
//<

//> Ask the kernel
namespace {
CurveQuery MakeQuery(const Ray &ray, const CurveOrigin *origin) {
    CurveQuery q{{ray.o.x, ray.o.y, ray.o.z}, {ray.d.x, ray.d.y, ray.d.z}, ray.tMin, ray.tMax};
    if (origin)
        q.originSegment = origin->segment, q.originU = std::clamp(origin->u, 0.f, 1.f);
    return q;
}
} // namespace

bool CurveSet::Intersect(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const {
    CurveAnswer answer;
    if (!data_->kernel->intersect(data_->tree, MakeQuery(ray, origin), &answer))
        return false;
    *hit = {answer.t, answer.u, answer.v, answer.segment};
    return true;
}
bool CurveSet::Occluded(const Ray &ray, const CurveOrigin *origin) const {
    return data_->kernel->occluded(data_->tree, MakeQuery(ray, origin));
}
CurveSurface CurveSet::Surface(const Ray &ray, const CurveHit &hit) const {
    return MakeCurveSurface(Segment(hit.segment), Type(hit.segment), Ribbon(hit.segment), ray, hit);
}
//<

//> Tell what the set holds
CurveSet::CurveSet() : CurveSet({}, {}) {}
CurveSet::~CurveSet() = default;
CurveSet::CurveSet(CurveSet &&) noexcept = default;
CurveSet &CurveSet::operator=(CurveSet &&) noexcept = default;

Bounds3f CurveSet::WorldBound() const { return data_->bounds; }
size_t CurveSet::SegmentCount() const { return data_->segmentCount; }
size_t CurveSet::DroppedSegments() const { return data_->dropped; }
size_t CurveSet::MemoryBytes() const {
    return data_->segmentPages.Size() + data_->groupTypes.capacity() +
           data_->ribbonOf.capacity() * sizeof(uint32_t) +
           data_->ribbonNormals.capacity() * sizeof(RibbonNormals) + data_->nodes.Size() +
           data_->leaves.Size() + data_->pieceMatrix.capacity() * sizeof(double) + sizeof(Data);
}
const CurveSegment &CurveSet::Segment(uint32_t i) const { return data_->segments[i].segment; }
CurveType CurveSet::Type(uint32_t i) const {
    const uint32_t group = data_->segments[i].segment.group;
    return group < data_->groupTypes.size() ? data_->groupTypes[group] : CurveType::Flat;
}
const RibbonNormals *CurveSet::Ribbon(uint32_t i) const {
    if (data_->ribbonOf.empty() || data_->ribbonOf[i] == kNoRibbon)
        return nullptr;
    return &data_->ribbonNormals[data_->ribbonOf[i]];
}
const char *CurveSet::Isa() const { return IsaName(data_->isa); }
//<

} // namespace cuticle
//<
