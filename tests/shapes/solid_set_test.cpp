// Laws of the set of solids: rays that leave a surface do not meet it again, meshes have no gaps, nonsense is
// refused.
#include "shapes/solid_set.h"

#include "core/error.h"
#include "shapes/solids.h"
#include "warnings.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// Rays that leave a hit through OffsetRayOrigin: a plane is never met again, a sphere not from outside, and
// from inside only on its far side.
TEST(Spawning, NoSurfaceShadowsItself) {
    RNG rng(5);
    for (const ParametrisedShape &shape : ParametrisedQuadrics()) {
        if (shape.name.ends_with("hyperboloid"))
            continue; // a saddle, which sees itself on both sides
        int self = 0, tried = 0;
        for (int i = 0; i < 300; ++i) {
            const float spread = std::pow(10.f, 4 * rng.UniformFloat());
            const Transform t =
                Transform::Translate(Vector3d(RandomPoint(rng, spread))) * RandomTransform(rng, i % 2);
            SolidSet set;
            shape.add(set, t, false);
            set.Commit();
            for (int k = 0; k < 100; ++k) {
                const double u = rng.UniformFloat(), v = rng.UniformFloat();
                const Point3f target(Apply(t, shape.at(u, v)));
                const Vector3f d = RandomDirection(rng);
                SolidHit hit;
                if (!set.Intersect({target - d * 10.f, d}, &hit))
                    continue;
                ++tried;
                // Outward of the hit only: the outside of a convex surface sees nothing of it.
                Vector3f w = RandomDirection(rng);
                if (Dot(w, hit.n) < 0)
                    w = -w;
                self += set.Occluded({OffsetRayOrigin(hit.p, hit.pError, hit.n, w), w});
            }
        }
        EXPECT_EQ(self, 0) << shape.name << ": self-hits, of " << tried;
        EXPECT_GT(tried, 20000) << shape.name;
    }
}

TEST(Spawning, InsideOfASphereMeetsItsFarSide) {
    RNG rng(6);
    int tried = 0;
    for (int i = 0; i < 200; ++i) {
        const Vector3f centre = RandomPoint(rng, 100);
        SolidSet set;
        set.AddSphere(Transform::Translate(Vector3d(centre)), 1, -1, 1, 360, 0, false);
        set.Commit();
        for (int k = 0; k < 100; ++k) {
            SolidHit hit;
            const Vector3f d = RandomDirection(rng);
            ASSERT_TRUE(set.Intersect({centre - d * 3.f + RandomPoint(rng, 0.3f), d}, &hit));
            Vector3f w = RandomDirection(rng);
            if (Dot(w, hit.n) > 0)
                w = -w;
            const float cosine = AbsDot(w, hit.n);
            if (cosine < 0.01f)
                continue;
            ++tried;
            SolidHit next;
            ASSERT_TRUE(set.Intersect({OffsetRayOrigin(hit.p, hit.pError, hit.n, w), w}, &next));
            // A chord of a unit sphere; positions hold about 1e-5 here, which the cosine divides.
            EXPECT_NEAR(next.t, 2 * cosine, 3e-5f / cosine);
        }
    }
    EXPECT_GT(tried, 15000);
}

