#include "shapes/curve.h"
#include "shapes/curve_oracle.h"

#include <gtest/gtest.h>

#include <random>

namespace cuticle {
namespace {

struct Random {
    explicit Random(uint64_t seed) : engine(seed) {}
    float operator()(float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine); }
    Point3f Point() { return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)}; }
    std::mt19937_64 engine;
};

CurveSegment Segment(Point3f a, Point3f b, Point3f c, Point3f d, float w0 = 0.1f, float w1 = 0.1f) {
    return {{a, b, c, d}, {w0, w1}, 0};
}
const CurveSegment kAlongX = Segment({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, 0.4f, 0.2f);

Vector3d At(const CurveSegment &s, double u, Vector3d *d = nullptr) {
    const Vector3d cp[4] = {Vector3d(s.cp[0]), Vector3d(s.cp[1]), Vector3d(s.cp[2]), Vector3d(s.cp[3])};
    return EvalBezier(cp, u, d);
}

TEST(Curve, MeetsAStraightCurveWhereGeometrySays) {
    Ray ray;
    ray.o = {1, 0.07f, -5};
    ray.d = {0, 0, 2};
    CurveHit hit;
    CurveSurface s;
    ASSERT_TRUE(Curve(kAlongX, CurveType::Flat).Intersect(ray, &hit, &s));
    EXPECT_NEAR(hit.t, 2.5f, 1e-6f);
    EXPECT_NEAR(hit.u, 1 / 3.f, 1e-6f);
    // pbrt-v3: v grows along d x dp/du = z x x = y.
    const float width = Lerp(1 / 3.f, 0.4f, 0.2f);
    EXPECT_NEAR(hit.v, 0.5f + 0.07f / width, 1e-5f);
    EXPECT_NEAR(s.h, -1 + 2 * hit.v, 1e-6f);
    EXPECT_NEAR(s.width, width, 1e-6f);
    EXPECT_LT((s.p - Point3f(1, 0.07f, 0)).Length(), 1e-6f);
    EXPECT_LT((s.n - Normal3f(0, 0, -1)).Length(), 1e-6f);
    EXPECT_LT((s.tangent - Vector3f(1, 0, 0)).Length(), 1e-6f);
    EXPECT_LT((s.dpdu - Vector3f(3, 0, 0)).Length(), 1e-5f);
    EXPECT_LT((s.dpdv - Vector3f(0, width, 0)).Length(), 1e-6f);
}

TEST(Curve, EndsAtItsEndsAndEdges) {
    const Curve curve(kAlongX, CurveType::Flat);
    const auto hit = [&](float x, float y) {
        Ray ray;
        ray.o = {x, y, -5};
        ray.d = {0, 0, 1};
        return curve.IntersectP(ray);
    };
    EXPECT_TRUE(hit(0.001f, 0.19f));
    EXPECT_FALSE(hit(-0.001f, 0));
    EXPECT_TRUE(hit(2.999f, 0.09f));
    EXPECT_FALSE(hit(3.001f, 0));
    EXPECT_FALSE(hit(0.1f, 0.2f));
    EXPECT_TRUE(hit(0.1f, -0.19f));
}

// The recursion against the oracle: random curves from all sides.
TEST(Curve, RecursionAgreesWithTheOracle) {
    Random random(1);
    size_t rays = 0, wrong = 0;
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
        const CurveSegment s =
            Segment(random.Point(), random.Point(), random.Point(), random.Point(), 0.01f, 0.02f);
        Ray ray;
        ray.o = random.Point() * 4;
        ray.d = Vector3f(At(s, random(0, 1))) + random.Point() * 0.01f - ray.o;
        std::vector<oracle::Candidate> all;
        oracle::FindAll(s, 0, nullptr, ray, 1e-4L, 1e-3L, &all);
        const oracle::Candidate *nearest = nullptr;
        bool border = false;
        for (const auto &c : all) {
            border |= std::abs(c.margin) < 1e-3L || c.u < 1e-4L || c.u > 1 - 1e-4L;
            if (!nearest || c.t < nearest->t)
                nearest = &c;
        }
        if (border)
            continue;
        ++rays;
        CurveHit hit;
        const bool found = Curve(s, CurveType::Flat).Intersect(ray, &hit);
        if (found != (nearest != nullptr) || (found && std::abs(hit.t - nearest->t) > 1e-3L * nearest->t))
            ++wrong;
        else if (found)
            worst = std::max(worst, static_cast<double>(std::abs(hit.v - nearest->v)));
    }
    EXPECT_GT(rays, 15000u);
    EXPECT_EQ(wrong, 0u) << "of " << rays;
    EXPECT_LT(worst, 1e-6);
}

