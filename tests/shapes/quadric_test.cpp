// Laws of the quadrics: hits lie on their surfaces, derivatives are derivatives.
#include "shapes/quadric.h"

#include "shapes/solids.h"
#include "warnings.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// Rays aimed at known points of the surface meet it there or nearer, and what the hit says of itself is
// consistent with the parametrisation: position, derivatives, normal.
TEST(Quadrics, HitsLieOnTheSurfaceWithItsDerivatives) {
    for (const ParametrisedShape &shape : ParametrisedQuadrics()) {
        RNG rng(11);
        double worst = 0;
        int tried = 0;
        for (int i = 0; i < 1000; ++i) {
            const bool mirror = i % 2, reverse = i % 3 == 0;
            const Transform t = RandomTransform(rng, mirror);
            SolidSet set;
            const uint32_t id = shape.add(set, t, reverse);
            set.Commit();
            for (int k = 0; k < 20; ++k) {
                const double u = 0.02 + 0.96 * rng.UniformFloat();
                const double v = 0.02 + 0.96 * rng.UniformFloat();
                const Point3f target(Apply(t, shape.at(u, v)));
                const float away = std::pow(10.f, 3 * rng.UniformFloat());
                // A step of the parameters this small stays on the surface; not so near to grazing that the
                // rounding of the origin (1e-4 at most) slides the hit over the rim, 0.02 of the parameters
                // away.
                constexpr double h = 1e-4;
                const Vector3d normal =
                    Normalize(Cross(Apply(t, shape.at(u + h, v)) - Apply(t, shape.at(u - h, v)),
                                    Apply(t, shape.at(u, v + h)) - Apply(t, shape.at(u, v - h))));
                const Vector3f d = RandomDirection(rng);
                if (std::abs(Dot(normal, Vector3d(d))) < 0.1)
                    continue;
                SolidHit hit;
                ASSERT_TRUE(set.Intersect({target - d * away, d}, &hit))
                    << shape.name << " u " << u << " v " << v;
                ++tried;
                EXPECT_EQ(hit.shapeId, 7u);
                EXPECT_EQ(hit.geometryId, id);
                // Another sheet may be nearer. The binary32 origin is off by up to 2e-7 of it, over the
                // cosine.
                EXPECT_LE(hit.t, away * (1 + 4e-6f) + 4e-5f) << shape.name;
                // The parametrisation at the hit's (u, v) gives the hit's point: (u, v) are rounded to 2^-24
                // of ranges that cover at most 16 in world space.
                const double hu = hit.uv.x, hv = hit.uv.y;
                const Vector3d p = Apply(t, shape.at(hu, hv));
                const double error = (p - Vector3d(hit.p)).Length();
                worst = std::max(worst, error);
                // Derivatives against central differences.
                const auto difference = [&](double du, double dv) {
                    return (Apply(t, shape.at(hu + du, hv + dv)) - Apply(t, shape.at(hu - du, hv - dv))) /
                           (2 * h);
                };
                const Vector3d dpdu = difference(h, 0), dpdv = difference(0, h);
                EXPECT_LT((dpdu - Vector3d(hit.dpdu)).Length(), 1e-4 * (1 + dpdu.Length())) << shape.name;
                EXPECT_LT((dpdv - Vector3d(hit.dpdv)).Length(), 1e-4 * (1 + dpdv.Length())) << shape.name;
                // pbrt-v3: the cross product, flipped by reverseOrientation ^ transformSwapsHandedness.
                const Vector3d n = Normalize(Cross(dpdu, dpdv)) * ((reverse != mirror) ? -1. : 1.);
                EXPECT_LT((n - Vector3d(hit.n)).Length(), 2e-3) << shape.name << " " << hit.n;
                EXPECT_EQ(hit.n, hit.ns);
            }
        }
        EXPECT_LT(worst, 4e-6) << shape.name
                               << ": distance of the point at (u, v) from the hit, n = " << tried;
        EXPECT_GT(tried, 15000) << shape.name;
    }
}

