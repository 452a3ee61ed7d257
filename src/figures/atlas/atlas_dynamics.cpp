// The atlas's maps of hair that moves: steps by stiffness for springs and rods, hairs thin and long, loads
// without measure, and the pull toward a density. Faults 23 to 25.
#include "core/parallel.h"
#include "dynamics/directing.h"
#include "dynamics/simulation.h"
#include "dynamics/strand.h"
#include "figures/atlas/atlas.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr double kG = 981; // cm/s^2
const double kInfinity = std::numeric_limits<double>::infinity();

// How a strand is stepped: a panel each.
struct StrandForm {
    const char *title;
    StrandMethod method;
    bool asPrinted;
};
constexpr StrandForm kForms[] = {{"springs as published, explicit", StrandMethod::Springs, true},
                                 {"springs held back, explicit", StrandMethod::Springs, false},
                                 {"rods, implicit", StrandMethod::Rods, false}};

// A straight hair that is held at one end, stands out to the side, and is let go under a load.
struct StrandCase {
    double length = 20;    // cm
    double bending = 5e6;  // cm^4/s^2
    double stretch = 3e10; // cm^2/s^2
    double load = kG;      // cm/s^2
    double dt = 1. / 60;
    size_t steps = 60, smallSteps = 1; // of springs in a step
};
struct StrandFate {
    double stretch = 0; // the largest of a length; infinite where a step gave no number
    // Of motion, over the most that the load can give by moving every point by its distance from the root:
    // above 1, energy has come from nothing.
    double energy = 0;
    size_t stopped = 0; // steps that gave no number
    bool isFinite = true;
};
StrandFate LetGo(const StrandCase &c, const StrandForm &form) {
    constexpr size_t kPoints = 16;
    StrandPhysics physics;
    physics.method = form.method, physics.springsAsPrinted = form.asPrinted,
    physics.springSteps = c.smallSteps;
    physics.bending = c.bending, physics.twist = 0.75 * c.bending, physics.stretch = c.stretch;
    std::vector<Vector3d> rest;
    for (size_t i = 0; i < kPoints; ++i)
        rest.push_back({c.length * static_cast<double>(i) / (kPoints - 1), 0, 0});
    KeyStrands set(rest, kPoints, physics);
    for (size_t i = 0; i < kPoints; ++i)
        set.SetForce(0, i, {0, -c.load, 0}, 0, {});
    const std::unique_ptr<Obstacle> nothing = MakeUnion({});
    StrandFate fate;
    for (size_t k = 0; k < c.steps; ++k) {
        const StepReport report = set.Step(c.dt, {}, *nothing);
        fate.stopped += report.recovered;
        fate.stretch = std::max(fate.stretch, report.stretch);
        fate.energy = std::max(fate.energy, set.KineticEnergy() / (c.load * Sqr(c.length) / 2));
        for (size_t i = 0; i < kPoints; ++i)
            fate.isFinite &= std::isfinite(set.Position(0, i).Length());
        if (fate.stopped > 0)
            break;
    }
    if (fate.stopped > 0 || !fate.isFinite)
        fate.stretch = fate.energy = kInfinity;
    return fate;
}

// The share of cells whose value is above a bound, or no number.
double ShareAbove(const std::vector<double> &values, double bound) {
    const auto above = std::count_if(values.begin(), values.end(), [=](double v) { return !(v <= bound); });
    return static_cast<double>(above) / static_cast<double>(values.size());
}

AtlasAxis StepAxis(const AtlasOptions &o) {
    return {"time step (s)", "dt_s", -7, -1, o.quick ? size_t(12) : size_t(30), true};
}

