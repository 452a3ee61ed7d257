// Laws of subdivision: limit points do not depend on the level at which they are asked for, a symmetric mesh
// stays symmetric, normals are those of the surface, the boundary is a curve of its own.
#include "shapes/loop_subdivision.h"

#include "core/error.h"

#include <gtest/gtest.h>
#include <map>
#include <string>

namespace cuticle {
namespace {

TriangleMesh Octahedron() {
    TriangleMesh m;
    m.p = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    m.indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    return m;
}
TriangleMesh Tetrahedron() {
    TriangleMesh m;
    m.p = {{0.9428f, 0, -0.3333f}, {-0.4714f, 0.8165f, -0.3333f}, {-0.4714f, -0.8165f, -0.3333f}, {0, 0, 1}};
    m.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    return m;
}
// An open mesh with vertices of valence 2 to 8 on its boundary and a hole: a bumpy grid, of which some faces
// are left out.
TriangleMesh Sheet() {
    TriangleMesh m;
    constexpr uint32_t n = 6;
    for (uint32_t y = 0; y <= n; ++y)
        for (uint32_t x = 0; x <= n; ++x)
            m.p.push_back(
                {static_cast<float>(x), static_cast<float>(y), std::sin(1.3f * static_cast<float>(x * y))});
    for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) {
            const uint32_t a = y * (n + 1) + x, b = a + 1, d = a + n + 1, c = d + 1;
            if ((x == 2 && y == 2) || (x == 5 && y < 2))
                continue;
            if ((x + y) % 2)
                m.indices.insert(m.indices.end(), {a, b, c, a, c, d});
            else
                m.indices.insert(m.indices.end(), {a, b, d, b, c, d});
        }
    return m;
}

Vector3f FaceNormal(const TriangleMesh &m, size_t face) {
    const Point3f p0 = m.p[m.indices[3 * face]];
    return Cross(m.p[m.indices[3 * face + 1]] - p0, m.p[m.indices[3 * face + 2]] - p0);
}
double Area(const TriangleMesh &m) {
    double sum = 0;
    for (size_t f = 0; f < m.indices.size() / 3; ++f)
        sum += static_cast<double>(FaceNormal(m, f).Length()) / 2;
    return sum;
}

// Vertices of the boundary with other than three faces, for which pbrt-v3's rules have no exact tangents.
std::vector<bool> IrregularRim(const TriangleMesh &m) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    std::vector<int> faces(m.p.size(), 0);
    for (size_t i = 0; i < m.indices.size(); ++i) {
        const uint32_t a = m.indices[i], b = m.indices[i % 3 == 2 ? i - 2 : i + 1];
        ++edges[{std::min(a, b), std::max(a, b)}];
        ++faces[a];
    }
    std::vector<bool> irregular(m.p.size(), false);
    for (const auto &[edge, count] : edges)
        for (const uint32_t v : {edge.first, edge.second})
            if (count == 1 && faces[v] != 3)
                irregular[v] = true;
    return irregular;
}

// A vertex of one level is a vertex of the next, and both know where it ends up.
TEST(LoopSubdivision, LimitPointsAndNormalsDoNotDependOnTheLevel) {
    for (const TriangleMesh &control : {Octahedron(), Tetrahedron(), Sheet()}) {
        TriangleMesh coarse = LoopSubdivide(control, 0);
        for (int level = 1; level <= 4; ++level) {
            const TriangleMesh fine = LoopSubdivide(control, level);
            ASSERT_EQ(fine.indices.size(), 4 * coarse.indices.size());
            const std::vector<bool> irregular = IrregularRim(coarse);
            for (size_t v = 0; v < coarse.p.size(); ++v) {
                EXPECT_LT((fine.p[v] - coarse.p[v]).Length(), 2e-6f) << "vertex " << v << " level " << level;
                EXPECT_NEAR(fine.n[v].Length(), 1, 1e-5);
                EXPECT_GT(Dot(fine.n[v], coarse.n[v]), irregular[v] ? 0.7f : 1 - 1e-6f)
                    << "vertex " << v << " level " << level;
            }
            coarse = fine;
        }
    }
}

// The areas of successive levels converge, with a quarter of the error left at each; the normals are those of
// the faces around them, in the limit, turned to pbrt-v3's side.
TEST(LoopSubdivision, AreasConvergeAndNormalsStandOnTheSurface) {
    for (const TriangleMesh &control : {Octahedron(), Tetrahedron()}) {
        double areas[7];
        for (int level = 0; level < 7; ++level)
            areas[level] = Area(LoopSubdivide(control, level));
        for (int level = 3; level < 6; ++level) {
            const double ratio = (areas[level + 1] - areas[level]) / (areas[level] - areas[level - 1]);
            EXPECT_NEAR(ratio, 0.25, 0.06) << "level " << level;
        }
    }
    for (const TriangleMesh &control : {Octahedron(), Tetrahedron()}) {
        float worst[2] = {0, 0}; // sine of the angle, at two levels
        for (const int level : {4, 6}) {
            const TriangleMesh m = LoopSubdivide(control, level);
            for (size_t f = 0; f < m.indices.size() / 3; ++f)
                for (size_t i = 0; i < 3; ++i) {
                    const Vector3f n = Normalize(FaceNormal(m, f)), ns = m.n[m.indices[3 * f + i]];
                    ASSERT_LT(Dot(n, ns), 0);
                    float &w = worst[level == 6];
                    w = std::max(w, Cross(n, ns).Length());
                }
        }
        // Worst at the control vertices, where it falls by the ratio of the subdivision matrix's third
        // eigenvalue to its second, 3/8 + cos(2 pi / n) / 4: 2/3 a level at valence 4, 1/2 at valence 3. A
        // tenth more for the finite level.
        const float ratio = control.p.size() == 6 ? 2.f / 3 : 0.5f;
        EXPECT_LT(worst[1], 1.1f * Sqr(ratio) * worst[0]) << worst[0];
    }
}

