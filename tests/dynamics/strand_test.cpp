// Strands against laws of mechanics whose right values come from elsewhere: quadrature, shooting, closed
// forms.
#include "core/error.h"
#include "core/isa.h"
#include "core/parallel.h"
#include "dynamics/strand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace cuticle {
namespace {

constexpr double kG = 981;
const Vector3d kDown{0, -kG, 0};

std::vector<Vector3d> StraightStrand(size_t points, double length, const Vector3d &direction) {
    std::vector<Vector3d> p;
    for (size_t i = 0; i < points; ++i)
        p.push_back(direction * (length * static_cast<double>(i) / static_cast<double>(points - 1)));
    return p;
}
// A helix of the radius and rise per turn (cm) that hangs down from a straight root.
std::vector<Vector3d> CurledStrand(size_t points, double radius, double rise, double turns) {
    std::vector<Vector3d> p;
    for (size_t i = 0; i < points; ++i) {
        const double u = turns * static_cast<double>(i) / static_cast<double>(points - 1);
        const double grow = std::min(1., u), angle = 2 * kPi<double> * u;
        p.push_back({radius * grow * std::sin(angle), -rise * u, radius * grow * (1 - std::cos(angle))});
    }
    return p;
}
void Weigh(KeyStrands *set, const Vector3d &gravity, double drag) {
    for (size_t s = 0; s < set->StrandCount(); ++s)
        for (size_t i = 0; i < set->PointCount(); ++i)
            set->SetForce(s, i, gravity, drag, {});
}
const Obstacle &Nothing() {
    static const std::unique_ptr<Obstacle> none = MakeUnion({});
    return *none;
}

// The derivatives by which forces are made, against differences of the measures themselves. Directors follow
// their edges by parallel transport.
TEST(RodHinges, DerivativesAreThoseOfTheMeasures) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&] { return Vector3d{uniform(random), uniform(random), uniform(random)}; };
    for (int k = 0; k < 50; ++k) {
        const Vector3d e = vector() + Vector3d{2, 0, 0}, f = vector() + Vector3d{2, 0, 0};
        const Vector3d dE = rods::AcrossUnit(vector(), Normalize(e)),
                       dF = rods::AcrossUnit(vector(), Normalize(f));
        const auto measure = [&](const Vector3d &e1, const Vector3d &f1, double turnE, double turnF) {
            const auto edge1 = rods::MakeRodEdge(Vector3d{}, e1), edge2 = rods::MakeRodEdge(Vector3d{}, f1);
            const auto turned = [](const Vector3d &d, const Vector3d &t, double a) {
                return d * std::cos(a) + Cross(t, d) * std::sin(a);
            };
            return rods::MeasureHinge(edge1, edge2,
                                      turned(rods::Transport(dE, Normalize(e), edge1.t), edge1.t, turnE),
                                      turned(rods::Transport(dF, Normalize(f), edge2.t), edge2.t, turnF));
        };
        const auto at = measure(e, f, 0, 0);
        if (std::abs(at.value[2]) > 10)
            continue; // near half a turn, where the measure grows without bound
        constexpr double h = 1e-6;
        for (size_t c = 0; c < 3; ++c) {
            for (size_t d = 0; d < 3; ++d) {
                Vector3d step;
                step[d] = h;
                EXPECT_NEAR((measure(e + step, f, 0, 0).value[c] - measure(e - step, f, 0, 0).value[c]) /
                                (2 * h),
                            at.byE[c][d], 1e-6 * (1 + at.byE[c].Length()))
                    << c << d;
                EXPECT_NEAR((measure(e, f + step, 0, 0).value[c] - measure(e, f - step, 0, 0).value[c]) /
                                (2 * h),
                            at.byF[c][d], 1e-6 * (1 + at.byF[c].Length()))
                    << c << d;
            }
            EXPECT_NEAR((measure(e, f, h, 0).value[c] - measure(e, f, -h, 0).value[c]) / (2 * h),
                        at.byTurnE[c], 1e-6 * (1 + std::abs(at.byTurnE[c])));
            EXPECT_NEAR((measure(e, f, 0, h).value[c] - measure(e, f, 0, -h).value[c]) / (2 * h),
                        at.byTurnF[c], 1e-6 * (1 + std::abs(at.byTurnF[c])));
        }
    }
}