TEST(Curve, CylinderNormalsTurnAsInPbrt) {
    for (const float y : {-0.12f, -0.05f, 0.f, 0.05f, 0.12f}) {
        Ray ray;
        ray.o = {1, y, -5};
        ray.d = {0, 0, 1};
        CurveHit hit;
        CurveSurface s;
        ASSERT_TRUE(Curve(kAlongX, CurveType::Cylinder).Intersect(ray, &hit, &s));
        const float angle = Lerp(hit.v, -Pi / 2, Pi / 2);
        EXPECT_NEAR(s.n.z, -std::cos(angle), 1e-5f);
        EXPECT_NEAR(s.n.y, -std::sin(angle), 1e-5f);
        EXPECT_NEAR(Dot(s.n, s.dpdv), 0, 1e-5f);
        EXPECT_LE(Dot(s.n, ray.d), 0);
    }
}

TEST(Curve, RibbonNarrowsWithItsAngle) {
    const double angle = 60 * kPi<double> / 180;
    const Normal3f n(0, static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle)));
    const RibbonNormals normals{{n, n}};
    CurveSegment s = kAlongX;
    s.width[0] = s.width[1] = 0.4f;
    const Curve ribbon(s, CurveType::Ribbon, &normals);
    const auto ray = [](float y) {
        Ray r;
        r.o = {1, y, -5};
        r.d = {0, 0, 1};
        return r;
    };
    CurveHit hit;
    CurveSurface surface;
    EXPECT_TRUE(ribbon.Intersect(ray(0.099f), &hit, &surface)); // half the width, halved by cos 60
    EXPECT_NEAR(hit.v, 0.5f + 0.099f / 0.2f, 1e-4f);
    EXPECT_NEAR(std::abs(Dot(surface.n, n)), 1, 1e-5f);
    EXPECT_LT(Dot(surface.n, Vector3f(0, 0, 1)), 0);
    EXPECT_FALSE(ribbon.Intersect(ray(0.101f), &hit));
    EXPECT_NEAR(RibbonNormal({{Normal3f(1, 0, 0), Normal3f(0, 1, 0)}}, 0.5f).x, std::sqrt(0.5f), 1e-6f);
}

// Whatever comes in, what goes out is finite.
TEST(Curve, DegenerateCurvesGiveNoNaN) {
    Random random(5);
    const float inf = Infinity, nan = std::numeric_limits<float>::quiet_NaN();
    size_t hits = 0;
    for (int i = 0; i < 1000; ++i) {
        const Point3f a = random.Point(), b = random.Point(), c = random.Point();
        const CurveSegment cases[] = {
            Segment(a, a, b, c),           Segment(a, b, c, c),           Segment(a, a, b, b),
            Segment(a, b, c, a),           Segment(a, a, a, b),           Segment(a, a, a, a),
            Segment(a, b, a, b),           Segment(a, b, c, a, 0, 0.5f),  Segment(a, b, c, c, -1, 0.3f),
            Segment(a, b, c, a, nan, 1),   Segment(a, b, c, b, inf, 1),   Segment({nan, 0, 0}, a, b, c),
            Segment(a, {inf, 0, 0}, b, c), Segment(a, b, c, a, 1e30f, 1), Segment(a * 1e30f, b, c, a, 1, 1)};
        for (const CurveSegment &s : cases)
            for (const CurveType type : {CurveType::Flat, CurveType::Cylinder, CurveType::Ribbon}) {
                const RibbonNormals normals{{Normal3f(0, 0, 1), Normal3f(0, 0, -1)}};
                Ray ray;
                ray.o = i % 2 ? a : random.Point() * 3;
                ray.d = i % 3 ? Vector3f(b - a) : c - ray.o; // also straight along the curve
                CurveHit hit;
                CurveSurface surface;
                if (!Curve(s, type, &normals).Intersect(ray, &hit, &surface))
                    continue;
                ++hits;
                EXPECT_TRUE(IsUsable(s));
                EXPECT_TRUE(std::isfinite(hit.t) && hit.u >= 0 && hit.u <= 1 && hit.v >= 0 && hit.v <= 1);
                EXPECT_TRUE(IsFinite(surface.p) && IsFinite(surface.n) && IsFinite(surface.tangent) &&
                            IsFinite(surface.dpdu) && IsFinite(surface.dpdv));
                EXPECT_NEAR(surface.n.Length(), 1, 1e-5f);
                EXPECT_NEAR(surface.tangent.Length(), 1, 1e-5f);
                EXPECT_NEAR(Dot(surface.n, surface.tangent), 0, 1e-5f);
            }
    }
    EXPECT_GT(hits, 300u);
}

TEST(CurveBases, CountsOfControlPoints) {
    std::string error;
    EXPECT_EQ(CurveSegmentCount(4, CurveBasis::Bezier, 3), 1u);
    EXPECT_EQ(CurveSegmentCount(7, CurveBasis::Bezier, 3), 2u);
    EXPECT_EQ(CurveSegmentCount(5, CurveBasis::Bezier, 2), 2u);
    EXPECT_EQ(CurveSegmentCount(4, CurveBasis::BSpline, 3), 1u);
    EXPECT_EQ(CurveSegmentCount(7, CurveBasis::BSpline, 3), 4u);
    EXPECT_EQ(CurveSegmentCount(7, CurveBasis::BSpline, 2), 5u);
    for (const size_t count : {0, 1, 3, 5, 6})
        EXPECT_EQ(CurveSegmentCount(count, CurveBasis::Bezier, 3, &error), 0u) << count;
    EXPECT_NE(error.find("n * 3 + 1"), std::string::npos) << error;
    EXPECT_EQ(CurveSegmentCount(2, CurveBasis::BSpline, 2, &error), 0u);
    EXPECT_NE(error.find("at least 3"), std::string::npos) << error;
    EXPECT_EQ(CurveSegmentCount(4, CurveBasis::Bezier, 4, &error), 0u);
    EXPECT_NE(error.find("2 or 3"), std::string::npos) << error;
}

