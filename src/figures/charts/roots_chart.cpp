// The paths that leave a smooth fiber in one direction, by Marschner's cubic, by the cubic polished, and by
// all roots exactly.
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

// To add a method: give RootMethod (fibers/smooth_fiber.h) a value, and this table a row.
struct RootSolver {
    const char *name;
    RootMethod method;
    bool narrow; // computes in binary32
    int family;
};
constexpr RootSolver kMethods[] = {
    {"cubic, float", RootMethod::Cubic, true, 1},
    {"cubic, double", RootMethod::Cubic, false, 1},
    {"cubic polished, float", RootMethod::PolishedCubic, true, 4},
    {"cubic polished, double", RootMethod::PolishedCubic, false, 4},
    {"exact, float", RootMethod::Exact, true, 0},
    {"exact, double", RootMethod::Exact, false, 0},
};
constexpr size_t kMethodCount = std::size(kMethods);

// n azimuths all around, none at a place where a path begins or ends.
std::vector<double> Azimuths(size_t n) {
    std::vector<double> phi;
    for (size_t i = 0; i < n; ++i)
        phi.push_back(kPi<double> * (2 * (static_cast<double>(i) + 0.3819) / static_cast<double>(n) - 1));
    return phi;
}

// The error of a solver at one azimuth phi: how far from it the light of the found paths really leaves
// (radians), and whether all paths were found and no others.
struct RootMiss {
    double largest = 0;
    bool wrongNumber = false;
};
template <typename T>
RootMiss MissOf(RootMethod method, int p, double etaPrime, double phi) {
    const SmoothFiber<long double> exact(1, etaPrime);
    const PathRoots<T> roots =
        SmoothFiber<T>(1, static_cast<T>(etaPrime)).Roots(p, static_cast<T>(phi), method);
    RootMiss miss;
    miss.wrongNumber = roots.count != exact.Roots(p, phi).count;
    for (size_t i = 0; i < roots.count; ++i) {
        const long double leaves = exact.Phi(p, static_cast<long double>(roots.gamma[i]));
        miss.largest = std::max(miss.largest, static_cast<double>(std::abs(WrapAngle(leaves - phi))));
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

// The largest error of the cubic's gamma_t, in degrees.
double CubicError(double etaPrime) {
    const double c = std::asin(1 / etaPrime), pi = kPi<double>;
    double largest = 0;
    for (const double g : Linspace(0, pi / 2, 2001)) {
        const double cubic = 3 * c / pi * g - 4 * c / (pi * pi * pi) * g * g * g;
        largest = std::max(largest, std::abs(cubic - std::asin(std::sin(g) / etaPrime)));
    }
    return largest / kDegree;
}

} // namespace

FigureData RootsChart(const FigureOptions &options) {
    // Hair under water, wet, dry, and dry hair seen along: eta' grows with theta.
    const std::vector<double> etas = {1.165, 1.3, 1.5, 1.55, 1.8, 2.2};
    const std::vector<double> azimuths = Azimuths(options.quick ? 90 : 720);
    const char *const pathNames[] = {"", "TT", "TRT", "TRRT"};

    FigureData data{Table({"path", "method", "greatest_miss_deg", "wrong_number_share", "ns_per_azimuth"})};
    data.plot.width = 900, data.plot.height = 350;
    std::array<double, kMethodCount> wrong = {}, miss = {};
    for (const int p : {1, 2, 3}) {
        std::vector<std::function<void()>> jobs;
        for (const RootSolver &m : kMethods)
            jobs.push_back([&, p] {
                m.narrow ? SolveAll<float>(m.method, p, etas, azimuths)
                         : SolveAll<double>(m.method, p, etas, azimuths);
            });
        const std::vector<double> seconds = TimeInTurns(jobs, options.quick ? 3 : 30);
        const auto solved = static_cast<double>(etas.size() * azimuths.size());
        std::vector<CostPoint> points;
        for (size_t k = 0; k < kMethodCount; ++k) {
            const RootSolver &m = kMethods[k];
            double largest = 0, wrongNumber = 0;
            for (const double eta : etas)
                for (const double phi : azimuths) {
                    const RootMiss one = m.narrow ? MissOf<float>(m.method, p, eta, phi)
                                                  : MissOf<double>(m.method, p, eta, phi);
                    largest = std::max(largest, one.largest / kDegree);
                    wrongNumber += one.wrongNumber;
                }
            const double ns = 1e9 * seconds[k] / solved;
            data.table.Add({pathNames[p], m.name, largest, wrongNumber / solved, ns});
            points.push_back({m.name + fmt::format(" ({:.2g}% miscounted)", 100 * wrongNumber / solved), ns,
                              largest, m.family});
            wrong[k] = std::max(wrong[k], wrongNumber / solved), miss[k] = std::max(miss[k], largest);
        }
        data.plot.panels.push_back(CostPanel(pathNames[p], "CPU time of an azimuth (ns)",
                                             "largest miss (degrees)", points, 1e-16, 100));
    }

    PlotPanel claim;
    claim.title = "the cubic's γ_t";
    claim.right = 0.55;
    claim.x = {.label = "η'", .min = 1, .max = 3, .step = 0.5};
    claim.y = {.label = "largest error (degrees)", .min = 0, .max = 6, .step = 1};
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
    data.note = fmt::format("The cubic's γ_t is off by {:.2f}° at η' = 1.5, {:.2f}° at 1.3 and {:.2f}° under "
                            "water (1.165), where the paper says nothing.",
                            CubicError(1.5), CubicError(1.3), CubicError(1.165));
    return data;
}

} // namespace cuticle