// Solves B theta'' = -g (L - s) cos theta, theta(0) = 0, theta'(L) = 0, by shooting; returns the tip of the
// elastica relative to its clamp.
Vector3d ElasticaTip(double bending, double length) {
    const auto shoot = [&](double slope, Vector3d *tip) {
        const size_t n = 20000;
        const double h = length / n;
        double theta = 0, kappa = slope;
        Vector3d p;
        const auto curve = [&](double s, double t) { return -kG * (length - s) * std::cos(t) / bending; };
        for (size_t k = 0; k < n; ++k) {
            const double s = h * static_cast<double>(k);
            const double k1 = curve(s, theta), k2 = curve(s + h / 2, theta + h / 2 * kappa);
            const double middle = theta + h / 2 * kappa + h * h / 8 * k1;
            p += Vector3d{std::cos(middle), -std::sin(middle), 0} * h;
            theta += h * kappa + h * h / 6 * (k1 + 2 * k2);
            kappa += h / 6 * (k1 + 4 * curve(s + h / 2, middle) + curve(s + h, theta));
        }
        if (tip != nullptr)
            *tip = p;
        return kappa;
    };
    double low = 0, high = kG * length * length / bending; // the slope of a beam that does not sag
    for (int k = 0; k < 100; ++k)
        (shoot((low + high) / 2, nullptr) > 0 ? high : low) = (low + high) / 2;
    Vector3d tip;
    shoot((low + high) / 2, &tip);
    return tip;
}

// The relative error of a cantilever's tip after it has come to rest.
double CantileverError(double bending, size_t points) {
    StrandPhysics physics;
    physics.bending = bending, physics.twist = 0.75 * bending, physics.damping = 0.02;
    KeyStrands set(StraightStrand(points, 20, {1, 0, 0}), points, physics);
    Weigh(&set, kDown, 4);
    for (int k = 0; k < 600; ++k)
        set.Step(1. / 60, {}, Nothing());
    EXPECT_LT(set.KineticEnergy(), 1e-6);
    // The first edge is clamped, so the curve begins where its tangent counts, at that edge's middle
    const double start = 20. / static_cast<double>(points - 1) / 2;
    const Vector3d tip = ElasticaTip(bending, 20 - start) + Vector3d{start, 0, 0};
    return (set.Position(0, points - 1) - tip).Length() / 20;
}

TEST(Strands, ACantileverIsAnElastica) {
    const double stiff = CantileverError(2e6, 32), coarse = CantileverError(2e5, 32),
                 fine = CantileverError(2e5, 63);
    std::printf("tip against the elastica: stiff %.2e, hanging %.2e, of twice the points %.2e\n", stiff,
                coarse, fine);
    EXPECT_LT(stiff, 0.002);
    EXPECT_LT(coarse, 0.002);
    EXPECT_NEAR(coarse / fine, 4, 1); // of second order in the length of edges
}

// A quarter of a circle that lies flat and is loaded by its weight bends and twists: Castigliano's integrals.
TEST(Strands, ABowTwistsAsMuchAsTheory) {
    constexpr size_t points = 49;
    constexpr double radius = 10, weight = 10; // a load so small that the bow stays nearly flat
    StrandPhysics physics;
    physics.damping = 0.05;
    for (const double twist : {0.75 * physics.bending, 0.1 * physics.bending}) {
        physics.twist = twist;
        std::vector<Vector3d> p;
        for (size_t i = 0; i < points; ++i) {
            const double phi = kPi<double> / 2 * static_cast<double>(i) / (points - 1);
            p.push_back({radius * std::sin(phi), 0, radius * (1 - std::cos(phi))});
        }
        KeyStrands set(p, points, physics);
        Weigh(&set, {0, -weight, 0}, 4);
        for (int k = 0; k < 900; ++k)
            set.Step(1. / 60, {}, Nothing());
        double drop = 0;
        const double from = kPi<double> / 2 / (points - 1) / 2; // the middle of the clamped edge
        constexpr int n = 2000;
        for (int k = 0; k < n; ++k) {
            const double beyond = (kPi<double> / 2 - from) * (k + 0.5) / n; // to the tip
            const double bend = weight * radius * radius * (1 - std::cos(beyond)),
                         unitBend = radius * std::sin(beyond);
            const double turn = weight * radius * radius * (beyond - std::sin(beyond));
            const double unitTurn = radius * (1 - std::cos(beyond));
            drop += (bend * unitBend / physics.bending + turn * unitTurn / twist) * radius *
                    (kPi<double> / 2 - from) / n;
        }
        const double measured = -set.Position(0, points - 1).y;
        std::printf("bow, twist %g: drops %.6f cm, theory %.6f\n", twist, measured, drop);
        EXPECT_NEAR(measured, drop, 0.01 * drop);
    }
}

