// Laws of the sampling of solids: densities integrate to one and are those of the samples.
#include "shapes/solids.h"
#include "warnings.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

std::vector<ParametrisedShape> Emitters() {
    std::vector<ParametrisedShape> shapes = ParametrisedQuadrics();
    shapes.push_back({"mesh",
                      [](SolidSet &s, const Transform &t, bool flip) {
                          TriangleMesh mesh;
                          mesh.p = {t.Point({0, 0, 0}), t.Point({2, 0, 0}), t.Point({0, 1, 0}),
                                    t.Point({0, 0, 0.3f}), t.Point({2, 2, 2})};
                          mesh.indices = {0, 1, 2, 9, 9, 9, 0, 2, 3, 1, 2, 4};
                          return s.AddMesh(mesh, 7, flip);
                      },
                      nullptr});
    return shapes;
}

// The density is one: summed over all the hits along each of many stratified directions it integrates to 1.
// Significance: 5 standard errors of the strata's means, about 6e-7 a case.
TEST(Sampling, DensityIntegratesToOne) {
    RNG rng(21);
    for (const ParametrisedShape &shape : Emitters())
        for (int round = 0; round < 4; ++round) {
            const Transform t = round == 0 ? Transform() : RandomTransform(rng, round % 2);
            SolidSet set;
            const uint32_t id = shape.add(set, t, false);
            set.Commit();
            ShapeSample around;
            ASSERT_TRUE(set.Sample(id, {0.3f, 0.6f}, &around));
            const Point3f ref = around.p + around.n * 1.5f + RandomPoint(rng, 1);
            constexpr int kGrid = 400;
            double sum = 0, sum2 = 0;
            for (int i = 0; i < kGrid; ++i)
                for (int j = 0; j < kGrid; ++j) {
                    const Vector3f w =
                        UniformSampleSphere({(static_cast<float>(i) + rng.UniformFloat()) / kGrid,
                                             (static_cast<float>(j) + rng.UniformFloat()) / kGrid});
                    double value = 0;
                    Ray ray{ref, w};
                    SolidHit hit;
                    for (int k = 0; k < 10 && set.Intersect(ray, &hit); ++k) {
                        // A sphere seen from outside is sampled by direction: its far side is not a second
                        // way.
                        const float pdf = set.Pdf(ref, hit);
                        const bool cone = shape.name == "sphere" && round == 0 && ref.Length() > 1.5f;
                        if (!cone || k == 0)
                            value += pdf;
                        ray.o = OffsetRayOrigin(hit.p, hit.pError, hit.n, w);
                    }
                    sum += value;
                    sum2 += value * value;
                }
            constexpr double n = kGrid * kGrid;
            const double mean = sum / n, error = std::sqrt(std::max(0., sum2 / n - mean * mean) / n);
            EXPECT_NEAR(mean * 4 * kPi<double>, 1, 5 * error * 4 * kPi<double>)
                << shape.name << " round " << round << ", n = " << n;
        }
}

// Pdf says of a direction what Sample says of it; and the sampled point is where a ray in that direction
// arrives.
TEST(Sampling, SampleAndPdfAgree) {
    RNG rng(22);
    for (const ParametrisedShape &shape : Emitters()) {
        int tried = 0;
        for (int round = 0; round < 40; ++round) {
            const Transform t = round == 0 ? Transform() : RandomTransform(rng, round % 2);
            SolidSet set;
            const uint32_t id = shape.add(set, t, round % 3 == 0);
            set.Commit();
            for (int k = 0; k < 100; ++k) {
                const Point3f ref = t.Point({0, 0, 0}) + RandomPoint(rng, 10);
                ShapeSample sample;
                if (!set.Sample(id, ref, {rng.UniformFloat(), rng.UniformFloat()}, &sample))
                    continue;
                ASSERT_TRUE(std::isfinite(sample.pdf) && sample.pdf > 0);
                EXPECT_NEAR(sample.n.Length(), 1, 1e-5);
                const Vector3f w = sample.p - ref;
                const float cosine = AbsDot(Normalize(w), sample.n);
                if (cosine < 0.02f)
                    continue;
                // Look about the sampled point only, as near as coordinates of up to 16 are rounded.
                SolidHit hit;
                const float window = 1e-5f / (cosine * w.Length()) + 1e-6f;
                ASSERT_TRUE(set.Intersect({ref, w, 1 - window, 1 + window}, &hit))
                    << shape.name << " cosine " << cosine;
                EXPECT_LT((hit.p - sample.p).Length(), 1e-4f / cosine) << shape.name;
                EXPECT_GT(Dot(hit.n, sample.n), 0.99f) << shape.name;
                EXPECT_NEAR(set.Pdf(ref, hit) / sample.pdf, 1, 1e-3 / cosine) << shape.name;
                ++tried;
            }
        }
        EXPECT_GT(tried, 2000) << shape.name;
    }
    FlushWarnings();
}