// Triangles of every shape: down to needles 1e5 times longer than wide, and far from the origin.
TEST(Spawning, NoTriangleShadowsItself) {
    RNG rng(8);
    int self = 0, tried = 0;
    for (int i = 0; i < 3000; ++i) {
        const Point3f base = RandomPoint(rng, std::pow(10.f, 5 * rng.UniformFloat()));
        const float size = std::pow(10.f, 3 * rng.UniformFloat());
        const float width = std::pow(10.f, -5 * rng.UniformFloat());
        const Vector3f along = RandomDirection(rng) * size, across = RandomDirection(rng) * (size * width);
        TriangleMesh mesh;
        mesh.p = {base, base + along, base + along * rng.UniformFloat() + across};
        mesh.indices = {0, 1, 2};
        SolidSet set;
        set.AddMesh(mesh, 0, false);
        set.Commit();
        for (int k = 0; k < 30; ++k) {
            const Point2f b = UniformSampleTriangle({rng.UniformFloat(), rng.UniformFloat()});
            const Point3f target = mesh.p[0] + (mesh.p[1] - mesh.p[0]) * b.x + (mesh.p[2] - mesh.p[0]) * b.y;
            const Vector3f d = RandomDirection(rng);
            SolidHit hit;
            if (!set.Intersect({target - d * (size * rng.UniformFloat()), d}, &hit))
                continue;
            ++tried;
            for (int j = 0; j < 4; ++j) {
                // Grazing directions among them.
                Vector3f w = RandomDirection(rng);
                if (j >= 2)
                    w = Normalize(w - hit.n * (Dot(w, hit.n) * (1 - 1e-4f)));
                self += set.Occluded({OffsetRayOrigin(hit.p, hit.pError, hit.n, w), w});
            }
        }
    }
    EXPECT_EQ(self, 0) << "self-hits, of " << 4 * tried;
    EXPECT_GT(tried, 20000);
}

// A cube of many triangles: every ray from inside meets it, those aimed at edges too. Embree's edge test is
// one and the same for both neighbours of an edge, but the edges around a vertex are rounded each for itself:
// of rays aimed exactly at a vertex, which no camera ray is, one in 500 slips through (measured); twice that
// is allowed.
TEST(Meshes, AClosedMeshHasNoGaps) {
    constexpr int n = 12;
    TriangleMesh mesh;
    RNG rng(2);
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                const int axis = face / 2;
                Point3f p;
                p[axis] = face % 2 ? 1.f : -1.f;
                p[(axis + 1) % 3] = 2.f * static_cast<float>(i) / n - 1;
                p[(axis + 2) % 3] = 2.f * static_cast<float>(j) / n - 1;
                mesh.p.push_back(p * 1.1f + Vector3f(0.3f, -0.1f, 0.7f));
            }
    for (uint32_t face = 0; face < 6; ++face)
        for (uint32_t i = 0; i < n; ++i)
            for (uint32_t j = 0; j < n; ++j) {
                const uint32_t a = face * (n + 1) * (n + 1) + i * (n + 1) + j, b = a + n + 1;
                mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
            }
    const TriangleMesh copy = mesh;
    SolidSet set;
    set.AddMesh(std::move(mesh), 0, false);
    set.Commit();
    int missed[3] = {}, tried[3] = {};
    for (int i = 0; i < 300000; ++i) {
        const Point3f o = RandomPoint(rng) + Vector3f(0.3f, -0.1f, 0.7f);
        const auto triangle = 3 * (rng.UniformUInt32() % (copy.indices.size() / 3));
        const Point3f p0 = copy.p[copy.indices[triangle]], p1 = copy.p[copy.indices[triangle + 1]];
        const int kind = i % 3;
        const Point3f target = kind == 0   ? p0
                               : kind == 1 ? p0 + (p1 - p0) * rng.UniformFloat()
                                           : RandomPoint(rng, 9);
        SolidHit hit;
        const Ray ray{o, target - o};
        const bool found = set.Intersect(ray, &hit);
        EXPECT_EQ(found, set.Occluded(ray));
        missed[kind] += !found;
        ++tried[kind];
    }
    EXPECT_LT(missed[0], tried[0] / 250) << "vertices, of " << tried[0];
    EXPECT_EQ(missed[1], 0) << "edges, of " << tried[1];
    EXPECT_EQ(missed[2], 0) << "anywhere, of " << tried[2];
}