TEST(Strands, RestTwistTurnsTheTip) {
    constexpr size_t points = 17;
    StrandPhysics physics;
    KeyStrands set(StraightStrand(points, 16, {1, 0, 0}), points, physics);
    set.AddRestTwist(0, 0.1);
    Weigh(&set, {}, 2);
    const Vector3d before = set.Director(0, points - 2);
    for (int k = 0; k < 200; ++k)
        set.Step(1. / 60, {}, Nothing());
    // 15 hinges of a centimetre
    const Vector3d after = set.Director(0, points - 2);
    EXPECT_NEAR(std::atan2(Dot(Cross(before, after), {1, 0, 0}), Dot(before, after)), 1.5, 1e-6);
    EXPECT_LT((set.Position(0, points - 1) - Vector3d{16, 0, 0}).Length(), 1e-6);
}

// The paper's springs: what they can do, and how they fall short of a rod.
TEST(Springs, HoldCurlsButLetStraightHairHang) {
    constexpr size_t points = 24;
    double drop[2], stretch[2], curled = 0;
    for (const StrandMethod method : {StrandMethod::Rods, StrandMethod::Springs}) {
        StrandPhysics physics;
        physics.method = method, physics.bending = 2e6, physics.twist = 1.5e6;
        std::vector<Vector3d> rest = StraightStrand(points, 20, {1, 0, 0});
        for (const Vector3d &p : CurledStrand(points, 0.8, 3, 3))
            rest.push_back(p + Vector3d{0, 0, 20});
        KeyStrands set(rest, points, physics);
        Weigh(&set, kDown, 6);
        StepReport report;
        for (int k = 0; k < 300; ++k)
            report = set.Step(1. / 60, {}, Nothing());
        const auto m = static_cast<size_t>(method);
        drop[m] = -set.Position(0, points - 1).y, stretch[m] = report.stretch;
        curled = (set.Position(1, points - 1) - set.RestPosition(1, points - 1)).Length();
        EXPECT_EQ(report.recovered, 0u);
    }
    std::printf("rod drops %.2f cm, springs drop %.2f cm; springs stretch by %.2e, rods by %.1e; curls of "
                "springs sag by "
                "%.2f cm\n",
                drop[0], drop[1], stretch[1], stretch[0], curled);
    EXPECT_GT(drop[1], 1.1 * drop[0]);
    EXPECT_LT(stretch[0], 1e-5);
    EXPECT_LT(stretch[1], 0.1);
}

// Half a swing of a point on a rod, from a standstill at an angle from below.
struct Swing {
    double period, energyLost; // s; of its potential energy at the start, in a period
    Vector3d atHalfASecond;
};
Swing SwingPendulum(double length, double amplitude, double dt) {
    StrandPhysics physics;
    physics.fixed = 1, physics.damping = 0;
    KeyStrands set(StraightStrand(2, length, {std::sin(amplitude), -std::cos(amplitude), 0}), 2, physics);
    Weigh(&set, kDown, 0);
    Swing swing{};
    double crossed = 0;
    int crossings = 0;
    for (int k = 1; crossings < 5; ++k) {
        const double before = set.Position(0, 1).x;
        EXPECT_LE(set.Step(dt, {}, Nothing()).stretch, 1e-4);
        const double after = set.Position(0, 1).x;
        if (k == std::lround(0.5 / dt))
            swing.atHalfASecond = set.Position(0, 1);
        if ((before > 0) != (after > 0)) {
            const double t = dt * (k - 1 + before / (before - after));
            if (crossings == 0)
                crossed = t;
            swing.period = (t - crossed) / 2;
            ++crossings;
            const double height = length + set.Position(0, 1).y, v2 = set.Velocity(0, 1).LengthSquared();
            swing.energyLost = 1 - (kG * height + v2 / 2) / (kG * length * (1 - std::cos(amplitude)));
        }
        if (k > 1000000)
            return swing;
    }
    return swing;
}