// A quadric by its implicit function, with its clips.
struct ImplicitQuadric {
    const char *name;
    std::function<void(SolidSet &)> add;
    std::function<double(const Vector3d &)> f;
    double zMin, zMax, phiMax;
    std::function<Vector3d(double)> sweepStart; // by z
};
std::vector<ImplicitQuadric> ImplicitQuadrics() {
    const double deg = kPi<double> / 180;
    const auto ahead = [](double) { return Vector3d(1, 0, 0); };
    const auto r2 = [](const Vector3d &p) { return p.x * p.x + p.y * p.y; };
    return {
        {"cone", [](SolidSet &s) { s.AddCone(Transform(), 0.8f, 1.5f, 300, 0, false); },
         [=](const Vector3d &p) { return r2(p) - Sqr(0.8f * (1 - p.z / 1.5)); }, 0, 1.5, 300 * deg, ahead},
        {"paraboloid", [](SolidSet &s) { s.AddParaboloid(Transform(), 1.25f, 0.125f, 1.5f, 230, 0, false); },
         [=](const Vector3d &p) { return r2(p) - Sqr(1.25) * p.z / 1.5; }, 0.125, 1.5, 230 * deg, ahead},
        {"paraboloid downward",
         [](SolidSet &s) { s.AddParaboloid(Transform(), 0.5f, -1.5f, -0.25f, 360, 0, false); },
         [=](const Vector3d &p) { return r2(p) + p.z; }, -1.5, -0.25, 360 * deg, ahead},
        // r^2 = 1/4 + z^2: the line x = 1/2, y = z
        {"hyperboloid",
         [](SolidSet &s) {
             s.AddHyperboloid(Transform(), {0.5f, -1, -1}, {0.5f, 0.75f, 0.75f}, 280, 0, false);
         },
         [=](const Vector3d &p) { return r2(p) - 0.25 - p.z * p.z; }, -1, 0.75, 280 * deg,
         [](double z) { return Vector3d(0.5, z, 0); }},
        // The line meets the axis: a double cone, for which pbrt-v3 searches without end
        {"hyperboloid of pbrt-v3's defaults",
         [](SolidSet &s) {
             s.AddHyperboloid(Transform(), {0, 0, 0}, {1, 1, 1}, 360, 0, false);
         },
         [=](const Vector3d &p) { return r2(p) - 2 * p.z * p.z; }, 0, 1, 360 * deg,
         [](double z) { return Vector3d(z, z, 0); }},
        // pbrt-v3's equation through the circles of p2 (r^2 = 1/4 at z = -1) and of 2 p2 - p1 (r^2 = 9/4 at z
        // = -3), which for this segment is no sweep: r^2 = z^2 / 4
        {"hyperboloid that is not swept",
         [](SolidSet &s) {
             s.AddHyperboloid(Transform(), {2.5f, 0, 1}, {0.5f, 0, -1}, 360, 0, false);
         },
         [=](const Vector3d &p) { return r2(p) - p.z * p.z / 4; }, -1, 1, 360 * deg, ahead},
        // As that of the scene that shows all shapes: r^2 = (3 z^2 - 1) / 8, with a gap between the sheets
        {"hyperboloid of two sheets",
         [](SolidSet &s) {
             s.AddHyperboloid(Transform(), {2.5f, 1, 1}, {0.5f, 0, -1}, 360, 0, false);
         },
         [=](const Vector3d &p) { return r2(p) - 0.25 - 0.375 * (p.z * p.z - 1); }, -1, 1, 360 * deg, ahead},
    };
}

// The answer of a search: t of the nearest hit, or -1; unsure: a clip or another root is too near.
struct RootSearch {
    double t = -1;
    bool unsure = false;
};
RootSearch FindFirstRoot(const ImplicitQuadric &c, const Ray &ray, double from, double to) {
    const Vector3d o(ray.o), d(ray.d);
    constexpr int kSteps = 1500;
    RootSearch found;
    double t0 = from, f0 = c.f(o + d * t0);
    for (int k = 1; k <= kSteps && found.t < 0; ++k) {
        const double t1 = Lerp(double(k) / kSteps, from, to), f1 = c.f(o + d * t1);
        if ((f0 > 0) != (f1 > 0)) {
            double lo = t0, hi = t1;
            for (int b = 0; b < 60; ++b)
                (((c.f(o + d * ((lo + hi) / 2)) > 0) == (f0 > 0)) ? lo : hi) = (lo + hi) / 2;
            const Vector3d p = o + d * lo, s = c.sweepStart(p.z);
            double phi = std::atan2(s.x * p.y - s.y * p.x, s.x * p.x + s.y * p.y);
            phi += phi < 0 ? 2 * kPi<double> : 0;
            const double clip = std::min({p.z - c.zMin, c.zMax - p.z, c.phiMax - phi});
            found.unsure |= std::abs(clip) < 1e-3 || phi < 1e-3 || phi > 2 * kPi<double> - 1e-3;
            if (clip > 0 || (c.phiMax > 6.28 && std::min(p.z - c.zMin, c.zMax - p.z) > 0))
                found.t = lo;
        } else {
            // Two roots in one step: the function comes near to zero.
            found.unsure |= std::abs(f0) < 1e-3;
        }
        t0 = t1, f0 = f1;
    }
    return found;
}