// Samples of the area are uniform: the mean of a function over them is its surface integral, known in closed
// form.
TEST(Sampling, AreaSamplesAreUniform) {
    SolidSet set;
    const uint32_t sphere = set.AddSphere(Transform(), 2, -1, 1.5f, 360, 0, false);
    const uint32_t disk = set.AddDisk(Transform(), 0, 2, 1, 360, 0, false);
    const uint32_t cylinder = set.AddCylinder(Transform::Scale(2, 2, 1), 0.5f, 0, 2, 180, 0, false);
    set.Commit();
    EXPECT_NEAR(set.Area(sphere), 2 * Pi * 2 * 2.5f, 1e-3);
    EXPECT_NEAR(set.Area(disk), Pi * 3, 1e-4);
    EXPECT_NEAR(set.Area(cylinder), Pi * 2, 1e-4);
    double z = 0, r2 = 0, y = 0;
    constexpr int kGrid = 200;
    for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
            const Point2f u{(static_cast<float>(i) + 0.5f) / kGrid, (static_cast<float>(j) + 0.5f) / kGrid};
            ShapeSample s;
            ASSERT_TRUE(set.Sample(sphere, u, &s));
            EXPECT_NEAR(s.pdf, 1 / (10 * Pi), 1e-6);
            z += s.p.z;
            ASSERT_TRUE(set.Sample(disk, u, &s));
            EXPECT_NEAR(s.pdf, 1 / (3 * Pi), 1e-6);
            r2 += static_cast<double>(s.p.x * s.p.x + s.p.y * s.p.y);
            ASSERT_TRUE(set.Sample(cylinder, u, &s));
            EXPECT_NEAR(s.pdf, 1 / (2 * Pi), 1e-6);
            y += s.p.y;
        }
    // Pappus: the cone's slant height times the path of its middle; a hyperboloid's is no closed form worth
    // writing, but that of a cone (its line through the axis) is.
    SolidSet round;
    const uint32_t cone = round.AddCone(Transform(), 1.5f, 2, 180, 0, false);
    const uint32_t bowl = round.AddParaboloid(Transform(), 2, 0, 1, 360, 0, false);
    const uint32_t line = round.AddHyperboloid(Transform(), {1.5f, 0, 2}, {0, 0, 0}, 360, 0, false);
    round.Commit();
    EXPECT_NEAR(round.Area(cone), Pi * 0.75f * 2.5f, 1e-4);
    // (pi r / 6 h^2) ((r^2 + 4 h^2)^(3/2) - r^3)
    EXPECT_NEAR(round.Area(bowl), Pi * 2 / 6 * (std::pow(8.f, 1.5f) - 8), 1e-4);
    EXPECT_NEAR(round.Area(line), Pi * 1.5f * 2.5f, 2e-3);
    double height = 0;
    for (int i = 0; i < kGrid; ++i) {
        ShapeSample s;
        ASSERT_TRUE(round.Sample(cone, {0.3f, (static_cast<float>(i) + 0.5f) / kGrid}, &s));
        EXPECT_NEAR(s.pdf, 1 / (Pi * 0.75f * 2.5f), 1e-6);
        height += s.p.z / kGrid;
        ASSERT_TRUE(round.Sample(bowl, {0.3f, (static_cast<float>(i) + 0.5f) / kGrid}, &s));
        EXPECT_NEAR(s.pdf, 1 / round.Area(bowl), 1e-6);
    }
    EXPECT_NEAR(height, 2. / 3, 1e-3); // centroid of a triangle
    constexpr double n = kGrid * kGrid;
    EXPECT_NEAR(z / n, 0.25, 1e-4);            // mean height of a zone: the middle of its range
    EXPECT_NEAR(r2 / n, 2.5, 1e-4);            // (1 + 4) / 2
    EXPECT_NEAR(y / n, 2 / kPi<double>, 1e-4); // mean of sin over half a turn
}

