//> Build the tree over pieces of curves
#include "shapes/curve_tree.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>

namespace cuticle {

using namespace curve_kernel;

namespace {

//> Name the parts of the build
// References [first, first + count) and a box around them.
struct PieceRange {
    uint32_t first, count;
    PieceBox box;
};
// A node of the binary tree from which the bottom of the tree is made.
struct BinaryPart {
    PieceRange range;
    uint32_t left = 0, right = 0; // indices in the tree, behind this one's; 0: none
};
//<

//> Plan wide nodes over a binary tree
// The least that the pieces below a part of the binary tree cost, in surface of boxes visited.
struct CollapsePlan {
    std::array<float, kWidth> cost; // as at most 1, 2, ... 8 children of one wide node
    bool isLeaf;                    // as one child: a leaf, not a node
};
//<

//> Declare the builder of the tree
constexpr int kBins = 64;
constexpr uint32_t kParallelPieces = 1 << 14;    // with fewer, segments are cut and the bottom is built
constexpr uint32_t kParallelBinPieces = 1 << 17; // from so many on, pieces are counted into bins in parallel
constexpr uint32_t kMaxAllAxes = 1 << 10;        // larger ranges are cut across their longest axis only
constexpr uint32_t kMaxUnsplit = 8;              // ranges of so few pieces are not split any more
constexpr int kMedianDepth = 36; // below this depth ranges are halved by number: bounds the depth
// Above and below kParallelPieces the depth is counted anew; halving by number takes 14 levels below, at most
// 6 above.
static_assert(2 * kMedianDepth + 6 + 14 < kMaxDepth);

// Puts references in order: splits a range of them in two.
class RangeSplitter {
  public:
    explicit RangeSplitter(std::vector<PieceReference> *references) : refs_(references->data()) {}
    PieceBox BoxOf(uint32_t first, uint32_t count) const;
    // Splits a range of two references or more in two that are not empty. Ranges of one centre, and all where
    // byNumber is set, are halved by number.
    void Split(const PieceRange &range, bool byNumber, PieceRange *left, PieceRange *right);

  private:
    PieceBox CenterBox(uint32_t first, uint32_t count) const;
    bool SplitByPlace(const PieceRange &range, PieceRange *left, PieceRange *right);

    PieceReference *refs_;
};

// Makes nodes over segments, and over their pieces at the bottom.
class CurveTreeBuilder {
  public:
    CurveTreeBuilder(std::vector<PieceReference> *segments, uint32_t piecesEach, const CutSegments &cut)
        : segments_(*segments), piecesEach_(piecesEach), cut_(cut), splitter_(segments) {}
    BuiltCurveTree Build();

  private:
    // What a node may have as a child, and a box round it.
    struct BuiltChild {
        uint32_t child = 0;
        PieceBox box;
    };
    BuiltChild BuildNode(const PieceRange &segments, int depth, std::vector<CurveNode> *nodes);
    BuiltChild BuildBelow(const PieceRange &segments, std::vector<CurveNode> *nodes);

    const std::vector<PieceReference> &segments_;
    const uint32_t piecesEach_;
    const CutSegments &cut_;
    RangeSplitter splitter_;
    BuiltCurveTree built_;
};
//<

//> Estimate what a leaf costs
// Returns the cost of a leaf of n pieces in visits to a node: half for the visit, half for each register of
// capsules.
float LeafCost(uint32_t n) {
    const uint32_t registers = (n + 15) / 16;
    return 0.5f + 0.5f * static_cast<float>(registers);
}
//<

//> Reduce many pieces in parallel
// Adds the references [first, first + count) to *result, which comes with nothing in it.
template <typename Result, typename Add>
void ReducePieces(uint32_t first, uint32_t count, uint32_t parallelFrom, Result *result, const Add &add) {
    if (count < parallelFrom) {
        add(first, first + count, result);
        return;
    }
    // Minimum, maximum and counts do not depend on the order in which the parts are joined.
    *result = ParallelReduce(
        count, 1 << 14, *result,
        [&](size_t begin, size_t end) {
            Result r = *result;
            add(first + begin, first + end, &r);
            return r;
        },
        [](Result *total, const Result &part) { total->Extend(part); });
}
PieceBox RangeSplitter::BoxOf(uint32_t first, uint32_t count) const {
    PieceBox all;
    ReducePieces(first, count, kParallelBinPieces, &all, [&](size_t begin, size_t end, PieceBox *box) {
        for (size_t i = begin; i < end; ++i)
            box->Extend(refs_[i].lo, refs_[i].hi);
    });
    return all;
}
PieceBox RangeSplitter::CenterBox(uint32_t first, uint32_t count) const {
    PieceBox all;
    ReducePieces(first, count, kParallelBinPieces, &all, [&](size_t begin, size_t end, PieceBox *box) {
        for (size_t i = begin; i < end; ++i)
            box->Extend(refs_[i].Center(), refs_[i].Center());
    });
    return all;
}
//<

//> Sort centres into bins
// A grid over the centres of n pieces: it says in which bin along each axis a piece is.
struct BinGrid {
    BinGrid(const PieceBox &centers, uint32_t n)
        : lo(centers.lo), extent(centers.hi - centers.lo),
          used(static_cast<int>(std::min(n, static_cast<uint32_t>(kBins)))) {
        for (int c = 0; c < 3; ++c)
            scale[c] = extent[c] > 0 ? static_cast<float>(used) * 0.9999f / extent[c] : 0;
        //> Choose the axes to try
        // All three; but only the longest where there are many pieces, which saves a third of the build and
        // no ray sees.
        const int longest =
            extent[0] > extent[1] ? (extent[0] > extent[2] ? 0 : 2) : (extent[1] > extent[2] ? 1 : 2);
        firstAxis = n > kMaxAllAxes ? longest : 0;
        lastAxis = n > kMaxAllAxes ? longest + 1 : 3;
        //<
    }
    Float4 Place(const PieceReference &r) const { return (r.Center() - lo) * scale; }
    int Bin(float place) const { return std::min(static_cast<int>(place), used - 1); }

