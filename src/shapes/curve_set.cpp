//> Define many curves at once
#include "shapes/curve_set.h"

#include "core/error.h"
#include "core/parallel.h"
#include "shapes/curve.h"
#include "shapes/curve_set_kernel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>

#ifdef __SSE2__
#include <emmintrin.h>
#endif
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace cuticle {

using namespace curve_kernel;

static_assert(sizeof(Node) == 256);

namespace {

//> Allocate memory in large pages
// Traversal jumps about in tens of megabytes; with pages of 2 MB it waits less for address translation.
class LargePages {
  public:
    LargePages() = default;
    // size bytes, all zero.
    explicit LargePages(size_t size) : size_(size) {
        constexpr size_t page = size_t(1) << 21;
        const size_t alignment = size >= page ? page : 64;
        const size_t rounded = (size + alignment - 1) / alignment * alignment;
        data_ = static_cast<unsigned char *>(std::aligned_alloc(alignment, rounded));
        if (!data_)
            throw std::bad_alloc();
#ifdef __linux__
        if (size >= page)
            madvise(data_, rounded, MADV_HUGEPAGE); // a wish: without it all works, slower
#endif
        std::memset(data_, 0, rounded);
    }
    LargePages(LargePages &&o) noexcept : data_(o.data_), size_(o.size_) { o.data_ = nullptr, o.size_ = 0; }
    LargePages &operator=(LargePages &&o) noexcept {
        std::swap(data_, o.data_), std::swap(size_, o.size_);
        return *this;
    }
    ~LargePages() { std::free(data_); }
    unsigned char *Data() const { return data_; }
    size_t Size() const { return size_; }

  private:
    unsigned char *data_ = nullptr;
    size_t size_ = 0;
};
//<

//> Choose an instruction set by name
struct IsaEntry {
    std::string_view name;
    const Kernel *kernel;
    bool (*supported)();
};
const IsaEntry kIsas[] = {
#ifdef CUTICLE_HAVE_X86_KERNELS
    {"avx512", &kAvx512,
     [] {
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
                __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("fma");
     }},
    {"avx2", &kAvx2, [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
#endif
    {"sse2", &kSse2, [] { return true; }},
};

// The one that is asked for, or the widest.
const Kernel *ChooseKernel(const std::string &option) {
    std::string wanted = option;
    std::string_view source = "the option isa";
    if (wanted.empty())
        if (const char *environment = std::getenv("CUTICLE_ISA")) {
            wanted = environment;
            source = "the environment's CUTICLE_ISA";
        }
    for (const IsaEntry &isa : kIsas) {
        if (wanted.empty() ? isa.supported() : wanted == isa.name) {
            if (!isa.supported())
                throw Error("this processor cannot run \"" + wanted + "\", which " + std::string(source) +
                            " asks for. Known are: sse2, avx2, avx512.");
            return isa.kernel;
        }
    }
    throw Error("unknown instruction set \"" + wanted + "\" in " + std::string(source) +
                ". Known are: sse2, avx2, avx512.");
}
//<

//> Bound by boxes, four floats at a time
typedef float Float4 __attribute__((vector_size(16)));
struct Box {
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
    void Extend(const Box &b) { Extend(b.lo, b.hi); }
    // Half the surface.
    float Area() const {
        const Float4 d = hi - lo;
        return d[0] >= 0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0;
    }
};
// A piece of curve while the tree is built: its box, and in the fourth place of lo its number.
struct Reference {
    Float4 lo, hi;
    uint32_t Piece() const { return std::bit_cast<uint32_t>(lo[3]); }
    Float4 Center() const { return lo + hi; } // twice the centre
};
struct Range {
    uint32_t first, count;
    Box box;
};
//<

//> Plan wide nodes over a binary tree
struct BinaryNode {
    Range range;
    uint32_t left = 0, right = 0; // places in the tree, behind this node's; 0: none
};

// What the pieces below a node of the binary tree cost at best, in surface of boxes visited.
struct Plan {
    std::array<float, kWidth> cost; // as at most 1, 2, ... 8 children of one wide node
    bool isLeaf;                    // as one child: a leaf, not a node
};
//<

//> Find the pieces of a segment
// The matrix from a cubic's control points to those of its part [u0, u1], by blossoming: the new point i is the
// blossom at 3 - i times u0 and i times u1, and a blossom is linear in the old points.
void PieceMatrix(double u0, double u1, double *columns) {
    for (int out = 0; out < 4; ++out) {
        std::array<double, 4> weight{1, 0, 0, 0}; // Bernstein weights, one argument after another
        for (int step = 0; step < 3; ++step) {
            const double u = step < 3 - out ? u0 : u1;
            std::array<double, 4> next{};
            for (size_t i = 0; i <= static_cast<size_t>(step); ++i) {
                next[i] += (1 - u) * weight[i];
                next[i + 1] += u * weight[i];
            }
            weight = next;
        }
        for (size_t in = 0; in < 4; ++in)
            columns[4 * in + static_cast<size_t>(out)] = weight[in];
    }
}

struct PieceShape {
    Vector3d p[4];
    double radius; // half the largest width
};
PieceShape ShapeOfPiece(const CurveSegment &s, const double *columns, double u0, double u1) {
    PieceShape shape;
    for (size_t out = 0; out < 4; ++out) {
        shape.p[out] = Vector3d();
        for (size_t in = 0; in < 4; ++in)
            shape.p[out] += Vector3d(s.cp[in]) * columns[4 * in + out];
    }
    const auto width = [&](double u) { return Lerp<double>(std::clamp(u, 0., 1.), s.width[0], s.width[1]); };
    shape.radius = 0.5 * std::max({width(u0), width(u1), 0.});
    return shape;
}
//<

//> Bound how far a piece strays from its chord
// The distance to a line segment is a convex function, so a curve point's is at most the Bernstein mean of those of the
// control points: the ends' are 0, and the inner two weigh at most 3/4 together.
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
// The largest of a cubic's control points in length, after it was halved twice: not far above the longest vector of the
// curve itself.
double Longest(const std::array<Vector3d, 4> &c, int halvings) {
    if (halvings == 0)
        return std::sqrt(std::max(
            {c[0].LengthSquared(), c[1].LengthSquared(), c[2].LengthSquared(), c[3].LengthSquared()}));
    const Vector3d a = (c[0] + c[1]) * 0.5, m = (c[1] + c[2]) * 0.5, b = (c[2] + c[3]) * 0.5;
    const Vector3d am = (a + m) * 0.5, mb = (m + b) * 0.5, mid = (am + mb) * 0.5;
    return std::max(Longest({c[0], a, am, mid}, halvings - 1), Longest({mid, mb, b, c[3]}, halvings - 1));
}

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
            shape.radius + Longest({Vector3d() - shift, off1 - shift, off2 - shift, Vector3d() - shift}, 2)};
    //<
}
//<

//> Declare the builder of the tree
class Builder {
  public:
    explicit Builder(std::vector<Reference> *references) : refs_(references->data()) {}
    // The tree over the references, which it puts in order. A leaf's place is for now its first reference.
    std::vector<Node> Build(uint32_t count) {
        const Range all{0, count, BoxOf(0, count)};
        std::vector<Node> nodes;
        const uint32_t root = BuildNode(all, 0, &nodes);
        if (root & kLeafBit) // the walk begins at a node
            nodes[AddNode({all}, &nodes)].child[0] = root;
        return nodes;
    }

  private:
    static constexpr int kBins = 64;
    static constexpr uint32_t kParallel = 1 << 14;    // pieces from which children are built side by side
    static constexpr uint32_t kParallelBin = 1 << 17; // and pieces are counted into bins in parallel
    static constexpr uint32_t kOneAxis = 1 << 10;     // cut larger ranges across their longest axis only
    static constexpr uint32_t kMinCount = 8;          // of so few pieces nobody makes two leaves
    static constexpr int kMedianDepth = 36;           // below, halve by number: bounds the depth
    // Above and below kParallel the depth is counted anew; to halve by number takes 14 levels below, at most 6 above.
    static_assert(2 * kMedianDepth + 6 + 14 < kMaxDepth);

    struct Bins {
        explicit Bins(int n) : used(n) {
            for (int c = 0; c < 3; ++c)
                for (int i = 0; i < used; ++i)
                    box[c][i] = Box(), count[c][i] = 0;
        }
        void Extend(const Bins &o) {
            for (int c = 0; c < 3; ++c)
                for (int i = 0; i < used; ++i)
                    box[c][i].Extend(o.box[c][i]), count[c][i] += o.count[c][i];
        }
        int used;
        union { // no time is spent on bins that are not used
            Box box[3][kBins];
        };
        uint32_t count[3][kBins];
    };

    Box BoxOf(uint32_t first, uint32_t count) const;
    Box CenterBox(uint32_t first, uint32_t count) const;
    void Split(const Range &range, bool byNumber, Range *left, Range *right);
    static size_t AddNode(const std::vector<Range> &children, std::vector<Node> *nodes);
    uint32_t BuildNode(const Range &range, int depth, std::vector<Node> *nodes);
    void BuildBinary(const Range &range, int depth, std::vector<BinaryNode> *tree);
    static uint32_t WritePlanned(const std::vector<BinaryNode> &tree, const std::vector<Plan> &plans,
                                 uint32_t i, std::vector<Node> *nodes);
    uint32_t BuildBelow(const Range &range, std::vector<Node> *nodes);

    Reference *refs_;
};
//<

//> Estimate what a leaf costs
// In units of one visit to a node: the visit, and one step for each register of capsules.
float LeafCost(uint32_t n) {
    const uint32_t registers = (n + 15) / 16;
    return 0.5f + 0.5f * static_cast<float>(registers);
}
//<

//> Gather over many pieces in parallel
// *result comes with nothing in it.
template <typename Result, typename Add>
void Gather(uint32_t first, uint32_t count, uint32_t parallelFrom, Result *result, const Add &add) {
    if (count < parallelFrom) {
        add(first, first + count, result);
        return;
    }
    // Least, greatest and counts do not depend on the order in which the parts are joined.
    *result = ParallelReduce(
        count, 1 << 14, *result,
        [&](size_t begin, size_t end) {
            Result r = *result;
            add(first + static_cast<uint32_t>(begin), first + static_cast<uint32_t>(end), &r);
            return r;
        },
        [](Result *total, const Result &piece) { total->Extend(piece); });
}
Box Builder::BoxOf(uint32_t first, uint32_t count) const {
    Box all;
    Gather(first, count, kParallelBin, &all, [&](uint32_t begin, uint32_t end, Box *box) {
        for (uint32_t i = begin; i < end; ++i)
            box->Extend(refs_[i].lo, refs_[i].hi);
    });
    return all;
}
Box Builder::CenterBox(uint32_t first, uint32_t count) const {
    Box all;
    Gather(first, count, kParallelBin, &all, [&](uint32_t begin, uint32_t end, Box *box) {
        for (uint32_t i = begin; i < end; ++i)
            box->Extend(refs_[i].Center(), refs_[i].Center());
    });
    return all;
}
//<

//> Split a range where it is cheapest
// In two that are not empty, of two pieces or more. By the surface-area heuristic over bins of the pieces' centres, along
// each axis. Ranges of one centre, and all where byNumber is set, are halved by number.
void Builder::Split(const Range &range, bool byNumber, Range *left, Range *right) {
    const uint32_t n = range.count, first = range.first;
    uint32_t middle = first + n / 2;
    const Box centers = CenterBox(first, n);
    const Float4 extent = centers.hi - centers.lo;
    if (!byNumber && std::max({extent[0], extent[1], extent[2]}) > 0) {
        const int used = static_cast<int>(std::min(n, static_cast<uint32_t>(kBins)));
        Float4 scale{};
        for (int c = 0; c < 3; ++c)
            scale[c] = extent[c] > 0 ? static_cast<float>(used) * 0.9999f / extent[c] : 0;
        //> Choose the axes to try
        // All three; but only the longest where there are many pieces, which saves a third of the build and no ray sees.
        const int longest =
            extent[0] > extent[1] ? (extent[0] > extent[2] ? 0 : 2) : (extent[1] > extent[2] ? 1 : 2);
        const int firstAxis = n > kOneAxis ? longest : 0, lastAxis = n > kOneAxis ? longest + 1 : 3;
        //<
        //> Count pieces into bins
        Bins bins(used);
        Gather(first, n, kParallelBin, &bins, [&](uint32_t begin, uint32_t end, Bins *b) {
            for (uint32_t i = begin; i < end; ++i) {
                const Reference &r = refs_[i];
                const Float4 place = (r.Center() - centers.lo) * scale;
                for (int c = firstAxis; c < lastAxis; ++c) {
                    const int bin = std::min(static_cast<int>(place[c]), used - 1);
                    b->box[c][bin].Extend(r.lo, r.hi);
                    ++b->count[c][bin];
                }
            }
        });
        //<
        //> Find the cheapest cut
        float bestCost = Infinity;
        int bestAxis = -1, bestBin = 0;
        for (int c = firstAxis; c < lastAxis; ++c) {
            if (!(extent[c] > 0))
                continue;
            std::array<float, kBins> rightCost{};
            Box box;
            uint32_t count = 0;
            for (int i = used - 1; i > 0; --i) {
                box.Extend(bins.box[c][i]);
                count += bins.count[c][i];
                rightCost[static_cast<size_t>(i)] = count ? box.Area() * LeafCost(count) : Infinity;
            }
            box = Box();
            count = 0;
            for (int i = 0; i + 1 < used; ++i) {
                box.Extend(bins.box[c][i]);
                count += bins.count[c][i];
                const float cost =
                    (count ? box.Area() * LeafCost(count) : Infinity) + rightCost[static_cast<size_t>(i) + 1];
                if (cost < bestCost)
                    bestCost = cost, bestAxis = c, bestBin = i;
            }
        }
        //<
        if (bestAxis >= 0) {
            Reference *const split =
                std::partition(refs_ + first, refs_ + first + n, [&](const Reference &r) {
                    const Float4 place = (r.Center() - centers.lo) * scale;
                    return std::min(static_cast<int>(place[bestAxis]), used - 1) <= bestBin;
                });
            middle = static_cast<uint32_t>(split - refs_);
            Box leftBox, rightBox;
            for (int i = 0; i < used; ++i)
                (i <= bestBin ? leftBox : rightBox).Extend(bins.box[bestAxis][i]);
            *left = {first, middle - first, leftBox};
            *right = {middle, first + n - middle, rightBox};
            return;
        }
    }
    *left = {first, middle - first, BoxOf(first, middle - first)};
    *right = {middle, first + n - middle, BoxOf(middle, first + n - middle)};
}
//<

//> Write a node
// With the children's boxes; the children themselves are filled in later. Returns its index.
size_t Builder::AddNode(const std::vector<Range> &children, std::vector<Node> *nodes) {
    Node node{};
    for (size_t i = 0; i < kWidth; ++i)
        for (int c = 0; c < 3; ++c) {
            node.bounds[c][i] = i < children.size() ? children[i].box.lo[c] : Infinity;
            node.bounds[3 + c][i] = i < children.size() ? children[i].box.hi[c] : -Infinity;
        }
    nodes->push_back(node);
    return nodes->size() - 1;
}
//<

//> Build the top of the tree
// Returns what a node may have as a child, a node's index being one into *nodes. Splits the largest part until there are
// eight, as long as there are many pieces.
uint32_t Builder::BuildNode(const Range &range, int depth, std::vector<Node> *nodes) {
    if (range.count < kParallel)
        return BuildBelow(range, nodes);
    std::vector<Range> child{range};
    while (child.size() < kWidth) {
        const auto largest = std::max_element(child.begin(), child.end(), [](const Range &a, const Range &b) {
            return (a.count > 1 ? a.box.Area() : -1) < (b.count > 1 ? b.box.Area() : -1);
        });
        Range left, right;
        Split(*largest, depth > kMedianDepth, &left, &right);
        *largest = left;
        child.push_back(right);
    }

    //> Build below it
    const size_t self = AddNode(child, nodes);
    std::array<std::vector<Node>, kWidth> below;
    std::array<uint32_t, kWidth> built{};
    ParallelFor(child.size(), [&](size_t i) { built[i] = BuildNode(child[i], depth + 1, &below[i]); });
    for (size_t i = 0; i < child.size(); ++i) {
        const auto base = static_cast<uint32_t>(nodes->size());
        (*nodes)[self].child[i] = built[i] & kLeafBit ? built[i] : built[i] + base;
        for (Node &node : below[i])
            for (uint32_t &c : node.child)
                c += c != 0 && !(c & kLeafBit) ? base : 0;
        nodes->insert(nodes->end(), below[i].begin(), below[i].end());
        below[i] = {};
    }
    return static_cast<uint32_t>(self);
    //<
}
//<

//> Plan wide nodes over a binary tree
// Deals k children to the two parts of a node where they save most; *toLeft: how many to the left one.
float Deal(const Plan &left, const Plan &right, size_t k, size_t *toLeft) {
    float best = Infinity;
    for (size_t a = 1; a < k; ++a)
        if (const float cost = left.cost[a - 1] + right.cost[k - a - 1]; cost < best)
            best = cost, *toLeft = a;
    return best;
}
// left, right: of the parts; null for a node without.
Plan MakePlan(const Range &range, const Plan *left, const Plan *right) {
    Plan plan;
    const float area = range.box.Area();
    const bool mayBeLeaf = range.count <= static_cast<uint32_t>(kLeafPieces);
    const float asLeaf = mayBeLeaf ? area * LeafCost(range.count) : Infinity;
    size_t toLeft = 0;
    const float asNode = left ? area + Deal(*left, *right, kWidth, &toLeft) : Infinity;
    plan.isLeaf = mayBeLeaf && asLeaf <= asNode; // of gigantic boxes both may be infinite
    plan.cost[0] = std::min(asLeaf, asNode);
    for (size_t k = 2; k <= kWidth; ++k)
        plan.cost[k - 1] =
            left ? std::min(plan.cost[k - 2], Deal(*left, *right, k, &toLeft)) : plan.cost[k - 2];
    return plan;
}
//<

//> Carry out the plan
// The children of one wide node, at most k, that part i of the tree makes.
void ChooseChildren(const std::vector<BinaryNode> &tree, const std::vector<Plan> &plans, uint32_t i, size_t k,
                    std::vector<uint32_t> *chosen) {
    while (k > 1 && plans[i].cost[k - 1] == plans[i].cost[k - 2])
        --k; // more would not help
    if (k == 1) {
        chosen->push_back(i);
        return;
    }
    size_t toLeft = 1;
    Deal(plans[tree[i].left], plans[tree[i].right], k, &toLeft);
    ChooseChildren(tree, plans, tree[i].left, toLeft, chosen);
    ChooseChildren(tree, plans, tree[i].right, k - toLeft, chosen);
}
// Returns what a node may have as a child.
uint32_t Builder::WritePlanned(const std::vector<BinaryNode> &tree, const std::vector<Plan> &plans,
                               uint32_t i, std::vector<Node> *nodes) {
    const BinaryNode &part = tree[i];
    if (plans[i].isLeaf)
        return kLeafBit | (part.range.count - 1) << kLeafCountShift | part.range.first;
    size_t toLeft = 1;
    Deal(plans[part.left], plans[part.right], kWidth, &toLeft);
    std::vector<uint32_t> chosen;
    ChooseChildren(tree, plans, part.left, toLeft, &chosen);
    ChooseChildren(tree, plans, part.right, kWidth - toLeft, &chosen);
    std::vector<Range> ranges;
    ranges.reserve(chosen.size());
    for (const uint32_t c : chosen)
        ranges.push_back(tree[c].range);
    const size_t self = AddNode(ranges, nodes);
    for (size_t k = 0; k < chosen.size(); ++k) {
        const uint32_t child = WritePlanned(tree, plans, chosen[k], nodes);
        (*nodes)[self].child[k] = child;
    }
    return static_cast<uint32_t>(self);
}
//<

//> Build the bottom of the tree
void Builder::BuildBinary(const Range &range, int depth, std::vector<BinaryNode> *tree) {
    const size_t self = tree->size();
    tree->push_back({range});
    if (range.count <= kMinCount)
        return;
    Range left, right;
    Split(range, depth > kMedianDepth, &left, &right);
    (*tree)[self].left = static_cast<uint32_t>(tree->size());
    BuildBinary(left, depth + 1, tree);
    (*tree)[self].right = static_cast<uint32_t>(tree->size());
    BuildBinary(right, depth + 1, tree);
}
uint32_t Builder::BuildBelow(const Range &range, std::vector<Node> *nodes) {
    std::vector<BinaryNode> tree;
    BuildBinary(range, 0, &tree);
    std::vector<Plan> plans(tree.size());
    for (size_t i = tree.size(); i-- > 0;) // parts lie behind the whole
        plans[i] = tree[i].left ? MakePlan(tree[i].range, &plans[tree[i].left], &plans[tree[i].right])
                                : MakePlan(tree[i].range, nullptr, nullptr);
    return WritePlanned(tree, plans, 0, nodes);
}
//<

//> Write a leaf
// Lengths below `least` need not be told apart.
void WriteLeaf(const std::vector<CurveCapsule> &capsules, const std::vector<uint32_t> &pieces, double least,
               unsigned char *data) {
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
    double largest = std::max(least, 1e-20);
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
        // Beginning and extent are off by sqrt(3)/2 steps at most, a point of the axis by both. The ray's directions are off
        // by half a unit in each of three numbers, sqrt(3)/2 / kAxisUnits as vectors, and no point is farther from the
        // origin than sqrt(3) 32700 steps: that is 1.5 steps in each of two directions.
        put(6 * n + i, std::ceil(capsules[i].radius / step + 1.74 + 2.13));
        //<
    }
}
//<

} // namespace