// A sphere as seen from outside: the density is one over its solid angle, also for tiny and for near ones.
TEST(Sampling, SphereConeIsExact) {
    for (const double ratio : {1.0001, 1.1, 2., 100., 1e5, 1e7}) {
        SolidSet set;
        const uint32_t id = set.AddSphere(Transform(), 1, -1, 1, 360, 0, false);
        set.Commit();
        ShapeSample s;
        const auto distance = static_cast<float>(ratio);
        ASSERT_TRUE(set.Sample(id, {0, 0, distance}, {0.4f, 0.7f}, &s));
        const auto d = static_cast<long double>(distance);
        const long double omega = 2 * kPi<long double> / (d * d) / (1 + std::sqrt(1 - 1 / (d * d)));
        EXPECT_NEAR(static_cast<double>(static_cast<long double>(s.pdf) * omega), 1, 2e-7)
            << "distance " << ratio;
        EXPECT_NEAR(s.p.Length(), 1, 1e-6);
        EXPECT_GT(s.p.z, 0);
    }
}

// A place on a sphere, rounded to single precision and so as often outside as inside, sees the whole sphere
// from inside: a point at distance d has the cosine d / 2R at both ends and the density d / 2 pi R, and
// every single sample of the irradiance is pi. Far away from the origin as well.
TEST(Sampling, SphereIsSeenFromItsOwnSurface) {
    RNG rng(24);
    for (const float far : {0.f, 100.f, 1e4f}) {
        SolidSet set;
        const Transform t = Transform::Translate({far, -far, 2 * far}) * Transform::Rotate(33, {1, 2, 3});
        const double radius = 1.5;
        const uint32_t id = set.AddSphere(t, 1.5f, -2, 2, 360, 0, true);
        set.Commit();
        for (int k = 0; k < 3000; ++k) {
            ShapeSample at, seen;
            ASSERT_TRUE(set.Sample(id, {rng.UniformFloat(), rng.UniformFloat()}, &at));
            ASSERT_TRUE(set.Sample(id, at.p, {rng.UniformFloat(), rng.UniformFloat()}, &seen));
            const double rounding = (1 + 2.5 * double(far)) * 0x1p-23;
            EXPECT_GT(seen.cosine, 0) << "inside, whatever the rounding";
            EXPECT_NEAR(seen.cosine, seen.distance / (2 * radius), 1e-5);
            if (seen.distance > 0.05) {
                EXPECT_NEAR(double(Dot(at.n, seen.wi) / seen.pdf), kPi<double>,
                            100 * rounding / seen.distance + 1e-4);
            }
            SolidHit hit;
            hit.geometryId = id, hit.p = seen.p, hit.n = seen.n;
            EXPECT_NEAR(set.Pdf(at.p, hit) / seen.pdf, 1, 4 * rounding / seen.distance + 1e-6);
        }
    }
}