    Float4 lo, extent, scale{};
    int used;                // bins along each axis
    int firstAxis, lastAxis; // the axes [firstAxis, lastAxis) are tried
};
struct SplitBins {
    explicit SplitBins(int n) : used(n) {
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < used; ++i)
                box[c][i] = PieceBox(), count[c][i] = 0;
    }
    void Extend(const SplitBins &o) {
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < used; ++i)
                box[c][i].Extend(o.box[c][i]), count[c][i] += o.count[c][i];
    }
    int used;
    union { // no time is spent on bins that are not used
        PieceBox box[3][kBins];
    };
    uint32_t count[3][kBins];
};
//<

//> Find the cheapest cut
// The cut along `axis` behind `bin`; axis is -1 where there is none.
struct SplitPlane {
    float cost = Infinity;
    int axis = -1, bin = 0;
};
SplitPlane FindCheapestCut(const BinGrid &grid, const SplitBins &bins) {
    SplitPlane best;
    for (int c = grid.firstAxis; c < grid.lastAxis; ++c) {
        if (!(grid.extent[c] > 0))
            continue;
        float rightCost[kBins] = {};
        PieceBox box;
        uint32_t count = 0;
        for (int i = grid.used - 1; i > 0; --i) {
            box.Extend(bins.box[c][i]);
            count += bins.count[c][i];
            rightCost[i] = count ? box.Area() * LeafCost(count) : Infinity;
        }
        box = PieceBox();
        count = 0;
        for (int i = 0; i + 1 < grid.used; ++i) {
            box.Extend(bins.box[c][i]);
            count += bins.count[c][i];
            const float cost = (count ? box.Area() * LeafCost(count) : Infinity) + rightCost[i + 1];
            if (cost < best.cost)
                best = {cost, c, i};
        }
    }
    return best;
}
//<

//> Split a range where it is cheapest
// Splits by the surface-area heuristic over bins of the pieces' centres, along each axis. False where no cut
// is possible.
bool RangeSplitter::SplitByPlace(const PieceRange &range, PieceRange *left, PieceRange *right) {
    const uint32_t n = range.count, first = range.first;
    const BinGrid grid(CenterBox(first, n), n);
    if (!(std::max({grid.extent[0], grid.extent[1], grid.extent[2]}) > 0))
        return false;
    //> Count pieces into bins
    SplitBins bins(grid.used);
    ReducePieces(first, n, kParallelBinPieces, &bins, [&](size_t begin, size_t end, SplitBins *b) {
        for (size_t i = begin; i < end; ++i) {
            const PieceReference &r = refs_[i];
            const Float4 place = grid.Place(r);
            for (int c = grid.firstAxis; c < grid.lastAxis; ++c) {
                const int bin = grid.Bin(place[c]);
                b->box[c][bin].Extend(r.lo, r.hi);
                ++b->count[c][bin];
            }
        }
    });
    //<
    const SplitPlane best = FindCheapestCut(grid, bins);
    if (best.axis < 0)
        return false;
    const PieceReference *const split =
        std::partition(refs_ + first, refs_ + first + n, [&](const PieceReference &r) {
            return grid.Bin(grid.Place(r)[best.axis]) <= best.bin;
        });
    const auto middle = static_cast<uint32_t>(split - refs_);
    *left = {first, middle - first, {}};
    *right = {middle, first + n - middle, {}};
    for (int i = 0; i < grid.used; ++i)
        (i <= best.bin ? left : right)->box.Extend(bins.box[best.axis][i]);
    return true;
}
void RangeSplitter::Split(const PieceRange &range, bool byNumber, PieceRange *left, PieceRange *right) {
    if (!byNumber && SplitByPlace(range, left, right))
        return;
    const uint32_t first = range.first, inLeft = range.count / 2, inRight = range.count - inLeft;
    *left = {first, inLeft, BoxOf(first, inLeft)};
    *right = {first + inLeft, inRight, BoxOf(first + inLeft, inRight)};
}
//<

