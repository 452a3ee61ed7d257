// Figures of Petrovic, Henne and Anderson: hair that moves, and hair that is directed.
#include "dynamics/crossings.h"
#include "dynamics/simulation.h"
#include "figures/papers/paper_figures.h"
#include "figures/rendered.h"
#include "grooms/pbrt_writer.h"
#include "grooms/procedural.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace cuticle {

namespace {

// How much of everything a draft and a picture for paper take.
struct MotionQuality {
    int strands, side, spp;
    float widthScale; // of strands, fewer of which are to cover as much
    size_t keys, points;
    explicit MotionQuality(bool quick)
        : strands(quick ? 2000 : 24000), side(quick ? 120 : 560), spp(quick ? 4 : 24),
          widthScale(quick ? 13.f : 4.f), keys(quick ? 250 : 1500), points(quick ? 16 : 24) {}
};

Groom StraightHead(const MotionQuality &quality) {
    GroomParams params = MakeGroomParams("head", "straight");
    params.strands = quality.strands;
    params.widthScale = quality.widthScale;
    return MakeGroom(params);
}

// The statements of all strands of a groom for which `takes` says so, in such hair.
std::string HairText(const Groom &groom, const std::string &pigments,
                     const std::function<bool(size_t strand)> &takes) {
    std::string text =
        fmt::format("AttributeBegin Material \"hair\" {} \"float beta_m\" 0.3 \"float beta_n\" "
                    "0.4 \"float alpha\" 2.5\n",
                    pigments);
    PbrtCurveCounts counts;
    for (size_t s = 0; s < groom.StrandCount(); ++s)
        if (takes(s))
            AppendPbrtCurves(groom, s, s + 1, {}, &text, &counts);
    return text + "AttributeEnd\n";
}

std::string TransformText(const Pose &pose) {
    std::string text = "Transform [";
    for (const Vector3d &column : {pose.x, pose.y, pose.z})
        text += fmt::format("{} {} {} 0 ", column.x, column.y, column.z);
    return text + fmt::format("{} {} {} 1]\n", pose.origin.x, pose.origin.y, pose.origin.z);
}

// Renders hair, and the head where it stands.
FigurePicture RenderHead(const std::string &name, const MotionQuality &quality, const std::string &lookAt,
                         const Pose &pose, const std::string &hair) {
    FigurePicture picture;
    picture.name = name;
    picture.samples = quality.spp;
    picture.image = RenderText(
        fmt::format("Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0} \"bool denoise\" "
                    "\"true\"\n"
                    "PixelFilter \"gaussian\" Integrator \"path\" \"integer maxdepth\" 16\n"
                    "Scale -1 1 1 LookAt {1} 0 1 0\n"
                    "Camera \"perspective\" \"float fov\" 27\n"
                    "WorldBegin\n"
                    "LightSource \"infinite\" \"rgb L\" [0.4 0.42 0.45]\n"
                    "LightSource \"distant\" \"point from\" [0.9 0.9 -0.7] \"rgb L\" [3.2 3 2.8]\n"
                    "{2}AttributeBegin\n{3}"
                    "Material \"matte\" \"rgb Kd\" [0.5 0.36 0.3] Shape \"groomhead\"\n"
                    "AttributeEnd\nWorldEnd\n",
                    quality.side, lookAt, hair, TransformText(pose)),
        quality.spp);
    return picture;
}

void AddPanel(FigureData *data, const std::string &title, FigurePicture picture) {
    data->plot.panels.push_back(PicturePanel(title, picture.image));
    data->pictures.push_back(std::move(picture));
}

// The points of the key hairs in the coordinates of a head, where a turn of the head moves nothing.
std::vector<Vector3d> KeysSeenFrom(const Pose &pose, const KeyStrands &keys) {
    std::vector<Vector3d> points;
    for (size_t s = 0; s < keys.StrandCount(); ++s)
        for (size_t i = 0; i < keys.PointCount(); ++i)
            points.push_back(pose.LocalPoint(keys.Position(s, i)));
    return points;
}

// Holds what became of a head that was shaken.
struct ShakenHead {
    Groom hair;
    Pose pose;
    size_t crossings = 0; // pairs of key hairs
    double swing = 0;     // cm that the tips have moved against the head, in the mean over time
    StepReport worst;
};

ShakenHead Shake(const Groom &groom, const SimulationSettings &settings, size_t frames) {
    HairSimulation simulation(groom, MakeHead(), settings);
    const std::vector<Vector3d> rest = KeysSeenFrom(settings.motion.At(0), simulation.Keys());
    StrandCrossings crossings(rest, settings.points);
    ShakenHead found;
    for (size_t frame = 0; frame < frames; ++frame) {
        found.worst.Join(simulation.NextFrame());
        found.pose = settings.motion.At(simulation.Time());
        const std::vector<Vector3d> now = KeysSeenFrom(found.pose, simulation.Keys());
        crossings.MoveTo(now);
        const auto tips = static_cast<double>(simulation.Keys().StrandCount() * frames);
        for (size_t tip = settings.points - 1; tip < now.size(); tip += settings.points)
            found.swing += (now[tip] - rest[tip]).Length() / tips;
    }
    found.hair = simulation.Frame();
    found.crossings = crossings.Pairs();
    return found;
}

} // namespace

