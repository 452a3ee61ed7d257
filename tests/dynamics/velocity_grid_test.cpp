// Hair to hair: laws of smoothing on a grid, and locks that pass through one another without it.
#include "dynamics/velocity_grid.h"

#include "core/parallel.h"
#include "dynamics/strand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace cuticle {
namespace {

struct Cloud {
    std::vector<Vector3d> points, velocities;
    std::vector<double> masses;
};
Cloud RandomCloud(size_t count, double size) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Cloud cloud;
    for (size_t i = 0; i < count; ++i) {
        cloud.points.push_back(Vector3d{uniform(random), uniform(random), uniform(random)} * size);
        cloud.velocities.push_back(Vector3d{uniform(random), uniform(random), 3 + uniform(random)} * 10.);
        cloud.masses.push_back(0.1 + std::pow(10., 2 * uniform(random)));
    }
    return cloud;
}
Vector3d MomentumOf(const Cloud &cloud) {
    Vector3d sum;
    for (size_t i = 0; i < cloud.points.size(); ++i)
        sum += cloud.velocities[i] * cloud.masses[i];
    return sum;
}
double EnergyOf(const Cloud &cloud) {
    double sum = 0;
    for (size_t i = 0; i < cloud.points.size(); ++i)
        sum += cloud.masses[i] * cloud.velocities[i].LengthSquared() / 2;
    return sum;
}
// Velocities by that share nearer to what the smoothed grid says (PIC), or to their own and what smoothing
// changed (FLIP).
Cloud Drawn(const Cloud &cloud, double share, size_t passes, bool flip) {
    VelocityGrid rough(cloud.points, cloud.masses, cloud.velocities, 1), smooth = rough;
    smooth.Smooth(passes);
    Cloud drawn = cloud;
    for (size_t i = 0; i < cloud.points.size(); ++i) {
        const Vector3d own = cloud.velocities[i], s = smooth.At(cloud.points[i], own);
        const Vector3d target = flip ? own + s - rough.At(cloud.points[i], own) : s;
        drawn.velocities[i] = own + (target - own) * share;
    }
    return drawn;
}

TEST(VelocityGrids, KeepMomentumAndLoseEnergy) {
    const Cloud cloud = RandomCloud(3000, 6);
    VelocityGrid grid(cloud.points, cloud.masses, cloud.velocities, 1);
    const Vector3d momentum = MomentumOf(cloud);
    EXPECT_LT((grid.Momentum() - momentum).Length(), 1e-12 * momentum.Length());
    EXPECT_LT(grid.Energy(), EnergyOf(cloud));
    double energy = grid.Energy(), first = energy;
    for (int pass = 0; pass < 50; ++pass) {
        grid.Smooth(1);
        EXPECT_LT((grid.Momentum() - momentum).Length(), 1e-12 * momentum.Length()) << pass;
        EXPECT_LE(grid.Energy(), energy) << pass;
        energy = grid.Energy();
    }
    EXPECT_LT(energy, 0.999 * first);
}

TEST(VelocityGrids, DragTowardThemKeepsMomentum) {
    const Cloud cloud = RandomCloud(3000, 6);
    const Vector3d momentum = MomentumOf(cloud);
    for (const bool flip : {false, true})
        for (const double share : {0.1, 0.5, 1.}) {
            const Cloud drawn = Drawn(cloud, share, 3, flip);
            EXPECT_LT((MomentumOf(drawn) - momentum).Length(), 1e-12 * momentum.Length()) << share << flip;
            EXPECT_LE(EnergyOf(drawn), EnergyOf(cloud)) << share << flip;
        }
}

TEST(VelocityGrids, AUniformVelocityStays) {
    Cloud cloud = RandomCloud(500, 4);
    for (Vector3d &v : cloud.velocities)
        v = {1, -2, 3};
    VelocityGrid grid(cloud.points, cloud.masses, cloud.velocities, 0.7);
    grid.Smooth(10);
    for (const Vector3d &p : cloud.points)
        EXPECT_LT((grid.At(p, {}) - Vector3d{1, -2, 3}).Length(), 1e-12);
    EXPECT_EQ(grid.At({1e9, 0, 0}, {7, 7, 7}), (Vector3d{7, 7, 7}));
}

