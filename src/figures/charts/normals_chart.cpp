// Normals that hair carries along from its rest, against those of a shell that is made anew for every frame.
#include "core/clock.h"
#include "core/parallel.h"
#include "dynamics/simulation.h"
#include "figures/charts/charts.h"
#include "grooms/procedural.h"
#include "volume/density.h"
#include "volume/normals.h"
#include "volume/shell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr float kCell = 1.5f; // cm

HairShell ShellOf(const Groom &groom) {
    const StrandSet strands = CurvesOf(groom, 2);
    const auto density = Smoothed(LineDensity(strands, BoxAround(BoundsOf(strands), kCell, 5)), 2);
    return MakeShell(density, MedianDensity(density) / 2);
}

std::vector<Normal3f> NormalsAt(const HairShell &shell, const std::vector<Point3f> &points) {
    std::vector<Normal3f> normals(points.size());
    for (size_t i = 0; i < points.size(); ++i)
        normals[i] = ShellNormal(shell.distance, points[i]);
    return normals;
}

std::vector<Normal3f> CarryAll(const Groom &rest, const std::vector<Normal3f> &normals, const Groom &posed,
                               const Transform &head) {
    std::vector<Normal3f> all;
    for (size_t s = 0; s < rest.StrandCount(); ++s) {
        const std::span<const Normal3f> own(normals.data() + rest.strandOffsets[s], rest.PointCount(s));
        const std::vector<Normal3f> carried = CarryNormals(rest.Strand(s), own, posed.Strand(s), head);
        all.insert(all.end(), carried.begin(), carried.end());
    }
    return all;
}

Transform TransformOf(const Pose &p) {
    return Transform(Transform::Matrix{{{p.x.x, p.y.x, p.z.x, p.origin.x},
                                        {p.x.y, p.y.y, p.z.y, p.origin.y},
                                        {p.x.z, p.y.z, p.z.z, p.origin.z},
                                        {0, 0, 0, 1}}});
}

// The mean angle (degrees) between normals, of points within two cells of the shell, where light is
// scattered.
double MeanAngle(const std::vector<Normal3f> &normals, const std::vector<Normal3f> &anew,
                 const HairShell &shell, const std::vector<Point3f> &points) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!(std::abs(shell.distance.Sample(points[i])) < 2 * kCell) || anew[i].LengthSquared() == 0 ||
            normals[i].LengthSquared() == 0)
            continue;
        sum += static_cast<double>(Degrees(std::acos(std::clamp(Dot(normals[i], anew[i]), -1.f, 1.f))));
        ++count;
    }
    return sum / count;
}

} // namespace

FigureData NormalsChart(const FigureOptions &options) {
    FigureData data{Table({"seconds", "carried_deg", "rigid_deg", "carry_ms", "anew_ms"})};
    GroomParams params = MakeGroomParams("head", "straight");
    params.strands = options.quick ? 400 : 2000;
    const Groom rest = MakeGroom(params);
    SimulationSettings settings;
    settings.keyHairs = options.quick ? 100 : 400, settings.points = 24;
    settings.motion = HeadMotion(
        {{0, {}, {}}, {0.4, {0, 0.7, 0}, {}}, {0.8, {0, -0.7, 0}, {}}, {1.1, {}, {}}}, {0, -12, -3});
    HairSimulation simulation(rest, MakeHead(), settings);
    const std::vector<Normal3f> atRest = NormalsAt(ShellOf(rest), rest.points);
    PlotSeries carried, rigid;
    carried.label = "carried along the strand", carried.color = 0;
    rigid.label = "turned with the head", rigid.color = 1;
    carried.style = rigid.style = PlotStyle::LinePoints;
    double carryCpu = 0, anewCpu = 0, sum = 0, rigidSum = 0, worst = 0;
    const size_t frames = 48, step = options.quick ? 12 : 2;
    for (size_t frame = 0; frame <= frames; frame += step) {
        while (simulation.FrameNumber() < frame)
            simulation.NextFrame();
        const Groom posed = frame == 0 ? rest : simulation.Frame();
        const Transform head = TransformOf(simulation.HeadPose());
        double start = ProcessCpuSeconds();
        const std::vector<Normal3f> along = CarryAll(rest, atRest, posed, head);
        const double carry = ProcessCpuSeconds() - start;
        start = ProcessCpuSeconds();
        const HairShell shell = ShellOf(posed);
        const std::vector<Normal3f> anew = NormalsAt(shell, posed.points);
        const double make = ProcessCpuSeconds() - start;
        std::vector<Normal3f> turned = atRest;
        for (Normal3f &n : turned)
            n = head.Vector(n);
        const double error = MeanAngle(along, anew, shell, posed.points),
                     rigidError = MeanAngle(turned, anew, shell, posed.points), time = simulation.Time();
        carried.x.push_back(time), carried.y.push_back(error);
        rigid.x.push_back(time), rigid.y.push_back(rigidError);
        carryCpu += carry, anewCpu += make, sum += error, rigidSum += rigidError,
            worst = std::max(worst, error);
        data.table.Add({time, error, rigidError, 1000 * carry, 1000 * make});
    }
    PlotPanel panel;
    panel.x = {.label = "time (s)"};
    panel.y = {.label = "mean angle to normals made anew (degrees)"};
    panel.series = {carried, rigid};
    data.plot.panels = {panel};
    const auto count = static_cast<double>(carried.y.size());
    data.checks = {
        {"angle at rest, degrees", carried.y.front(), 0, 0.1},
        {"the worst mean angle of a frame, degrees", worst, 0, 45},
        {"mean angle over the motion, of that of normals turned with the head", sum / rigidSum, 0, 1.1},
        {"time of carrying, of making anew", carryCpu / anewCpu, 0, 0.5}};
    data.note =
        fmt::format("{} hairs, a head that turns by 40° to either side and is still from 1.1 s on. Carried "
                    "normals are off by {:.0f}° in the mean and by {:.0f}° in the worst frame, and take "
                    "{:.1f} ms a frame; shell and normals anew take {:.0f} ms.",
                    rest.StrandCount(), sum / count, worst, 1000 * carryCpu / count, 1000 * anewCpu / count);
    return data;
}

} // namespace cuticle
