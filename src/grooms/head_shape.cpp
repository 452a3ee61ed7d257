#include "grooms/head_shape.h"

#include "core/check.h"
#include "core/error.h"
#include "core/parallel.h"
#include "files/file.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cuticle {

namespace {

constexpr float kCutHeight = -27.f; // the bust ends here
// The cranium's middle, from which directions to the scalp are measured.
constexpr Point3f kCranium{0, 2.6f, -0.8f};
constexpr Point3f kCrown{1.f, 10.6f, -4.8f};

// First-order distance to an ellipsoid: the implicit function over its gradient's length.
float Ellipsoid(const Point3f &p, const Point3f &c, const Vector3f &r) {
    const Vector3f q = p - c;
    const Vector3f a{q.x / r.x, q.y / r.y, q.z / r.z};
    const Vector3f b{a.x / r.x, a.y / r.y, a.z / r.z};
    const float k = a.Length(), g = b.Length();
    if (!(g > 0))
        return -std::min(r.x, std::min(r.y, r.z));
    return k * (k - 1) / g;
}

// Capsule whose radius goes from ra at a to rb at b.
float Capsule(const Point3f &p, const Point3f &a, const Point3f &b, float ra, float rb) {
    const Vector3f ab = b - a, ap = p - a;
    const float t = std::clamp(Dot(ap, ab) / ab.LengthSquared(), 0.f, 1.f);
    return (ap - ab * t).Length() - Lerp(t, ra, rb);
}

// Union that rounds the crease over a width of k (a quadratic blend).
float Join(float a, float b, float k) {
    const float h = std::max(k - std::abs(a - b), 0.f) / k;
    return std::min(a, b) - h * h * k * 0.25f;
}
float Carve(float a, float b, float k) { return -Join(-a, b, k); }

float SmoothStep(float a, float b, float v) {
    const float t = std::clamp((v - a) / (b - a), 0.f, 1.f);
    return t * t * (3 - 2 * t);
}

// The bust is the same left and right: work on |x|.
float Bust(Point3f p) {
    p.x = std::abs(p.x);
    float d = Ellipsoid(p, {0, 3.1f, -0.9f}, {7.3f, 8.4f, 9.3f});          // cranium
    d = Join(d, Ellipsoid(p, {0, 4.6f, 1.6f}, {6.3f, 6.0f, 7.1f}), 3.f);   // forehead
    d = Join(d, Ellipsoid(p, {0, -2.6f, 2.6f}, {6.0f, 7.6f, 6.2f}), 2.5f); // face
    d = Join(d, Ellipsoid(p, {0, -8.3f, 5.4f}, {2.6f, 2.0f, 2.9f}), 2.5f); // chin
    // Neck, shoulders and chest hang under the head.
    float body = Capsule(p, {0, -3.5f, -2.4f}, {0, -16.f, -3.8f}, 4.7f, 5.0f);
    body = Join(body, Ellipsoid(p, {0, -22.8f, -3.5f}, {14.5f, 8.5f, 8.f}), 6.f);
    body = Join(body, Capsule(p, {4.f, -17.2f, -4.f}, {14.6f, -19.8f, -4.2f}, 3.4f, 4.3f), 4.f);
    body = Join(body, Capsule(p, {14.6f, -19.8f, -4.2f}, {16.4f, -34.f, -3.8f}, 4.3f, 4.1f), 2.f);
    d = Join(d, body, 2.2f);
    if (p.z > 1.5f && p.y < 6.f && p.y > -10.f &&
        p.x < 8.5f) { // the face's small parts, where nothing else is
        d = Join(d, Ellipsoid(p, {3.7f, -2.4f, 5.7f}, {2.2f, 1.7f, 2.3f}), 1.6f);            // cheek
        d = Join(d, Capsule(p, {0.6f, 1.7f, 8.1f}, {4.1f, 1.6f, 6.3f}, 0.85f, 0.75f), 1.2f); // brow
        d = Carve(d, Ellipsoid(p, {3.1f, 0.2f, 9.1f}, {1.6f, 0.95f, 1.7f}), 1.2f);           // socket
        d = Join(d, Ellipsoid(p, {3.05f, 0.15f, 7.05f}, {1.35f, 0.95f, 1.05f}), 0.3f);       // eye
        d = Join(d, Capsule(p, {0, 1.1f, 8.3f}, {0, -2.6f, 9.9f}, 0.55f, 0.8f), 0.9f);       // nose
        d = Join(d, Ellipsoid(p, {0.95f, -3.1f, 9.5f}, {0.6f, 0.5f, 0.8f}), 0.5f);           // nostril
        d = Join(d, Ellipsoid(p, {0, -5.3f, 8.0f}, {2.1f, 0.42f, 0.85f}), 0.7f);             // lips
        d = Join(d, Ellipsoid(p, {0, -6.1f, 7.9f}, {1.7f, 0.48f, 0.9f}), 0.7f);
        d = Carve(d, Ellipsoid(p, {0, -5.65f, 9.3f}, {2.1f, 0.08f, 0.5f}), 0.25f);
    }
    if (p.x > 4.5f && p.y > -5.f && p.y < 4.f) {
        // An ear: a tilted disc with a bowl in it. The tilt is a shear, which keeps the sign.
        const Point3f q{p.x - 0.35f * (-0.4f - p.z), p.y, p.z};
        float ear = Ellipsoid(q, {7.2f, -0.4f, -0.8f}, {0.55f, 3.0f, 1.8f});
        ear = Carve(ear, Ellipsoid(q, {7.75f, -0.3f, -0.6f}, {0.5f, 2.0f, 1.1f}), 0.4f);
        d = Join(d, ear, 0.5f);
    }
    return d;
}

} // namespace

