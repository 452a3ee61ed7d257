// The chart of N_p of d'Eon et al. 2011 through the Gaussian detector, by rule, order and roughness.
#include "fibers/deon.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

using Quadrature = DEonQuadrature<double>;

// A rule to integrate N_p by; order 0: nodes as many as the roughness asks for, split where Phi turns. To add
// one: give kRules a row, and ByRule a branch if neither of its two fits.
struct NpRule {
    const char *name;
    size_t order;
    bool half;
    int family;
    PlotDash dash;
};
const NpRule kRules[] = {
    {"9 over the width", 9, false, 1, PlotDash::Dotted},
    {"18 over the width", 18, false, 1, PlotDash::DashDot},
    {"35 over the width (the paper)", 35, false, 1, PlotDash::Solid},
    {"64 over the width", 64, false, 1, PlotDash::Dashed},
    {"9 over half", 9, true, 4, PlotDash::Dotted},
    {"18 over half", 18, true, 4, PlotDash::DashDot},
    {"35 over half", 35, true, 4, PlotDash::Solid},
    {"64 over half", 64, true, 4, PlotDash::Dashed},
    {"ours, by roughness, split", 0, true, 0, PlotDash::Solid},
};
constexpr size_t kRuleCount = std::size(kRules);

double ByRule(const NpRule &rule, const Quadrature &q, int p, const SmoothFiber<double> &fiber, double phi) {
    return rule.order == 0 ? q.Value(static_cast<size_t>(p), fiber, phi).n[0]
                           : q.ByFixedOrder(p, fiber, phi, rule.order, rule.half)[0];
}

// The light that each of very many rays carries, once for all roughnesses.
struct PathLight {
    double turn, light;
};
std::vector<PathLight> ManyRays(int p, const SmoothFiber<double> &fiber, const std::array<double, 3> &sigmaA,
                                size_t nodes) {
    std::vector<PathLight> rays;
    const double turn = fiber.TurningPoint(p), ends[] = {0, turn, kPi<double> / 2};
    for (size_t k = 0; k < 2; ++k)
        if (ends[k + 1] > ends[k])
            NodesOnPanel(ends[k], ends[k + 1], nodes, [&](double gamma, double weight) {
                rays.push_back({fiber.Phi(p, gamma),
                                weight * fiber.Attenuation(p, gamma, sigmaA, SegmentLength::Chord)[0]});
            });
    return rays;
}
double Exact(const std::vector<PathLight> &rays, double beta, double phi) {
    double sum = 0;
    for (const PathLight &ray : rays)
        sum +=
            ray.light * (GaussianDetector(beta, phi - ray.turn) + GaussianDetector(beta, phi + ray.turn)) / 2;
    return sum;
}

DEonParameters Fiber(double betaDegrees) {
    DEonParameters p;
    p.sigmaA = {0.2f, 0.2f, 0.2f};
    p.betaN.fill(static_cast<float>(betaDegrees));
    return p;
}

// The grid of the chart. theta_d and beta are in degrees.
struct QuadratureGrid {
    std::vector<double> betas, thetas, azimuths;
    int rounds;
};
QuadratureGrid QuadratureGridOf(bool quick) {
    QuadratureGrid grid;
    grid.betas = {0.25, 0.5, 1, 1.5, 2, 3, 5, 8, 12, 20, 40, 80};
    if (quick)
        grid.betas = {0.5, 2, 10, 40};
    grid.thetas = {0, 60};
    grid.azimuths = Linspace(0, kPi<double>, quick ? 61 : 181);
    grid.rounds = quick ? 1 : 3;
    return grid;
}

// The relative RMS error around the fiber, and nanoseconds of a value, of every rule.
struct RuleCosts {
    std::array<double, kRuleCount> rms = {}, ns = {};
};
RuleCosts MeasureRules(int p, double theta, double beta, const QuadratureGrid &grid) {
    const Quadrature q(CheckedDEon(Fiber(beta)));
    const SmoothFiber<double> fiber = q.At(std::cos(theta * kDegree));
    const double width = q.Width(static_cast<size_t>(p));
    // Ten nodes to a width, and more.
    const std::vector<PathLight> rays =
        ManyRays(p, fiber, {0.2f, 0.2f, 0.2f}, std::max<size_t>(256, static_cast<size_t>(60 / width)));
    std::vector<double> exact;
    exact.reserve(grid.azimuths.size());
    for (const double phi : grid.azimuths)
        exact.push_back(Exact(rays, width, phi));
    std::vector<std::function<void()>> jobs;
    for (const NpRule &rule : kRules)
        jobs.push_back([&] {
            for (const double phi : grid.azimuths)
                Keep(ByRule(rule, q, p, fiber, phi));
        });
    const std::vector<double> seconds = TimeInTurns(jobs, grid.rounds);
    RuleCosts costs;
    for (size_t k = 0; k < kRuleCount; ++k) {
        double error = 0, all = 0;
        for (size_t i = 0; i < grid.azimuths.size(); ++i) {
            error += Sqr(ByRule(kRules[k], q, p, fiber, grid.azimuths[i]) - exact[i]);
            all += Sqr(exact[i]);
        }
        costs.rms[k] = std::sqrt(error / all);
        costs.ns[k] = 1e9 * seconds[k] / static_cast<double>(grid.azimuths.size());
    }
    return costs;
}