// The quadrics against a search that knows nothing but their implicit functions: a ray is walked in small
// steps, and each change of sign is bisected, in double. A root is a hit where the point lies within the
// clips; roots nearer than a thousandth to a clip or to another root are left to the others. Rays start
// inside, near and far.
TEST(Quadrics, AgreeWithARootSearch) {
    for (const ImplicitQuadric &c : ImplicitQuadrics()) {
        SolidSet set;
        c.add(set);
        set.Commit();
        RNG rng(31);
        int hits = 0, misses = 0;
        for (int i = 0; i < 4000; ++i) {
            const float away = std::pow(10.f, 2 * rng.UniformFloat() - 1);
            const Point3f target = RandomPoint(rng, 1.2f);
            const Vector3f d = RandomDirection(rng);
            const Ray ray{target - d * away, d};
            // Roots within the cube of half-width 2, which holds every shape.
            const RootSearch expected =
                FindFirstRoot(c, ray, std::max(0., double(away) - 6), double(away) + 6);
            SolidHit hit;
            const bool found = set.Intersect(ray, &hit);
            EXPECT_EQ(found, set.Occluded(ray)) << c.name;
            if (expected.unsure)
                continue;
            ASSERT_EQ(found, expected.t >= 0)
                << c.name << " o " << ray.o << " d " << ray.d << " t " << expected.t;
            (found ? hits : misses) += 1;
            if (found) {
                EXPECT_NEAR(hit.t, expected.t, 1e-6 * (1 + expected.t)) << c.name;
            }
        }
        EXPECT_GT(hits, 400) << c.name;
        EXPECT_GT(misses, 300) << c.name;
    }
    FlushWarnings();
}

// A full sphere against the closed form in long double, also from far away and with large radii.
TEST(Quadrics, SphereDistanceAgreesWithLongDouble) {
    RNG rng(3);
    int hits = 0;
    for (int i = 0; i < 20000; ++i) {
        const float radius = std::pow(10.f, 6 * rng.UniformFloat() - 3);
        SolidSet set;
        set.AddSphere(Transform(), radius, -radius, radius, 360, 0, false);
        set.Commit();
        const Vector3f w = RandomDirection(rng);
        const Point3f o = w * (radius * std::pow(10.f, 4 * rng.UniformFloat() - 1));
        const Point3f target = RandomPoint(rng, radius);
        const Vector3f d = target - o;
        using Real = long double;
        const Vector3<Real> od(o), dd(d);
        const Real a = Dot(dd, dd), b = Dot(od, dd), c = Dot(od, od) - Real(radius) * Real(radius);
        const Real disc = b * b - a * c;
        SolidHit hit;
        const bool found = set.Intersect({o, d}, &hit);
        if (std::abs(disc) < 1e-9L * b * b || std::abs(c) < 1e-6L * Dot(od, od))
            continue;
        const Real s = std::sqrt(std::max(disc, Real(0))), near = (-b - s) / a, far = (-b + s) / a;
        const bool expected = disc > 0 && far > 0;
        ASSERT_EQ(found, expected) << "radius " << radius << " o " << o << " d " << d;
        if (!found)
            continue;
        ++hits;
        const Real t = near > 0 ? near : far;
        EXPECT_LE(std::abs(Real(hit.t) - t), 1.2e-7L * t);
        const Vector3<Real> p = od + dd * t;
        for (int k = 0; k < 3; ++k)
            EXPECT_LE(std::abs(Real(hit.p[k]) - p[k]), Real(hit.pError[k]) + 1e-13L * radius)
                << "coordinate " << k;
    }
    EXPECT_GT(hits, 8000);
}

TEST(Quadrics, PoleAndCentreGiveAFrame) {
    SolidSet set;
    set.AddSphere(Transform(), 1, -1, 1, 360, 0, false);
    set.AddDisk(Transform(), 3, 1, 0, 360, 0, false);
    set.AddCone(Transform::Translate({0, 0, 4}), 1, 1, 360, 0, false);
    set.Commit();
    for (const float z : {2.f, 4.f, 6.f}) {
        SolidHit hit;
        ASSERT_TRUE(set.Intersect({{0, 0, z}, {0, 0, -1}}, &hit));
        EXPECT_EQ(hit.n, Normal3f(0, 0, 1));
        EXPECT_GT(Cross(hit.dpdu, hit.dpdv).Length(), 0.99f);
        EXPECT_TRUE(std::isfinite(hit.uv.x) && std::isfinite(hit.uv.y));
    }
}

} // namespace
} // namespace cuticle
