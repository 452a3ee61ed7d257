// Equation 3: its derivative, its limit of stability, and hair that it directs.
#include "dynamics/directing.h"

#include "dynamics/simulation.h"
#include "grooms/groom.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cuticle {
namespace {

std::vector<Vector3d> RandomPoints(size_t count, double size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-size, size);
    std::vector<Vector3d> points;
    for (size_t i = 0; i < count; ++i)
        points.push_back({uniform(random), uniform(random), uniform(random)});
    return points;
}

// The printed line before the last lacks a minus: force is minus the derivative.
TEST(Directing, ForceIsMinusTheDerivative) {
    for (const DensityKernel kernel : {DensityKernel::Smooth, DensityKernel::Tent}) {
        const DensityTarget target(RandomPoints(300, 4, 1), 1.3, kernel);
        std::vector<Vector3d> points = RandomPoints(200, 5, 2);
        const std::vector<DensityTarget::Pull> pulls = target.Pulls(points);
        for (size_t i = 0; i < points.size(); i += 7)
            for (size_t c = 0; c < 3; ++c) {
                constexpr double h = 1e-5;
                const double at = points[i][c];
                points[i][c] = at + h;
                const double up = target.Energy(points);
                points[i][c] = at - h;
                const double down = target.Energy(points);
                points[i][c] = at;
                EXPECT_NEAR(pulls[i].force[c], (down - up) / (2 * h),
                            1e-4 * (1 + std::abs(pulls[i].force[c])));
            }
    }
}

TEST(Directing, TheSmoothForceHasNoJumpsAndTheTentsHas) {
    for (const DensityKernel kernel : {DensityKernel::Smooth, DensityKernel::Tent}) {
        const DensityTarget target(RandomPoints(300, 4, 1), 1, kernel);
        double jump = 0;
        Vector3d before;
        for (double x = -0.6; x < 0.6; x += 4e-3) {
            const std::vector<Vector3d> point{{x, 0.3, 0.2}};
            const Vector3d force = target.Pulls(point)[0].force;
            if (x > -0.6)
                jump = std::max(jump, (force - before).Length());
            before = force;
        }
        if (kernel == DensityKernel::Smooth)
            EXPECT_LT(jump, 0.1);
        else
            EXPECT_GT(jump, 0.2);
    }
}

// Free points, moved by the pull over its stiffness, and by plain steps that grow: the first never raises the
// energy, and the plain step does from about one over the greatest density on.
TEST(Directing, TheStiffnessBoundsTheStep) {
    for (const double size : {3., 0.6}) { // loose and dense
        std::vector<Vector3d> wanted = RandomPoints(400, size, 3);
        for (Vector3d &p : wanted)
            p.x += 1;
        const DensityTarget target(wanted, 1, DensityKernel::Smooth);
        const std::vector<Vector3d> start = RandomPoints(400, size, 4);
        const double first = target.Energy(start);
        for (const double factor : {1., 10., 1e3, 1e6}) {
            std::vector<Vector3d> points = start;
            double energy = first;
            for (int step = 0; step < 40; ++step) {
                const auto pulls = target.Pulls(points);
                for (size_t i = 0; i < points.size(); ++i)
                    points[i] += pulls[i].force * (factor / (1 + factor * pulls[i].stiffness));
                const double next = target.Energy(points);
                EXPECT_LE(next, energy * (1 + 1e-12)) << "factor " << factor << " step " << step;
                energy = next;
            }
            EXPECT_LT(energy, 0.7 * first) << size << " factor " << factor;
        }
        double limit = 0; // of plain steps
        for (double factor = 1e-4; limit == 0 && factor < 100; factor *= 2) {
            std::vector<Vector3d> points = start;
            const auto pulls = target.Pulls(points);
            for (size_t i = 0; i < points.size(); ++i)
                points[i] += pulls[i].force * factor;
            if (target.Energy(points) > first)
                limit = factor;
        }
        std::printf("400 points within %g cm: plain steps raise the energy from a factor of %.2g on\n", size,
                    limit);
        if (size < 1) {
            EXPECT_GT(limit, 0);
            EXPECT_LT(limit, 1);
        }
    }
}

// A curtain of straight hair, directed to one that the wind has bent.
Groom Curtain(double bend) {
    Groom groom;
    for (size_t s = 0; s < 100; ++s) {
        for (size_t i = 0; i < 12; ++i) {
            const double u = static_cast<double>(i), angle = bend * u / 11;
            const double r = bend > 0 ? 11 / bend : 0;
            const Vector3d p =
                bend > 0 ? Vector3d{r * (1 - std::cos(angle)), -r * std::sin(angle), 0} : Vector3d{0, -u, 0};
            groom.points.push_back(Point3f(
                p + Vector3d{0.6 * static_cast<double>(s % 10), 0, 0.6 * static_cast<double>(s / 10)}));
        }
        groom.strandOffsets.push_back(static_cast<uint32_t>(groom.points.size()));
    }
    return groom;
}

TEST(Directing, HairReachesItsTargetAndTheEnergyNeverRises) {
    SimulationSettings settings;
    settings.points = 12;
    settings.gravity = {};
    settings.drag = 30; // damped, as in the paper
    settings.physics.bending = 1e5, settings.physics.twist = 7.5e4;
    const Groom wanted = Curtain(1.0);
    settings.direction.points = ResampleKeyHairs(wanted, ChooseKeyHairs(wanted, 100), 12);
    settings.direction.seconds = 4;
    HairSimulation simulation(Curtain(0), MakeUnion({}), settings);
    const double first = simulation.TargetEnergy(1.5);
    StepReport report;
    for (int frame = 0; frame < 4 * 24; ++frame) {
        const double cell = settings.direction.CellAt(simulation.Time() + 0.5 / 24);
        const double before = simulation.TargetEnergy(cell);
        report.Join(simulation.NextFrame());
        if (frame % 32 > 0) { // but for the frame in which the lattice changes
            EXPECT_LE(simulation.TargetEnergy(cell), before * (1 + 1e-3)) << frame;
        }
    }
    const double last = simulation.TargetEnergy(1.5);
    std::printf("directed: energy falls to %.2e of what it was, stretch %.1e\n", last / first,
                report.stretch);
    EXPECT_LT(last, 0.25 * first);
    EXPECT_LT(report.stretch, 1e-4);
}

} // namespace
} // namespace cuticle
