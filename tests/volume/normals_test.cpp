// Laws of the frames that carry normals: rigid motions, bends without twist, the torsion of a helix.
#include "volume/normals.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "grooms/procedural.h"
#include "volume/density.h"
#include "volume/shell.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

std::vector<Point3f> Crooked(size_t n, uint64_t seed) {
    RNG rng(seed);
    std::vector<Point3f> points{{0, 0, 0}};
    while (points.size() < n)
        points.push_back(points.back() + Vector3f{rng.UniformFloat() - 0.5f, 0.3f + rng.UniformFloat(),
                                                  rng.UniformFloat() - 0.5f});
    return points;
}
std::vector<Normal3f> RandomNormals(size_t n) {
    RNG rng(7);
    std::vector<Normal3f> normals;
    while (normals.size() < n) {
        const Vector3f v{rng.UniformFloat() - 0.5f, rng.UniformFloat() - 0.5f, rng.UniformFloat() - 0.5f};
        if (v.LengthSquared() > 0.01f)
            normals.push_back(Normalize(v));
    }
    return normals;
}

TEST(Normals, ARigidMotionCarriesThemRigidly) {
    const auto rest = Crooked(40, 1);
    const auto normals = RandomNormals(rest.size());
    const Transform head = Transform::Translate({3, -2, 5}) * Transform::Rotate(133, {1, 2, -0.5});
    std::vector<Point3f> posed;
    for (const Point3f &p : rest)
        posed.push_back(head.Point(p));
    const auto carried = CarryNormals(rest, normals, posed, head);
    for (size_t k = 0; k < rest.size(); ++k)
        EXPECT_LT((carried[k] - head.Vector(normals[k])).Length(), 2e-5f) << k;
    // At rest nothing moves
    const auto still = CarryNormals(rest, normals, rest, Transform());
    for (size_t k = 0; k < rest.size(); ++k)
        EXPECT_LT((still[k] - normals[k]).Length(), 1e-5f);
}

// A straight strand bent to an arc in a plane: what is perpendicular to the plane stays so, what lies in it
// turns by the angle of the bend. No twist comes in.
TEST(Normals, ABendInAPlaneDoesNotTwist) {
    constexpr size_t n = 50;
    std::vector<Point3f> rest, posed;
    for (size_t k = 0; k < n; ++k) {
        const float s = 0.1f * static_cast<float>(k);
        rest.push_back({0, s, 0});
        posed.push_back({2 * (1 - std::cos(s / 2)), 2 * std::sin(s / 2), 0});
    }
    const auto across = CarryNormals(rest, std::vector<Normal3f>(n, {0, 0, 1}), posed, Transform());
    const auto within = CarryNormals(rest, std::vector<Normal3f>(n, {1, 0, 0}), posed, Transform());
    for (size_t k = 0; k < n; ++k) {
        EXPECT_LT((across[k] - Vector3f{0, 0, 1}).Length(), 1e-5f);
        const Vector3f along = Normalize(k + 1 < n ? posed[k + 1] - posed[k] : posed[k] - posed[k - 1]);
        // The first segment leans a little already
        EXPECT_LT((within[k] - Vector3f{along.y, -along.x, 0}).Length(), 1e-4f) << k;
    }
}

// Around a helix Frenet's normal turns by the torsion times the length; the transported frame does not.
TEST(Normals, AlongAHelixTheFrameLagsByTheTorsion) {
    constexpr size_t n = 4000;
    constexpr float radius = 1, rise = 0.5f, turns = 3;
    const float ends = turns * 2 * Pi;
    std::vector<Point3f> points;
    for (size_t k = 0; k < n; ++k) {
        const float t = ends * static_cast<float>(k) / (n - 1);
        points.push_back({radius * std::cos(t), radius * std::sin(t), rise * t});
    }
    const auto frenet = [&](float t) { return Vector3f{-std::cos(t), -std::sin(t), 0}; };
    Frame root;
    root.x = Normalize(points[1] - points[0]);
    root.y = Normalize(frenet(0) - root.x * Dot(frenet(0), root.x));
    root.z = Cross(root.x, root.y);
    const Frame last = TransportFrames(points, root).back();
    const float length = ends * std::sqrt(Sqr(radius) + Sqr(rise)),
                torsion = rise / (Sqr(radius) + Sqr(rise));
    const Vector3f normal = frenet(ends);
    const float angle = std::atan2(Dot(normal, last.z), Dot(normal, last.y));
    EXPECT_NEAR(std::remainder(angle - torsion * length, 2 * Pi), 0, 5e-3f);
}