std::vector<AtlasMap> StepMaps(const AtlasOptions &o) {
    AtlasMap energy, stretch;
    energy.name = "strand-energy",
    energy.title = "A hair that is let go: the energy of its motion, step by stiffness";
    energy.quantity = "energy over the most that gravity gives";
    stretch.name = "strand-stretch", stretch.title = "A hair that is let go: how far it stretches";
    stretch.quantity = "largest stretch";
    energy.x = stretch.x = StepAxis(o);
    energy.y = stretch.y = {"stiffness over that of hair",    "stiffness", -4, 2,
                            o.quick ? size_t(6) : size_t(24), true};
    energy.min = 1e-3, energy.max = 1e3, stretch.min = 1e-8, stretch.max = 1;
    energy.columns = stretch.columns = 3;
    for (const StrandForm &form : kForms) {
        std::vector<StrandFate> fates(energy.x.cells * energy.y.cells);
        ParallelFor(fates.size(), [&](size_t i) {
            StrandCase c;
            c.dt = energy.x.At(i % energy.x.cells);
            const double stiffness = energy.y.At(i / energy.x.cells);
            c.bending *= stiffness, c.stretch *= stiffness;
            c.steps = std::clamp<size_t>(static_cast<size_t>(0.5 / c.dt), 40, o.quick ? 150 : 400);
            fates[i] = LetGo(c, form);
        });
        AtlasPanel energies{form.title, {}}, stretches{form.title, {}};
        for (const StrandFate &fate : fates)
            energies.values.push_back(fate.energy), stretches.values.push_back(fate.stretch);
        energy.panels.push_back(std::move(energies)), stretch.panels.push_back(std::move(stretches));
    }
    energy.findings = {{23, "share of the map where energy comes from nothing",
                        ShareAbove(energy.panels[0].values, 1), ShareAbove(energy.panels[2].values, 1)}};
    stretch.findings = {{23, "share of the map where a hair stretches by more than a thousandth",
                         ShareAbove(stretch.panels[0].values, 1e-3),
                         ShareAbove(stretch.panels[2].values, 1e-3)}};
    return {energy, stretch};
}

AtlasMap ShapesMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "strand-shapes",
    map.title = "Hairs short and long, thin and thick, in steps of 1/60 s (springs: in 200 small steps each)";
    map.quantity = "largest stretch";
    map.x = {"length (cm)", "length_cm", -1, 3, o.quick ? size_t(8) : size_t(24), true};
    map.y = {"bending stiffness (cm^4/s^2)", "bending", 0, 12, o.quick ? size_t(6) : size_t(24), true};
    map.min = 1e-8, map.max = 1, map.columns = 3;
    map.note = "A hair of 80 μm has 1.2e5, and the square of its thickness counts.";
    for (const StrandForm &form : kForms)
        map.panels.push_back({form.title, FillMap(map.x, map.y, [&](double length, double bending) {
                                  StrandCase c;
                                  c.length = length, c.bending = bending;
                                  c.steps = o.quick ? 8 : 40, c.smallSteps = 200;
                                  return LetGo(c, form).stretch;
                              })});
    map.findings = {{23, "largest stretch of hairs of all sizes", WorstOf(map.panels[0].values),
                     WorstOf(map.panels[2].values)}};
    return map;
}

AtlasMap LoadsMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "strand-loads",
    map.title =
        "A load without measure: a hair goes on (0), is stopped with a warning (1/2), or has no number (1)";
    map.quantity = "0 on, 1/2 stopped, 1 none";
    map.x = {"acceleration (cm/s^2)", "load", 0, 60, o.quick ? size_t(10) : size_t(30), true};
    map.y = {"time step (s)", "dt_s", -7, 5, o.quick ? size_t(6) : size_t(24), true};
    map.log = false, map.min = 0, map.max = 1, map.columns = 3;
    map.note = "What is published has no guard: where a step gives no number, the strand has none from there "
               "on.";
    const auto answer = [](double load, double dt, const StrandForm &form) {
        StrandCase c;
        c.load = load, c.dt = dt, c.steps = 6;
        const StrandFate fate = LetGo(c, form);
        return !fate.isFinite || (fate.stopped > 0 && form.asPrinted) ? 1. : fate.stopped > 0 ? 0.5 : 0.;
    };
    for (const StrandForm &form : kForms)
        map.panels.push_back({form.title, FillMap(map.x, map.y, [&](double load, double dt) {
                                  return answer(load, dt, form);
                              })});
    const double nan = std::numeric_limits<double>::quiet_NaN();
    map.findings = {
        {25, "share of loads and steps that leave no number", ShareAbove(map.panels[0].values, 0.75),
         ShareAbove(map.panels[2].values, 0.75)},
        {25, "a load of NaN leaves: 0 a strand, 1 no number", nan, answer(nan, 1. / 60, kForms[2])}};
    return map;
}

// --- directing ------------------------------------------------------------------

// Points in a cube, evenly spread, a cm from where they are wanted.
std::vector<Vector3d> SpreadPoints(size_t count, double x) {
    std::vector<Vector3d> points;
    for (size_t k = 1; k <= count; ++k) {
        const auto turn = [k](double irrational) {
            return 2 * std::fmod(irrational * static_cast<double>(k), 1.) - 1;
        };
        points.push_back({turn(0.8191725134) * 2 + x, turn(0.6710436067) * 2, turn(0.5497004779) * 2});
    }
    return points;
}