TEST(VelocityGrids, NoNumberReachesAnIndex) {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    const std::vector<Vector3d> points{{0, 0, 0},     {nan, 0, 0},      {1e17, 0, 0},
                                       {1e300, 0, 0}, {0, infinite, 0}, {1, 1, 1}};
    const std::vector<double> masses(points.size(), 1.);
    const std::vector<Vector3d> velocities{{1, 0, 0}, {1, 0, 0}, {1, 0, 0},
                                           {1, 0, 0}, {1, 0, 0}, {nan, 0, 0}};
    VelocityGrid grid(points, masses, velocities, 1e-3);
    grid.Smooth(2);
    for (const Vector3d &p : points) {
        const Vector3d v = grid.At(p, {});
        EXPECT_TRUE(std::isfinite(v.x));
    }
}

// Two locks that hang beside one another, one of them swung into the other. Returns how many pairs of their
// strands have passed through one another at the tips.
size_t CrossingPairs(double speed, double drag, size_t passes) {
    constexpr size_t points = 16, across = 6;
    std::vector<Vector3d> rest;
    for (size_t lock = 0; lock < 2; ++lock)
        for (size_t a = 0; a < across * across; ++a)
            for (size_t i = 0; i < points; ++i)
                rest.push_back({4. * static_cast<double>(lock) + 0.4 * static_cast<double>(a % across),
                                -1.2 * static_cast<double>(i), 0.4 * static_cast<double>(a / across)});
    StrandPhysics physics;
    physics.bending = 1e6, physics.twist = 7.5e5;
    KeyStrands set(rest, points, physics);
    const size_t strands = set.StrandCount();
    for (size_t s = 0; s < strands / 2; ++s)
        for (size_t i = 2; i < points; ++i)
            set.SetVelocity(s, i, {speed * static_cast<double>(i), 0, 0});
    const std::unique_ptr<Obstacle> nothing = MakeUnion({});
    size_t most = 0;
    for (int step = 0; step < 40; ++step) {
        std::vector<Vector3d> x, v;
        std::vector<double> m;
        for (size_t s = 0; s < strands; ++s)
            for (size_t i = 0; i < points; ++i)
                x.push_back(set.Position(s, i)), v.push_back(set.Velocity(s, i)), m.push_back(set.Mass(s, i));
        VelocityGrid grid(x, m, v, 1.2);
        grid.Smooth(passes);
        for (size_t s = 0; s < strands; ++s)
            for (size_t i = 0; i < points; ++i)
                set.SetForce(s, i, {0, -981, 0}, drag, grid.At(x[s * points + i], {}));
        set.Step(1. / 60, {}, *nothing);
        size_t crossed = 0;
        for (size_t a = 0; a < strands / 2; ++a)
            for (size_t b = strands / 2; b < strands; ++b)
                crossed += set.Position(a, points - 1).x > set.Position(b, points - 1).x ? 1 : 0;
        most = std::max(most, crossed);
    }
    return most;
}

TEST(HairToHair, LocksCrossLessWithSmoothing) {
    std::vector<size_t> crossed;
    for (const double drag : {0., 30., 60., 120.})
        crossed.push_back(CrossingPairs(4, drag, 4));
    std::printf(
        "of %d pairs of strands %zu cross without smoothing, with it %zu, %zu, %zu at drags of 30, 60, 120\n",
        36 * 36, crossed[0], crossed[1], crossed[2], crossed[3]);
    EXPECT_GT(crossed[0], 500u);
    EXPECT_LT(crossed[1], crossed[0] / 2);
    EXPECT_LT(crossed[2], crossed[1]);
    EXPECT_LE(crossed[3], crossed[2] / 4);
}

} // namespace
} // namespace cuticle
