//> Define the head as triangles
#include "grooms/head_mesh.h"

#include "core/check.h"
#include "core/error.h"
#include "core/parallel.h"
#include "files/file.h"
#include "grooms/head_shape.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cuticle {

namespace {

using Lattice = std::array<size_t, 3>; // x, y, z

//> List where the surface crosses a lattice
// HeadCrossings list where the surface crosses a lattice of cubes around the head. A cube is named by its
// lowest corner, a corner by its number, x fastest.
struct HeadCrossings {
    struct Cube {
        uint64_t at;
        Point3f p; // the mean of where the surface crosses the cube's edges
    };
    struct Edge {
        uint64_t at; // of its lower corner
        uint8_t axis;
        bool inside; // the lower corner
        bool operator<(const Edge &e) const { return at != e.at ? at < e.at : axis < e.axis; }
    };
    std::vector<Cube> cubes;
    std::vector<Edge> edges;
};
//<

//> Lay a lattice around the head
// Finds the crossings without looking at every cube: work and memory go with the surface and not with the
// space around it.
class HeadLattice {
  public:
    explicit HeadLattice(float spacing) : spacing_(spacing) {
        const Point3f high{24, 14, 14};
        for (size_t axis = 0; axis < 3; ++axis)
            size_[axis] = static_cast<size_t>((high[axis] - low_[axis]) / spacing) + 2;
    }
    uint64_t Index(const Lattice &at) const { return at[0] + size_[0] * (at[1] + size_[1] * at[2]); }
    // The distance between a corner's number and that of its neighbour along an axis.
    uint64_t Stride(size_t axis) const { return axis == 0 ? 1 : axis == 1 ? size_[0] : size_[0] * size_[1]; }

    //> Find all crossings
    // In the order of their numbers, whatever the number of threads.
    HeadCrossings Find() const {
        size_t side = kLeaf; // of the blocks that are looked at first, in cubes
        while (static_cast<float>(2 * side) * spacing_ <= kMaxBlock)
            side *= 2;
        Lattice blocks;
        for (size_t axis = 0; axis < 3; ++axis)
            blocks[axis] = (size_[axis] + side - 1) / side;
        HeadCrossings all = ParallelReduce(
            blocks[0] * blocks[1] * blocks[2], 16, HeadCrossings{},
            [&](size_t first, size_t last) {
                HeadCrossings found;
                for (size_t i = first; i < last; ++i)
                    Search({i % blocks[0] * side, i / blocks[0] % blocks[1] * side,
                            i / (blocks[0] * blocks[1]) * side},
                           side, &found);
                return found;
            },
            [](HeadCrossings *total, const HeadCrossings &piece) {
                total->cubes.insert(total->cubes.end(), piece.cubes.begin(), piece.cubes.end());
                total->edges.insert(total->edges.end(), piece.edges.begin(), piece.edges.end());
            });
        std::sort(all.cubes.begin(), all.cubes.end(),
                  [](const auto &a, const auto &b) { return a.at < b.at; });
        std::sort(all.edges.begin(), all.edges.end());
        return all;
    }
    //<

  private:
    static constexpr size_t kLeaf = 2;       // cubes to a side of a block that is searched one by one
    static constexpr float kMaxBlock = 1.6f; // cm
    // HeadDistance grows by no more than this from one place to another, per cm between them: 1.54, at
    // an ear, was the most in 215,000 pairs of places on both sides of the surface, up to 1.4 cm apart.
    static constexpr float kSteepest = 2.5f;

    Point3f Corner(const Lattice &at) const {
        return low_ +
               Vector3f{static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])} *
                   spacing_;
    }

    //> Search a block that the surface can reach
    void Search(const Lattice &low, size_t side, HeadCrossings *found) const {
        for (size_t axis = 0; axis < 3; ++axis)
            if (low[axis] >= size_[axis])
                return;
        const float half = static_cast<float>(side) * spacing_ / 2;
        if (std::abs(HeadDistance(Corner(low) + Vector3f{half, half, half})) > kSteepest * 1.7321f * half)
            return;
        if (side == kLeaf)
            return SearchLeaf(low, found);
        const size_t part = side / 2;
        for (size_t i = 0; i < 8; ++i)
            Search({low[0] + (i & 1) * part, low[1] + (i >> 1 & 1) * part, low[2] + (i >> 2) * part}, part,
                   found);
    }
    //<

    //> Look at the cubes of a small block
    void SearchLeaf(const Lattice &low, HeadCrossings *found) const {
        constexpr size_t n = kLeaf + 1;
        std::array<float, n * n * n> values;
        const auto value = [&](const Lattice &at) -> float & {
            return values[at[0] - low[0] + n * (at[1] - low[1] + n * (at[2] - low[2]))];
        };
        Lattice at;
        for (at[2] = low[2]; at[2] < low[2] + n; ++at[2])
            for (at[1] = low[1]; at[1] < low[1] + n; ++at[1])
                for (at[0] = low[0]; at[0] < low[0] + n; ++at[0])
                    value(at) = HeadDistance(Corner(at));
        for (at[2] = low[2]; at[2] < low[2] + kLeaf; ++at[2])
            for (at[1] = low[1]; at[1] < low[1] + kLeaf; ++at[1])
                for (at[0] = low[0]; at[0] < low[0] + kLeaf; ++at[0]) {
                    AddCube(at, value, found);
                    AddEdges(at, value, found);
                }
    }
    //<

    //> Put a vertex into a cube
    template <class Value>
    void AddCube(const Lattice &cube, const Value &value, HeadCrossings *found) const {
        for (size_t axis = 0; axis < 3; ++axis)
            if (cube[axis] + 1 >= size_[axis])
                return;
        Vector3f sum;
        int crossings = 0;
        for (size_t axis = 0; axis < 3; ++axis)
            for (size_t k = 0; k < 4; ++k) {
                Lattice a = cube;
                a[(axis + 1) % 3] += k & 1;
                a[(axis + 2) % 3] += k >> 1;
                Lattice b = a;
                ++b[axis];
                const float va = value(a), vb = value(b);
                if ((va < 0) == (vb < 0))
                    continue;
                sum += Lerp(va / (va - vb), 0.f, 1.f) * (Corner(b) - Corner(a)) + Corner(a);
                ++crossings;
            }
        if (crossings > 0)
            found->cubes.push_back({Index(cube), sum / static_cast<float>(crossings)});
    }
    //<

    //> Note an edge with cubes all around
    // Those that have cubes all around.
    template <class Value>
    void AddEdges(const Lattice &a, const Value &value, HeadCrossings *found) const {
        for (size_t axis = 0; axis < 3; ++axis)
            if (a[axis] == 0 || a[axis] + 1 >= size_[axis])
                return;
        for (size_t axis = 0; axis < 3; ++axis) {
            Lattice b = a;
            ++b[axis];
            const bool inside = value(a) < 0;
            if (inside != (value(b) < 0))
                found->edges.push_back({Index(a), static_cast<uint8_t>(axis), inside});
        }
    }
    //<

    Point3f low_{-24, kHeadBottom - 1.5f, -15};
    float spacing_;
    Lattice size_;
};
//<

