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

Groom GrownHead(const MotionQuality &quality, const char *style, float length = 34) {
    GroomParams params = MakeGroomParams("head", style);
    params.length = length;
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
                         const Pose &pose, const std::string &hair,
                         const std::string &integrator = "\"path\" \"integer maxdepth\" 16") {
    FigurePicture picture;
    picture.name = name;
    picture.samples = quality.spp;
    picture.image = RenderText(
        fmt::format("Film \"image\" \"integer xresolution\" {0} \"integer yresolution\" {0} \"bool denoise\" "
                    "\"true\"\n"
                    "PixelFilter \"gaussian\" Integrator {4}\n"
                    "Scale -1 1 1 LookAt {1} 0 1 0\n"
                    "Camera \"perspective\" \"float fov\" 27\n"
                    "WorldBegin\n"
                    "LightSource \"infinite\" \"rgb L\" [0.4 0.42 0.45]\n"
                    "LightSource \"distant\" \"point from\" [0.9 0.9 -0.7] \"rgb L\" [3.2 3 2.8]\n"
                    "{2}AttributeBegin\n{3}"
                    "Material \"matte\" \"rgb Kd\" [0.5 0.36 0.3] Shape \"groomhead\"\n"
                    "AttributeEnd\nWorldEnd\n",
                    quality.side, lookAt, hair, TransformText(pose), integrator),
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

// A turn to each side, and back.
HeadMotion TurnsOf(double angle) {
    return HeadMotion({{0, {}, {}}, {0.3, {0, angle, 0}, {}}, {0.6, {0, -angle, 0}, {}}, {0.9, {}, {}}},
                      {0, -12, -3});
}

} // namespace

// Curls in gel, which keep their shape, in the middle of a motion; lit by the shell's normals, deep shadows.
FigureData Petrovic1(const FigureOptions &options) {
    const MotionQuality quality(options.quick);
    SimulationSettings settings;
    settings.keyHairs = quality.keys, settings.points = quality.points * 2;
    settings.framesPerSecond = 60;
    settings.motion = TurnsOf(Radians(40.));
    settings.coupling.drag = 60;
    const ShakenHead head = Shake(GrownHead(quality, "curly"), settings, 30);
    FigureData data{Table({"stretch", "penetration_cm", "mean_swing_cm", "mean_luminance"})};
    const std::string hair =
        HairText(head.hair,
                 "\"string model\" \"kajiya-kay\" \"rgb Kd\" [0.85 0.55 0.28] \"rgb Ks\" [0.1 "
                 "0.09 0.08] \"float exponent\" 30",
                 [](size_t) { return true; });
    AddPanel(&data, "",
             RenderHead("petrovic-1-a", quality, "60 5 -100  0 -4 0", head.pose, hair,
                        fmt::format("\"hairlight\" \"bool shellnormals\" true \"float shellcell\" {}",
                                    options.quick ? 1.2 : 0.6)));
    const double light = MeanLuminance(data.pictures[0].image, {0.35, 0.65, 0.3, 0.6});
    data.table.Add({head.worst.stretch, head.worst.penetration, head.swing, light});
    data.plot.width = 620, data.plot.height = 660;
    data.note = fmt::format(
        "Curls half a second into a shake, {} key hairs of {} points; tips have moved by {:.1f} cm against "
        "the head in the mean. Key hairs are rods where the paper has springs. Single scattering only.",
        quality.keys, settings.points, head.swing);
    data.checks = {{"greatest stretch", head.worst.stretch, 0, 1e-5},
                   {"deepest point in the head, cm", head.worst.penetration, 0, 1e-5},
                   {"the tips' mean swing, cm", head.swing, 0.3, 20},
                   {"mean luminance of hair", light, 0.02, 2}};
    return data;
}

// A head shakes once to each side; hair is light and dark by where around the head it grows.
FigureData Petrovic4(const FigureOptions &options) {
    const MotionQuality quality(options.quick);
    const Groom groom = GrownHead(quality, "straight");
    const auto isLight = [&](size_t s) {
        const Point3f root = groom.points[groom.strandOffsets[s]];
        return std::fmod(Degrees(std::atan2(root.x, -root.z)) + 360, 60) < 30;
    };
    SimulationSettings settings;
    settings.keyHairs = quality.keys, settings.points = quality.points;
    settings.framesPerSecond = 60;
    settings.motion = TurnsOf(Radians(40.));
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
    const Groom groom = GrownHead(quality, "straight");
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

// a: colours, lengths and styles at rest. b: two of them in the same frame of a shake, in gel and loose.
FigureData Petrovic6(const FigureOptions &options) {
    MotionQuality quality(options.quick);
    if (!options.quick)
        quality.side = 400;
    constexpr const char *kLook = "62 4 -84  2 -5 0";
    struct Look {
        const char *name, *title, *style, *pigments;
        float length;
        double bending; // 0: at rest
    };
    constexpr double kGel = 2e8, kLoose = 1e6;
    constexpr std::array looks = std::to_array<Look>({
        {"petrovic-6-a1", "a: black", "straight", "\"float eumelanin\" 4", 36, 0},
        {"petrovic-6-a2", "red, waves", "wavy", "\"float eumelanin\" 0.25 \"float pheomelanin\" 0.9", 30, 0},
        {"petrovic-6-a3", "blond, short curls", "curly",
         "\"float eumelanin\" 0.08 \"float pheomelanin\" 0.12", 16, 0},
        {"petrovic-6-b1", "b: waves in gel", "wavy", "\"float eumelanin\" 0.25 \"float pheomelanin\" 0.9", 30,
         kGel},
        {"petrovic-6-b2", "loose waves", "wavy", "\"float eumelanin\" 0.25 \"float pheomelanin\" 0.9", 30,
         kLoose},
        {"petrovic-6-b3", "loose, straight", "straight", "\"float eumelanin\" 4", 36, kLoose},
    });
    FigureData data{Table({"picture", "bending_cm4_per_s2", "mean_swing_cm", "stretch", "mean_luminance"})};
    data.plot.columns = 3;
    data.plot.width = 400, data.plot.height = 440;
    double gel = 0, loose = 0, stretch = 0;
    std::vector<double> light;
    for (const Look &look : looks) {
        const Groom groom = GrownHead(quality, look.style, look.length);
        ShakenHead head;
        head.hair = groom;
        if (look.bending > 0) {
            SimulationSettings settings;
            settings.keyHairs = quality.keys, settings.points = quality.points * 2;
            settings.framesPerSecond = 60;
            settings.motion = TurnsOf(Radians(40.));
            settings.coupling.drag = 60;
            settings.physics.bending = look.bending, settings.physics.twist = 0.75 * look.bending;
            head = Shake(groom, settings, 30);
            stretch = std::max(stretch, head.worst.stretch);
            if (look.style == std::string_view("wavy"))
                (look.bending == kGel ? gel : loose) = head.swing;
        }
        AddPanel(&data, look.title,
                 RenderHead(look.name, quality, kLook, head.pose,
                            HairText(head.hair, look.pigments, [](size_t) { return true; })));
        light.push_back(MeanLuminance(data.pictures.back().image, {0.42, 0.58, 0.3, 0.45}));
        data.table.Add({look.name, look.bending, head.swing, head.worst.stretch, light.back()});
    }
    data.note = fmt::format("Row b is the same frame, half a second into a shake, of hair of other "
                            "stiffness: tips of waves move by "
                            "{:.1f} cm against the head in gel and by {:.1f} cm loose, in the mean.",
                            gel, loose);
    data.checks = {{"the tips' swing in gel, of that of loose hair", gel / loose, 0, 0.5},
                   {"luminance of black hair, of blond", light[0] / light[2], 0, 0.5},
                   {"greatest stretch", stretch, 0, 1e-5}};
    return data;
}

} // namespace cuticle