TEST(Meshes, CoordinatesNormalsAndDerivatives) {
    RNG rng(4);
    for (int i = 0; i < 3000; ++i) {
        TriangleMesh mesh;
        mesh.p = {RandomPoint(rng), RandomPoint(rng), RandomPoint(rng)};
        mesh.indices = {0, 1, 2};
        const bool withUV = i % 2, withN = i % 3 == 0, flip = i % 5 == 0;
        Point2f uv[3] = {{0, 0}, {1, 0}, {1, 1}};
        if (withUV)
            for (Point2f &p : uv)
                mesh.uv.push_back(p = {rng.UniformFloat(), rng.UniformFloat()});
        const Vector3f cross = Cross(mesh.p[1] - mesh.p[0], mesh.p[2] - mesh.p[0]);
        const float det =
            (uv[0].x - uv[2].x) * (uv[1].y - uv[2].y) - (uv[0].y - uv[2].y) * (uv[1].x - uv[2].x);
        if (cross.Length() < 0.1f || std::abs(det) < 0.05f)
            continue;
        const Vector3f side = RandomDirection(rng);
        if (withN)
            for (int k = 0; k < 3; ++k)
                mesh.n.push_back(side * (1 + rng.UniformFloat()));
        SolidSet set;
        const std::vector<Point3f> p = mesh.p;
        set.AddMesh(mesh, 3, flip);
        set.Commit();
        const Point2f b = UniformSampleTriangle({rng.UniformFloat(), rng.UniformFloat()});
        const Point3f target = p[0] * b.x + p[1] * b.y + p[2] * (1 - b.x - b.y);
        const Vector3f n = Normalize(cross), d = RandomDirection(rng);
        if (AbsDot(n, d) < 0.05f || std::min({b.x, b.y, 1 - b.x - b.y}) < 1e-3f)
            continue;
        SolidHit hit;
        ASSERT_TRUE(set.Intersect({target - d * 2.f, d}, &hit));
        EXPECT_NEAR(hit.t, 2, 2e-5);
        EXPECT_LT((hit.p - target).Length(), 2e-5f);
        const Point2f expected = uv[0] * b.x + uv[1] * b.y + uv[2] * (1 - b.x - b.y);
        EXPECT_NEAR(hit.uv.x, expected.x, 2e-4);
        EXPECT_NEAR(hit.uv.y, expected.y, 2e-4);
        // dpdu and dpdv carry a difference of uv to the difference of positions.
        for (int k = 0; k < 2; ++k) {
            const Vector2f duv = uv[k] - uv[2];
            EXPECT_LT((hit.dpdu * duv.x + hit.dpdv * duv.y - (p[static_cast<size_t>(k)] - p[2])).Length(),
                      2e-4f);
        }
        if (withN) {
            EXPECT_GT(Dot(hit.n, side), 0);
            EXPECT_LT((hit.ns - side).Length(), 1e-5f);
            EXPECT_GT(AbsDot(hit.n, n), 1 - 1e-5f);
        } else {
            EXPECT_LT((hit.n - (flip ? -n : n)).Length(), 1e-4f);
            EXPECT_EQ(hit.n, hit.ns);
        }
    }
}

TEST(Meshes, DegenerateTextureCoordinatesGiveAFrame) {
    TriangleMesh mesh;
    mesh.p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.uv = {{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}};
    mesh.indices = {0, 1, 2};
    SolidSet set;
    set.AddMesh(mesh, 0, false);
    set.Commit();
    SolidHit hit;
    ASSERT_TRUE(set.Intersect({{0.2f, 0.2f, 1}, {0, 0, -1}}, &hit));
    EXPECT_NEAR(Dot(hit.dpdu, hit.dpdv), 0, 1e-6);
    EXPECT_NEAR(Dot(hit.dpdu, hit.n), 0, 1e-6);
    EXPECT_GT(Cross(hit.dpdu, hit.dpdv).Length(), 0.99f);
}

TEST(Meshes, BadTrianglesAreDroppedAndTheRestKeepsItsNumbers) {
    TriangleMesh mesh;
    mesh.p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNaN, 0, 0}, {Infinity, 0, 0}, {2, 0, 0}, {0, 0, 1}};
    mesh.indices = {0, 1, 99, 0, 1, 3, 0, 1, 2, 0, 4, 1, 0, 1, 5, 0, 1, 1, 0, 2, 6};
    SolidSet set;
    const uint32_t id = set.AddMesh(mesh, 0, false);
    set.Commit();
    SolidHit hit;
    ASSERT_TRUE(set.Intersect({{0.2f, 0.2f, 1}, {0, 0, -1}}, &hit));
    EXPECT_EQ(hit.primId, 2u);
    EXPECT_GT(set.Pdf({0.2f, 0.2f, 1}, hit), 0);
    ASSERT_TRUE(set.Intersect({{1, 0.2f, 0.2f}, {-1, 0, 0}}, &hit));
    EXPECT_EQ(hit.primId, 6u);
    EXPECT_FLOAT_EQ(set.Area(id), 1);
    // The vertices that no kept triangle uses do not count.
    EXPECT_EQ(set.WorldBound().pMax, Point3f(1, 1, 1));
    const StrictWarnings strict;
    EXPECT_THROW(set.AddMesh(mesh, 0, false), Error);

    FlushWarnings();
}

