//> Define the shell of hair and the distance to it
#include "volume/shell.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>
#include <numeric>

namespace cuticle {

namespace {

//> Set a vertex into every cell that the surface crosses
// Finds where the surface crosses the edges of a cell: the mean of the places, in cells; false if it does not
// cross any.
bool MeanCrossing(const DenseGrid<float> &density, float iso, const GridBox::Vertex &cell, Point3f *mean) {
    Vector3f sum;
    int crossings = 0;
    for (size_t axis = 0; axis < 3; ++axis)
        for (size_t k = 0; k < 4; ++k) {
            GridBox::Vertex a = cell;
            a[(axis + 1) % 3] += k & 1;
            a[(axis + 2) % 3] += k >> 1;
            const size_t at = density.box.Index(a[0], a[1], a[2]);
            const float va = density.values[at], vb = density.values[at + density.box.Stride(axis)];
            if ((va >= iso) == (vb >= iso))
                continue;
            Vector3f p{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
            p[axis] += (iso - va) / (vb - va);
            sum += p;
            ++crossings;
        }
    if (crossings > 0)
        *mean = sum / static_cast<float>(crossings);
    return crossings > 0;
}

// The vertices of the surface, in cells, in the order of their cells; and which cell has which.
struct NetVertices {
    std::vector<Point3f> points;
    std::vector<uint32_t> ofCell; // by the index of a cell's lowest corner; kNone: none
    static constexpr uint32_t kNone = ~uint32_t{0};
};

NetVertices FindNetVertices(const DenseGrid<float> &density, float iso) {
    const GridBox &box = density.box;
    NetVertices net;
    net.ofCell.assign(box.Count(), NetVertices::kNone);
    std::vector<std::vector<Point3f>> layers(box.size[2] - 1);
    ParallelFor(layers.size(), [&](size_t k) {
        Point3f p;
        for (size_t j = 0; j + 1 < box.size[1]; ++j)
            for (size_t i = 0; i + 1 < box.size[0]; ++i)
                if (MeanCrossing(density, iso, {i, j, k}, &p)) {
                    net.ofCell[box.Index(i, j, k)] = static_cast<uint32_t>(layers[k].size());
                    layers[k].push_back(p);
                }
    });
    for (size_t k = 0; k < layers.size(); ++k) {
        const auto before = static_cast<uint32_t>(net.points.size());
        for (size_t at = k * box.Stride(2); at < (k + 1) * box.Stride(2); ++at)
            if (net.ofCell[at] != NetVertices::kNone)
                net.ofCell[at] += before;
        net.points.insert(net.points.end(), layers[k].begin(), layers[k].end());
    }
    return net;
}
//<

//> Span two triangles over every edge that the surface crosses
// Between the vertices of the four cells around the edge; they face away from the denser end.
void SpanEdge(const DenseGrid<float> &density, float iso, const NetVertices &net, const GridBox::Vertex &a,
              size_t axis, std::vector<uint32_t> *indices) {
    const size_t at = density.box.Index(a[0], a[1], a[2]);
    const bool inside = density.values[at] >= iso;
    if (inside == (density.values[at + density.box.Stride(axis)] >= iso))
        return;
    const size_t one = density.box.Stride((axis + 1) % 3), two = density.box.Stride((axis + 2) % 3);
    uint32_t q[4] = {net.ofCell[at], net.ofCell[at - one], net.ofCell[at - one - two], net.ofCell[at - two]};
    if (!inside)
        std::swap(q[1], q[3]);
    const auto diagonal = [&](size_t k) { return (net.points[q[k]] - net.points[q[k + 2]]).LengthSquared(); };
    const size_t k = diagonal(0) <= diagonal(1) ? 0 : 1; // the shorter one
    for (const size_t corner : {k, k + 1, k + 2, k, k + 2, k + 3})
        indices->push_back(q[corner % 4]);
}

std::vector<uint32_t> SpanNet(const DenseGrid<float> &density, float iso, const NetVertices &net) {
    const GridBox &box = density.box;
    std::vector<std::vector<uint32_t>> layers(box.size[2] - 1);
    ParallelFor(layers.size(), [&](size_t k) {
        for (size_t j = 0; j + 1 < box.size[1]; ++j)
            for (size_t i = 0; i + 1 < box.size[0]; ++i)
                for (size_t axis = 0; axis < 3; ++axis) {
                    const GridBox::Vertex a{i, j, k};
                    if (a[(axis + 1) % 3] > 0 && a[(axis + 2) % 3] > 0) // cells on all sides
                        SpanEdge(density, iso, net, a, axis, &layers[k]);
                }
    });
    std::vector<uint32_t> indices;
    for (const auto &layer : layers)
        indices.insert(indices.end(), layer.begin(), layer.end());
    return indices;
}
//<

//> Find the distance to a triangle
float SquaredDistanceToLine(const Vector3f &ap, const Vector3f &ab, float length) {
    const float t = length > 0 ? std::clamp(Dot(ap, ab) / length, 0.f, 1.f) : 0.f;
    return (ap - ab * t).LengthSquared();
}

// The nearest point of the triangle's plane is a + v (b - a) + w (c - a); by the scalar products alone. Where
// it lies outside of the triangle the nearest point lies on a side.
float SquaredDistanceToTriangle(const Point3f &p, const Point3f &a, const Point3f &b, const Point3f &c) {
    const Vector3f ab = b - a, ac = c - a, ap = p - a;
    const float bb = Dot(ab, ab), bc = Dot(ab, ac), cc = Dot(ac, ac), pb = Dot(ap, ab), pc = Dot(ap, ac);
    const float v = cc * pb - bc * pc, w = bb * pc - bc * pb, area = bb * cc - bc * bc;
    if (v >= 0 && w >= 0 && v + w <= area && area > 0)
        return (ap - (ab * v + ac * w) / area).LengthSquared();
    return std::min({SquaredDistanceToLine(ap, ab, bb), SquaredDistanceToLine(ap, ac, cc),
                     SquaredDistanceToLine(p - b, c - b, bb - 2 * bc + cc)});
}
//<

//> Sort triangles into a tree of boxes
// Finds the nearest of many triangles: a binary tree of boxes, each around the triangles below it.
class TriangleTree {
  public:
    TriangleTree(const std::vector<Point3f> &points, const std::vector<uint32_t> &indices);
    // The nearest triangle to p and its squared distance. guess: any triangle; a near one saves time.
    struct Nearest {
        uint32_t triangle = 0;
        float squared = Infinity;
    };
    Nearest Find(const Point3f &p, uint32_t guess) const;

  private:
    static constexpr size_t kLeaf = 2; // triangles of a leaf, at most
    struct Node {
        Bounds3f bounds;
        uint32_t first, count; // of a leaf: triangles in order_; count 0: an inner node
        uint32_t right;        // of an inner node: its second child; the first follows it
    };
    void Build(size_t begin, size_t end);
    const Point3f &Corner(uint32_t triangle, size_t k) const { return points_[indices_[3 * triangle + k]]; }
    float Squared(const Point3f &p, uint32_t t) const {
        return SquaredDistanceToTriangle(p, Corner(t, 0), Corner(t, 1), Corner(t, 2));
    }

    const std::vector<Point3f> &points_;
    const std::vector<uint32_t> &indices_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;
};

TriangleTree::TriangleTree(const std::vector<Point3f> &points, const std::vector<uint32_t> &indices)
    : points_(points), indices_(indices), order_(indices.size() / 3) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(order_.size());
    Build(0, order_.size());
}

// Triangles are halved along the longest side of their box, by their first corners.
void TriangleTree::Build(size_t begin, size_t end) {
    const size_t node = nodes_.size();
    nodes_.push_back({{}, static_cast<uint32_t>(begin), static_cast<uint32_t>(end - begin), 0});
    Bounds3f bounds;
    for (size_t i = begin; i < end; ++i)
        for (size_t k = 0; k < 3; ++k)
            bounds.Extend(Corner(order_[i], k));
    nodes_[node].bounds = bounds;
    if (end - begin <= kLeaf)
        return;
    const Vector3f d = bounds.Diagonal();
    const size_t axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2, middle = (begin + end) / 2;
    const auto at = [&](size_t i) { return order_.begin() + static_cast<ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
        const float pa = Corner(a, 0)[axis], pb = Corner(b, 0)[axis];
        return pa < pb || (pa == pb && a < b);
    });
    nodes_[node].count = 0;
    Build(begin, middle);
    nodes_[node].right = static_cast<uint32_t>(nodes_.size());
    Build(middle, end);
}
//<

//> Find the nearest triangle of the tree
float SquaredDistanceToBox(const Point3f &p, const Bounds3f &b) {
    const Vector3f outside = Max(Max(b.pMin - p, p - b.pMax), Vector3f{0, 0, 0});
    return outside.LengthSquared();
}

TriangleTree::Nearest TriangleTree::Find(const Point3f &p, uint32_t guess) const {
    Nearest best{guess, Squared(p, guess)};
    struct Waiting {
        uint32_t node;
        float squared; // to its box
    };
    Waiting stack[64]; // a tree of halves is no deeper than the bits of a count
    size_t waiting = 0;
    stack[waiting++] = {0, SquaredDistanceToBox(p, nodes_[0].bounds)};
    while (waiting > 0) {
        const Waiting at = stack[--waiting];
        if (at.squared >= best.squared)
            continue;
        const Node &node = nodes_[at.node];
        for (size_t i = node.first; i < node.first + node.count; ++i)
            if (const float d = Squared(p, order_[i]); d < best.squared)
                best = {order_[i], d};
        if (node.count > 0)
            continue;
        Waiting near{at.node + 1, SquaredDistanceToBox(p, nodes_[at.node + 1].bounds)},
            far{node.right, SquaredDistanceToBox(p, nodes_[node.right].bounds)};
        if (far.squared < near.squared)
            std::swap(near, far);
        stack[waiting++] = far;
        stack[waiting++] = near;
    }
    return best;
}
//<

//> Measure the distance from every vertex
// Each vertex begins with the triangle that its neighbour in the row found.
void MeasureDistances(const DenseGrid<float> &density, const std::vector<Point3f> &points, HairShell *shell) {
    const GridBox &box = density.box;
    const TriangleTree tree(points, shell->mesh.indices);
    ParallelFor(box.size[1] * box.size[2], [&](size_t row) {
        TriangleTree::Nearest nearest;
        for (size_t i = 0; i < box.size[0]; ++i) {
            const size_t j = row % box.size[1], k = row / box.size[1], at = box.Index(i, j, k);
            nearest = tree.Find({static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)},
                                nearest.triangle);
            const float d = std::sqrt(nearest.squared) * box.cell;
            shell->distance.values[at] = density.values[at] >= shell->iso ? -d : d;
        }
    });
}
//<

} // namespace