TEST(Strands, APendulumKeepsItsPeriodAndEnergy) {
    constexpr double length = 20, amplitude = 1;
    // The complete elliptic integral of the first kind by the arithmetic-geometric mean
    double a = 1, g = std::cos(amplitude / 2);
    for (int k = 0; k < 10; ++k) {
        const double next = (a + g) / 2;
        g = std::sqrt(a * g), a = next;
    }
    const double period = 2 * kPi<double> * std::sqrt(length / kG) / a;
    const Swing swing = SwingPendulum(length, amplitude, 1. / 240);
    std::printf("pendulum: period %.5f s, theory %.5f; two swings lose %.2e of the energy\n", swing.period,
                period, swing.energyLost);
    EXPECT_NEAR(swing.period, period, 0.003 * period);
    EXPECT_GT(swing.energyLost, -1e-3);
    EXPECT_LT(swing.energyLost, 0.01);
}

TEST(Strands, StepsAreOfSecondOrder) {
    const Vector3d exact = SwingPendulum(20, 1, 1. / 7680).atHalfASecond;
    const double coarse = (SwingPendulum(20, 1, 1. / 240).atHalfASecond - exact).Length();
    const double fine = (SwingPendulum(20, 1, 1. / 480).atHalfASecond - exact).Length();
    std::printf("a pendulum after half a second: error %.2e cm at 1/240 s, %.2e at 1/480\n", coarse, fine);
    EXPECT_NEAR(std::log2(coarse / fine), 2, 0.25);
}

TEST(Strands, ABlockSlidesAboveTheAngleOfFrictionOnly) {
    constexpr double friction = 0.5, dt = 1. / 480;
    for (const double slope : {0.3, 0.45, 0.55, 0.8}) { // tangents
        const double angle = std::atan(slope);
        const Vector3d down{std::cos(angle), -std::sin(angle), 0},
            normal{std::sin(angle), std::cos(angle), 0};
        StrandPhysics physics;
        physics.fixed = 0, physics.friction = friction, physics.clearance = 0.05;
        std::vector<Vector3d> rest =
            StraightStrand(8, 4, {0, 0, 1}); // a hair across the slope, and one along it
        for (const Vector3d &p : StraightStrand(8, 4, down))
            rest.push_back(p + Vector3d{0, 0, 10});
        for (Vector3d &p : rest)
            p += normal * 0.05;
        KeyStrands set(rest, 8, physics);
        Weigh(&set, kDown, 0);
        const std::unique_ptr<Obstacle> ground = MakeGround({}, normal);
        for (int k = 0; k < 240; ++k) {
            const StepReport report = set.Step(dt, {}, *ground);
            EXPECT_LE(report.penetration, 1e-4);
            EXPECT_LE(report.stretch, 1e-4);
        }
        const double acceleration = std::max(0., kG * (std::sin(angle) - friction * std::cos(angle)));
        for (size_t s = 0; s < 2; ++s)
            for (size_t i = 0; i < 8; ++i) {
                const double slid = Dot(set.Position(s, i) - set.RestPosition(s, i), down),
                             fell = acceleration / 8;
                // Friction knows of a load after the first step only, which leaves a step's fall of speed
                const double extra = kG * std::sin(angle) * dt * (slope < friction ? 4 * dt : 0.5);
                EXPECT_NEAR(slid, fell, 0.02 * fell + extra) << "slope " << slope << ", point " << i;
                const double speed = set.Velocity(s, i).Length();
                EXPECT_NEAR(speed, acceleration / 2,
                            slope < friction ? 1e-3 : 0.02 * acceleration / 2 + kG * std::sin(angle) * dt);
            }
    }
}

