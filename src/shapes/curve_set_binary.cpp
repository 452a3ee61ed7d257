//> Define the plain baseline
#include "shapes/curve.h"
#include "shapes/curve_set.h"

#include <array>

namespace cuticle {
namespace {

//> Lay out a binary tree in one array
// The first child of an inner node follows it; `next` is the second child, or a leaf's first primitive.
struct BinaryNode {
    Bounds3f bounds;
    uint32_t next;
    uint16_t count; // primitives of a leaf; 0: an inner node
    uint16_t axis;  // along which the children were parted
};
constexpr size_t kMaxInLeaf = 4; // primitives

// A part [u0, u1] of a segment, as pbrt-v3 makes a shape of it.
struct Primitive {
    uint32_t segment;
    float u0, u1;
};
struct Item {
    Bounds3f bounds;
    Point3f center;
    Primitive primitive;
};
//<

} // namespace

//> List what the plain tree holds
struct BinaryCurveBvh::Data {
    std::vector<CurveSegment> segments;
    std::vector<CurveType> groupTypes;
    std::unordered_map<uint32_t, RibbonNormals> ribbons;
    std::vector<BinaryNode> nodes;
    std::vector<Primitive> primitives;
    int maxDepth = 10;

    CurveType Type(uint32_t i) const {
        const uint32_t group = segments[i].group;
        return group < groupTypes.size() ? groupTypes[group] : CurveType::Flat;
    }
    const RibbonNormals *Ribbon(uint32_t i) const {
        const auto found = Type(i) == CurveType::Ribbon ? ribbons.find(i) : ribbons.end();
        return found == ribbons.end() ? nullptr : &found->second;
    }
    void Build(std::vector<Item> *items, size_t first, size_t count, int depth);
    template <bool Any>
    bool Traverse(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const;
};
//<

//> Build it by the surface-area heuristic
// Sorts the primitives [first, first + count) into twelve buckets along the widest axis of their centres,
// cuts where it is cheapest, and does the same with both sides; at most four primitives make a leaf.
void BinaryCurveBvh::Data::Build(std::vector<Item> *items, size_t first, size_t count, int depth) {
    const auto begin = items->begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(count);
    Bounds3f bounds, centers;
    for (auto i = begin; i != end; ++i)
        bounds.Extend(i->bounds), centers.Extend(i->center);
    const size_t self = nodes.size();
    nodes.push_back({bounds, 0, 0, 0});
    const Vector3f extent = centers.Diagonal();
    const int axis = extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);

