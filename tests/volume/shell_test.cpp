// Laws of the shell and of the distance to it: shapes whose distance is known, brute force, and hair.
#include "volume/shell.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "grooms/procedural.h"
#include "volume/density.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

namespace cuticle {
namespace {

template <class F>
DenseGrid<float> Field(float cell, float half, const F &value) {
    DenseGrid<float> grid(BoxAround({{-half, -half, -half}, {half, half, half}}, cell, 2));
    for (size_t k = 0; k < grid.box.size[2]; ++k)
        for (size_t j = 0; j < grid.box.size[1]; ++j)
            for (size_t i = 0; i < grid.box.size[0]; ++i)
                grid.At(i, j, k) = value(grid.box.Position(i, j, k));
    return grid;
}
// A density whose shell at 1 is a sphere of radius 1.
DenseGrid<float> Ball(float cell) {
    return Field(cell, 1.5f, [](const Point3f &p) { return 2 - p.LengthSquared(); });
}
DenseGrid<float> DensityOfHead(float cell) {
    GroomParams params = MakeGroomParams("head", "wavy");
    params.strands = 4000;
    const Groom groom = MakeGroom(params);
    const StrandSet strands = CurvesOf(groom);
    return LineDensity(strands, BoxAround(BoundsOf(strands), cell, 3));
}

// The error of a sphere's shell falls by four with every halving of the cells.
TEST(Shell, OfABallConvergesToTheSphere) {
    double before = 0;
    for (const float cell : {0.2f, 0.1f, 0.05f}) {
        const HairShell shell = MakeShell(Ball(cell), 1);
        double most = 0, mean = 0;
        for (size_t k = 0; k < shell.distance.box.size[2]; ++k)
            for (size_t j = 0; j < shell.distance.box.size[1]; ++j)
                for (size_t i = 0; i < shell.distance.box.size[0]; ++i) {
                    const Point3f p = shell.distance.box.Position(i, j, k);
                    most = std::max(
                        most, static_cast<double>(std::abs(shell.distance.At(i, j, k) - (p.Length() - 1))));
                }
        EXPECT_LT(most, 1.5 * Sqr(static_cast<double>(cell)));
        if (before > 0) {
            EXPECT_LT(mean, before / 3.5) << cell;
        }
        before = mean;
        EXPECT_NEAR(shell.Volume(), 4 * kPi<double> / 3, 6 * Sqr(static_cast<double>(cell)));
        for (size_t i = 0; i < shell.mesh.points.size(); ++i)
            ASSERT_GT(Dot(shell.mesh.normals[i], Normalize(shell.mesh.points[i])), 0.99f);
    }
}

// A closed surface: every side of a triangle is a side of its neighbours as often in the other direction.
TEST(Shell, IsClosed) {
    const HairShell shell = MakeShell(DensityOfHead(1.5f), 1e-4f);
    std::map<std::pair<uint32_t, uint32_t>, int> sides;
    const auto &indices = shell.mesh.indices;
    for (size_t i = 0; i < indices.size(); i += 3)
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t a = indices[i + k], b = indices[i + (k + 1) % 3];
            sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    ASSERT_GT(sides.size(), 1000u);
    for (const auto &[side, turns] : sides)
        ASSERT_EQ(turns, 0);
    EXPECT_GT(shell.Volume(), 0);
}

// The nearest point of a triangle to p, by another way than the program's: barycentric walls, then sides.
Point3f NearestOf(const Point3f &p, const Point3f &a, const Point3f &b, const Point3f &c) {
    const auto onSide = [&](const Point3f &from, const Point3f &to) {
        const Vector3f d = to - from;
        const float t = Dot(p - from, d) / std::max(d.LengthSquared(), 1e-30f);
        return from + d * std::clamp(t, 0.f, 1.f);
    };
    const Vector3f n = Cross(b - a, c - a);
    if (n.LengthSquared() > 0 && Dot(Cross(n, b - a), p - a) >= 0 && Dot(Cross(n, c - b), p - b) >= 0 &&
        Dot(Cross(n, a - c), p - c) >= 0)
        return p - n * (Dot(p - a, n) / n.LengthSquared());
    Point3f best = onSide(a, b);
    for (const Point3f &q : {onSide(b, c), onSide(c, a)})
        if ((p - q).LengthSquared() < (p - best).LengthSquared())
            best = q;
    return best;
}
// The nearest point of all triangles.
Point3f NearestOf(const Point3f &p, const SurfaceMesh &mesh) {
    Point3f best{1e9f, 0, 0};
    for (size_t t = 0; t < mesh.indices.size(); t += 3) {
        const Point3f q = NearestOf(p, mesh.points[mesh.indices[t]], mesh.points[mesh.indices[t + 1]],
                                    mesh.points[mesh.indices[t + 2]]);
        if ((p - q).LengthSquared() < (p - best).LengthSquared())
            best = q;
    }
    return best;
}

struct HeadShell {
    DenseGrid<float> density = Smoothed(DensityOfHead(1.8f), 2);
    HairShell shell = MakeShell(density, MedianDensity(density) / 2);
    // From the nearest point of the surface to each vertex within four cells, outward; else 0.
    DenseGrid<Vector3f> directions{density.box};
    HeadShell() {
        const GridBox &box = density.box;
        ParallelFor(box.Count(), [&](size_t at) {
            const Point3f p =
                box.Position(at % box.size[0], at / box.size[0] % box.size[1], at / box.Stride(2));
            const float s = shell.distance.values[at];
            if (std::abs(s) > 4 * box.cell || s == 0)
                return;
            const Vector3f to = p - NearestOf(p, shell.mesh);
            EXPECT_NEAR(to.Length(), std::abs(s), 1e-4f * box.cell);
            EXPECT_EQ(s <= 0, density.values[at] >= shell.iso);
            directions.values[at] = to / s;
        });
    }
};

// The law that the paper asks of S, and the distance itself against brute force. A vertex is away from the
// medial set if its neighbours see the surface in directions within 20 degrees of each other.
TEST(Shell, GradientOfTheDistanceHasLengthOneAwayFromTheMedialSet) {
    const HeadShell head;
    const GridBox &box = head.density.box;
    size_t away = 0, near = 0;
    double mean = 0, most = 0;
    for (size_t k = 1; k + 1 < box.size[2]; ++k)
        for (size_t j = 1; j + 1 < box.size[1]; ++j)
            for (size_t i = 1; i + 1 < box.size[0]; ++i) {
                if (std::abs(head.shell.distance.At(i, j, k)) > 3 * box.cell)
                    continue;
                const size_t at = box.Index(i, j, k);
                std::vector<Vector3f> seen;
                for (size_t axis = 0; axis < 3; ++axis)
                    for (const size_t neighbour : {at - box.Stride(axis), at + box.Stride(axis)})
                        seen.push_back(head.directions.values[neighbour]);
                bool medial = false;
                for (const Vector3f &a : seen)
                    for (const Vector3f &b : seen)
                        medial |= Dot(a, b) < std::cos(Radians(20));
                if (medial) {
                    ++near;
                    continue;
                }
                const double off =
                    std::abs(static_cast<double>(GradientAt(head.shell.distance, {i, j, k}).Length()) - 1);
                mean += off, most = std::max(most, off), ++away;
            }
    mean /= static_cast<double>(away);
    printf(
        "[ gradients within three cells: %zu away from the medial set, off by %.4f in the mean and %.3f at "
        "worst; %zu near it ]\n",
        away, mean, most, near);
    EXPECT_GT(away, 1000u);
    EXPECT_LT(mean, 0.01);
    EXPECT_LT(most, 0.05);
}

TEST(Shell, IsTheSameBitsForAnyNumberOfThreads) {
    const DenseGrid<float> density = DensityOfHead(1.5f);
    HairShell one;
    OnOneThread([&] { one = MakeShell(density, 1e-4f); });
    const HairShell many = MakeShell(density, 1e-4f);
    EXPECT_EQ(many.mesh.indices, one.mesh.indices);
    EXPECT_EQ(many.mesh.points, one.mesh.points);
    EXPECT_EQ(std::memcmp(many.distance.values.data(), one.distance.values.data(), one.distance.Bytes()), 0);
}

TEST(Shell, OfNothingIsRefused) {
    const DenseGrid<float> ball = Ball(0.2f);
    EXPECT_THROW(MakeShell(ball, 0), Error);
    EXPECT_THROW(MakeShell(ball, std::nanf("")), Error);
    EXPECT_THROW(MakeShell(ball, 3), Error);
}

TEST(Shell, DistanceToATriangleIsThatOfItsNearestPoint) {
    RNG rng(5);
    const auto point = [&] {
        return Point3f{rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()} * 2 - Vector3f{1, 1, 1};
    };
    for (int n = 0; n < 200; ++n) {
        const Point3f a = point(), b = point(), c = n % 10 == 0 ? b : point(), p = point() * 2;
        float nearest = Infinity;
        constexpr int kSteps = 200;
        for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; i + j <= kSteps; ++j) {
                const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
                nearest = std::min(nearest, (a + (b - a) * u + (c - a) * v - p).Length());
            }
        EXPECT_NEAR(DistanceToTriangle(p, a, b, c), nearest, 0.01f) << n;
        EXPECT_LE(DistanceToTriangle(p, a, b, c), nearest + 1e-6f) << n;
    }
}

} // namespace
} // namespace cuticle