float HeadDistance(const Point3f &p) { return std::max(Bust(p), kCutHeight - p.y); }

Normal3f HeadNormal(const Point3f &p) {
    constexpr float h = 0.02f;
    const Vector3f g{HeadDistance({p.x + h, p.y, p.z}) - HeadDistance({p.x - h, p.y, p.z}),
                     HeadDistance({p.x, p.y + h, p.z}) - HeadDistance({p.x, p.y - h, p.z}),
                     HeadDistance({p.x, p.y, p.z + h}) - HeadDistance({p.x, p.y, p.z - h})};
    const float length = g.Length();
    return length > 0 ? g / length : Vector3f{0, 1, 0}; // at an exact centre any direction leads out
}

Point3f PushOutOfHead(Point3f p, float offset) {
    // Near the surface two or three steps do it; from deep inside, where the distance is a rough guess, more.
    for (int i = 0; i < 64; ++i) {
        const float d = HeadDistance(p);
        if (d >= offset)
            break;
        p += HeadNormal(p) * (offset - d + 1e-4f);
    }
    return p;
}

float HairDensity(const Point3f &p) {
    // The hairline by azimuth from the face (degrees) and elevation seen from the cranium's middle: forehead,
    // temple, sideburn, above and behind the ear, nape.
    static constexpr float kLine[][2] = {{0, 35},    {18, 37.5f}, {36, 37.5f}, {52, 27},   {62, 12},
                                         {70, -6},   {78, -22},   {86, -14},   {94, 2},    {106, 2},
                                         {118, -16}, {130, -33},  {146, -44},  {162, -49}, {180, -50}};
    const Vector3f d = p - kCranium;
    const float azimuth = Degrees(std::atan2(std::abs(d.x), d.z));
    const float elevation = Degrees(std::atan2(d.y, std::sqrt(d.x * d.x + d.z * d.z)));
    size_t i = 0;
    while (i + 2 < std::size(kLine) && azimuth > kLine[i + 1][0])
        ++i;
    const float t = (azimuth - kLine[i][0]) / (kLine[i + 1][0] - kLine[i][0]);
    const float edge = Lerp(t, kLine[i][1], kLine[i + 1][1]);
    return SmoothStep(-1.5f, 4.5f, elevation - edge);
}