// Errors against the roughness, a line for each rule; AddTo fills it.
PlotPanel ErrorPanel(const std::string &lobe, const QuadratureGrid &grid) {
    PlotPanel panel;
    panel.title = lobe + ", θ_d = 60°";
    panel.right = 0.58;
    panel.x = {.label = "β (degrees)", .log = true, .min = grid.betas.front(), .max = grid.betas.back()};
    panel.y = {.label = "relative RMS error", .log = true, .min = 1e-10, .max = 10};
    panel.lines = {{.vertical = true, .at = 2, .label = "the paper's bound", .labelBelow = true}};
    for (const NpRule &rule : kRules) {
        PlotSeries s;
        s.label = rule.name, s.color = rule.family, s.dash = rule.dash;
        panel.series.push_back(s);
    }
    return panel;
}

} // namespace

FigureData QuadratureChart(const FigureOptions &options) {
    const QuadratureGrid grid = QuadratureGridOf(options.quick);
    const std::array<std::string, 3> lobes = {"R", "TT", "TRT"};
    FigureData data{Table({"lobe", "theta_d_deg", "beta_deg", "rule", "relative_RMS_error", "ns_per_value"})};
    data.plot.width = 900, data.plot.height = 400, data.plot.columns = 2;
    double ours = 0;
    std::array<double, 3> paperAt2 = {};
    for (size_t p = 0; p < lobes.size(); ++p) {
        PlotPanel errors = ErrorPanel(lobes[p], grid);
        RuleCosts rough; // from beta = 2 on: worst error, sum of times
        size_t cells = 0;
        for (const double theta : grid.thetas)
            for (const double beta : grid.betas) {
                const RuleCosts costs = MeasureRules(static_cast<int>(p), theta, beta, grid);
                cells += beta >= 2;
                for (size_t k = 0; k < kRuleCount; ++k) {
                    const double rms = costs.rms[k];
                    data.table.Add({lobes[p], theta, beta, kRules[k].name, rms, costs.ns[k]});
                    if (theta == 60)
                        errors.series[k].x.push_back(beta),
                            errors.series[k].y.push_back(std::max(rms, 1e-16));
                    if (beta >= 2)
                        rough.rms[k] = std::max(rough.rms[k], rms), rough.ns[k] += costs.ns[k];
                    if (kRules[k].order == 0)
                        ours = std::max(ours, rms);
                    if (beta == 2 && theta == 0 && kRules[k].order == 35 && !kRules[k].half)
                        paperAt2[p] = rms;
                }
            }
        std::vector<CostPoint> points;
        for (size_t k = 0; k < kRuleCount; ++k)
            points.push_back(
                {kRules[k].name, rough.ns[k] / static_cast<double>(cells), rough.rms[k], kRules[k].family});
        data.plot.panels.push_back(errors);
        data.plot.panels.push_back(CostPanel(lobes[p] + ", β from 2°",
                                             "CPU time of a value (ns, mean over β)",
                                             "worst relative RMS error", points, 1e-10, 10));
    }
    data.checks = {
        {"ours is off by at most, for every β (relative RMS)", ours, 0, 2e-3},
        {"35 points over the width at β = 2° and normal incidence: TT is off by (relative RMS)", paperAt2[1],
         0.02, 0.2},
        {"and R by", paperAt2[0], 0.3, 1},
    };
    data.note = fmt::format("The paper's 35 points at its bound, β = 2°, and normal incidence are off by "
                            "{:.0f}% (R), {:.1f}% (TT) and {:.1f}% (TRT); ours by at most {:.1g} at any β.",
                            100 * paperAt2[0], 100 * paperAt2[1], 100 * paperAt2[2], ours);
    return data;
}

} // namespace cuticle