TEST(Meshes, RefusesWhatHasNoMeaning) {
    SolidSet set;
    TriangleMesh mesh;
    mesh.p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.indices = {0, 1};
    EXPECT_THROW(set.AddMesh(mesh, 0, false), Error);
    mesh.indices = {0, 1, 2};
    mesh.n = {{0, 0, 1}};
    EXPECT_THROW(set.AddMesh(mesh, 0, false), Error);
    mesh.n.clear();
    mesh.uv = {{0, 0}};
    EXPECT_THROW(set.AddMesh(mesh, 0, false), Error);
    EXPECT_THROW(set.AddSphere(Transform::Scale(1, 0, 1), 1, -1, 1, 360, 0, false), Error);
    EXPECT_THROW(set.AddSphere(Transform(), kNaN, -1, 1, 360, 0, false), Error);
    EXPECT_THROW(set.AddDisk(Transform(), 0, Infinity, 0, 360, 0, false), Error);
}

TEST(Sets, EmptyOnesAndSenselessRaysMeetNothing) {
    SolidSet empty;
    SolidHit hit;
    EXPECT_FALSE(empty.Intersect({{0, 0, 0}, {0, 0, 1}}, &hit));
    empty.Commit();
    EXPECT_FALSE(empty.Intersect({{0, 0, 0}, {0, 0, 1}}, &hit));
    EXPECT_TRUE(empty.WorldBound().IsEmpty());

    SolidSet set;
    const uint32_t none = set.AddMesh({}, 0, false);
    const uint32_t flat = set.AddSphere(Transform(), 0, 0, 0, 360, 0, false);
    const uint32_t swept = set.AddDisk(Transform(), 0, 1, 0, 0, 0, false);
    set.AddSphere(Transform(), 1, -1, 1, 360, 5, false);
    set.Commit();
    FlushWarnings();
    ShapeSample sample;
    for (const uint32_t id : {none, flat, swept}) {
        EXPECT_EQ(set.Area(id), 0);
        EXPECT_FALSE(set.Sample(id, {0.5f, 0.5f}, &sample));
        EXPECT_FALSE(set.Sample(id, {3, 3, 3}, {0.5f, 0.5f}, &sample));
    }
    ASSERT_TRUE(set.Intersect({{0, 0, -3}, {0, 0, 1}}, &hit));
    EXPECT_EQ(hit.shapeId, 5u);
    EXPECT_NEAR(hit.t, 2, 1e-6);
    for (const Ray &ray :
         {Ray{{kNaN, 0, 0}, {0, 0, 1}}, Ray{{0, 0, -3}, {0, kNaN, 1}}, Ray{{0, 0, -3}, {0, 0, 0}},
          Ray{{0, 0, -3}, {0, 0, Infinity}}, Ray{{0, 0, -3}, {0, 0, 1}, 0, kNaN},
          Ray{{0, 0, -3}, {0, 0, 1}, 0, 1.9f}, Ray{{0, 0, -3}, {0, 0, 1}, 4.1f, 9}}) {
        EXPECT_FALSE(set.Intersect(ray, &hit));
        EXPECT_FALSE(set.Occluded(ray));
    }
    // Within (tMin, tMax) the far side counts.
    ASSERT_TRUE(set.Intersect({{0, 0, -3}, {0, 0, 1}, 2.5f, 9}, &hit));
    EXPECT_NEAR(hit.t, 4, 1e-6);
    EXPECT_GT(set.MemoryBytes(), 0u);
}

} // namespace
} // namespace cuticle