// A head shakes once to each side; hair is light and dark by where around the head it grows.
FigureData Petrovic4(const FigureOptions &options) {
    const MotionQuality quality(options.quick);
    const Groom groom = StraightHead(quality);
    const auto isLight = [&](size_t s) {
        const Point3f root = groom.points[groom.strandOffsets[s]];
        return std::fmod(Degrees(std::atan2(root.x, -root.z)) + 360, 60) < 30;
    };
    SimulationSettings settings;
    settings.keyHairs = quality.keys, settings.points = quality.points;
    settings.framesPerSecond = 60;
    const double turn = Radians(40.);
    settings.motion = HeadMotion(
        {{0, {}, {}}, {0.3, {0, turn, 0}, {}}, {0.6, {0, -turn, 0}, {}}, {0.9, {}, {}}}, {0, -12, -3});
    settings.coupling.cell = 1.5, settings.coupling.passes = 3;
    constexpr size_t kFrames = 36;

    FigureData data{Table({"picture", "drag_per_s", "crossing_pairs", "mean_swing_cm", "stretch"})};
    data.plot.columns = 2;
    data.plot.width = 560, data.plot.height = 600;
    std::array<ShakenHead, 2> heads;
    for (size_t i = 0; i < 2; ++i) {
        settings.coupling.drag = i == 0 ? 0 : 100;
        heads[i] = Shake(groom, settings, kFrames);
        const ShakenHead &head = heads[i];
        data.table.Add({i == 0 ? "a" : "b", settings.coupling.drag, static_cast<double>(head.crossings),
                        head.swing, head.worst.stretch});
        const std::string hair =
            HairText(head.hair, "\"float eumelanin\" 0.12 \"float pheomelanin\" 0.1", isLight) +
            HairText(head.hair, "\"float eumelanin\" 1.3 \"float pheomelanin\" 0.3",
                     [&](size_t s) { return !isLight(s); });
        AddPanel(&data,
                 fmt::format("{}: {} pairs cross", i == 0 ? "a: without" : "b: smoothed", head.crossings),
                 RenderHead(i == 0 ? "petrovic-4-a" : "petrovic-4-b", quality, "50 6 -80  0 -6 0", head.pose,
                            hair));
    }
    const double share = static_cast<double>(heads[1].crossings) / static_cast<double>(heads[0].crossings),
                 swing = heads[1].swing / heads[0].swing;
    data.note =
        fmt::format("Of {} key hairs {} pairs have passed through one another after {:.1f} s, and {} where "
                    "velocities are smoothed, "
                    "though the tips move as far ({:.1f} and {:.1f} cm in the mean). The paper says how hair "
                    "is drawn to the grid's velocity and not how "
                    "strongly; here by 100/s, on cells of 1.5 cm.",
                    quality.keys, heads[0].crossings, static_cast<double>(kFrames) / settings.framesPerSecond,
                    heads[1].crossings, heads[0].swing, heads[1].swing);
    data.checks = {{"crossing pairs with smoothing, of those without", share, 0, 0.8},
                   {"the tips' swing with smoothing, of that without", swing, 0.75, 1.5},
                   {"greatest stretch", std::max(heads[0].worst.stretch, heads[1].worst.stretch), 0, 1e-5}};
    return data;
}