Point3f Scalp::SurfaceAlong(float azimuth, float cosine) const {
    const float sine = std::sqrt(std::max(0.f, 1 - cosine * cosine));
    const Vector3f d{sine * std::sin(azimuth), cosine, sine * std::cos(azimuth)};
    // The cranium is star-shaped seen from its middle: regula falsi between inside and outside, in the
    // Illinois way (an end that stays for two steps counts half).
    float inside = 5, outside = 13;
    float a = HeadDistance(kCranium + d * inside), b = HeadDistance(kCranium + d * outside);
    if (!(a < 0 && b > 0)) { // along the neck: no scalp there, any point of it will do
        return kCranium + d * outside;
    }
    int last = 0;
    float t = outside;
    for (int i = 0; i < 40; ++i) {
        t = inside + (outside - inside) * (a / (a - b));
        const float v = HeadDistance(kCranium + d * t);
        if (std::abs(v) < 2e-6f)
            break;
        const int end = v < 0 ? -1 : 1;
        (end < 0 ? inside : outside) = t;
        (end < 0 ? a : b) = v;
        if (end == last)
            (end < 0 ? b : a) *= 0.5f;
        last = end;
    }
    return kCranium + d * t;
}

Scalp::Scalp() {
    // Area times density of cells even in azimuth and in the cosine from straight up.
    std::vector<Point3f> corner((kAzimuth + 1) * (kHeight + 1));
    for (size_t j = 0; j <= kHeight; ++j)
        for (size_t i = 0; i <= kAzimuth; ++i)
            corner[j * (kAzimuth + 1) + i] =
                SurfaceAlong(2 * Pi * static_cast<float>(i) / kAzimuth - Pi,
                             1 - 2 * static_cast<float>(j) / static_cast<float>(kHeight));
    double total = 0;
    rowCdf_.assign(kHeight + 1, 0);
    columnCdf_.assign(kHeight * (kAzimuth + 1), 0);
    for (size_t j = 0; j < kHeight; ++j) {
        double row = 0;
        float *cdf = columnCdf_.data() + j * (kAzimuth + 1);
        for (size_t i = 0; i < kAzimuth; ++i) {
            const auto at = [&](size_t y, size_t x) { return corner[y * (kAzimuth + 1) + x]; };
            const Point3f a = at(j, i), b = at(j, i + 1), c = at(j + 1, i), d = at(j + 1, i + 1);
            const float area = (Cross(b - a, c - a).Length() + Cross(b - d, c - d).Length()) / 2;
            const Point3f middle = (a + b + c + d) * 0.25f;
            // Hair lies away from the crown on all sides and would leave it bare: it grows closer there.
            const float crown = 1 + 1.5f * std::exp((middle - kCrown).LengthSquared() * -0.125f);
            row += static_cast<double>(area * HairDensity(middle) * crown);
            cdf[i + 1] = static_cast<float>(row);
        }
        if (row > 0)
            for (size_t i = 0; i <= kAzimuth; ++i)
                cdf[i] /= static_cast<float>(row);
        total += row;
        rowCdf_[j + 1] = static_cast<float>(total);
    }
    area_ = static_cast<float>(total);
    for (float &v : rowCdf_)
        v /= area_;
}

ScalpPoint Scalp::Sample(float u, float v) const {
    const auto invert = [](const float *cdf, size_t n, float x) {
        const auto below = static_cast<size_t>(std::upper_bound(cdf, cdf + n + 1, x) - cdf);
        const size_t cell = std::min(below > 0 ? below - 1 : 0, n - 1);
        const float width = cdf[cell + 1] - cdf[cell];
        return std::pair(cell, width > 0 ? std::min((x - cdf[cell]) / width, 1.f) : 0.5f);
    };
    const auto [row, fv] = invert(rowCdf_.data(), kHeight, v);
    const auto [column, fu] = invert(columnCdf_.data() + row * (kAzimuth + 1), kAzimuth, u);
    ScalpPoint s;
    s.p = SurfaceAlong(2 * Pi * (static_cast<float>(column) + fu) / kAzimuth - Pi,
                       1 - 2 * (static_cast<float>(row) + fv) / static_cast<float>(kHeight));
    s.n = HeadNormal(s.p);
    s.density = HairDensity(s.p);
    return s;
}

namespace {

using Lattice = std::array<size_t, 3>; // x, y, z

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

    Point3f low_{-24, kCutHeight - 1.5f, -15};
    float spacing_;
    Lattice size_;
};

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

} // namespace cuticle
