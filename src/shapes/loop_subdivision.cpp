#include "shapes/loop_subdivision.h"

#include "core/error.h"

#include <fmt/format.h>

#include <string>

namespace cuticle {

namespace {

constexpr uint32_t kNone = UINT32_MAX;
constexpr size_t kMaxTriangles = size_t(1) << 27;

// Half-edge h = 3 f + i runs from corner i of face f to the next corner.
uint32_t Next(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
uint32_t Previous(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

// A mesh with its neighbourhoods.
struct LoopSurface {
    std::vector<Vector3d> p;
    std::vector<uint32_t> from; // by half-edge: the vertex that it leaves
    std::vector<uint32_t> twin; // by half-edge: the one of the neighbouring face, or kNone on the boundary
    // By vertex, a half-edge that leaves it; at the boundary the last one clockwise, which is on the
    // boundary.
    std::vector<uint32_t> leaving;

    uint32_t To(uint32_t h) const { return from[Next(h)]; }
    bool OnBoundary(uint32_t vertex) const { return twin[leaving[vertex]] == kNone; }

    // Finds the neighbours of a vertex, in pbrt-v3's order: clockwise around an inner one, anticlockwise from
    // one end of the boundary to the other around one of the boundary.
    void Ring(uint32_t vertex, std::vector<uint32_t> *ring) const {
        ring->clear();
        const uint32_t first = leaving[vertex];
        uint32_t h = first;
        if (OnBoundary(vertex)) {
            ring->push_back(To(h));
            while (true) {
                const uint32_t in = Previous(h);
                ring->push_back(from[in]);
                if (twin[in] == kNone)
                    return;
                h = twin[in];
            }
        }
        do {
            ring->push_back(To(h));
            h = Next(twin[h]);
        } while (h != first);
    }
    void Connect();
};

std::string EdgeName(uint32_t a, uint32_t b) { return fmt::format("edge between vertices {} and {}", a, b); }

// Finds twin and leaving from `from`; Error where the faces are no surface with at most a boundary.
void LoopSurface::Connect() {
    const auto halfEdges = static_cast<uint32_t>(from.size());
    // Half-edges in the order of their two vertices, so that those of one edge stand together.
    struct Edge {
        uint32_t low, high, half;
        bool operator<(const Edge &o) const {
            return low != o.low ? low < o.low : high != o.high ? high < o.high : half < o.half;
        }
        bool Same(const Edge &o) const { return low == o.low && high == o.high; }
    };
    std::vector<Edge> edges(halfEdges);
    for (uint32_t h = 0; h < halfEdges; ++h)
        edges[h] = {std::min(from[h], To(h)), std::max(from[h], To(h)), h};
    std::sort(edges.begin(), edges.end());
    twin.assign(halfEdges, kNone);
    for (size_t i = 0; i + 1 < edges.size(); ++i) {
        if (!edges[i].Same(edges[i + 1]))
            continue;
        const uint32_t a = edges[i].half, b = edges[i + 1].half;
        if (i + 2 < edges.size() && edges[i].Same(edges[i + 2]))
            throw Error("loopsubdiv: the {} belongs to more than two faces",
                        EdgeName(edges[i].low, edges[i].high))
                .WithRemedy("a surface has one or two at each edge");
        if (from[a] == from[b])
            throw Error("loopsubdiv: the two faces at the {} turn different ways",
                        EdgeName(edges[i].low, edges[i].high))
                .WithRemedy("neighbouring faces must run along their edge in opposite directions");
        twin[a] = b;
        twin[b] = a;
    }

    leaving.assign(p.size(), kNone);
    std::vector<uint32_t> faces(p.size(), 0), ring;
    for (uint32_t h = 0; h < halfEdges; ++h) {
        ++faces[from[h]];
        if (leaving[from[h]] == kNone || twin[h] == kNone)
            leaving[from[h]] = h;
    }
    for (uint32_t v = 0; v < p.size(); ++v) {
        if (leaving[v] == kNone)
            continue;
        Ring(v, &ring);
        if (ring.size() != faces[v] + (OnBoundary(v) ? 1 : 0))
            throw Error("loopsubdiv: at vertex {} parts of the surface touch in that point alone", v)
                .WithRemedy("give each part a vertex of its own");
    }
}

LoopSurface SurfaceOf(const TriangleMesh &control) {
    if (control.indices.size() % 3 != 0)
        throw Error("loopsubdiv: {} indices, which is not a multiple of 3", control.indices.size());
    LoopSurface s;
    std::vector<uint32_t> place(control.p.size(), kNone);
    for (size_t f = 0; f < control.indices.size(); f += 3)
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t v = control.indices[f + i];
            if (v >= control.p.size())
                throw Error("loopsubdiv: vertex index {} is out of range", v)
                    .WithRemedy("there are {} points, counted from 0", control.p.size());
            if (v == control.indices[f + (i + 1) % 3])
                throw Error("loopsubdiv: face {} names vertex {} twice", f / 3, v);
            place[v] = 0;
        }
    s.from = control.indices;
    for (const Point3f &p : control.p)
        s.p.emplace_back(p);
    s.Connect();
    // Drop the vertices that no face names, now that no error has to name the others.
    uint32_t count = 0;
    for (size_t v = 0; v < control.p.size(); ++v)
        if (place[v] == 0) {
            s.p[count] = s.p[v];
            s.leaving[count] = s.leaving[v];
            place[v] = count++;
        }
    s.p.resize(count);
    s.leaving.resize(count);
    for (uint32_t &v : s.from)
        v = place[v];
    return s;
}

// Returns (1 - n beta) v + beta times the sum of the ring.
Vector3d WeightRing(const LoopSurface &s, uint32_t v, const std::vector<uint32_t> &ring, double beta) {
    Vector3d sum;
    for (const uint32_t r : ring)
        sum += s.p[r];
    return s.p[v] * (1 - static_cast<double>(ring.size()) * beta) + sum * beta;
}
// Returns (1 - 2 beta) v + beta times its two neighbours on the boundary.
Vector3d WeightBoundary(const LoopSurface &s, uint32_t v, const std::vector<uint32_t> &ring, double beta) {
    return s.p[v] * (1 - 2 * beta) + (s.p[ring.front()] + s.p[ring.back()]) * beta;
}
double Beta(size_t valence) { return valence == 3 ? 3. / 16 : 3. / (8 * static_cast<double>(valence)); }
double LimitBeta(size_t valence) { return 1 / (static_cast<double>(valence) + 3 / (8 * Beta(valence))); }

LoopSurface Refine(const LoopSurface &s) {
    LoopSurface fine;
    const auto halfEdges = static_cast<uint32_t>(s.from.size());
    fine.p.reserve(s.p.size() + halfEdges);
    std::vector<uint32_t> ring;
    for (uint32_t v = 0; v < s.p.size(); ++v) {
        s.Ring(v, &ring);
        fine.p.push_back(s.OnBoundary(v) ? WeightBoundary(s, v, ring, 1. / 8)
                                         : WeightRing(s, v, ring, Beta(ring.size())));
    }
    // A new vertex on each edge.
    std::vector<uint32_t> middle(halfEdges);
    for (uint32_t h = 0; h < halfEdges; ++h) {
        const uint32_t t = s.twin[h];
        if (t != kNone && t < h) {
            middle[h] = middle[t];
            continue;
        }
        middle[h] = static_cast<uint32_t>(fine.p.size());
        const Vector3d ends = s.p[s.from[h]] + s.p[s.To(h)];
        fine.p.push_back(t == kNone ? ends * 0.5
                                    : ends * (3. / 8) +
                                          (s.p[s.from[Previous(h)]] + s.p[s.from[Previous(t)]]) * (1. / 8));
    }
    // Three faces at the corners, one between them.
    fine.from.reserve(4 * size_t{halfEdges});
    for (uint32_t f = 0; f < halfEdges; f += 3) {
        for (uint32_t i = 0; i < 3; ++i)
            fine.from.insert(fine.from.end(), {s.from[f + i], middle[f + i], middle[f + (i + 2) % 3]});
        fine.from.insert(fine.from.end(), {middle[f], middle[f + 1], middle[f + 2]});
    }
    fine.Connect();
    return fine;
}

// Returns the cross product of two tangents, from the ring of a vertex: Loop's and Hoppe's masks, which give
// exact tangents of the limit surface when applied to the control points (pbrt-v3 applies them to points that
// are already on it).
Vector3d LimitNormal(const LoopSurface &s, uint32_t v, const std::vector<uint32_t> &ring) {
    const size_t n = ring.size();
    Vector3d along, across;
    if (!s.OnBoundary(v)) {
        for (size_t j = 0; j < n; ++j) {
            const double angle = 2 * kPi<double> * static_cast<double>(j) / static_cast<double>(n);
            along += s.p[ring[j]] * std::cos(angle);
            across += s.p[ring[j]] * std::sin(angle);
        }
        return Cross(along, across);
    }
    along = s.p[ring.back()] - s.p[ring.front()];
    const Vector3d ends = s.p[ring.back()] + s.p[ring.front()];
    if (n == 2) {
        across = ends - s.p[v] * 2.;
    } else if (n == 3) {
        across = s.p[ring[1]] - s.p[v];
    } else if (n == 4) {
        across = (s.p[ring[1]] + s.p[ring[2]]) * 2. - ends - s.p[v] * 2.;
    } else {
        const double theta = kPi<double> / static_cast<double>(n - 1);
        across = ends * -std::sin(theta);
        for (size_t k = 1; k + 1 < n; ++k)
            across += s.p[ring[k]] * ((2 - 2 * std::cos(theta)) * std::sin(static_cast<double>(k) * theta));
    }
    return Cross(along, across);
}

} // namespace

TriangleMesh LoopSubdivide(const TriangleMesh &control, int levels) {
    if (levels < 0 || levels > 13 || control.indices.size() / 3 << (2 * levels) > kMaxTriangles)
        throw Error("loopsubdiv: {} levels of {} faces", levels, control.indices.size() / 3)
            .WithRemedy("levels must be at least 0 and leave at most {} triangles", kMaxTriangles);
    LoopSurface s = SurfaceOf(control);
    for (int i = 0; i < levels; ++i)
        s = Refine(s);
    TriangleMesh mesh;
    mesh.p.reserve(s.p.size() + 1);
    mesh.n.reserve(s.p.size());
    std::vector<uint32_t> ring;
    for (uint32_t v = 0; v < s.p.size(); ++v) {
        s.Ring(v, &ring);
        mesh.p.emplace_back(s.OnBoundary(v) ? WeightBoundary(s, v, ring, 1. / 6)
                                            : WeightRing(s, v, ring, LimitBeta(ring.size())));
        const Vector3d n = LimitNormal(s, v, ring);
        const double length = n.Length();
        mesh.n.emplace_back(length > 0 ? n / length : Vector3d());
    }
    mesh.indices = std::move(s.from);
    return mesh;
}

} // namespace cuticle