// A head of hair, the same blown by a wind, and where density forces alone bring the first.
FigureData Petrovic5(const FigureOptions &options) {
    const MotionQuality quality(options.quick);
    const Groom groom = StraightHead(quality);
    SimulationSettings settings;
    settings.keyHairs = quality.keys, settings.points = quality.points;
    SimulationSettings blown = settings;
    blown.drag = 6, blown.coupling.drag = 20;
    blown.wind = {{420, 0, 170}, 0.3, 25};
    HairSimulation wanted(groom, MakeHead(), blown);
    for (int frame = 0; frame < 24; ++frame)
        wanted.NextFrame();

    // As in the paper: no gravity, no obstacles, and so much drag that inertia counts little
    settings.gravity = {};
    settings.drag = 30;
    settings.direction.points = KeysSeenFrom({}, wanted.Keys());
    settings.direction.seconds = options.quick ? 2 : 4;
    HairSimulation directed(groom, MakeUnion({}), settings);
    FigureData data{Table({"time_s", "cell_cm", "energy", "energy_on_the_finest", "stretch"})};
    const double finest = settings.direction.cells.back(), first = directed.TargetEnergy(finest);
    double rise = 0;
    StepReport worst;
    while (directed.Time() < settings.direction.seconds) {
        const double cell = settings.direction.CellAt(directed.Time() + 0.5 / settings.framesPerSecond),
                     before = directed.TargetEnergy(cell);
        worst.Join(directed.NextFrame());
        const double after = directed.TargetEnergy(cell);
        rise = std::max(rise, after / before - 1);
        data.table.Add({directed.Time(), cell, after, directed.TargetEnergy(finest), worst.stretch});
    }
    const double share = directed.TargetEnergy(finest) / first;
    data.plot.columns = 3;
    data.plot.width = 420, data.plot.height = 460;
    const std::array<Groom, 3> shapes = {groom, wanted.Frame(), directed.Frame()};
    constexpr std::array titles = {"a: at the start", "b: the target", "c: reached by density"};
    constexpr std::array names = {"petrovic-5-a", "petrovic-5-b", "petrovic-5-c"};
    for (size_t i = 0; i < 3; ++i)
        AddPanel(&data, titles[i],
                 RenderHead(names[i], quality, "50 2 -104  4 -6 0", {},
                            HairText(shapes[i], "\"float eumelanin\" 0.35 \"float pheomelanin\" 0.3",
                                     [](size_t) { return true; })));
    data.note = fmt::format(
        "On cells of {:g} cm the energy of equation 3 falls to {:.3f} of what it was. Cells are 6, 3 and 1.5 "
        "cm, a "
        "third of the time each; the density is made by a smooth kernel, not by the tent, whose force "
        "jumps at the walls of cells. Strands are rods, not springs.",
        finest, share);
    data.checks = {{"energy at the end, of that at the start", share, 0, 0.15},
                   {"greatest rise of the energy in a frame, relative", rise, 0, 1e-9},
                   {"greatest stretch", worst.stretch, 0, 1e-5}};
    return data;
}

} // namespace cuticle