//> Find the density that half of the mass is denser than
float MedianDensity(const DenseGrid<float> &density) {
    std::vector<float> sorted;
    for (const float d : density.values)
        if (d > 0)
            sorted.push_back(d);
    std::sort(sorted.begin(), sorted.end());
    double mass = 0, below = 0;
    for (const float d : sorted)
        mass += static_cast<double>(d);
    for (const float d : sorted)
        if ((below += static_cast<double>(d)) >= mass / 2)
            return d;
    return 0;
}
//<

//> Make the shell
float DistanceToTriangle(const Point3f &p, const Point3f &a, const Point3f &b, const Point3f &c) {
    return std::sqrt(SquaredDistanceToTriangle(p, a, b, c));
}

HairShell MakeShell(const DenseGrid<float> &density, float iso) {
    if (!(iso > 0))
        throw Error("the shell of a density of {}", iso).WithRemedy("the density on the shell is positive");
    const NetVertices net = FindNetVertices(density, iso);
    HairShell shell{iso, {net.points, {}, SpanNet(density, iso, net)}, DenseGrid<float>(density.box)};
    if (shell.mesh.indices.empty()) {
        const float most = *std::max_element(density.values.begin(), density.values.end());
        throw Error("no hair is as dense as {}", iso)
            .WithRemedy("the densest place of the grid has {}; the shell lies below that", most);
    }
    MeasureDistances(density, shell.mesh.points, &shell);
    for (Point3f &p : shell.mesh.points)
        p = density.box.origin + p * density.box.cell;
    shell.mesh.normals.resize(shell.mesh.points.size());
    ParallelForRange(shell.mesh.points.size(), 256, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const Vector3f g = SampleGradient(shell.distance, shell.mesh.points[i]);
            shell.mesh.normals[i] = g.LengthSquared() > 0 ? Normalize(g) : Vector3f{0, 0, 1};
        }
    });
    return shell;
}

// Gauss's theorem adds up the pyramids from a point to all triangles.
double HairShell::Volume() const {
    double six = 0;
    const Vector3d from(distance.box.origin);
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const Vector3d a = Vector3d(mesh.points[mesh.indices[i]]) - from,
                       b = Vector3d(mesh.points[mesh.indices[i + 1]]) - from,
                       c = Vector3d(mesh.points[mesh.indices[i + 2]]) - from;
        six += Dot(a, Cross(b, c));
    }
    return six / 6;
}
//<

} // namespace cuticle
//<
