// The paths that leave a smooth fiber in one direction: Marschner's cubic, the cubic polished, and all roots exactly.
#include "fibers/smooth_fiber.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr double kDegree = kPi<double> / 180;

struct Method {
    const char *name;
    RootMethod method;
    bool narrow; // computes in binary32
    int family;
};
const Method kMethods[] = {
    {"cubic, float", RootMethod::Cubic, true, 1},
    {"cubic, double", RootMethod::Cubic, false, 1},
    {"cubic polished, float", RootMethod::PolishedCubic, true, 4},
    {"cubic polished, double", RootMethod::PolishedCubic, false, 4},
    {"exact, float", RootMethod::Exact, true, 0},
    {"exact, double", RootMethod::Exact, false, 0},
};
constexpr size_t kMethodCount = std::size(kMethods);

// Azimuths all around, none at a place where a path begins or ends.
std::vector<double> Azimuths(size_t n) {
    std::vector<double> phi;
    for (size_t i = 0; i < n; ++i)
        phi.push_back(kPi<double> * (2 * (static_cast<double>(i) + 0.3819) / static_cast<double>(n) - 1));
    return phi;
}

// How far from phi the light of the found paths really leaves, and whether all paths were found and no others.
struct Miss {
    double greatest = 0;
    bool wrongNumber = false;
};
template <typename T>
Miss MissOf(RootMethod method, int p, double etaPrime, double phi) {
    const SmoothFiber<long double> exact(1, etaPrime);
    const PathRoots<T> roots =
        SmoothFiber<T>(1, static_cast<T>(etaPrime)).Roots(p, static_cast<T>(phi), method);
    Miss miss;
    miss.wrongNumber = roots.count != exact.Roots(p, phi).count;
    for (size_t i = 0; i < roots.count; ++i) {
        const long double leaves = exact.Phi(p, static_cast<long double>(roots.gamma[i]));
        miss.greatest = std::max(miss.greatest, static_cast<double>(std::abs(WrapAngle(leaves - phi))));
    }
    return miss;
}

template <typename T>
void SolveAll(RootMethod method, int p, const std::vector<double> &etas,
              const std::vector<double> &azimuths) {
    for (const double eta : etas) {
        const SmoothFiber<T> fiber(1, static_cast<T>(eta));
        for (const double phi : azimuths)
            Keep(fiber.Roots(p, static_cast<T>(phi), method));
    }
}

// The greatest error of the cubic's gamma_t, in degrees.
double CubicError(double etaPrime) {
    const double c = std::asin(1 / etaPrime), pi = kPi<double>;
    double greatest = 0;
    for (const double g : Linspace(0, pi / 2, 2001)) {
        const double cubic = 3 * c / pi * g - 4 * c / (pi * pi * pi) * g * g * g;
        greatest = std::max(greatest, std::abs(cubic - std::asin(std::sin(g) / etaPrime)));
    }
    return greatest / kDegree;
}

} // namespace

FigureData RootsChart(const FigureOptions &options) {
    // Hair under water, wet, dry, and dry hair seen along: eta' grows with theta.
    const std::vector<double> etas = {1.165, 1.3, 1.5, 1.55, 1.8, 2.2};
    const std::vector<double> azimuths = Azimuths(options.quick ? 90 : 720);
    const char *const pathNames[] = {"", "TT", "TRT", "TRRT"};

    FigureData data{
        Table({"path", "method", "greatest_miss_deg", "wrong_number_share", "ns_per_azimuth"}), {}, "", {}};
    data.plot.width = 900, data.plot.height = 350;
    std::array<double, kMethodCount> wrong = {}, miss = {};
    for (const int p : {1, 2, 3}) {
        std::vector<std::function<void()>> jobs;
        for (const Method &m : kMethods)
            jobs.push_back([&, p] {
                m.narrow ? SolveAll<float>(m.method, p, etas, azimuths)
                         : SolveAll<double>(m.method, p, etas, azimuths);
            });
        const std::vector<double> seconds = TimeInTurns(jobs, options.quick ? 3 : 30);
        const auto solved = static_cast<double>(etas.size() * azimuths.size());
        std::vector<CostPoint> points;
        for (size_t k = 0; k < kMethodCount; ++k) {
            const Method &m = kMethods[k];
            double greatest = 0, wrongNumber = 0;
            for (const double eta : etas)
                for (const double phi : azimuths) {
                    const Miss one = m.narrow ? MissOf<float>(m.method, p, eta, phi)
                                              : MissOf<double>(m.method, p, eta, phi);
                    greatest = std::max(greatest, one.greatest / kDegree);
                    wrongNumber += one.wrongNumber;
                }
            const double ns = 1e9 * seconds[k] / solved;
            data.table.Add({pathNames[p], m.name, greatest, wrongNumber / solved, ns});
            points.push_back({m.name + Printed(" (%.2g%% miscounted)", 100 * wrongNumber / solved), ns,
                              greatest, m.family});
            wrong[k] = std::max(wrong[k], wrongNumber / solved), miss[k] = std::max(miss[k], greatest);
        }
        data.plot.panels.push_back(CostPanel(pathNames[p], "time of an azimuth (ns)",
                                             "greatest miss (degrees)", points, 1e-16, 100));
    }

    PlotPanel claim;
    claim.title = "the cubic's γ_t";
    claim.right = 0.55;
    claim.x = {.label = "η'", .min = 1, .max = 3, .step = 0.5};
    claim.y = {.label = "greatest error (degrees)", .min = 0, .max = 6, .step = 1};
    PlotSeries curve;
    curve.label = "against Snell's law";
    curve.color = 1;
    for (const double eta : Linspace(1.02, 3, 199))
        curve.x.push_back(eta), curve.y.push_back(CubicError(eta));
    claim.series = {curve};
    claim.lines = {{.vertical = false, .at = 0.75, .label = "Marschner's bound, for 1.5"}};
    data.plot.panels.push_back(claim);

    data.checks = {
        {"the cubic's γ_t at η' = 1.5 is off by (degrees; claimed: less than 0.75)", CubicError(1.5), 0.6,
         0.75},
        {"the cubic's γ_t at η' = 1.165, hair under water, is off by more than (degrees)", CubicError(1.165),
         0.75, 90},
        {"exact roots in binary64 miss by at most (degrees)", miss[5], 0, 1e-10},
        {"exact roots in binary64 are of the wrong number in a share of", wrong[5], 0, 0},
        {"exact roots in binary32 miss by at most (degrees)", miss[4], 0, 0.01},
    };
    data.note = Printed("The cubic's γ_t is off by %.2f° at η' = 1.5, ", CubicError(1.5)) +
                Printed("%.2f° at 1.3 and ", CubicError(1.3)) +
                Printed("%.2f° under water (1.165), where the paper says nothing.", CubicError(1.165));
    return data;
}

} // namespace cuticle