TEST(Normals, StrandsThatTurnBackOrStandStillHaveFrames) {
    const std::vector<Point3f> points{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    for (const Frame &f : TransportFrames(points, Frame{})) {
        EXPECT_NEAR(f.x.Length(), 1, 1e-6f);
        EXPECT_NEAR(Dot(f.x, f.y), 0, 1e-6f);
        EXPECT_LT((Cross(f.x, f.y) - f.z).Length(), 1e-5f);
    }
    EXPECT_TRUE(CarryNormals({}, {}, {}, Transform()).empty());
}

// How far carried normals are from those of a shell that is made anew for the pose: a head of hair that the
// wind takes to one side, more and more. Within two cells of the shell, where light is scattered.
TEST(Normals, CarriedOverAMotionTheyStayNearThoseMadeAnew) {
    GroomParams params = MakeGroomParams("head", "straight");
    params.strands = 1500;
    const Groom rest = MakeGroom(params);
    const auto shellOf = [](const Groom &groom) {
        const StrandSet strands = CurvesOf(groom, 2);
        const auto density = Smoothed(LineDensity(strands, BoxAround(BoundsOf(strands), 1.5f, 5)), 2);
        return MakeShell(density, MedianDensity(density) / 2);
    };
    const HairShell restShell = shellOf(rest);
    double before = -1;
    for (const float wind : {0.f, 0.15f, 0.3f, 0.6f}) {
        Groom posed = rest;
        for (size_t i = 0; i < rest.StrandCount(); ++i) {
            const auto strand = rest.Strand(i);
            float s = 0; // length from the second point: the first segment stays with the head
            for (size_t k = 2; k < strand.size(); ++k) {
                s += (strand[k] - strand[k - 1]).Length();
                posed.points[rest.strandOffsets[i] + k] += Vector3f{wind * s * s / 20, 0, 0};
            }
        }
        const HairShell newShell = wind > 0 ? shellOf(posed) : restShell;
        double sum = 0;
        size_t count = 0;
        for (size_t i = 0; i < rest.StrandCount(); ++i) {
            std::vector<Normal3f> normals;
            for (const Point3f &p : rest.Strand(i))
                normals.push_back(ShellNormal(restShell.distance, p));
            const auto carried = CarryNormals(rest.Strand(i), normals, posed.Strand(i), Transform());
            for (size_t k = 0; k < carried.size(); ++k) {
                const Point3f p = posed.Strand(i)[k];
                if (std::abs(newShell.distance.Sample(p)) > 3)
                    continue;
                const Normal3f anew = ShellNormal(newShell.distance, p);
                if (anew.LengthSquared() == 0 || carried[k].LengthSquared() == 0)
                    continue;
                sum += static_cast<double>(Degrees(std::acos(std::clamp(Dot(carried[k], anew), -1.f, 1.f))));
                ++count;
            }
        }
        const double mean = sum / static_cast<double>(count);
        printf("[ wind %.2f: carried normals are %.1f degrees from those made anew, in the mean of %zu ]\n",
               static_cast<double>(wind), mean, count);
        ASSERT_GT(count, 1000u);
        EXPECT_GT(mean, before);
        EXPECT_LT(mean, wind > 0 ? 45 : 0.1);
        before = mean;
    }
}

} // namespace
} // namespace cuticle
