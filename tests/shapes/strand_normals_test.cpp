// The axis that strands carry: across the strand, without jumps, without twist, another on every strand.
#include "shapes/strand_normals.h"

#include "shapes/curve.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// A helix of cubic pieces: position and derivative are the curve's own at the ends.
CurveList Helix(float pitch, size_t pieces, double turns) {
    std::vector<CurveSegment> segments;
    const double step = 2 * std::numbers::pi * turns / static_cast<double>(pieces);
    const auto at = [pitch](double t) {
        return Vector3f(static_cast<float>(std::cos(t)), static_cast<float>(std::sin(t)),
                        pitch * static_cast<float>(t));
    };
    const auto slope = [pitch](double t) {
        return Vector3f(static_cast<float>(-std::sin(t)), static_cast<float>(std::cos(t)), pitch);
    };
    for (size_t i = 0; i < pieces; ++i) {
        const double a = step * static_cast<double>(i), b = a + step;
        const Point3f start = Point3f(0, 0, 0) + at(a), end = Point3f(0, 0, 0) + at(b);
        const auto third = static_cast<float>(step / 3);
        segments.push_back(
            {{start, start + slope(a) * third, end - slope(b) * third, end}, {0.01f, 0.01f}, 0});
    }
    for (size_t i = 1; i < pieces; ++i)
        segments[i].cp[0] = segments[i - 1].cp[3];
    return segments;
}
Vector3f TangentAt(const CurveSegment &s, double u) {
    Vector3d cp[4], d;
    for (size_t i = 0; i < 4; ++i)
        cp[i] = {s.cp[i].x, s.cp[i].y, s.cp[i].z};
    EvalBezier(cp, u, &d);
    return Vector3f(Normalize(d));
}

TEST(StrandNormals, AreAcrossAndSmooth) {
    const CurveList helix = Helix(0.3f, 24, 3);
    const std::vector<Vector3f> normals = MakeStrandNormals(helix);
    ASSERT_EQ(normals.size(), helix.size());
    Vector3f before;
    for (size_t i = 0; i < helix.size(); ++i)
        for (int k = 0; k <= 16; ++k) {
            const Vector3f t = TangentAt(helix[i], k / 16.),
                           n = StrandNormal(helix[i], normals[i], static_cast<float>(k) / 16, t);
            EXPECT_NEAR(n.Length(), 1, 1e-5);
            EXPECT_NEAR(Dot(n, t), 0, 1e-5);
            if (i + static_cast<size_t>(k) > 0) {
                EXPECT_LT((n - before).Length(), 0.06f) << i << " " << k; // 3 turns in 24 x 16 steps
            }
            before = n;
        }
}

// Carried without twist, a frame turns about the tangent by what the curve's shape alone asks for: on a helix
// of radius 1 and pitch b the principal normal turns back against it by torsion times length, b / sqrt(1 +
// b^2) a radian.
TEST(StrandNormals, DoNotTwist) {
    const double pitch = 0.5, turns = 2;
    const CurveList helix = Helix(static_cast<float>(pitch), 200, turns);
    const std::vector<Vector3f> normals = MakeStrandNormals(helix);
    const auto angle = [](const Vector3f &normal, double t, const Vector3f &tangent) {
        const Vector3f inward(static_cast<float>(-std::cos(t)), static_cast<float>(-std::sin(t)), 0);
        return std::atan2(static_cast<double>(Dot(normal, Cross(tangent, inward))),
                          static_cast<double>(Dot(normal, inward)));
    };
    const Vector3f last = TangentAt(helix.back(), 1);
    const double turned =
        angle(StrandNormal(helix.back(), normals.back(), 1, last), 2 * std::numbers::pi * turns, last) -
        angle(normals[0], 0, TangentAt(helix[0], 0));
    const double expected = -2 * std::numbers::pi * turns * pitch / std::sqrt(1 + pitch * pitch);
    EXPECT_NEAR(std::remainder(turned - expected, 2 * std::numbers::pi), 0, 2e-3);
}

TEST(StrandNormals, DifferFromStrandToStrand) {
    CurveList strands;
    for (int i = 0; i < 2000; ++i) {
        const auto x = static_cast<float>(i);
        strands.push_back({{{x, 0, 0}, {x, 1, 0}, {x, 2, 0}, {x, 3, 0}}, {0.1f, 0.1f}, 0});
        strands.push_back({{{x, 3, 0}, {x, 4, 0}, {x, 5, 0}, {x, 6, 0}}, {0.1f, 0.1f}, 0});
    }
    const std::vector<Vector3f> normals = MakeStrandNormals(strands);
    double x = 0, y = 0; // of the doubled angle: mean of uniform directions is 0 +- 1/sqrt(n)
    for (size_t i = 0; i < normals.size(); i += 2) {
        EXPECT_NEAR((normals[i] - normals[i + 1]).Length(), 0, 1e-6);
        const auto a = std::atan2(normals[i].z, normals[i].x);
        x += std::cos(2 * a), y += std::sin(2 * a);
    }
    EXPECT_LT(std::hypot(x, y) / 2000, 4 / std::sqrt(2000.));
    EXPECT_GT((normals[0] - normals[2]).Length(), 1e-3);
}

// Segments without length, and cusps, still have a direction.
TEST(StrandNormals, DegenerateSegments) {
    const Point3f p(1, 2, 3);
    const CurveSegment point{{p, p, p, p}, {0.1f, 0.1f}, 0};
    const std::vector<Vector3f> normals = MakeStrandNormals(std::vector{point, point});
    for (const Vector3f &n : normals)
        EXPECT_NEAR(n.Length(), 1, 1e-5);
    EXPECT_NEAR(StrandNormal(point, normals[0], 0.5f, {0, 0, 1}).Length(), 1, 1e-5);
    EXPECT_TRUE(MakeStrandNormals({}).empty());
}

} // namespace
} // namespace cuticle