// The irradiance across a sphere's surface, on a plane that faces its centre: pi R^2 / d^2 outside, pi inside
// (of a uniform field) wherever the place is.
TEST(Sampling, SphereIsTheSameNearItsSurface) {
    const auto irradiance = [](float z, bool inward) {
        SolidSet set;
        const uint32_t id = set.AddSphere(Transform(), 1, -1, 1, 360, 0, inward);
        set.Commit();
        constexpr int kGrid = 500;
        double sum = 0;
        for (int i = 0; i < kGrid; ++i)
            for (int j = 0; j < kGrid; ++j) {
                ShapeSample s;
                const Point2f u{(static_cast<float>(i) + 0.5f) / kGrid,
                                (static_cast<float>(j) + 0.5f) / kGrid};
                if (set.Sample(id, {0, 0, z}, u, &s) && s.cosine > 0)
                    sum += std::max(0.f, -s.wi.z) / s.pdf;
            }
        return sum / (kGrid * kGrid);
    };
    for (const float out : {1e-6f, 1e-4f, 0.1f, 1.f}) {
        const double d = 1 + double(out);
        EXPECT_NEAR(irradiance(1 + out, false), kPi<double> / (d * d), 1e-4) << out << " outside";
    }
    EXPECT_NEAR(irradiance(1, true), kPi<double>, 1e-4) << "on it";
    // By area, of which half lies behind the place: the midpoint rule smears the part that is near.
    EXPECT_NEAR(irradiance(0.9f, true), kPi<double>, 5e-3) << "inside";
}

// The limb of a sphere is seen from outside, however the last bits fall; so is all of it from afar.
TEST(Sampling, SphereShowsItsOuterSideUpToTheLimb) {
    for (const bool reversed : {false, true})
        for (const float d : {1.00001f, 1.5f, 1e4f}) {
            SolidSet set;
            const uint32_t id = set.AddSphere(Transform::Translate({0.3, -2, 5}), 1, -1, 1, 360, 0, reversed);
            set.Commit();
            for (int k = 0; k < 100; ++k) {
                ShapeSample s;
                ASSERT_TRUE(
                    set.Sample(id, {0.3f, -2, 5 + d}, {OneMinusEpsilon, 0.01f * static_cast<float>(k)}, &s));
                EXPECT_EQ(s.cosine > 0, !reversed) << d;
                EXPECT_LT(std::abs(s.cosine), 0.01f) << d;
                EXPECT_TRUE(IsFinite(s.wi) && s.distance > 0) << d;
            }
        }
}

// A flat emitter does not light its own plane, and its two sides are told apart right above it. Rounded
// corners and places leave a height of a few last bits either way: that is no side.
TEST(Sampling, FlatEmittersAreDarkInTheirPlane) {
    RNG rng(25);
    for (int round = 0; round < 100; ++round) {
        const Transform t = Transform::Translate(Vector3d(RandomPoint(rng, 50))) *
                            Transform::Rotate(360 * rng.UniformFloat(), Vector3d(RandomDirection(rng)));
        SolidSet set;
        TriangleMesh mesh;
        mesh.p = {t.Point({0, 0, 0}), t.Point({1, 0, 0}), t.Point({0, 1, 0})};
        mesh.indices = {0, 1, 2};
        const uint32_t ids[] = {set.AddDisk(t, 0, 1, 0, 360, 0, false), set.AddMesh(mesh, 1, false)};
        set.Commit();
        for (const uint32_t id : ids) {
            const auto u = [&] { return Point2f(rng.UniformFloat(), rng.UniformFloat()); };
            ShapeSample at, seen;
            ASSERT_TRUE(set.Sample(id, u(), &at));
            EXPECT_FALSE(set.Sample(id, at.p, u(), &seen)) << "shape " << id;
            SolidHit hit;
            hit.geometryId = id;
            ASSERT_TRUE(set.Sample(id, u(), &seen));
            hit.p = seen.p, hit.n = seen.n;
            EXPECT_EQ(set.Pdf(at.p, hit), 0) << "shape " << id;
            for (const float side : {-1e-4f, 1e-4f}) {
                const Point3f above = at.p + at.n * side;
                ASSERT_TRUE(set.Sample(id, above, u(), &seen));
                EXPECT_EQ(seen.cosine > 0, side > 0) << "shape " << id;
                hit.p = seen.p, hit.n = seen.n;
                EXPECT_NEAR(set.Pdf(above, hit) / seen.pdf, 1, 0.01) << "shape " << id;
            }
        }
    }
}

} // namespace
} // namespace cuticle