// De Boor's recurrence on uniform knots.
Vector3d BSpline(const std::vector<Point3f> &p, int degree, double t) {
    const int span = std::min(static_cast<int>(t), static_cast<int>(p.size()) - degree - 1);
    std::vector<Vector3d> d;
    for (int i = 0; i <= degree; ++i)
        d.push_back(Vector3d(p[static_cast<size_t>(span + i)]));
    for (int r = 1; r <= degree; ++r)
        for (int i = degree; i >= r; --i) {
            // In knots counted so that the span begins at `degree`.
            const double alpha = (t - span + degree - i) / (degree - r + 1);
            d[static_cast<size_t>(i)] =
                d[static_cast<size_t>(i) - 1] * (1 - alpha) + d[static_cast<size_t>(i)] * alpha;
        }
    return d[static_cast<size_t>(degree)];
}

TEST(CurveBases, BSplinesAreDeBoors) {
    Random random(9);
    for (const int degree : {2, 3}) {
        std::vector<Point3f> p;
        for (int i = 0; i < 9; ++i)
            p.push_back(random.Point());
        CurveList s;
        ASSERT_TRUE(AppendCurve(p.data(), p.size(), CurveBasis::BSpline, degree, 1, 0, 7, &s));
        ASSERT_EQ(s.size(), p.size() - static_cast<size_t>(degree));
        for (size_t i = 0; i < s.size(); ++i) {
            for (const double u : {0., 0.3, 0.9})
                EXPECT_LT((At(s[i], u) - BSpline(p, degree, static_cast<double>(i) + u)).Length(), 1e-6)
                    << degree << " " << i << " " << u;
            EXPECT_EQ(s[i].cp[0], i > 0 ? s[i - 1].cp[3] : s[0].cp[0]);
            EXPECT_EQ(s[i].group, 7u);
            EXPECT_NEAR(s[i].width[1], 1 - static_cast<float>(i + 1) / static_cast<float>(s.size()), 1e-6f);
        }
    }
}

TEST(CurveBases, QuadraticBeziersKeepTheirShape) {
    Random random(11);
    const std::vector<Point3f> p{random.Point(), random.Point(), random.Point(), random.Point(),
                                 random.Point()};
    CurveList s;
    ASSERT_TRUE(AppendCurve(p.data(), p.size(), CurveBasis::Bezier, 2, 1, 1, 0, &s));
    ASSERT_EQ(s.size(), 2u);
    for (size_t i = 0; i < 2; ++i)
        for (const double u : {0., 0.25, 0.7, 1.}) {
            const Vector3d q = Vector3d(p[2 * i]) * Sqr(1 - u) + Vector3d(p[2 * i + 1]) * (2 * u * (1 - u)) +
                               Vector3d(p[2 * i + 2]) * Sqr(u);
            EXPECT_LT((At(s[i], u) - q).Length(), 1e-6);
        }
}

TEST(CurveBases, BadWidthsAndNormals) {
    const Point3f p[4] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
    CurveList s;
    std::string error;
    EXPECT_TRUE(AppendCurve(p, 4, CurveBasis::Bezier, 3, -1, 2, 0, &s));
    EXPECT_EQ(s[0].width[0], 0);
    EXPECT_EQ(s[0].width[1], 2);
    EXPECT_FALSE(AppendCurve(p, 4, CurveBasis::Bezier, 3, std::nanf(""), 2, 0, &s, &error));
    EXPECT_NE(error.find("up to 1e18"), std::string::npos);
    EXPECT_EQ(s.size(), 1u);

    std::unordered_map<uint32_t, RibbonNormals> ribbons;
    const Normal3f n[2] = {{0, 0, 2}, {0, 3, 0}}, zero[2] = {{0, 0, 1}, {0, 0, 0}};
    EXPECT_TRUE(AppendRibbon(p, 4, CurveBasis::Bezier, 3, 1, 1, n, 2, 0, &s, &ribbons));
    ASSERT_TRUE(ribbons.contains(1));
    EXPECT_EQ(ribbons[1].n[1], Normal3f(0, 1, 0));
    EXPECT_FALSE(AppendRibbon(p, 4, CurveBasis::Bezier, 3, 1, 1, n, 1, 0, &s, &ribbons, &error));
    EXPECT_NE(error.find("2 are needed"), std::string::npos) << error;
    EXPECT_FALSE(AppendRibbon(p, 4, CurveBasis::Bezier, 3, 1, 1, zero, 2, 0, &s, &ribbons, &error));
    EXPECT_EQ(s.size(), 2u);
}

} // namespace
} // namespace cuticle
