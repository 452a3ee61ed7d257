// How far hairs that follow key hairs are from where they would be, were they simulated themselves.
#include "core/clock.h"
#include "dynamics/simulation.h"
#include "figures/charts/charts.h"
#include "grooms/procedural.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

namespace cuticle {

namespace {

// All hairs after half a second of a shake, of which so many were simulated.
struct FollowedHead {
    Groom hair;
    double cpuSeconds = 0; // of a frame
};

FollowedHead Follow(const Groom &groom, size_t keys) {
    SimulationSettings settings;
    settings.keyHairs = keys;
    settings.framesPerSecond = 60;
    settings.motion =
        HeadMotion({{0, {}, {}}, {0.3, {0, 0.7, 0}, {}}, {0.6, {0, -0.7, 0}, {}}}, {0, -12, -3});
    HairSimulation simulation(groom, MakeHead(), settings);
    constexpr size_t kFrames = 30;
    const double start = ProcessCpuSeconds();
    for (size_t frame = 0; frame < kFrames; ++frame)
        simulation.NextFrame();
    FollowedHead found;
    found.hair = simulation.Frame();
    found.cpuSeconds = (ProcessCpuSeconds() - start) / kFrames;
    return found;
}

// The root-mean-square distance (cm) of the points of two grooms of the same hairs.
double DistanceOf(const Groom &a, const Groom &b) {
    double sum = 0;
    for (size_t i = 0; i < a.points.size(); ++i)
        sum += static_cast<double>((a.points[i] - b.points[i]).LengthSquared());
    return std::sqrt(sum / static_cast<double>(a.points.size()));
}

} // namespace

FigureData KeyHairsChart(const FigureOptions &options) {
    FigureData data{Table({"style", "key_hairs", "rms_error_cm", "frame_ms"})};
    PlotPanel panel;
    panel.x = {.label = "key hairs", .log = true};
    panel.y = {.label = "rms distance from hair that is simulated itself (cm)", .log = true};
    const int strands = options.quick ? 400 : 3000;
    std::string note;
    int color = 0;
    for (const char *style : {"straight", "wavy", "curly"}) {
        GroomParams params = MakeGroomParams("head", style);
        params.strands = strands;
        const Groom groom = MakeGroom(params);
        const FollowedHead all = Follow(groom, groom.StrandCount());
        PlotSeries series;
        series.label = style, series.color = color++, series.style = PlotStyle::LinePoints;
        for (size_t keys = 25; keys < static_cast<size_t>(strands); keys *= 2) {
            const FollowedHead some = Follow(groom, keys);
            const double error = DistanceOf(some.hair, all.hair);
            series.x.push_back(static_cast<double>(keys)), series.y.push_back(error);
            data.table.Add({style, static_cast<double>(keys), error, 1000 * some.cpuSeconds});
        }
        note += fmt::format("{}{} hair is off by {:.2f} cm with {:.0f} key hairs", note.empty() ? "" : ", ",
                            style, series.y.back(), series.x.back());
        data.checks.push_back(
            {fmt::format("error of {} hair with most key hairs, of that with fewest", style),
             series.y.back() / series.y.front(), 0, options.quick ? 0.9 : 0.6});
        data.checks.push_back(
            {fmt::format("error of {} hair with most key hairs, cm", style), series.y.back(), 0, 3});
        panel.series.push_back(series);
    }
    note[0] = static_cast<char>(std::toupper(note[0]));
    data.note =
        note + fmt::format("; of {} hairs in all, half a second into a shake of 40° to a side.", strands);
    data.plot.panels = {panel};
    return data;
}

} // namespace cuticle