//> Write a node
// Adds a node without children. Returns its index.
size_t AddNode(std::vector<CurveNode> *nodes) {
    CurveNode node{};
    for (size_t i = 0; i < kWidth; ++i)
        for (int c = 0; c < 3; ++c)
            node.bounds[c][i] = Infinity, node.bounds[3 + c][i] = -Infinity;
    nodes->push_back(node);
    return nodes->size() - 1;
}
void SetChild(size_t i, uint32_t child, const PieceBox &box, CurveNode *node) {
    node->child[i] = child;
    for (int c = 0; c < 3; ++c)
        node->bounds[c][i] = box.lo[c], node->bounds[3 + c][i] = box.hi[c];
}
//<

//> Build the top of the tree
// A node's index is one into *nodes. Splits the largest part until there are eight, as long as there are many
// pieces.
CurveTreeBuilder::BuiltChild CurveTreeBuilder::BuildNode(const PieceRange &segments, int depth,
                                                         std::vector<CurveNode> *nodes) {
    if (size_t(segments.count) * piecesEach_ < kParallelPieces)
        return BuildBelow(segments, nodes);
    std::vector<PieceRange> child{segments};
    while (child.size() < kWidth) {
        const auto largest =
            std::max_element(child.begin(), child.end(), [](const PieceRange &a, const PieceRange &b) {
                return (a.count > 1 ? a.box.Area() : -1) < (b.count > 1 ? b.box.Area() : -1);
            });
        PieceRange left, right;
        splitter_.Split(*largest, depth > kMedianDepth, &left, &right);
        *largest = left;
        child.push_back(right);
    }

    //> Build below it
    const size_t self = AddNode(nodes);
    std::array<std::vector<CurveNode>, kWidth> below;
    std::array<BuiltChild, kWidth> built;
    ParallelFor(child.size(), [&](size_t i) { built[i] = BuildNode(child[i], depth + 1, &below[i]); });
    PieceBox box;
    for (size_t i = 0; i < child.size(); ++i) {
        const auto base = static_cast<uint32_t>(nodes->size());
        const uint32_t moved = built[i].child & kLeafBit ? built[i].child : built[i].child + base;
        SetChild(i, moved, built[i].box, &(*nodes)[self]);
        box.Extend(built[i].box);
        for (CurveNode &node : below[i])
            for (uint32_t &c : node.child)
                c += c != 0 && !(c & kLeafBit) ? base : 0;
        nodes->insert(nodes->end(), below[i].begin(), below[i].end());
        std::vector<CurveNode>().swap(below[i]); // `= {}` would keep its memory
    }
    return {static_cast<uint32_t>(self), box};
    //<
}
//<

//> Plan wide nodes over a binary tree
// Divides k children between the two parts of a node where they save most; *toLeft: how many the left one
// gets.
float SplitBudget(const CollapsePlan &left, const CollapsePlan &right, size_t k, size_t *toLeft) {
    float best = Infinity;
    for (size_t a = 1; a < k; ++a)
        if (const float cost = left.cost[a - 1] + right.cost[k - a - 1]; cost < best)
            best = cost, *toLeft = a;
    return best;
}
// left, right: the plans of the two parts; null where the range was not split.
CollapsePlan MakePlan(const PieceRange &range, const CollapsePlan *left, const CollapsePlan *right) {
    CollapsePlan plan;
    const float area = range.box.Area();
    const bool mayBeLeaf = range.count <= kLeafPieces;
    const float asLeaf = mayBeLeaf ? area * LeafCost(range.count) : Infinity;
    size_t toLeft = 0;
    const float asNode = left ? area + SplitBudget(*left, *right, kWidth, &toLeft) : Infinity;
    plan.isLeaf = mayBeLeaf && asLeaf <= asNode; // with gigantic boxes both may be infinite
    plan.cost[0] = std::min(asLeaf, asNode);
    for (size_t k = 2; k <= kWidth; ++k)
        plan.cost[k - 1] =
            left ? std::min(plan.cost[k - 2], SplitBudget(*left, *right, k, &toLeft)) : plan.cost[k - 2];
    return plan;
}
//<

