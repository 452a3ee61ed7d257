// The atlas: every model that a scene may name, over planes of its parameters, as published beside ours.
// Faults 6, 7, 8, 20, 21 and what is a model's own.
#include "figures/atlas/atlas.h"

#include "core/parallel.h"
#include "figures/atlas/atlas_fibers.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace cuticle {

namespace {

// A plane of parameters: how x and y set a fiber and its viewer's theta (degrees).
struct Plane {
    const char *name, *title;
    AtlasAxis x, y;
    void (*set)(double x, double y, AtlasInputs *in, double *theta);
};

// 0 in the first cell of an axis from 10^-5 to 1 of five or ten cells.
double OrZero(double beta) { return beta < 4e-5 ? 0 : beta; }
// Cells of one digit each; the last is the end itself.
constexpr double kLastDigit = 8;
double NinesOf(double x) { return x >= kLastDigit ? 1 : 1 - std::pow(10, -x); }

// The first is that of the roughness.
std::vector<Plane> Planes(const AtlasOptions &o) {
    const size_t n = o.quick ? 5 : 12, m = o.quick ? 5 : 11, ends = o.quick ? 5 : 10;
    const AtlasAxis theta = {"θ_o (degrees)", "theta_o_deg", -90, 90, m};
    return {
        {"beta-theta",
         "roughness, along and around alike",
         {"β_m = β_n", "beta", -1.25, 0, n, true},
         theta,
         [](double x, double y, AtlasInputs *in, double *t) { in->betaM = in->betaN = x, *t = y; }},
        {"h-theta",
         "offset across the fiber",
         {"offset h", "h", -1, 1, n},
         theta,
         [](double x, double y, AtlasInputs *in, double *t) { in->h = x, *t = y; }},
        {"alpha-theta",
         "tilt of the scales",
         {"α (degrees)", "alpha_deg", 0, 10, n},
         theta,
         [](double x, double y, AtlasInputs *in, double *t) { in->alpha = x, *t = y; }},
        {"eta-theta",
         "index of refraction",
         {"η", "eta", 1.2, 2.5, n},
         theta,
         [](double x, double y, AtlasInputs *in, double *t) { in->eta = x, *t = y; }},
        {"sigma-theta",
         "absorption",
         {"σ_a", "sigma_a", -2, 2, n, true},
         theta,
         [](double x, double y, AtlasInputs *in, double *t) { in->sigmaA = x, *t = y; }},
        {"reflectance-beta",
         "reflectance",
         {"reflectance; first cell: 0", "reflectance", 0, 1.2, o.quick ? size_t(6) : size_t(12)},
         {"β_n", "beta_n", -1.25, 0, m, true},
         [](double x, double y, AtlasInputs *in, double *t) {
             in->reflectance = x < 0.12 ? 0 : x, in->betaN = y, *t = 30;
         }},
        {"edge-sigma",
         "the edge of the fiber",
         {"digits of 9 in h; 8 to 9: h = 1", "nines_of_h", 0, 9, 9},
         {"σ_a; below 10^{-6}: 0", "sigma_a", -7, 0, 7, true},
         [](double x, double y, AtlasInputs *in, double *t) {
             in->h = NinesOf(x), in->sigmaA = y < 1e-6 ? 0 : y, *t = 30;
         }},
        {"grazing-h",
         "along the fiber",
         {"90° - θ_o = 10^{-x} rad; 8 to 9: 0", "digits", 0, 9, 9},
         {"offset h", "h", -1, 1, m},
         [](double x, double y, AtlasInputs *in, double *t) {
             in->h = y, *t = 90 - (x >= kLastDigit ? 0 : std::pow(10, -x) / kDegree);
         }},
        {"eta-one",
         "a fiber that does not refract, η = 1",
         {"σ_a", "sigma_a", -2, 4, 12, true},
         {"offset h", "h", -1, 1, m},
         [](double x, double y, AtlasInputs *in, double *t) {
             in->eta = 1, in->sigmaA = x, in->h = y, *t = 30;
         }},
        {"smooth",
         "smooth fibers",
         {"β_m; first cell: 0", "beta_m", -5, 0, ends, true},
         {"β_n; first cell: 0", "beta_n", -5, 0, ends, true},
         [](double x, double y, AtlasInputs *in, double *t) {
             in->betaM = OrZero(x), in->betaN = OrZero(y), *t = 30;
         }},
    };
}

struct Measure {
    const char *name, *title, *quantity;
    double FiberFaults::*value;
    bool log;
    double min, max;
    const char *note = "";
};
constexpr const char *kAgainstSmooth =
    "Against the light that leaves a smooth fiber of the same index and "
    "absorption, the only one whose energy is "
    "known exactly; the table is of a rough one with tilted scales, which keep light inside for longer.";
constexpr const char *kSampledOurWay =
    "The papers of 1989, 2003 and 2011 give no way to sample: these models are sampled in ours.";
constexpr std::array kMeasures = std::to_array<Measure>({
    {"bad", "NaN, infinite and negative values", "share of values", &FiberFaults::bad, false, 0, 1},
    {"energy", "Energy", "energy error", &FiberFaults::energy, true, 1e-7, 1, kAgainstSmooth},
    {"disagreement", "Samples against density", "difference of moments", &FiberFaults::disagreement, true,
     1e-4, 1, kSampledOurWay},
    {"weight", "Worst weight of a sample", "f |cos| / pdf", &FiberFaults::weight, true, 1e-2, 1e2,
     kSampledOurWay},
    {"reciprocity", "Non-reciprocity", "mean |S - S'| / (S + S')", &FiberFaults::asymmetry, true, 1e-4, 1},
});

// At the edges lobes are narrower than the quadrature: only NaN and weights are measured there.
bool IsMeasured(const Plane &plane, const Measure &measure) {
    const bool edges = plane.name == std::string("smooth") || plane.name == std::string("eta-one") ||
                       plane.name == std::string("grazing-h") || plane.name == std::string("edge-sigma");
    return !edges || measure.name == std::string("bad") || measure.name == std::string("weight");
}

// The fault that a map of this plane and measure is about.
int FaultOf(const std::string &plane, const std::string &measure) {
    if (plane == "alpha-theta" && (measure == "energy" || measure == "disagreement"))
        return 6;
    if (measure != "bad")
        return 0;
    return plane == "edge-sigma"                     ? 7
           : plane == "grazing-h"                    ? 8
           : plane == "smooth" || plane == "eta-one" ? 20
                                                     : 0;
}

// A cell of a plane.
struct Cell {
    AtlasInputs in;
    double theta = 0;
    // First by what tables are made of, so that cells in order share them.
    auto Key() const {
        return std::tie(in.eta, in.sigmaA, in.reflectance, in.betaN, in.betaM, in.alpha, in.h, theta);
    }
    bool operator<(const Cell &other) const { return Key() < other.Key(); }
    bool operator==(const Cell &other) const { return Key() == other.Key(); }
};
std::vector<Cell> CellsOf(const Plane &plane) {
    std::vector<Cell> cells(plane.x.cells * plane.y.cells);
    for (size_t i = 0; i < cells.size(); ++i)
        plane.set(plane.x.At(i % plane.x.cells), plane.y.At(i / plane.x.cells), &cells[i].in,
                  &cells[i].theta);
    return cells;
}

// All measures of a cell come from one visit to it, for all forms of the model.
using FaultsOfForms = std::array<FiberFaults, kAtlasForms.size()>;
std::vector<FaultsOfForms> MeasureCells(const FiberModel &model, std::vector<Cell> cells, bool quick) {
    if (model.farField) // one visit for all h
        for (Cell &cell : cells)
            cell.in.h = 0;
    std::vector<Cell> different = cells;
    std::sort(different.begin(), different.end());
    different.erase(std::unique(different.begin(), different.end()), different.end());
    std::vector<FaultsOfForms> measured(different.size());
    ParallelFor(different.size(), [&](size_t i) {
        for (size_t form = 0; form < kAtlasForms.size(); ++form)
            if (HasForm(model, kAtlasForms[form]))
                measured[i][form] = MeasureFiber(model, kAtlasForms[form], different[i].in,
                                                 different[i].theta * kDegree, quick);
    });
    std::vector<FaultsOfForms> faults;
    faults.reserve(cells.size());
    for (const Cell &cell : cells)
        faults.push_back(measured[static_cast<size_t>(
            std::lower_bound(different.begin(), different.end(), cell) - different.begin())]);
    return faults;
}

// The finding of a map of this measure on one model.
AtlasFinding FindingOf(const FiberModel &model, int fault, const char *quantity,
                       std::span<const AtlasPanel> forms) {
    AtlasFinding f{&model == &FiberModels().front() ? fault : 0,
                   fmt::format("{}, worst {}", model.title, quantity), NAN, WorstOf(forms[1].values)};
    if (HasForm(model, AtlasForm::Published))
        f.published = WorstOf(forms[0].values);
    f.inDouble = WorstOf(forms[2].values);
    return f;
}

std::vector<AtlasMap> MapsOfPlane(const Plane &plane, bool quick) {
    constexpr std::array kTitles = {": as published, float", ": ours, float", ": ours, double"};
    const std::deque<FiberModel> &models = FiberModels();
    std::vector<std::vector<FaultsOfForms>> faults;
    faults.reserve(models.size());
    for (const FiberModel &model : models)
        faults.push_back(MeasureCells(model, CellsOf(plane), quick));
    std::vector<AtlasMap> maps;
    for (const Measure &measure : kMeasures) {
        if (!IsMeasured(plane, measure))
            continue;
        AtlasMap map;
        map.name = std::string("model-") + plane.name + "-" + measure.name;
        map.title = std::string(measure.title) + ": " + plane.title;
        map.quantity = measure.quantity;
        map.note = measure.note;
        map.x = plane.x, map.y = plane.y;
        map.log = measure.log, map.min = measure.min, map.max = measure.max;
        map.columns = static_cast<int>(kAtlasForms.size());
        for (size_t m = 0; m < models.size(); ++m) {
            const size_t first = map.panels.size();
            for (size_t form = 0; form < kAtlasForms.size(); ++form) {
                AtlasPanel panel{std::string(models[m].title) + kTitles[form], {}};
                if (!HasForm(models[m], kAtlasForms[form]))
                    panel = {std::string(models[m].title) + ": as published", {}, models[m].published.absent};
                else
                    for (const FaultsOfForms &f : faults[m])
                        panel.values.push_back(f[form].*measure.value);
                map.panels.push_back(std::move(panel));
            }
            map.findings.push_back(FindingOf(models[m], FaultOf(plane.name, measure.name), measure.quantity,
                                             std::span(map.panels).subspan(first)));
        }
        maps.push_back(std::move(map));
    }
    return maps;
}

// A furnace that samples the BSDF sees nothing of what one that integrates it sees.
AtlasMap FurnaceMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "furnace", map.title = "A white furnace, by sampling and by integrating (θ_o = 60°)";
    map.quantity = "|E - 1|";
    map.x = {"β_m", "beta_m", -1.5, 0, o.quick ? size_t(6) : size_t(20), true};
    map.y = {"α (degrees)", "alpha_deg", 0, 10, o.quick ? size_t(5) : size_t(15)};
    map.min = 1e-7, map.max = 1;
    const double theta = 60 * kDegree;
    const auto at = [](double beta, double alpha) {
        AtlasInputs in;
        in.betaM = beta, in.alpha = alpha;
        return in;
    };
    map.panels = {
        {"published tilt of θ_o, sampled",
         FillMap(map.x, map.y,
                 [&](double b, double a) {
                     return std::abs(EnergyBySamples(*PrintedFiber(at(b, a), false), theta, 2000) - 1);
                 })},
        {"published tilt of θ_o, integrated",
         FillMap(map.x, map.y,
                 [&](double b, double a) {
                     return std::abs(EnergyByQuadrature(*PrintedFiber(at(b, a), false), at(b, a), theta) - 1);
                 })},
        {"ours, sampled", FillMap(map.x, map.y,
                                  [&](double b, double a) {
                                      return std::abs(EnergyBySamples(*OurFiber(at(b, a)), theta, 2000) - 1);
                                  })},
        {"ours, integrated", FillMap(map.x, map.y, [&](double b, double a) {
             return std::abs(EnergyByQuadrature(*OurFiber(at(b, a)), at(b, a), theta) - 1);
         })}};
    map.findings = {
        {21, "largest |E - 1| that a sampled furnace sees", WorstOf(map.panels[0].values),
         WorstOf(map.panels[2].values)},
        {21, "largest |E - 1| that is there", WorstOf(map.panels[1].values), WorstOf(map.panels[3].values)}};
    return map;
}

} // namespace

std::vector<AtlasMap> RoughnessMaps(const AtlasOptions &options) {
    return MapsOfPlane(Planes(options).front(), options.quick);
}

std::vector<AtlasMap> ModelMaps(const AtlasOptions &options) {
    std::vector<AtlasMap> maps = {FurnaceMap(options)};
    const std::vector<Plane> planes = Planes(options);
    for (size_t i = 1; i < planes.size(); ++i)
        for (AtlasMap &map : MapsOfPlane(planes[i], options.quick))
            maps.push_back(std::move(map));
    return maps;
}

} // namespace cuticle