//> Pull the vertices onto the head
// Moves the vertices onto the surface, along the gradient of the distance.
void PullOntoHead(SurfaceMesh *mesh) {
    mesh->normals.resize(mesh->points.size());
    ParallelForRange(mesh->points.size(), 256, [&](size_t first, size_t last) {
        for (size_t k = first; k < last; ++k) {
            Point3f &p = mesh->points[k];
            for (int i = 0; i < 64; ++i) {
                const float d = HeadDistance(p);
                if (std::abs(d) < 2e-4f)
                    break;
                p -= HeadNormal(p) *
                     (0.8f * d); // short of the full step, which creases would answer by a swing
            }
            mesh->normals[k] = HeadNormal(p);
        }
    });
}
//<

//> Join the vertices around each crossed edge
// Adds two triangles for every edge that the surface crosses, between the vertices of the four cubes around
// it.
void AddTriangles(const HeadLattice &lattice, const HeadCrossings &crossings, SurfaceMesh *mesh) {
    const auto vertexOf = [&](uint64_t cube) {
        const auto found = std::lower_bound(crossings.cubes.begin(), crossings.cubes.end(), cube,
                                            [](const auto &c, uint64_t at) { return c.at < at; });
        CHECK(found != crossings.cubes.end() && found->at == cube);
        return static_cast<uint32_t>(found - crossings.cubes.begin());
    };
    mesh->indices.resize(6 * crossings.edges.size());
    ParallelForRange(crossings.edges.size(), 1024, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const HeadCrossings::Edge &edge = crossings.edges[i];
            const uint64_t one = lattice.Stride((edge.axis + 1) % 3),
                           two = lattice.Stride((edge.axis + 2) % 3);
            uint32_t q[4] = {vertexOf(edge.at), vertexOf(edge.at - one), vertexOf(edge.at - one - two),
                             vertexOf(edge.at - two)};
            if (!edge.inside)
                std::swap(q[1], q[3]);
            const uint32_t corners[6] = {q[0], q[1], q[2], q[0], q[2], q[3]};
            std::copy(std::begin(corners), std::end(corners),
                      mesh->indices.begin() + 6 * static_cast<ptrdiff_t>(i));
        }
    });
}
//<

} // namespace

// Surface nets (Gibson 1998): one vertex in every cube that the surface crosses, one quad for every crossed
// edge.
SurfaceMesh MakeHeadMesh(float spacing) {
    if (!(spacing >= 0.05f && spacing <= 5))
        throw Error("the spacing of the head's mesh must lie between 0.05 and 5 (cm)");
    const HeadLattice lattice(spacing);
    const HeadCrossings crossings = lattice.Find();
    SurfaceMesh mesh;
    mesh.points.reserve(crossings.cubes.size());
    for (const HeadCrossings::Cube &cube : crossings.cubes)
        mesh.points.push_back(cube.p);
    PullOntoHead(&mesh);
    AddTriangles(lattice, crossings, &mesh);
    return mesh;
}

//> Write triangles as a file
void WritePly(const std::string &filename, const SurfaceMesh &mesh) {
    OutputFile out(filename);
    out.Write(fmt::format("ply\nformat binary_little_endian 1.0\ncomment written by Cuticle\n"
                          "element vertex {}\n"
                          "property float x\nproperty float y\nproperty float z\n"
                          "property float nx\nproperty float ny\nproperty float nz\n"
                          "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                          mesh.points.size(), mesh.indices.size() / 3));
    std::string bytes;
    const auto put = [&](const auto &v) { bytes.append(reinterpret_cast<const char *>(&v), sizeof v); };
    for (size_t i = 0; i < mesh.points.size(); ++i) {
        put(mesh.points[i]);
        put(mesh.normals[i]);
    }
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        put(static_cast<uint8_t>(3));
        for (size_t k = 0; k < 3; ++k)
            put(mesh.indices[i + k]);
    }
    out.Write(bytes);
    out.Commit();
}
//<

} // namespace cuticle
//<