//> Carry out the plan
// Appends the children of one wide node, at most k, that part i of the tree makes.
void ChooseChildren(const std::vector<BinaryPart> &tree, const std::vector<CollapsePlan> &plans, uint32_t i,
                    size_t k, std::vector<uint32_t> *chosen) {
    while (k > 1 && plans[i].cost[k - 1] == plans[i].cost[k - 2])
        --k; // more would not help
    if (k == 1) {
        chosen->push_back(i);
        return;
    }
    size_t toLeft = 1;
    SplitBudget(plans[tree[i].left], plans[tree[i].right], k, &toLeft);
    ChooseChildren(tree, plans, tree[i].left, toLeft, chosen);
    ChooseChildren(tree, plans, tree[i].right, k - toLeft, chosen);
}
// Returns what a node may have as a child. firstPlace: that of the tree's first piece.
uint32_t WritePlanned(const std::vector<BinaryPart> &tree, const std::vector<CollapsePlan> &plans, uint32_t i,
                      uint32_t firstPlace, std::vector<CurveNode> *nodes) {
    const BinaryPart &part = tree[i];
    if (plans[i].isLeaf)
        return kLeafBit | (part.range.count - 1) << kLeafCountShift | (firstPlace + part.range.first);
    size_t toLeft = 1;
    SplitBudget(plans[part.left], plans[part.right], kWidth, &toLeft);
    std::vector<uint32_t> chosen;
    ChooseChildren(tree, plans, part.left, toLeft, &chosen);
    ChooseChildren(tree, plans, part.right, kWidth - toLeft, &chosen);
    const size_t self = AddNode(nodes);
    for (size_t k = 0; k < chosen.size(); ++k) {
        const uint32_t child = WritePlanned(tree, plans, chosen[k], firstPlace, nodes);
        SetChild(k, child, tree[chosen[k]].range.box, &(*nodes)[self]);
    }
    return static_cast<uint32_t>(self);
}
//<

//> Build the bottom of the tree
void BuildBinary(const PieceRange &range, int depth, RangeSplitter *splitter, std::vector<BinaryPart> *tree) {
    const size_t self = tree->size();
    tree->push_back({range});
    if (range.count <= kMaxUnsplit)
        return;
    PieceRange left, right;
    splitter->Split(range, depth > kMedianDepth, &left, &right);
    (*tree)[self].left = static_cast<uint32_t>(tree->size());
    BuildBinary(left, depth + 1, splitter, tree);
    (*tree)[self].right = static_cast<uint32_t>(tree->size());
    BuildBinary(right, depth + 1, splitter, tree);
}
CurveTreeBuilder::BuiltChild CurveTreeBuilder::BuildBelow(const PieceRange &segments,
                                                          std::vector<CurveNode> *nodes) {
    std::vector<PieceReference> pieces(size_t(segments.count) * piecesEach_);
    cut_(&segments_[segments.first], segments.count, pieces.data());
    RangeSplitter splitter(&pieces);
    const auto count = static_cast<uint32_t>(pieces.size());
    const PieceRange all{0, count, splitter.BoxOf(0, count)};
    std::vector<BinaryPart> tree;
    BuildBinary(all, 0, &splitter, &tree);
    std::vector<CollapsePlan> plans(tree.size());
    for (size_t i = tree.size(); i-- > 0;) // parts lie behind the whole
        plans[i] = tree[i].left ? MakePlan(tree[i].range, &plans[tree[i].left], &plans[tree[i].right])
                                : MakePlan(tree[i].range, nullptr, nullptr);
    const uint32_t firstPlace = segments.first * piecesEach_;
    for (uint32_t i = 0; i < count; ++i)
        built_.pieces[firstPlace + i] = pieces[i].Number();
    return {WritePlanned(tree, plans, 0, firstPlace, nodes), all.box};
}
//<

//> Declare the builder of the tree
BuiltCurveTree CurveTreeBuilder::Build() {
    const auto count = static_cast<uint32_t>(segments_.size());
    built_.pieces.resize(segments_.size() * piecesEach_);
    std::vector<CurveNode> &nodes = built_.nodes;
    const BuiltChild root = BuildNode({0, count, splitter_.BoxOf(0, count)}, 0, &nodes);
    if (root.child & kLeafBit) // the traversal begins at a node
        SetChild(0, root.child, root.box, &nodes[AddNode(&nodes)]);
    return std::move(built_);
}
//<

} // namespace

//> Declare the builder of the tree
BuiltCurveTree BuildCurveTree(std::vector<PieceReference> segments, uint32_t piecesEach,
                              const CutSegments &cut) {
    return CurveTreeBuilder(&segments, piecesEach, cut).Build();
}
//<

} // namespace cuticle
//<
