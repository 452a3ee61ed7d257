// Who passed through whom: by hand for two sticks, and for closed loops against their linking numbers.
#include "dynamics/crossings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cuticle {
namespace {

std::vector<Vector3d> TwoSticks(double x, double y) {
    return {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {x, y, -1}, {x, y, 0.2}, {x, y, 1}};
}

TEST(StrandCrossings, AStickThatFallsThroughAnotherCountsUntilItComesBack) {
    StrandCrossings crossings(TwoSticks(0.3, 1), 3);
    crossings.MoveTo(TwoSticks(0.3, 0.5));
    EXPECT_EQ(crossings.Pairs(), 0u);
    crossings.MoveTo(TwoSticks(0.3, -0.5));
    EXPECT_EQ(crossings.Pairs(), 1u);
    EXPECT_EQ(std::abs(crossings.Side(0, 1)), 1);
    EXPECT_EQ(crossings.Side(1, 0), crossings.Side(0, 1));
    crossings.MoveTo(TwoSticks(0.3, 0.5));
    EXPECT_EQ(crossings.Pairs(), 0u);
    EXPECT_EQ(crossings.Passes(), 2u);
}

// The edges of a stick share a point: what goes through there has gone through one of them.
TEST(StrandCrossings, APassThroughACommonPointCountsOnce) {
    StrandCrossings crossings(TwoSticks(0, 1), 3);
    crossings.MoveTo(TwoSticks(0, -1));
    EXPECT_EQ(crossings.Passes(), 1u);
}

TEST(StrandCrossings, WhatGoesRoundAnEndDoesNotPass) {
    StrandCrossings crossings(TwoSticks(0.3, 1), 3);
    crossings.MoveTo(TwoSticks(1.5, 1));
    crossings.MoveTo(TwoSticks(1.5, -1));
    crossings.MoveTo(TwoSticks(0.3, -1));
    EXPECT_EQ(crossings.Passes(), 0u);
    crossings.MoveTo(TwoSticks(0.3, 1)); // and back through: on the wrong side now
    EXPECT_EQ(crossings.Pairs(), 1u);
}

// Linking number of two closed polygons: half the signed crossings of their shadows on a plane.
int LinkingNumber(const Vector3d *a, const Vector3d *b, size_t n) {
    int sum = 0;
    for (size_t i = 0; i + 1 < n; ++i)
        for (size_t j = 0; j + 1 < n; ++j) {
            const Vector3d p = a[i], u = a[i + 1] - p, q = b[j], v = b[j + 1] - q;
            const double d = u.x * v.y - u.y * v.x;
            const double s = ((q.x - p.x) * v.y - (q.y - p.y) * v.x) / d,
                         t = ((q.x - p.x) * u.y - (q.y - p.y) * u.x) / d;
            if (s >= 0 && s < 1 && t >= 0 && t < 1)
                sum += (d > 0) == (p.z + s * u.z > q.z + t * v.z) ? 1 : -1;
        }
    return sum / 2;
}

// The linking number of two loops changes by one, up or down by the sign, at each pass and at nothing else.
TEST(StrandCrossings, OfLoopsChangeTheLinkingNumberByTheirSum) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    constexpr size_t loops = 12, n = 9;
    const auto place = [&] {
        std::vector<Vector3d> points;
        for (size_t s = 0; s < loops; ++s) {
            for (size_t i = 0; i + 1 < n; ++i)
                points.push_back({uniform(random), uniform(random), uniform(random)});
            points.push_back(points[s * n]);
        }
        return points;
    };
    const std::vector<Vector3d> start = place();
    StrandCrossings crossings(start, n);
    std::vector<Vector3d> now;
    for (int move = 0; move < 3; ++move) // across the whole box: many passes in each
        crossings.MoveTo(now = place());
    size_t changed = 0;
    int sign = 0; // by which the two conventions differ: one for all pairs
    for (size_t a = 0; a < loops; ++a)
        for (size_t b = a + 1; b < loops; ++b) {
            const int change =
                LinkingNumber(&now[a * n], &now[b * n], n) - LinkingNumber(&start[a * n], &start[b * n], n);
            changed += change != 0 ? 1 : 0;
            if (sign == 0 && change != 0)
                sign = change * crossings.Side(a, b) > 0 ? 1 : -1;
            EXPECT_EQ(crossings.Side(a, b), sign * change) << a << " and " << b;
        }
    EXPECT_GT(changed, loops);
    EXPECT_EQ(crossings.Pairs(), changed);
    EXPECT_GT(crossings.Passes(), 10 * changed);
}

} // namespace
} // namespace cuticle