//> Find a capsule that holds a piece
CurveCapsule CapsuleOf(const CurveSegment &segment, double u0, double u1) {
    double columns[16];
    PieceMatrix(u0, u1, columns);
    return CapsuleOf(ShapeOfPiece(segment, columns, u0, u1));
}
//<

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
    const Kernel *kernel = nullptr;
    Tree tree;

    void SortRibbons(const std::unordered_map<uint32_t, RibbonNormals> &ribbons);
    std::vector<Reference> CutIntoPieces();
    void WriteLeaves(std::vector<Node> *built, const std::vector<Reference> &references);
};
//<

//> Keep the ribbons' normals
// Those of segments that are ribbons, scaled to unit length; a normal without direction makes the ribbon a flat curve.
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
std::vector<Reference> CurveSet::Data::CutIntoPieces() {
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
    // Of a distance between two points of the bounds, computed in the ray's frame, about 20 roundings.
    tree.slack = 2e-6f * largest;
    const float padding = 1e-6f * largest;
    //<

    std::vector<Reference> references(usable.size() << tree.split);
    ParallelForRange(usable.size(), 4096, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            for (uint32_t j = 0; j < pieces; ++j) {
                const double u0 = double(j) / pieces - kPieceSlack, u1 = double(j + 1) / pieces + kPieceSlack;
                const PieceShape shape =
                    ShapeOfPiece(segments[usable[i]].segment, &pieceMatrix[16 * size_t(j)], u0, u1);
                const Vector3d lo = Min(Min(shape.p[0], shape.p[1]), Min(shape.p[2], shape.p[3]));
                const Vector3d hi = Max(Max(shape.p[0], shape.p[1]), Max(shape.p[2], shape.p[3]));
                Reference &r = references[(i << tree.split) + j];
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
void CurveSet::Data::WriteLeaves(std::vector<Node> *built, const std::vector<Reference> &references) {
    //> Give each leaf its place
    std::vector<uint32_t> first; // reference of each leaf, in the order of the nodes
    uint32_t place = 0;
    for (Node &node : *built)
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
    nodes = LargePages(built->size() * sizeof(Node));
    std::memcpy(nodes.Data(), built->data(), built->size() * sizeof(Node));
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
// Eight pieces for each segment let rays through up to 1.4 times as fast as four, but take 255 bytes a segment against
// 160 and twice the time to build: worth it up to half a million segments.
int DefaultSplit(size_t segments) { return segments > (size_t(1) << 19) ? 2 : 3; }
} // namespace

CurveSet::CurveSet(std::vector<CurveSegment> segments, std::vector<CurveType> groupTypes,
                   const std::unordered_map<uint32_t, RibbonNormals> &ribbons, const CurveSetOptions &options)
    : data_(std::make_unique<Data>()) {
    Data &d = *data_;
    d.kernel = ChooseKernel(options.isa);
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
        throw Error("too many curves for one set: " + std::to_string(d.segmentCount));
    d.SortRibbons(ribbons);
    std::vector<Reference> references = d.CutIntoPieces();
    if (references.empty())
        return;
    std::vector<Node> built = Builder(&references).Build(static_cast<uint32_t>(references.size()));
    d.WriteLeaves(&built, references);

    //> Hand the tree to the kernel
    Box all;
    for (size_t i = 0; i < kWidth; ++i)
        if (built[0].child[i] != 0)
            all.Extend(Float4{built[0].bounds[0][i], built[0].bounds[1][i], built[0].bounds[2][i], 0},
                       Float4{built[0].bounds[3][i], built[0].bounds[4][i], built[0].bounds[5][i], 0});
    d.bounds.Extend({{all.lo[0], all.lo[1], all.lo[2]}, {all.hi[0], all.hi[1], all.hi[2]}});
    for (int c = 0; c < 3; ++c)
        d.tree.bounds[c] = all.lo[c], d.tree.bounds[3 + c] = all.hi[c];
    d.tree.nodes = reinterpret_cast<const Node *>(d.nodes.Data());
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
Query MakeQuery(const Ray &ray, const CurveOrigin *origin) {
    Query q{{ray.o.x, ray.o.y, ray.o.z}, {ray.d.x, ray.d.y, ray.d.z}, ray.tMin, ray.tMax};
    if (origin)
        q.originSegment = origin->segment, q.originU = std::clamp(origin->u, 0.f, 1.f);
    return q;
}
} // namespace

bool CurveSet::Intersect(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const {
    Answer answer;
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
const char *CurveSet::Isa() const { return data_->kernel->name; }

const char *CurveSetIsa() { return ChooseKernel("")->name; }
bool CurveSetIsaSupported(const std::string &isa) {
    for (const IsaEntry &entry : kIsas)
        if (entry.name == isa)
            return entry.supported();
    return false;
}
//<

} // namespace cuticle
//<
