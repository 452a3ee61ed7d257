// N_p of d'Eon et al. 2011 through the Gaussian detector, by rule, order and roughness.
#include "fibers/deon.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr double kDegree = kPi<double> / 180;
using Quadrature = DEonQuadrature<double>;

// order 0: nodes as many as the roughness asks for, split where Phi turns.
struct Rule {
    const char *name;
    size_t order;
    bool half;
    int family;
    PlotDash dash;
};
const Rule kRules[] = {
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

double ByRule(const Rule &rule, const Quadrature &q, int p, const SmoothFiber<double> &fiber, double phi) {
    return rule.order == 0 ? q.Value(static_cast<size_t>(p), fiber, phi).n[0]
                           : q.ByFixedOrder(p, fiber, phi, rule.order, rule.half)[0];
}

// What each of very many rays carries, once for all roughnesses.
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

} // namespace

FigureData QuadratureChart(const FigureOptions &options) {
    const std::vector<double> betas =
        options.quick ? std::vector<double>{0.5, 2, 10, 40}
                      : std::vector<double>{0.25, 0.5, 1, 1.5, 2, 3, 5, 8, 12, 20, 40, 80};
    const std::vector<double> thetas = {0, 60};
    const std::vector<double> azimuths = Linspace(0, kPi<double>, options.quick ? 61 : 181);
    const char *const names[] = {"R", "TT", "TRT"};

    FigureData data{
        Table({"lobe", "theta_d_deg", "beta_deg", "rule", "relative_RMS_error", "ns_per_value"}), {}, "", {}};
    data.plot.width = 900, data.plot.height = 400;
    std::vector<PlotPanel> curves, costs;
    double ours = 0;
    std::array<double, 3> paperAt2 = {};
    for (const int p : {0, 1, 2}) {
        PlotPanel panel;
        panel.title = std::string(names[p]) + ", θ_d = 60°";
        panel.right = 0.58;
        panel.x = {.label = "β (degrees)", .log = true, .min = betas.front(), .max = betas.back()};
        panel.y = {.label = "relative RMS error", .log = true, .min = 1e-10, .max = 10};
        panel.lines = {{.vertical = true, .at = 2, .label = "the paper's bound"}};
        panel.series.resize(kRuleCount);
        std::array<double, kRuleCount> worst = {}, ns = {};
        for (const double theta : thetas)
            for (const double beta : betas) {
                const Quadrature q(CheckedDEon(Fiber(beta)));
                const SmoothFiber<double> fiber = q.At(std::cos(theta * kDegree));
                const double width = q.Width(static_cast<size_t>(p));
                // Ten nodes to a width, and more.
                const std::vector<PathLight> rays = ManyRays(
                    p, fiber, {0.2f, 0.2f, 0.2f}, std::max<size_t>(256, static_cast<size_t>(60 / width)));
                std::vector<double> exact;
                exact.reserve(azimuths.size());
                for (const double phi : azimuths)
                    exact.push_back(Exact(rays, width, phi));
                std::vector<std::function<void()>> jobs;
                for (const Rule &rule : kRules)
                    jobs.push_back([&, p] {
                        for (const double phi : azimuths)
                            Keep(ByRule(rule, q, p, fiber, phi));
                    });
                const std::vector<double> seconds = TimeInTurns(jobs, options.quick ? 1 : 3);
                for (size_t k = 0; k < kRuleCount; ++k) {
                    double error = 0, all = 0;
                    for (size_t i = 0; i < azimuths.size(); ++i) {
                        const double e = ByRule(kRules[k], q, p, fiber, azimuths[i]) - exact[i];
                        error += e * e, all += exact[i] * exact[i];
                    }
                    const double rms = std::sqrt(error / all),
                                 time = 1e9 * seconds[k] / static_cast<double>(azimuths.size());
                    data.table.Add({names[p], theta, beta, kRules[k].name, rms, time});
                    if (theta == 60) {
                        PlotSeries &s = panel.series[k];
                        s.label = kRules[k].name, s.color = kRules[k].family, s.dash = kRules[k].dash;
                        s.x.push_back(beta), s.y.push_back(std::max(rms, 1e-16));
                    }
                    if (beta >= 2) {
                        worst[k] = std::max(worst[k], rms);
                        ns[k] += time;
                    }
                    if (kRules[k].order == 0)
                        ours = std::max(ours, rms);
                    if (beta == 2 && theta == 0 && kRules[k].order == 35 && !kRules[k].half)
                        paperAt2[static_cast<size_t>(p)] = rms;
                }
            }
        curves.push_back(panel);
        std::vector<CostPoint> points;
        const auto rough = static_cast<double>(
            std::count_if(betas.begin(), betas.end(), [](double b) { return b >= 2; }) * thetas.size());
        for (size_t k = 0; k < kRuleCount; ++k)
            points.push_back({kRules[k].name, ns[k] / rough, worst[k], kRules[k].family});
        costs.push_back(CostPanel(std::string(names[p]) + ", β from 2°", "time of a value (ns, mean over β)",
                                  "worst relative RMS error", points, 1e-10, 10));
    }
    data.plot.columns = 2;
    for (size_t p = 0; p < curves.size(); ++p)
        data.plot.panels.insert(data.plot.panels.end(), {curves[p], costs[p]});
    data.checks = {
        {"ours is off by at most, for every β (relative RMS)", ours, 0, 2e-3},
        {"35 points over the width at β = 2° and normal incidence: TT is off by (relative RMS)", paperAt2[1],
         0.02, 0.2},
        {"and R by", paperAt2[0], 0.3, 1},
    };
    data.note =
        Printed("The paper's 35 points at its bound, β = 2°, and normal incidence are off by %.0f%% (R), ",
                100 * paperAt2[0]) +
        Printed("%.1f%% (TT) and ", 100 * paperAt2[1]) + Printed("%.1f%% (TRT); ", 100 * paperAt2[2]) +
        Printed("ours by at most %.1g at any β.", ours);
    return data;
}

} // namespace cuticle
