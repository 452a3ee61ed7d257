// The atlas: every model that a scene may name, over planes of its parameters. Faults 6, 7, 8, 20, 21 and what is a model's own.
#include "figures/atlas.h"
#include "figures/atlas_fibers.h"

#include "fibers/hair_model.h"

#include <array>

namespace cuticle {

namespace {

constexpr double kDegree = kPi<double> / 180;

// A plane of parameters: how x and y set a fiber and its viewer's theta (degrees).
struct Plane {
    const char *name, *title;
    AtlasAxis x, y;
    void (*set)(double x, double y, FiberInputs *in, double *theta);
};

// beta with 0 as the first cell of its axis, which is one of exponents.
double OrZero(double beta, const AtlasAxis &axis) {
    return beta < std::pow(10, axis.low + (axis.high - axis.low) / static_cast<double>(axis.cells)) ? 0
                                                                                                    : beta;
}
// Cells of one digit each; the last is the end itself.
constexpr double kLastDigit = 8;
double NinesOf(double x) { return x >= kLastDigit ? 1 : 1 - std::pow(10, -x); }

std::vector<Plane> Planes(const AtlasOptions &o) {
    const size_t n = o.quick ? 5 : 12, m = o.quick ? 5 : 11;
    const AtlasAxis theta = {"θ_o (degrees)", "theta_o_deg", -90, 90, m};
    return {
        {"beta-theta",
         "β_m = β_n",
         {"β_m = β_n", "beta", -1.25, 0, n, true},
         theta,
         [](double x, double y, FiberInputs *in, double *t) { in->betaM = in->betaN = x, *t = y; }},
        {"h-theta",
         "h",
         {"offset h", "h", -1, 1, n},
         theta,
         [](double x, double y, FiberInputs *in, double *t) { in->h = x, *t = y; }},
        {"alpha-theta",
         "tilt of the scales",
         {"α (degrees)", "alpha_deg", 0, 10, n},
         theta,
         [](double x, double y, FiberInputs *in, double *t) { in->alpha = x, *t = y; }},
        {"eta-theta",
         "index of refraction",
         {"η", "eta", 1.2, 2.5, n},
         theta,
         [](double x, double y, FiberInputs *in, double *t) { in->eta = x, *t = y; }},
        {"sigma-theta",
         "absorption",
         {"σ_a", "sigma_a", -2, 2, n, true},
         theta,
         [](double x, double y, FiberInputs *in, double *t) { in->sigmaA = x, *t = y; }},
        {"reflectance-beta",
         "reflectance",
         {"reflectance; below 0.1: 0", "reflectance", 0, 1.2, 12},
         {"β_n", "beta_n", -1.25, 0, m, true},
         [](double x, double y, FiberInputs *in, double *t) {
             in->reflectance = x < 0.1 ? 0 : x, in->betaN = y, *t = 30;
         }},
        {"edge-sigma",
         "the edge of the fiber",
         {"digits of 9 in h; 8 to 9: h = 1", "nines_of_h", 0, 9, 9},
         {"σ_a; below 10^{-6}: 0", "sigma_a", -7, 0, 7, true},
         [](double x, double y, FiberInputs *in, double *t) {
             in->h = NinesOf(x), in->sigmaA = y < 1e-6 ? 0 : y, *t = 30;
         }},
        {"grazing-h",
         "along the fiber",
         {"90° - θ_o = 10^{-x} rad; 8 to 9: 0", "digits", 0, 9, 9},
         {"offset h", "h", -1, 1, m},
         [](double x, double y, FiberInputs *in, double *t) {
             in->h = y, *t = 90 - (x >= kLastDigit ? 0 : std::pow(10, -x) / kDegree);
         }},
        {"eta-one",
         "a fiber that does not refract, η = 1",
         {"σ_a", "sigma_a", -2, 4, 12, true},
         {"offset h", "h", -1, 1, m},
         [](double x, double y, FiberInputs *in, double *t) {
             in->eta = 1, in->sigmaA = x, in->h = y, *t = 30;
         }},
        {"smooth",
         "smooth fibers",
         {"β_m; first cell: 0", "beta_m", -5, 0, 10, true},
         {"β_n; first cell: 0", "beta_n", -5, 0, 10, true},
         [](double x, double y, FiberInputs *in, double *t) {
             const AtlasAxis axis = {"", "", -5, 0, 10, true};
             in->betaM = OrZero(x, axis), in->betaN = OrZero(y, axis), *t = 30;
         }},
    };
}

struct Measure {
    const char *name, *title, *quantity;
    double FiberFaults::*value;
    bool log;
    double min, max;
};
constexpr std::array kMeasures = std::to_array<Measure>({
    {"bad", "NaN, infinite and negative values", "share of values", &FiberFaults::bad, false, 0, 1},
    {"energy", "Energy", "energy error", &FiberFaults::energy, true, 1e-7, 1},
    {"disagreement", "Samples against density", "difference of moments", &FiberFaults::disagreement, true,
     1e-4, 1},
    {"weight", "Worst weight of a sample", "f |cos| / pdf", &FiberFaults::weight, true, 1e-2, 1e2},
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

std::vector<AtlasMap> MapsOfPlane(const Plane &plane, const std::vector<AtlasModel> &models, bool quick) {
    // All measures of a cell come from one visit to it.
    std::vector<std::vector<FiberFaults>> faults;
    for (const AtlasModel &model : models) {
        faults.emplace_back(plane.x.cells * plane.y.cells);
        std::vector<FiberFaults> &of = faults.back();
        AtlasAxis cell = {"", "", 0, static_cast<double>(of.size()), of.size()};
        FillMap(cell, {"", "", 0, 1, 1}, [&](double i, double) {
            const auto at = static_cast<size_t>(i);
            FiberInputs in;
            double theta = 0;
            plane.set(plane.x.At(at % plane.x.cells), plane.y.At(at / plane.x.cells), &in, &theta);
            of[at] = MeasureFiber(model, in, theta * kDegree, quick);
            return 0.;
        });
    }
    std::vector<AtlasMap> maps;
    for (const Measure &measure : kMeasures) {
        if (!IsMeasured(plane, measure))
            continue;
        AtlasMap map;
        map.name = std::string("model-") + plane.name + "-" + measure.name;
        map.title = std::string(measure.title) + ": " + plane.title;
        map.quantity = measure.quantity;
        map.x = plane.x, map.y = plane.y;
        map.log = measure.log, map.min = measure.min, map.max = measure.max;
        for (size_t m = 0; m < models.size(); ++m) {
            AtlasPanel panel{models[m].name, {}};
            for (const FiberFaults &f : faults[m])
                panel.values.push_back(f.*measure.value);
            map.panels.push_back(std::move(panel));
        }
        const double printed = WorstOf(map.panels[kPrintedModel].values);
        map.findings.push_back({FaultOf(plane.name, measure.name),
                                std::string("chiang, worst ") + measure.quantity, printed,
                                WorstOf(map.panels[kOurModel].values)});
        for (size_t m = kOurModel + 1; m < models.size(); ++m) {
            const double worst = WorstOf(map.panels[m].values);
            map.findings.push_back({0, models[m].name + ", worst " + measure.quantity, worst, worst});
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
    const AtlasModel ours = AtlasModels()[kOurModel];
    const auto at = [](double beta, double alpha) {
        FiberInputs in;
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
                                      return std::abs(EnergyBySamples(*ours.At(at(b, a)), theta, 2000) - 1);
                                  })},
        {"ours, integrated", FillMap(map.x, map.y, [&](double b, double a) {
             return std::abs(EnergyByQuadrature(*ours.At(at(b, a)), at(b, a), theta) - 1);
         })}};
    map.findings = {
        {21, "largest |E - 1| that a sampled furnace sees", WorstOf(map.panels[0].values),
         WorstOf(map.panels[2].values)},
        {21, "largest |E - 1| that is there", WorstOf(map.panels[1].values), WorstOf(map.panels[3].values)}};
    return map;
}

} // namespace

std::vector<AtlasMap> ModelMaps(const AtlasOptions &options) {
    const std::vector<AtlasModel> models = AtlasModels();
    std::vector<AtlasMap> maps = {FurnaceMap(options)};
    for (const Plane &plane : Planes(options))
        for (AtlasMap &map : MapsOfPlane(plane, models, options.quick))
            maps.push_back(std::move(map));
    return maps;
}

} // namespace cuticle