AtlasMap FactorMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "directed-points", map.title = "Equation 3 moves points to a density: factor by grid";
    map.quantity = "greatest energy over the first";
    map.x = {"cell (cm)", "cell_cm", -0.6, 0.9, o.quick ? size_t(5) : size_t(15), true};
    map.y = {"factor (cm^2 a step)", "factor", -5, 5, o.quick ? size_t(10) : size_t(25), true};
    map.min = 0.1, map.max = 100;
    const std::vector<Vector3d> start = SpreadPoints(300, 0), wanted = SpreadPoints(300, 1);
    const auto greatest = [&](double cell, double factor, DensityKernel kernel, bool published) {
        const DensityTarget target(wanted, cell, kernel);
        std::vector<Vector3d> points = start;
        const double first = target.Energy(points);
        double most = 0;
        for (int step = 0; step < (o.quick ? 6 : 15); ++step) {
            const auto pulls = target.Pulls(points);
            for (size_t i = 0; i < points.size(); ++i)
                points[i] +=
                    pulls[i].force * (published ? factor : factor / (1 + factor * pulls[i].stiffness));
            most = std::max(most, target.Energy(points) / first);
        }
        return most;
    };
    for (const bool published : {true, false})
        for (const DensityKernel kernel : {DensityKernel::Tent, DensityKernel::Smooth})
            map.panels.push_back({std::string(published ? "published" : "ours") +
                                      (kernel == DensityKernel::Tent ? ", tent" : ", smooth kernel"),
                                  FillMap(map.x, map.y, [&](double cell, double factor) {
                                      return greatest(cell, factor, kernel, published);
                                  })});
    map.note = "Published: plain steps. Ours: held back by the pull's stiffness.";
    map.findings = {{24, "greatest energy over the first, the paper's tent", WorstOf(map.panels[0].values),
                     WorstOf(map.panels[2].values)},
                    {24, "greatest energy over the first, smooth kernel", WorstOf(map.panels[1].values),
                     WorstOf(map.panels[3].values)}};
    return map;
}

AtlasMap DirectedHairMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "directed-hair", map.title = "Key hairs drawn to a density by our step: factor by grid";
    map.quantity = "largest stretch";
    map.x = {"cell (cm)", "cell_cm", -0.2, 0.9, o.quick ? size_t(3) : size_t(8), true};
    map.y = {"factor (cm^2/s^2)", "factor", 2, 12, o.quick ? size_t(5) : size_t(15), true};
    map.min = 1e-8, map.max = 1;
    constexpr size_t kHairs = 24, kPoints = 12;
    map.panels = {{"ours", FillMap(map.x, map.y, [&](double cell, double factor) {
                       SimulationSettings settings;
                       settings.keyHairs = kHairs, settings.points = kPoints, settings.framesPerSecond = 60;
                       settings.gravity = {}, settings.direction.factor = factor;
                       settings.direction.cells = {cell};
                       Groom groom;
                       groom.width = 0.01f;
                       for (size_t s = 0; s < kHairs; ++s) {
                           const auto u = static_cast<double>(s);
                           for (size_t i = 0; i < kPoints; ++i) {
                               const Vector3d p{0.5 * u, -static_cast<double>(i), 0};
                               groom.points.push_back(Point3f(p));
                               settings.direction.points.push_back(p + Vector3d{0, 0, 0.3 * -p.y});
                           }
                           groom.strandOffsets.push_back(static_cast<uint32_t>(groom.points.size()));
                       }
                       HairSimulation simulation(std::move(groom), MakeUnion({}), settings);
                       StepReport report;
                       for (int frame = 0; frame < (o.quick ? 10 : 30); ++frame)
                           report.Join(simulation.NextFrame());
                       return report.recovered > 0 ? kInfinity : report.stretch;
                   })}};
    map.findings = {{24, "largest stretch of directed hair", std::numeric_limits<double>::quiet_NaN(),
                     WorstOf(map.panels[0].values)}};
    return map;
}

} // namespace

std::vector<AtlasMap> DynamicsMaps(const AtlasOptions &options) {
    std::vector<AtlasMap> maps = StepMaps(options);
    maps.push_back(ShapesMap(options));
    maps.push_back(LoadsMap(options));
    maps.push_back(FactorMap(options));
    maps.push_back(DirectedHairMap(options));
    return maps;
}

} // namespace cuticle