// Curls under a head that is shaken for a while: no sag before, the groomed shape after.
TEST(Strands, CurlsStayAtRestAndComeBackAfterShaking) {
    constexpr size_t points = 32;
    StrandPhysics physics;
    std::vector<Vector3d> rest;
    for (const double radius : {0.3, 0.5, 0.8, 0.})
        for (const Vector3d &p : CurledStrand(points, radius, 3, 5))
            rest.push_back(p + Vector3d{10 * radius, 0, 0});
    KeyStrands set(rest, points, physics);
    set.BalanceUnder(kDown);
    Weigh(&set, kDown, 2);
    const auto away = [&] {
        double sum = 0;
        for (size_t s = 0; s < set.StrandCount(); ++s)
            for (size_t i = 0; i < points; ++i)
                sum += (set.Position(s, i) - set.RestPosition(s, i)).LengthSquared();
        return std::sqrt(sum / static_cast<double>(set.StrandCount() * points));
    };
    StepReport report;
    for (int k = 0; k < 60; ++k)
        report.Join(set.Step(1. / 60, {}, Nothing()));
    const double sagged = away();
    double swung = 0;
    for (int k = 0; k < 240; ++k) {
        const double t = k / 60.,
                     turn = 0.6 * std::sin(2 * kPi<double> * 1.5 * t) * std::sin(kPi<double> * t / 4);
        report.Join(set.Step(1. / 60, TurnAbout({0, -5, 0}, {0.3 * turn, turn, turn}, {}), Nothing()));
        swung = std::max(swung, away());
    }
    for (int k = 0; k < 600; ++k)
        report.Join(set.Step(1. / 60, {}, Nothing()));
    std::printf(
        "curls: sag %.2e cm, swing %.1f cm, back within %.2e cm rms, kinetic energy %.1e, stretch %.1e, "
        "rounds %zu\n",
        sagged, swung, away(), set.KineticEnergy(), report.stretch, report.rounds);
    EXPECT_LT(sagged, 1e-4);
    EXPECT_GT(swung, 1);
    EXPECT_LT(away(), 0.1);
    EXPECT_LT(set.KineticEnergy(), 1e-6);
    EXPECT_LE(report.stretch, 1e-4);
    EXPECT_EQ(report.recovered, 0u);
}

// Two neighbours stand on either side of a ridge (a nose) thinner than their edge is long: rounds of pushing
// points out and mending lengths do not end. Strands are laid out then, and neither stretch nor go in.
TEST(Strands, ARidgeThinnerThanAnEdgeNeitherStretchesNorSwallowsThem) {
    constexpr size_t strands = 48, points = 16;
    std::vector<Vector3d> rest;
    for (size_t s = 0; s < strands; ++s)
        for (size_t i = 0; i < points; ++i) // hanging in front of a ball, beside its nose
            rest.push_back({-3 + 0.1 * static_cast<double>(s), 10 - 1.3 * static_cast<double>(i), 9});
    StrandPhysics physics;
    physics.bending = 1e5, physics.twist = 7.5e4;
    KeyStrands set(rest, points, physics);
    std::vector<std::unique_ptr<Obstacle>> bodies;
    bodies.push_back(MakeSphere({0, 0, 0}, 8));
    bodies.push_back(MakeEllipsoid({0, -1, 8}, {0.8, 2, 2.5}));
    const std::unique_ptr<Obstacle> obstacle = MakeUnion(std::move(bodies));
    StepReport report;
    for (int step = 0; step < 120; ++step) {
        const double t = step / 60.;
        for (size_t s = 0; s < strands; ++s)
            for (size_t i = 0; i < points; ++i)
                set.SetForce(s, i, {4e3 * std::sin(7 * t), -981, -2e3}, 3, {});
        report.Join(set.Step(1. / 60, {}, *obstacle));
    }
    EXPECT_EQ(report.rounds, KeyStrands::kMaxRounds) << "this is about rounds that do not end";
    EXPECT_LT(report.stretch, 1e-5);
    EXPECT_LT(report.penetration, 1e-5);
    EXPECT_EQ(report.recovered, 0u);
}

} // namespace
} // namespace cuticle
