// Whole simulations: contact with the head, threads, kernels, hairs that follow key hairs, recipes.
#include "dynamics/simulation.h"

#include "core/error.h"
#include "core/isa.h"
#include "core/parallel.h"
#include "dynamics/pose_file.h"
#include "dynamics/recipe.h"
#include "grooms/procedural.h"
#include "message_of.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

namespace cuticle {
namespace {

Groom SmallHead(const char *style, float strands) {
    GroomParams params = MakeGroomParams("head", style);
    SetGroomParam(&params, "strands", static_cast<double>(strands));
    return MakeGroom(params);
}
SimulationSettings ShakenHead(size_t keys) {
    SimulationSettings settings;
    settings.keyHairs = keys, settings.points = 24;
    settings.motion = HeadMotion(
        {{0, {}, {}}, {0.4, {0, 0.8, 0}, {}}, {0.8, {0.2, -0.7, 0}, {}}, {1.1, {}, {}}}, {0, -12, -3});
    return settings;
}

TEST(Simulations, HairMovesWithTheHeadAndStaysOutOfIt) {
    for (const char *style : {"straight", "curly"}) {
        HairSimulation simulation(SmallHead(style, 400), MakeHead(), ShakenHead(150));
        const std::unique_ptr<Obstacle> head = MakeHead();
        const KeyStrands &keys = simulation.Keys();
        StepReport report;
        double moved = 0, deepest = 0, longest = 0;
        for (int frame = 1; frame <= 40; ++frame) {
            report.Join(simulation.NextFrame());
            const Pose pose = simulation.Settings().motion.At(simulation.Time());
            for (size_t s = 0; s < keys.StrandCount(); ++s)
                for (size_t i = 0; i < keys.PointCount(); ++i) {
                    const Vector3d local = pose.LocalPoint(keys.Position(s, i));
                    const double keep =
                        std::min(keys.Physics().clearance, head->Distance(keys.RestPosition(s, i)));
                    deepest = std::max(deepest, keep - head->Distance(local));
                    moved = std::max(moved, (local - keys.RestPosition(s, i)).Length());
                    if (i > 0)
                        longest = std::max(longest,
                                           std::abs((keys.Position(s, i) - keys.Position(s, i - 1)).Length() /
                                                        keys.EdgeLength(s, i - 1) -
                                                    1));
                }
        }
        std::printf("%s: moved %.1f cm against the head, stretch %.1e, deepest %.1e cm, %zu rounds at most\n",
                    style, moved, longest, deepest, report.rounds);
        EXPECT_GT(moved, 3);
        EXPECT_LT(longest, 1e-4);
        EXPECT_LT(deepest, 1e-4); // 1e-6 m
        EXPECT_EQ(report.recovered, 0u);
    }
}

TEST(Simulations, SpringsMoveWithTheHeadToo) {
    SimulationSettings settings = ShakenHead(30);
    settings.physics.method = StrandMethod::Springs;
    HairSimulation simulation(SmallHead("curly", 60), MakeHead(), settings);
    StepReport report;
    for (int frame = 0; frame < 12; ++frame)
        report.Join(simulation.NextFrame());
    EXPECT_EQ(report.recovered, 0u);
    EXPECT_LT(report.stretch, 0.1);
    const Pose pose = settings.motion.At(simulation.Time());
    const KeyStrands &keys = simulation.Keys();
    for (size_t s = 0; s < keys.StrandCount(); ++s)
        EXPECT_LT((pose.Point(keys.RestPosition(s, 0)) - keys.Position(s, 0)).Length(), 1e-9);
    for (const Point3f &p : simulation.Frame().points)
        EXPECT_TRUE(IsFinite(p));
}

TEST(Simulations, ThreadsDoNotMatter) {
    std::vector<Vector3d> first;
    for (const size_t threads : {1, 2, 3}) {
        std::vector<Vector3d> all;
        OnThreads(threads, [&] {
            SimulationSettings settings = ShakenHead(60);
            settings.wind = {{100, 0, 50}, 0.5, 15};
            HairSimulation simulation(SmallHead("wavy", 200), MakeHead(), settings);
            for (int frame = 0; frame < 8; ++frame)
                simulation.NextFrame();
            for (const Point3f &p : simulation.Frame().points)
                all.push_back(Vector3d(p));
        });
        if (threads == 1)
            first = all;
        EXPECT_EQ(first, all) << threads << " threads";
    }
}

// In the middle of a motion, with contacts and all couplings: a new simulation goes on to the same bits.
TEST(Simulations, GoOnFromAStateToTheSameBits) {
    SimulationSettings settings = ShakenHead(40);
    settings.coupling.drag = 30, settings.coupling.flip = 0.5;
    settings.wind.velocity = {100, 0, 50};
    const auto make = [&] { return HairSimulation(SmallHead("curly", 60), MakeHead(), settings); };
    HairSimulation whole = make();
    for (int frame = 0; frame < 6; ++frame)
        whole.NextFrame();
    const std::string state = whole.State();
    for (int frame = 0; frame < 5; ++frame)
        whole.NextFrame();
    HairSimulation second = make();
    ASSERT_TRUE(second.SetState(state));
    EXPECT_EQ(second.FrameNumber(), 6u);
    for (int frame = 0; frame < 5; ++frame)
        second.NextFrame();
    EXPECT_EQ(second.State(), whole.State());
    EXPECT_EQ(second.Frame().points, whole.Frame().points);
    EXPECT_FALSE(second.SetState(state.substr(1)));
    EXPECT_FALSE(second.SetState(""));
    EXPECT_EQ(second.FrameNumber(), 11u);
    EXPECT_EQ(whole.KeyFrame().StrandCount(), whole.Keys().StrandCount());
}

TEST(Simulations, ARestingHeadStaysAtRest) {
    SimulationSettings settings;
    settings.keyHairs = 100;
    HairSimulation simulation(SmallHead("curly", 300), MakeHead(), settings);
    const Groom before = simulation.Frame();
    for (int frame = 0; frame < 24; ++frame)
        simulation.NextFrame();
    const Groom after = simulation.Frame();
    float away = 0;
    for (size_t i = 0; i < before.points.size(); ++i)
        away = std::max(away, (after.points[i] - before.points[i]).Length());
    EXPECT_LT(away, 1e-2f);
    EXPECT_LT(simulation.Keys().KineticEnergy(), 1e-2);
}

TEST(Simulations, HugeAndMissingNumbersStayFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    HairSimulation simulation(SmallHead("wavy", 50), MakeHead(), ShakenHead(20));
    KeyStrands &keys = *simulation.MutableKeys();
    const std::unique_ptr<Obstacle> head = MakeHead();
    size_t recovered = 0;
    for (const double huge : {1e6, 1e12, 1e30, 1e300, nan, infinite}) {
        for (size_t s = 0; s < keys.StrandCount(); ++s)
            for (size_t i = 0; i < keys.PointCount(); ++i)
                keys.SetForce(s, i, {huge, -huge, 0}, s % 2 == 0 ? huge : 1, {0, huge, huge});
        for (int k = 0; k < 5; ++k)
            recovered +=
                keys.Step(1. / 60, TurnAbout({}, {0, huge < 1e7 ? 3. * k : 0., 0}, {}), *head).recovered;
        for (size_t s = 0; s < keys.StrandCount(); ++s)
            for (size_t i = 0; i < keys.PointCount(); ++i) {
                const Vector3d p = keys.Position(s, i);
                EXPECT_TRUE(std::isfinite(p.x + p.y + p.z)) << huge << " strand " << s;
            }
    }
    EXPECT_GT(recovered, 0u); // and it is said
}

// Every instruction set's kernel, and the plain double that shares only the text with them.
TEST(Kernels, AllStepAlike) {
    std::vector<Vector3d> first;
    const Groom groom = SmallHead("curly", 30);
    for (const InstructionSet isa : SupportedIsas()) {
        HairSimulation simulation(groom, MakeHead(), ShakenHead(30));
        simulation.MutableKeys()->UseKernel(RodKernelFor(isa));
        for (int frame = 0; frame < 6; ++frame)
            simulation.NextFrame();
        const KeyStrands &keys = simulation.Keys();
        for (size_t s = 0, n = 0; s < keys.StrandCount(); ++s)
            for (size_t i = 0; i < keys.PointCount(); ++i, ++n) {
                if (first.size() <= n)
                    first.push_back(keys.Position(s, i));
                EXPECT_LT((first[n] - keys.Position(s, i)).Length(), 1e-4) << IsaName(isa);
            }
    }
}

TEST(Kernels, ALaneIsThePlainSolver) {
    constexpr size_t points = 20;
    std::vector<Vector3d> rest;
    for (size_t i = 0; i < points; ++i) {
        const double u = static_cast<double>(i);
        rest.push_back({std::cos(u / 3), -0.7 * u, std::sin(u / 3)});
    }
    KeyStrands set(rest, points, {});
    for (size_t i = 0; i < points; ++i)
        set.SetForce(0, i, {300, -981, 0}, 2, {});
    // The same strand in plain arrays
    std::vector<Vector3d> x = rest, v(points), xBefore = rest, vBefore(points), director(points),
                          none(points), acceleration(points, Vector3d{300, -981, 0});
    std::vector<double> length(points), mass(points), zero(points), drag(points, 2), curvature[3];
    for (size_t j = 0; j + 1 < points; ++j)
        length[j] = set.EdgeLength(0, j), director[j] = set.Director(0, j);
    for (size_t i = 0; i < points; ++i)
        mass[i] = set.Mass(0, i);
    rods::RodArrays<double> a;
    a.points = points, a.x = x.data(), a.v = v.data(), a.xBefore = xBefore.data(), a.vBefore = vBefore.data();
    a.director = director.data(), a.fixedTo = rest.data(), a.length = length.data(), a.mass = mass.data();
    const Vector3d root = director[0];
    a.fixedDirector = &root, a.acceleration = acceleration.data(), a.drag = drag.data();
    a.contactNormalStiffness = a.contactTangentStiffness = zero.data();
    a.contactNormal = a.contactForce = none.data();
    for (size_t c = 0; c < 3; ++c) {
        curvature[c].resize(points);
        for (size_t i = 1; i + 1 < points; ++i)
            curvature[c][i] =
                rods::MeasureHinge(rods::MakeRodEdge(rest[i - 1], rest[i]),
                                   rods::MakeRodEdge(rest[i], rest[i + 1]), director[i - 1], director[i])
                    .value[c];
        a.rest[c] = curvature[c].data();
    }
    const StrandPhysics p;
    std::vector<double> scratch(rods::RodSolver<double>::ScratchSize(points));
    const std::unique_ptr<Obstacle> nothing = MakeUnion({});
    for (int step = 0; step < 30; ++step) {
        rods::RodSolver<double> solver(a, {p.bending, p.twist, p.stretch, p.damping},
                                       step == 0 ? rods::RodFormula::Euler : rods::RodFormula::Bdf2, 1. / 60,
                                       scratch.data());
        solver.Begin();
        for (size_t k = 0; k < p.newtonSteps; ++k)
            solver.Newton();
        for (int k = 0; k < 60 && solver.ProjectLengths() >= 1e-6; ++k) {
        }
        solver.End();
        set.Step(1. / 60, {}, *nothing);
    }
    for (size_t i = 0; i < points; ++i)
        EXPECT_LT((x[i] - set.Position(0, i)).Length(), 1e-5) << i;
    EXPECT_GT((x[points - 1] - rest[points - 1]).Length(), 0.1);
}

TEST(Followers, KeepTheirPlaceUnderARigidMotion) {
    const Groom groom = SmallHead("curly", 200);
    const std::vector<uint32_t> keys = ChooseKeyHairs(groom, 40);
    EXPECT_EQ(keys.size(), 40u);
    KeyStrands set(ResampleKeyHairs(groom, keys, 24), 24, {});
    const HairInterpolation interpolation(groom, keys, set);
    const Pose pose = TurnAbout({1, 2, 3}, {0.3, 0.5, -0.8}, {5, 0, 0});
    const std::unique_ptr<Obstacle> nothing = MakeUnion({});
    KeyStrands turned(ResampleKeyHairs(groom, keys, 24), 24, {});
    // Turned so slowly that nothing swings
    for (int k = 1; k <= 60; ++k) {
        const double f = k / 60.;
        turned.Step(100, TurnAbout({1, 2, 3}, Vector3d{0.3, 0.5, -0.8} * f, Vector3d{5, 0, 0} * f), *nothing);
    }
    const Groom moved = interpolation.Deform(turned, pose, *nothing, 0);
    float away = 0;
    for (size_t i = 0; i < groom.points.size(); ++i)
        away = std::max(away, (moved.points[i] - Point3f(pose.Point(Vector3d(groom.points[i])))).Length());
    const Groom still = interpolation.Deform(set, {}, *nothing, 0);
    float same = 0;
    for (size_t i = 0; i < groom.points.size(); ++i)
        same = std::max(same, (still.points[i] - groom.points[i]).Length());
    EXPECT_LT(same, 1e-4f);
    EXPECT_LT(away, 0.05f);
}

// Hairs between key hairs that part, behind a shoulder and before it: none stretches, none goes through, and
// none jumps when all key hairs have come to rest. Pushed out point by point, one was three times as long.
TEST(Followers, KeepTheirLengthAndStayOutside) {
    const Groom groom = SmallHead("straight", 1500);
    SimulationSettings settings = ShakenHead(120);
    settings.framesPerSecond = 16;
    HairSimulation simulation(groom, MakeHead(), settings);
    const std::unique_ptr<Obstacle> head = MakeHead();
    const KeyStrands &keys = simulation.Keys();
    double deepest = 0, jump = 0, keyJump = 0;
    std::vector<double> stretch(groom.StrandCount());
    Groom before;
    std::vector<Vector3d> tips(keys.StrandCount());
    for (int frame = 1; frame <= 40; ++frame) {
        simulation.NextFrame();
        const Groom now = simulation.Frame();
        for (size_t s = 0; s < groom.StrandCount(); ++s) {
            double length = 0, rest = 0;
            for (size_t i = groom.strandOffsets[s]; i < groom.strandOffsets[s + 1]; ++i) {
                const Vector3d local = simulation.HeadPose().LocalPoint(Vector3d(now.points[i]));
                const double keep = std::min(0.03, head->Distance(Vector3d(groom.points[i])));
                deepest = std::max(deepest, keep - head->Distance(local));
                if (frame > 30)
                    jump = std::max(jump, Vector3d(now.points[i] - before.points[i]).Length());
                if (i == groom.strandOffsets[s])
                    continue;
                length += Vector3d(now.points[i] - now.points[i - 1]).Length();
                rest += Vector3d(groom.points[i] - groom.points[i - 1]).Length();
            }
            stretch[s] = std::max(stretch[s], std::abs(length / rest - 1));
        }
        for (size_t k = 0; k < keys.StrandCount(); ++k) {
            const Vector3d tip = keys.Position(k, keys.PointCount() - 1);
            if (frame > 30)
                keyJump = std::max(keyJump, (tip - tips[k]).Length());
            tips[k] = tip;
        }
        before = now;
    }
    const double longest = *std::max_element(stretch.begin(), stretch.end());
    std::printf(
        "hairs that follow: lengths are off by %.2g at most, %.2g cm too deep; in a frame near rest they "
        "go %.2g cm, key hairs %.2g cm\n",
        longest, deepest, jump, keyJump);
    EXPECT_LT(longest, 0.1);
    EXPECT_LT(std::count_if(stretch.begin(), stretch.end(), [](double v) { return v > 0.01; }), 15);
    EXPECT_LT(deepest, 1e-3);
    EXPECT_LT(jump, 2 * keyJump);
}

TEST(Motions, PassThroughTheirKeysSmoothly) {
    const HeadMotion motion = ShakenHead(1).motion;
    EXPECT_LT((motion.At(0.4).Point({0, 0, 7}) - TurnAbout({0, -12, -3}, {0, 0.8, 0}, {}).Point({0, 0, 7}))
                  .Length(),
              1e-12);
    EXPECT_LT((motion.At(9).Point({1, 2, 3}) - Vector3d{1, 2, 3}).Length(), 1e-12);
    for (double t = -0.1; t < 1.3; t += 0.013) { // no jump of place or velocity
        const auto at = [&](double time) { return motion.At(time).Point({3, 4, 5}); };
        const Vector3d before = (at(t) - at(t - 1e-4)) / 1e-4, after = (at(t + 1e-4) - at(t)) / 1e-4;
        EXPECT_LT((before - after).Length(), 0.2) << t;
    }
}

// A point of the head at rest, where it is by a pose: with the first pose undone.
Vector3d Rotated(const Vector3d &p, double degrees) { // about y
    const double a = degrees * kPi<double> / 180;
    return {p.x * std::cos(a) + p.z * std::sin(a), p.y, p.z * std::cos(a) - p.x * std::sin(a)};
}

TEST(Motions, PosesThatOthersMade) {
    // Three frames of a head that stands turned by 30 degrees at (1, 2, 3) when it begins
    const std::string turns = "frame,x,y,z,rx,ry,rz\n"
                              "10, 1,2,3, 0,30,0\n12; 1 2 4; 0 70 0 # on\n\n16 2 2 4 0 90 0\n";
    const std::string quaternions =
        fmt::format("10 1 2 3 {} 0 {} 0\n12 1 2 4 {} 0 {} 0\n16 2 2 4 -{} 0 -{} 0\n",
                    std::cos(kPi<double> / 12), std::sin(kPi<double> / 12), std::cos(kPi<double> * 7 / 36),
                    std::sin(kPi<double> * 7 / 36), std::cos(kPi<double> / 4), std::sin(kPi<double> / 4));
    // The same by an Xform in an Xform: the outer one turns and is twice as large, lengths are metres
    const std::string usda = R"(#usda 1.0
(
    metersPerUnit = 0.01
    timeCodesPerSecond = 5
    upAxis = "Y"
)
def Xform "Still"
{
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Xform "World"
{
    double3 xformOp:scale = (2, 2, 2)
    float xformOp:rotateY.timeSamples = { 10: 30, 12: 70, 16: 90, }
    double3 xformOp:translate.timeSamples = { 10: (1, 2, 3), 12: (1, 2, 4), 14: (1.5, 2, 4), 16: (2, 2, 4) }
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateY", "xformOp:scale"]
    def Mesh "Head"
    {
    }
}
)";
    const Vector3d local{3, 4, 5};
    const Vector3d start = Rotated(local, 30) + Vector3d{1, 2, 3};
    PoseFileOptions inFifths;
    inFifths.framesPerSecond = 5;
    PoseFileOptions ofHead = {}, fromTwelve = inFifths;
    ofHead.prim = "/World/Head";
    fromTwelve.start = 12;
    const HeadMotion motions[] = {
        HeadMotion(ParsePoses(turns, "t", inFifths)), HeadMotion(ParsePoses(quaternions, "q", inFifths)),
        HeadMotion(ParsePoses(usda, "u", {})), HeadMotion(ParsePoses(usda, "u", ofHead))};
    for (const HeadMotion &motion : motions) {
        EXPECT_LT((motion.At(0).Point(start) - start).Length(), 1e-6);
        EXPECT_LT((motion.At(0.4).Point(start) - (Rotated(local, 70) + Vector3d{1, 2, 4})).Length(), 1e-6);
        for (const double end : {1.2, 9.})
            EXPECT_LT((motion.At(end).Point(start) - (Rotated(local, 90) + Vector3d{2, 2, 4})).Length(),
                      1e-6);
        for (double t = -0.1; t < 1.4; t += 0.013) { // rigid, and no jump of place or velocity
            const Pose pose = motion.At(t);
            EXPECT_NEAR(pose.x.Length(), 1, 1e-12);
            EXPECT_NEAR(Dot(pose.x, pose.y), 0, 1e-12);
            EXPECT_NEAR(Dot(Cross(pose.x, pose.y), pose.z), 1, 1e-12);
            const auto at = [&](double time) { return motion.At(time).Point(start); };
            const Vector3d before = (at(t) - at(t - 1e-4)) / 1e-4, after = (at(t + 1e-4) - at(t)) / 1e-4;
            EXPECT_LT((before - after).Length(), 0.2) << t;
        }
    }
    EXPECT_LT((HeadMotion(ParsePoses(turns, "t", fromTwelve)).At(0.8).Point(Rotated(local, 70)) -
               (Rotated(local, 90) + Vector3d{2, 2, 4} - Rotated(Vector3d{1, 2, 4}, 20)))
                  .Length(),
              1e-6);
    // A table whose z axis is up, in inches: turns about z are ours about y, steps along y ours along -z
    PoseFileOptions zUp;
    zUp.isZUp = true, zUp.unit = 2.54;
    const Pose turned = HeadMotion(ParsePoses("0 0 0 0 0 0 0\n24 0 1 0 0 0 40\n", "z", zUp)).At(1);
    EXPECT_LT((turned.Point(local) - (Rotated(local, 40) + Vector3d{0, 0, -2.54})).Length(), 1e-6);
}

TEST(Motions, MistakesInPosesAreNamed) {
    const auto says = [](const std::string &text, const PoseFileOptions &options = {}) {
        return MessageOf([&] { ParsePoses(text, "p", options); });
    };
    const std::string xform = "#usda 1.0\ndef Xform \"Head\" {\n  double3 ";
    const std::string order = "\n  uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}\n";
    PoseFileOptions nobody, late;
    nobody.prim = "Hat", late.start = 3;
    const std::pair<std::string, std::string> mistakes[] = {
        {says(""), "p:1:1: error: there is no pose"},
        {says("1 2 3\n"), "p:1:1: error: this line has 3 numbers; 7 are a frame"},
        {says("1 0 0 0 0 0 0\n2 0 0 0 0 0 0 1\n"),
         "p:2:1: error: this line has 8 numbers, the lines before it have 7"},
        {says("1 0 0 0 0 0 0\n1 0 0 0 0 0 0\n"),
         "p:2:1: error: frame 1 stands after frame 1; frames must grow"},
        {says("1 0 0 0 0 zero 0\n"), "p:1:11: error: \"zero\" is no number"},
        {says("x y\nframe x\n"), "p:2:1: error: \"frame\" is no number"},
        {says("1 0 0 nan 0 0 0\n"), "p:1:7: error: \"nan\" is no number"},
        {says("1 0 0 1e300 0 0 0\n"), "within a million"},
        {says("1 0 0 0 0 0 0 0\n"), "is no quaternion; no turn is 1 0 0 0"},
        {says("1 0 0 0 0 0 0\n2 0 0 0 0 170 0\n"),
         "p:2:1: error: between frames 1 and 2 the head turns by 170 degrees"},
        {says("1 0 0 0 0 0 0\n", late), "there is no frame 3 to start from; the file has frames 1 to 1"},
        {says("#usda 1.0\n"), "no prim of this layer has xformOps with time samples"},
        {says(xform + "xformOp:scale.timeSamples = {1: (1, 1, 1), 2: (1, 2, 1)}" + order),
         "at frame 2 the head is scaled"},
        {says(xform + "xformOp:scale.timeSamples = {1: (0, 1, 1), 2: (1, 1, 1)}" + order),
         "scaled to nothing"},
        {says(xform + "xformOp:scale.timeSamples = {1: (1, 1, 1), 2: (1, 1)}" + order),
         "p:3:57: error: this sample has 2"},
        {says(xform + "xformOp:scale.timeSamples = {1: (1, 1, 1)}" + order, nobody),
         "no prim is named \"Hat\"; these move: /Head"},
        {says(xform + "xformOp:scale = (1, 1, 1)" + order,
              [] {
                  PoseFileOptions o;
                  o.prim = "Head";
                  return o;
              }()),
         "/Head does not move"},
    };
    for (const auto &[said, message] : mistakes)
        EXPECT_NE(said.find(message), std::string::npos) << message << "\nis not in\n" << said;
}

SimulationRecipe Parse(const std::string &text) { return ParseSimulationRecipe(text, "r.recipe"); }

TEST(Recipes, SayWhatTheyAskFor) {
    const SimulationRecipe r = Parse(R"(
        Hair "groom" "string style" "curly" "integer strands" 20
        Simulation "strands" "string method" "springs" "float seconds" 1.5 "float fps" 30 "integer keys" 7
            "float bending" 1e6 "float twist" .5 "vector3 gravity" [0 0 -981] "bool balanced" "false"
        Obstacle "head"
        Obstacle "sphere" "point3 center" [0 0 30] "float radius" 2
        Motion "keys" "float time" [0 1] "vector3 turn" [0 0 0 0 90 0]
        HairToHair "grid" "float drag" 5 "integer passes" 3
        Wind "steady" "vector3 velocity" [100 0 0])");
    EXPECT_EQ(r.groom.StrandCount(), 20u);
    EXPECT_EQ(r.FrameCount(), 46u);
    EXPECT_EQ(r.settings.keyHairs, 7u);
    EXPECT_EQ(r.settings.physics.twist, 5e5);
    EXPECT_FALSE(r.settings.balanced);
    EXPECT_EQ(r.settings.gravity.z, -981);
    EXPECT_LT(r.obstacle->Distance({0, 0, 30}), 0);
    EXPECT_LT(r.obstacle->Distance({0, 3, 0}), 0);
    EXPECT_NEAR(r.settings.motion.At(2).z.x, 1, 1e-12);
    EXPECT_EQ(r.settings.wind.velocity.x, 100);
    EXPECT_EQ(r.settings.physics.method, StrandMethod::Springs);
    EXPECT_EQ(r.settings.coupling.drag, 5);
    EXPECT_EQ(r.settings.coupling.passes, 3u);
}

TEST(Recipes, MistakesAreNamed) {
    const auto says = [](const std::string &text) { return MessageOf([&] { Parse(text); }); };
    const std::string hair = "Hair \"groom\" \"integer strands\" 5\n";
    const std::pair<std::string, std::string> mistakes[] = {
        {"", "no Hair"},
        {"Hare \"groom\"", "r.recipe:1:1: error: \"Hare\" is no directive here. Did you mean \"Hair\"?"},
        {"Hair \"grom\"", "Did you mean \"groom\"?"},
        {hair + hair, "r.recipe:2:1: error: Hair stands here a second time"},
        {hair + "Simulation \"strands\" \"float bendin\" 3", "Did you mean \"bending\"?"},
        {hair + "Simulation \"strands\" \"float bending\" -3", "\"bending\" is -3; it must be 1 to 1e+12"},
        {hair + "Simulation \"strands\" \"string bending\" \"soft\"", "write \"float bending\""},
        {hair + "Simulation \"strands\" \"float bending\" [1 2]", "it takes one"},
        {hair + "Simulation \"strands\" \"vector3 gravity\" [1 2]", "gravity"},
        {hair + "Simulation \"strands\" \"float seconds\" 100000 \"float fps\" 1000",
         "more than 100000 frames"},
        {hair + "Motion \"keys\"", "\"float time\""},
        {hair + "Motion \"keys\" \"float time\" [0 2 1]",
         "\"time\" holds 1 after 2; times must begin with 0 and grow"},
        {hair + "Motion \"keys\" \"float time\" [0 1] \"vector3 turn\" [0 0 0]", "1 vectors for 2 times"},
        {hair + "Motion \"keys\" \"float time\" [0 1] \"vector3 turn\" [1 0 0 0 0 0]",
         "does not begin with 0 0 0"},
        {hair + "Motion \"poses\"", "r.recipe:2:1: error: this motion needs \"string filename\""},
        {hair + "Motion \"poses\" \"string filename\" \"none.txt\"", "none.txt"},
        {hair + "Motion \"poses\" \"string up\" \"x\"", "up"},
        {hair + "Target \"density\"", "r.recipe:2:1: error: this target needs \"string filename\""},
        {hair + "Target \"density\" \"string kernel\" \"tend\"", "Did you mean \"tent\"?"},
        {"Hair \"hairfile\"", "needs \"string filename\""},
        {"Hair \"hairfile\" \"string filename\" \"none.hair\"", "none.hair"},
        {hair + "3", "expected a directive"},
    };
    for (const auto &[text, message] : mistakes)
        EXPECT_NE(says(text).find(message), std::string::npos) << text << "\nis answered with\n"
                                                               << says(text);
}

TEST(Recipes, ReadPosesBesideThem) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "poses";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "head.txt") << "5 0 0 0 0 0 0\n9 0 0 0 0 0 0\n10 0 0 0 0 0 90\n11 0 0 0 0 0 90\n";
    const SimulationRecipe r = ParseSimulationRecipe(R"(
        Hair "groom" "integer strands" 5
        Motion "poses" "string filename" "head.txt" "float fps" 2 "float start" 9 "string up" "z")",
                                                     "r.recipe", folder.string());
    std::filesystem::remove_all(folder);
    EXPECT_LT((r.settings.motion.At(0.5).Point({1, 0, 0}) - Vector3d{0, 0, -1}).Length(), 1e-9);
}

TEST(Recipes, TheManualHasEveryParameter) {
    const std::string manual = SimulationManual();
    for (const char *name :
         {"## Hair \"groom\"", "## Simulation \"strands\"", "`bending`", "cm^4/s^2", "`gustlength`"})
        EXPECT_NE(manual.find(name), std::string::npos) << name;
}

} // namespace
} // namespace cuticle