// A map of the control mesh onto itself maps the surface onto itself.
TEST(LoopSubdivision, AnOctahedronKeepsItsSymmetry) {
    const TriangleMesh m = LoopSubdivide(Octahedron(), 4);
    EXPECT_EQ(m.p.size(), 2 + m.indices.size() / 6); // Euler: V = 2 + F / 2
    const auto key = [](const Point3f &p) {
        const auto digit = [](float x) { return static_cast<int>(std::lround(x * 1e5f)); };
        return std::array<int, 3>{digit(p.x), digit(p.y), digit(p.z)};
    };
    std::map<std::array<int, 3>, int> points;
    for (const Point3f &p : m.p)
        for (int dx = -1; dx <= 1; ++dx)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dz = -1; dz <= 1; ++dz) {
                    const std::array<int, 3> k = key(p);
                    points[{k[0] + dx, k[1] + dy, k[2] + dz}] = 1;
                }
    for (const Point3f &p : m.p)
        for (const Point3f &image : {Point3f(-p.x, p.y, p.z), Point3f(p.y, p.z, p.x), Point3f(p.y, p.x, p.z)})
            EXPECT_TRUE(points.count(key(image))) << p;
    // Of valence 4: beta 3/32, so the limit weights the ring by 1/8 and the vertex itself by 1/2.
    EXPECT_NEAR(m.p[0].x, 0.5, 1e-6);
}

// A boundary does not feel the inside: it is the cubic B-spline of its own control points.
TEST(LoopSubdivision, TheBoundaryIsASpline) {
    TriangleMesh a = Sheet(), b = a;
    for (uint32_t y = 3; y < 6; ++y)
        for (uint32_t x = 1; x < 5; ++x)
            if (!(y == 3 && (x == 2 || x == 3))) // the hole's rim
                b.p[y * 7 + x].z += 1;
    a = LoopSubdivide(a, 3);
    b = LoopSubdivide(b, 3);
    // (0, 2) stands on a straight part of the rim: the spline's 1/6, 2/3, 1/6.
    const TriangleMesh control = Sheet();
    const Vector3f expected =
        control.p[7] * (1.f / 6) + control.p[14] * (2.f / 3) + control.p[21] * (1.f / 6);
    int unmoved = 0;
    float nearest = Infinity;
    for (size_t v = 0; v < a.p.size(); ++v) {
        unmoved += a.p[v] == b.p[v];
        nearest = std::min(nearest, (a.p[v] - expected).Length());
    }
    EXPECT_GT(unmoved, 100);
    EXPECT_LT(nearest, 1e-6f);
}

std::string ErrorOf(const TriangleMesh &mesh, int levels = 1) {
    try {
        LoopSubdivide(mesh, levels);
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

TEST(LoopSubdivision, RefusesWhatIsNoSurface) {
    const auto with = [](std::vector<uint32_t> indices) {
        TriangleMesh m;
        m.p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {2, 2, 0}, {3, 2, 1}};
        m.indices = std::move(indices);
        return m;
    };
    const auto has = [](const std::string &text, const char *part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    EXPECT_EQ(ErrorOf(with({0, 1, 2, 1, 0, 3})), "");
    has(ErrorOf(with({0, 1, 2, 1, 0, 3, 1, 0, 4})),
        "edge between vertices 0 and 1 belongs to more than two faces");
    has(ErrorOf(with({0, 1, 2, 0, 1, 3})), "at the edge between vertices 0 and 1 turn different ways");
    has(ErrorOf(with({2, 5, 6, 2, 3, 4})), "at vertex 2 parts of the surface touch");
    has(ErrorOf(with({0, 1, 1})), "face 0 names vertex 1 twice");
    has(ErrorOf(with({0, 1, 9})), "vertex index 9 is out of range");
    has(ErrorOf(with({0, 1})), "not a multiple of 3");
    has(ErrorOf(with({0, 1, 2}), -1), "levels must be at least 0");
    has(ErrorOf(with({0, 1, 2}), 14), "levels must be at least 0");
    EXPECT_EQ(LoopSubdivide(with({0, 2, 5}), 0).p.size(), 3u); // the others are dropped
    EXPECT_TRUE(LoopSubdivide({}, 3).p.empty());
}

} // namespace
} // namespace cuticle