    size_t left = count / 2;
    bool leaf = count == 1;
    if (extent[axis] > 0 && !leaf && depth < 60) {
        //> Choose the cheapest of eleven cuts
        constexpr size_t kBuckets = 12;
        const auto bucket = [&](const Item &item) {
            const float place = kBuckets * ((item.center[axis] - centers.pMin[axis]) / extent[axis]);
            return std::min(static_cast<size_t>(place), kBuckets - 1);
        };
        std::array<Bounds3f, kBuckets> box;
        std::array<size_t, kBuckets> n{};
        for (auto i = begin; i != end; ++i) {
            const size_t b = bucket(*i);
            box[b].Extend(i->bounds);
            ++n[b];
        }
        float best = Infinity;
        size_t cut = 0;
        for (size_t c = 0; c + 1 < kBuckets; ++c) {
            Bounds3f b0, b1;
            size_t n0 = 0, n1 = 0;
            for (size_t i = 0; i < kBuckets; ++i)
                if (i <= c)
                    b0.Extend(box[i]), n0 += n[i];
                else
                    b1.Extend(box[i]), n1 += n[i];
            const float cost =
                static_cast<float>(n0) * b0.SurfaceArea() + static_cast<float>(n1) * b1.SurfaceArea();
            if (n0 > 0 && n1 > 0 && cost < best)
                best = cost, cut = c;
        }
        //<
        leaf = count <= kMaxInLeaf && !(1 + best / bounds.SurfaceArea() < static_cast<float>(count));
        if (!leaf)
            left = static_cast<size_t>(
                std::partition(begin, end, [&](const Item &item) { return bucket(item) <= cut; }) - begin);
    } else {
        leaf = leaf || count <= kMaxInLeaf;
    }
    if (leaf) {
        //> Write a leaf
        nodes[self].next = static_cast<uint32_t>(primitives.size());
        nodes[self].count = static_cast<uint16_t>(count);
        for (auto i = begin; i != end; ++i)
            primitives.push_back(i->primitive);
        return;
        //<
    }
    nodes[self].axis = static_cast<uint16_t>(axis);
    Build(items, first, left, depth + 1);
    nodes[self].next = static_cast<uint32_t>(nodes.size());
    Build(items, first + left, count - left, depth + 1);
}
//<

//> Cut every segment in parts and build over them
BinaryCurveBvh::BinaryCurveBvh(const CurveList &segments, std::vector<CurveType> groupTypes,
                               std::unordered_map<uint32_t, RibbonNormals> ribbons, int splitDepth,
                               int maxDepth)
    : data_(std::make_unique<Data>()) {
    data_->segments.reserve(segments.size());
    for (const CurveSegment &segment : segments)
        data_->segments.push_back(segment);
    data_->groupTypes = std::move(groupTypes);
    data_->ribbons = std::move(ribbons);
    data_->maxDepth = std::clamp(maxDepth, 0, 20);
    const uint32_t pieces = 1u << std::clamp(splitDepth, 0, 8);
    std::vector<Item> items;
    items.reserve(data_->segments.size() * pieces);
    for (uint32_t s = 0; s < data_->segments.size(); ++s) {
        const CurveSegment &segment = data_->segments[s];
        if (!IsUsable(segment))
            continue;
        for (uint32_t i = 0; i < pieces; ++i) {
            //> Bound one piece
            const float u0 = static_cast<float>(i) / static_cast<float>(pieces);
            const float u1 = static_cast<float>(i + 1) / static_cast<float>(pieces);
            Bounds3f b;
            const Vector3d cp[4] = {Vector3d(segment.cp[0]), Vector3d(segment.cp[1]), Vector3d(segment.cp[2]),
                                    Vector3d(segment.cp[3])};
            Vector3d d0, d1;
            const Vector3d p0 = EvalBezier(cp, u0, &d0), p1 = EvalBezier(cp, u1, &d1);
            const double third = (double(u1) - u0) / 3;
            for (const Vector3d &p : {p0, p0 + d0 * third, p1 - d1 * third, p1})
                b.Extend(Point3f(p));
            const float radius = 0.5f * std::max(Lerp(u0, segment.width[0], segment.width[1]),
                                                 Lerp(u1, segment.width[0], segment.width[1]));
            b.pMin -= Vector3f(radius, radius, radius);
            b.pMax += Vector3f(radius, radius, radius);
            items.push_back({b, b.Center(), {s, u0, u1}});
            //<
        }
    }
    if (!items.empty())
        data_->Build(&items, 0, items.size(), 0);
}
//<

//> Intersect a box
namespace {
bool IntersectsBox(const Bounds3f &b, const Point3f &o, const Vector3f &inverse, float tMin, float tMax) {
    for (int c = 0; c < 3; ++c) {
        float t0 = (b.pMin[c] - o[c]) * inverse[c], t1 = (b.pMax[c] - o[c]) * inverse[c];
        if (t0 > t1)
            std::swap(t0, t1);
        t1 *= 1 + 4 * 0x1p-23f; // rounding must not lose a hit
        tMin = t0 > tMin ? t0 : tMin;
        tMax = t1 < tMax ? t1 : tMax;
        if (tMin > tMax)
            return false;
    }
    return true;
}
} // namespace
//<

//> Traverse it
template <bool Any>
bool BinaryCurveBvh::Data::Traverse(const Ray &givenRay, const CurveOrigin *origin, CurveHit *hit) const {
    Ray ray = givenRay;
    const float length = ray.d.Length();
    if (nodes.empty() || !(length > 0) || !IsFinite(ray.d) || !IsFinite(ray.o))
        return false;
    //> Start two widths away from a curve that the ray leaves
    if (origin) {
        const CurveSegment &s = segments[origin->segment];
        ray.tMin = std::max(ray.tMin, 2 * Lerp(origin->u, s.width[0], s.width[1]) / length);
    }
    //<
    const Vector3f inverse(1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z);
    uint32_t stack[128]; // the build halves by number below depth 60
    int top = 0;
    uint32_t at = 0;
    bool found = false;
    for (;;) {
        const BinaryNode &node = nodes[at];
        if (IntersectsBox(node.bounds, ray.o, inverse, ray.tMin, ray.tMax)) {
            if (node.count == 0) {
                const bool backward = ray.d[node.axis] < 0;
                stack[top++] = backward ? at + 1 : node.next;
                at = backward ? node.next : at + 1;
                continue;
            }
            //> Intersect the parts of a leaf, one after the other
            for (uint32_t i = node.next; i < node.next + node.count; ++i) {
                const Primitive &p = primitives[i];
                CurveSearch<float> search(segments[p.segment], Ribbon(p.segment), ray, 0.05f, maxDepth);
                if (!search.Intersect(p.u0, p.u1))
                    continue;
                if constexpr (Any)
                    return true;
                found = true;
                *hit = search.Hit();
                hit->segment = p.segment;
                ray.tMax = hit->t;
            }
            //<
        }
        if (top == 0)
            return found;
        at = stack[--top];
    }
}
bool BinaryCurveBvh::Intersect(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const {
    return data_->Traverse<false>(ray, origin, hit);
}
bool BinaryCurveBvh::Occluded(const Ray &ray, const CurveOrigin *origin) const {
    return data_->Traverse<true>(ray, origin, nullptr);
}
//<

//> Tell what the plain tree holds
BinaryCurveBvh::~BinaryCurveBvh() = default;
BinaryCurveBvh::BinaryCurveBvh(BinaryCurveBvh &&) noexcept = default;
BinaryCurveBvh &BinaryCurveBvh::operator=(BinaryCurveBvh &&) noexcept = default;

CurveSurface BinaryCurveBvh::Surface(const Ray &ray, const CurveHit &hit) const {
    return MakeCurveSurface(Segment(hit.segment), data_->Type(hit.segment), data_->Ribbon(hit.segment), ray,
                            hit);
}
Bounds3f BinaryCurveBvh::WorldBound() const {
    return data_->nodes.empty() ? Bounds3f() : data_->nodes[0].bounds;
}
size_t BinaryCurveBvh::SegmentCount() const { return data_->segments.size(); }
size_t BinaryCurveBvh::MemoryBytes() const {
    return data_->segments.capacity() * sizeof(CurveSegment) + data_->groupTypes.capacity() +
           data_->ribbons.size() * (sizeof(RibbonNormals) + 4 * sizeof(void *)) +
           data_->nodes.capacity() * sizeof(BinaryNode) + data_->primitives.capacity() * sizeof(Primitive) +
           sizeof(Data);
}
const CurveSegment &BinaryCurveBvh::Segment(uint32_t i) const { return data_->segments[i]; }
//<

} // namespace cuticle
//<
