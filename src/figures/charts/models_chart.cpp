// Every model of a fiber against the simulated fiber, its free parameters fitted.
#include "core/parallel.h"
#include "core/quadrature.h"
#include "core/sampling.h"
#include "fibers/fiber_simulator.h"
#include "fibers/models.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cuticle {

namespace {

using Parameters = std::vector<double>;
using Colors = std::array<float, 3>;

// --- the grid of fibers ------------------------------------------------------------------------------------

constexpr float kEta = 1.55f;
constexpr double kAbsorptions[] = {0.05, 0.5};

// Brown: absorption in eumelanin's proportions, the middle colour's is sigmaA. Errors are that colour's; what
// sampling costs depends on all three, since one direction is drawn for them.
Colors BrownOf(double sigmaA) {
    const auto middle = static_cast<float>(sigmaA);
    return {0.601f * middle, middle, 1.966f * middle};
}

// One of the grid: Beckmann's roughness along and across, tilt of the scales in degrees, second over first
// semi-axis of the section, absorption. The first semi-axis is at azimuth 0.
struct Fiber {
    double roughness, alpha, axisRatio, sigmaA;
    Colors Brown() const { return BrownOf(sigmaA); }
};

FiberDescription Described(const Fiber &fiber, std::vector<double> absorptions) {
    FiberDescription description;
    description.eta = static_cast<double>(kEta), description.axisRatio = fiber.axisRatio,
    description.alpha = fiber.alpha * kDegree;
    description.roughnessU = description.roughnessV = fiber.roughness;
    description.sigmaA = std::move(absorptions);
    return description;
}

// --- the models: what is fitted, in logarithms but for tilts -----------------------------------------------

// The value f |cos| of the middle colour for a pair of directions: viewer's and light's.
using Scattering = std::function<double(const Vector3d &, const Vector3d &)>;
// A model of the table, with one of the fits that its row names.
struct Model {
    const FiberModel *row;
    FiberFit fit;
    // The model of this fiber whose free numbers are x.
    PreparedFiber Prepared(const Fiber &fiber, const Parameters &x, bool quick) const {
        FiberInputs at;
        at.eta = kEta, at.sigmaA = fiber.Brown();
        std::vector<OwnValue> own;
        fit.set(x, {fiber.roughness, fiber.alpha, fiber.axisRatio, quick ? 0.5 : 1}, &at, &own);
        return {*row, at, own};
    }
};
// In the order of the papers. A model whose row names no fit is taken with the fiber's tilt, as it comes.
std::vector<Model> Models() {
    std::vector<const FiberModel *> rows;
    for (const FiberModel &row : FiberModels())
        rows.push_back(&row);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const FiberModel *a, const FiberModel *b) { return a->year < b->year; });
    std::vector<Model> models;
    for (const FiberModel *row : rows) {
        for (const FiberFit &fit : row->fits)
            models.push_back({row, fit});
        if (row->fits.empty())
            models.push_back(
                {row,
                 {row->title,
                  5,
                  {},
                  [](const Parameters &, const SimulatedFiber &fiber, FiberInputs *at,
                     std::vector<OwnValue> *) { at->alpha = static_cast<float>(fiber.alpha); }}});
    }
    return models;
}

// The light that is seen from afar, in double: of a model that knows h, the mean over the width.
Scattering FarField(const FiberModel &row, const PreparedFiber &fiber) {
    struct Node {
        std::shared_ptr<const FiberInDouble> fiber;
        double weight;
    };
    std::vector<Node> nodes;
    if (row.farField) {
        nodes.push_back({fiber.MakeInDouble(0), 1});
    } else {
        const GaussLegendreRule &rule = GaussLegendre(20);
        for (size_t i = 0; i < rule.x.size(); ++i) {
            const double gamma = kPi<double> / 2 * rule.x[i];
            nodes.push_back({fiber.MakeInDouble(static_cast<float>(std::sin(gamma))),
                             kPi<double> / 4 * rule.w[i] * std::cos(gamma)});
        }
    }
    return [nodes](const Vector3d &wo, const Vector3d &wi) {
        double sum = 0;
        for (const Node &node : nodes)
            sum += node.weight * node.fiber->Evaluate(wo, wi).fCos[1];
        return sum;
    };
}

// --- the truth ---------------------------------------------------------------------------------------------

// A direction that a fiber is lit from, degrees; the azimuth counts from the section's first semi-axis. A
// circle looks alike from all around.
struct Incidence {
    double theta, phi;
};
std::vector<Incidence> LightsOf(const Fiber &fiber) {
    if (fiber.axisRatio == 1)
        return {{0, 0}, {45, 0}};
    return {{0, 0}, {0, 45}, {0, 90}, {45, 0}, {45, 45}, {45, 90}};
}

// A cell of the sphere around a lit fiber: two directions in it, whose mean is the model's (Gauss's rule in
// phi, in which cells are wide), its density in the simulation and that one's standard error.
struct LitCell {
    double thetaLight;
    Vector3d light, w[2];
    double density, error, solidAngle;
    double Miss(const Scattering &f) const { return (f(light, w[0]) + f(light, w[1])) / 2 - density; }
};
// The light that the fiber scatters with each absorption of the grid. The seed is none of a table's.
using Truth = std::array<std::vector<LitCell>, std::size(kAbsorptions)>;
Truth Simulate(const Fiber &fiber, bool quick) {
    const auto direction = [](double t, double phi) {
        return Vector3d(std::sin(t), std::cos(t) * std::cos(phi), std::cos(t) * std::sin(phi));
    };
    const std::vector<Incidence> lights = LightsOf(fiber);
    FiberMeasurement measurement;
    measurement.samples = (quick ? 200'000 : 2'000'000) / lights.size(), measurement.orders = 1;
    measurement.cells = {quick ? size_t(30) : size_t(60), quick ? size_t(24) : size_t(48), false};
    const SphereCells &cells = measurement.cells;
    const double half = kPi<double> / static_cast<double>(cells.columns) / std::sqrt(3.);
    Truth truth;
    for (const Incidence &light : lights) {
        const FiberHistogram seen =
            SimulateFiber(Described(fiber, {std::begin(kAbsorptions), std::end(kAbsorptions)}),
                          {light.theta * kDegree, light.phi * kDegree, {}}, measurement);
        for (size_t k = 0; k < truth.size(); ++k)
            for (size_t row = 0; row < cells.rows; ++row)
                for (size_t column = 0; column < cells.columns; ++column) {
                    const double theta = cells.Theta(row), phi = cells.Phi(column);
                    truth[k].push_back({light.theta,
                                        direction(light.theta * kDegree, light.phi * kDegree),
                                        {direction(theta, phi - half), direction(theta, phi + half)},
                                        seen.Density(seen.Sum(), k, row, column),
                                        seen.DensityError(seen.Sum(), k, row, column),
                                        cells.SolidAngle(row)});
                }
    }
    return truth;
}

// Root mean square over the sphere of `miss`, relative to the density's, over every stride-th of the places
// that `counts`.
template <typename Miss, typename Counts>
double RelativeRms(const std::vector<LitCell> &places, size_t stride, Miss miss, Counts counts) {
    double off = 0, all = 0;
    for (size_t i = 0; i < places.size(); i += stride)
        if (const LitCell &p = places[i]; counts(p))
            off += Sqr(miss(p)) * p.solidAngle, all += Sqr(p.density) * p.solidAngle;
    return std::sqrt(off / all);
}
bool Everywhere(const LitCell &) { return true; }
double RelativeError(const std::vector<LitCell> &places, size_t stride, const Scattering &f) {
    return RelativeRms(
        places, stride, [&](const LitCell &p) { return p.Miss(f); }, Everywhere);
}

// --- fitting -----------------------------------------------------------------------------------------------

// Nelder and Mead 1965, with their coefficients; evaluations of f at most.
template <typename F>
Parameters MinimizerOf(const Parameters &start, int evaluations, F f) {
    struct Corner {
        Parameters x;
        double value;
    };
    std::vector<Corner> simplex = {{start, f(start)}};
    for (size_t i = 0; i < start.size(); ++i) {
        Parameters x = start;
        x[i] += 0.5;
        simplex.push_back({x, f(x)});
    }
    const auto worse = [](const Corner &a, const Corner &b) { return a.value < b.value; };
    for (int n = 0; n < evaluations; ++n) {
        std::sort(simplex.begin(), simplex.end(), worse);
        Corner &last = simplex.back();
        Parameters center(start.size(), 0);
        for (size_t k = 0; k + 1 < simplex.size(); ++k)
            for (size_t i = 0; i < start.size(); ++i)
                center[i] += simplex[k].x[i] / static_cast<double>(start.size());
        const auto along = [&](double t) {
            Parameters x(start.size());
            for (size_t i = 0; i < x.size(); ++i)
                x[i] = center[i] + t * (last.x[i] - center[i]);
            const double value = f(x);
            ++n;
            return Corner{x, value};
        };
        Corner reflected = along(-1);
        if (reflected.value < simplex.front().value) {
            const Corner expanded = along(-2);
            last = expanded.value < reflected.value ? expanded : reflected;
        } else if (reflected.value < simplex[simplex.size() - 2].value) {
            last = reflected;
        } else if (const Corner contracted = along(reflected.value < last.value ? -0.5 : 0.5);
                   contracted.value < std::min(last.value, reflected.value)) {
            last = contracted;
        } else {
            for (size_t k = 1; k < simplex.size(); ++k) {
                for (size_t i = 0; i < start.size(); ++i)
                    simplex[k].x[i] = (simplex[k].x[i] + simplex[0].x[i]) / 2;
                simplex[k].value = f(simplex[k].x);
                ++n;
            }
        }
    }
    return std::min_element(simplex.begin(), simplex.end(), worse)->x;
}

// --- cost --------------------------------------------------------------------------------------------------

struct Query {
    float h;
    Vector3f wo, wi;
    std::array<float, 4> u;
};
std::vector<Query> Queries(size_t n) {
    RNG rng(1);
    std::vector<Query> queries(n);
    for (Query &q : queries) {
        q.h = 2 * rng.UniformFloat() - 1;
        q.wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
        q.wi = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
        for (float &u : q.u)
            u = rng.UniformFloat();
    }
    return queries;
}

// Variance of a sample's weight f |cos| / pdf for a given viewer, in units of its squared mean: the mean over
// viewers from all around and over the three colours. By differences of two samples for the same viewer, each
// at an h of its own.
double RelativeVariance(const PreparedFiber &model, const std::vector<Query> &queries) {
    std::array<double, 3> sum = {0, 0, 0}, squares = {0, 0, 0};
    FiberStorage fiber;
    const auto weight = [&](const Query &q, const Vector3f &wo) {
        Vector3f wi;
        Float pdf = 0;
        model.Make(q.h, &fiber);
        const Spectrum f = fiber.Get()->Sample_f(wo, &wi, q.u, &pdf);
        return pdf > 0 ? f * (std::abs(wi.z) / pdf) : Spectrum(0);
    };
    for (size_t i = 0; i + 1 < queries.size(); i += 2) {
        const Spectrum first = weight(queries[i], queries[i].wo),
                       second = weight(queries[i + 1], queries[i].wo);
        for (size_t c = 0; c < 3; ++c) {
            const auto a = static_cast<double>(first[static_cast<int>(c)]),
                       b = static_cast<double>(second[static_cast<int>(c)]);
            sum[c] += a + b, squares[c] += Sqr(a - b);
        }
    }
    double mean = 0;
    const auto n = static_cast<double>(queries.size());
    for (size_t c = 0; c < 3; ++c)
        mean += squares[c] / n / Sqr(sum[c] / n) / 3;
    return mean;
}

// Nanoseconds of an evaluation with its density, and of a sample with both, what is set up at a hit included.
struct Cost {
    double evaluate, sample;
};
std::vector<Cost> CostsOf(const std::vector<PreparedFiber> &models, const std::vector<Query> &queries,
                          int rounds) {
    std::vector<std::function<void()>> jobs;
    for (const PreparedFiber &model : models) {
        jobs.push_back([&] {
            FiberStorage fiber;
            for (const Query &q : queries) {
                Float pdf = 0;
                model.Make(q.h, &fiber);
                Keep(fiber.Get()->FPdf(q.wo, q.wi, &pdf));
            }
        });
        jobs.push_back([&] {
            FiberStorage fiber;
            for (const Query &q : queries) {
                Float pdf = 0;
                Vector3f wi;
                model.Make(q.h, &fiber);
                Keep(fiber.Get()->Sample_f(q.wo, &wi, q.u, &pdf));
            }
        });
    }
    const std::vector<double> seconds = TimeInTurns(jobs, rounds);
    const double toNs = 1e9 / static_cast<double>(queries.size());
    std::vector<Cost> costs;
    for (size_t k = 0; k < models.size(); ++k)
        costs.push_back({toNs * seconds[2 * k], toNs * seconds[2 * k + 1]});
    return costs;
}

// --- the chart ---------------------------------------------------------------------------------------------

struct Grid {
    std::vector<double> axisRatios, roughnesses, alphas;
};
Grid GridOf(bool quick) {
    return quick ? Grid{{1, 0.7}, {0.3}, {3}} : Grid{{1, 0.8, 0.6}, {0.1, 0.3}, {0, 3}};
}
std::vector<Fiber> GridOfFibers(const Grid &grid) {
    std::vector<Fiber> fibers;
    for (const double axisRatio : grid.axisRatios)
        for (const double roughness : grid.roughnesses)
            for (const double alpha : grid.alphas)
                for (const double sigmaA : kAbsorptions)
                    fibers.push_back({roughness, alpha, axisRatio, sigmaA});
    return fibers;
}

// "1, 0.8 and 0.6".
std::string Listed(const std::vector<double> &numbers) {
    std::string text;
    for (size_t i = 0; i < numbers.size(); ++i)
        text += (i == 0 ? "" : i + 1 < numbers.size() ? ", " : " and ") + Printed("%g", numbers[i]);
    return text;
}
// Lists what a run has measured, for its caption.
std::string NoteOf(const Grid &grid, size_t round, size_t elliptical, double noisiest) {
    const auto counted = [](size_t n, const std::string &what) {
        return std::to_string(n) + " " + what + (n == 1 ? " fiber" : " fibers");
    };
    return "Measured here: " + counted(round, "round") + " and " + counted(elliptical, "elliptical") +
           ", of axis ratio " + Listed(grid.axisRatios) + ", Beckmann roughness " + Listed(grid.roughnesses) +
           ", scales tilted by " + Listed(grid.alphas) +
           "°, σ_a = " + Listed({std::begin(kAbsorptions), std::end(kAbsorptions)}) + " per radius" +
           Printed("; the simulation's own noise is at most %.1g.", noisiest);
}

// Measurements of one model, the mean over the round fibers (0) and over the elliptical ones (1).
struct Mean {
    std::array<double, 2> error = {0, 0}, evaluate = {0, 0}, effort = {0, 0};
};

// Draws the models: round fibers are points with letters; a thin line leads from each to the same
// model's elliptical fibers.
PlotPanel PanelOf(const std::vector<Model> &models, const std::vector<Mean> &means,
                  std::array<double, 2> Mean::*cost, const char *label) {
    constexpr double kBest = 0.01, kWorst = 2;
    std::array<std::vector<CostPoint>, 2> points;
    for (size_t k = 0; k < models.size(); ++k)
        for (size_t s = 0; s < 2 && models[k].fit.drawn; ++s)
            points[s].push_back({std::string(models[k].fit.title), (means[k].*cost)[s], means[k].error[s],
                                 models[k].fit.color});
    PlotPanel panel = CostPanel("", label, "relative RMS error", points[0], kBest, kWorst);
    panel.series.back().label = "front, round fibers";
    PlotSeries front = ParetoSteps(points[1], kBest, kWorst);
    front.label = "front, elliptical fibers", front.dash = PlotDash::Dashed;
    panel.series.push_back(front);
    for (size_t k = 0; k < points[0].size(); ++k) {
        PlotSeries line;
        line.label = k == 0 ? "the same, elliptical" : "";
        line.style = PlotStyle::LinePoints;
        line.color = points[0][k].family, line.marker = 6, line.width = 1;
        for (const auto &ofSection : points)
            line.x.push_back(ofSection[k].cost), line.y.push_back(ofSection[k].error);
        panel.x.min = std::min(*panel.x.min, points[1][k].cost / 1.4);
        panel.x.max = std::max(*panel.x.max, points[1][k].cost * 1.6);
        panel.series.push_back(line);
    }
    return panel;
}

std::vector<FigureCheck> LawsOf(const std::vector<Model> &models, const std::vector<Mean> &means,
                                double noisiest, bool quick) {
    const auto mean = [&](std::string_view title) {
        for (size_t k = 0; k < models.size(); ++k)
            if (models[k].fit.title == title)
                return means[k];
        throw Error("the chart of models has no fit \"{}\"", title);
    };
    const Mean kajiyaKay = mean("Kajiya-Kay"), marschner = mean("Marschner"),
               sectionIgnored = mean("Marschner, section ignored"), quadrature = mean("d'Eon, quadrature"),
               table = mean("d'Eon, table of N_p"), chiang = mean("Chiang (ours)"),
               tabulated = mean("tabulated");
    const auto best = [&](size_t section) {
        return std::min({marschner.error[section], quadrature.error[section], chiang.error[section]});
    };
    return {
        {"the simulation's own noise is at most (relative RMS)", noisiest, 0, quick ? 0.2 : 0.05},
        {"some model of the three since 2003 is nearer than Kajiya and Kay's: error over theirs",
         best(0) / kajiyaKay.error[0], 0, 0.9},
        {"d'Eon's table errs as the integral does: error over the other's, round fibers",
         table.error[0] / quadrature.error[0], 0.97, 1.03},
        {"a tabulated simulation is nearer to another one than any model: error over the best's, round "
         "fibers",
         tabulated.error[0] / best(0), 0, 0.9},
        {"and elliptical fibers", tabulated.error[1] / best(1), 0, 0.9},
        {"to take an elliptical fiber for round costs accuracy: d'Eon's error over that for round fibers",
         quadrature.error[1] / quadrature.error[0], 1.05, 100},
        {"eta* gains on elliptical fibers little: Marschner's error over that with the section ignored",
         marschner.error[1] / sectionIgnored.error[1], 0.8, 1.02},
    };
}

} // namespace

FigureData ModelsChart(const FigureOptions &options) {
    const bool quick = options.quick;
    const std::vector<Model> models = Models();
    const Grid grid = GridOf(quick);
    const std::vector<Fiber> fibers = GridOfFibers(grid);
    std::vector<std::vector<LitCell>> truth;
    for (size_t i = 0; i < fibers.size();
         i += std::size(kAbsorptions)) // neighbours differ in absorption alone
        for (std::vector<LitCell> &places : Simulate(fibers[i], quick))
            truth.push_back(std::move(places));

    std::vector<Parameters> fitted(fibers.size() * models.size());
    ParallelFor(fitted.size(), [&](size_t i) {
        const Fiber &fiber = fibers[i / models.size()];
        const std::vector<LitCell> &places = truth[i / models.size()];
        const Model &model = models[i % models.size()];
        // An odd stride, so that all azimuths and inclinations have their turn.
        const size_t stride = places.size() / 500 | 1;
        if (!model.fit.start.empty())
            fitted[i] = MinimizerOf(model.fit.start, quick ? 60 : 200, [&](const Parameters &x) {
                const double error =
                    RelativeError(places, stride, FarField(*model.row, model.Prepared(fiber, x, quick)));
                return std::isfinite(error) ? error : 1e9;
            });
    });
    for (size_t i = 1; i < fitted.size(); ++i)
        if (models[i % models.size()].fit.asPrevious)
            fitted[i] = fitted[i - 1];

    FigureData data{Table({"axis_ratio", "roughness", "sigma_a", "alpha_deg", "model", "relative_RMS_error",
                           "error_lit_at_0_deg", "error_lit_at_45_deg", "noise_of_the_simulation",
                           "ns_of_an_evaluation", "ns_of_a_sample", "relative_variance_of_a_sample"})};
    const std::vector<Query> queries = Queries(quick ? 1000 : 8000);
    std::vector<Mean> mean(models.size());
    const auto round = static_cast<size_t>(
        std::count_if(fibers.begin(), fibers.end(), [](const Fiber &f) { return f.axisRatio == 1; }));
    const double share[] = {1 / static_cast<double>(round), 1 / static_cast<double>(fibers.size() - round)};
    double noisiest = 0;
    for (size_t i = 0; i < fibers.size(); ++i) {
        const Fiber &fiber = fibers[i];
        const size_t section = fiber.axisRatio == 1 ? 0 : 1;
        const double noise = RelativeRms(
            truth[i], 1, [](const LitCell &p) { return p.error; }, Everywhere);
        noisiest = std::max(noisiest, noise);
        std::vector<PreparedFiber> prepared;
        for (size_t k = 0; k < models.size(); ++k)
            prepared.push_back(models[k].Prepared(fiber, fitted[i * models.size() + k], quick));
        const std::vector<Cost> costs = CostsOf(prepared, queries, 3);
        for (size_t k = 0; k < models.size(); ++k) {
            const Scattering f = FarField(*models[k].row, prepared[k]);
            const auto litAt = [&](double theta) {
                return RelativeRms(
                    truth[i], 1, [&](const LitCell &p) { return p.Miss(f); },
                    [&](const LitCell &p) { return p.thetaLight == theta; });
            };
            const double error = RelativeError(truth[i], 1, f),
                         variance = RelativeVariance(prepared[k], queries);
            data.table.Add({fiber.axisRatio, fiber.roughness, fiber.sigmaA, fiber.alpha,
                            std::string(models[k].fit.title), error, litAt(0), litAt(45), noise,
                            costs[k].evaluate, costs[k].sample, variance});
            mean[k].error[section] += error * share[section];
            mean[k].evaluate[section] += costs[k].evaluate * share[section];
            mean[k].effort[section] += variance * costs[k].sample * share[section];
        }
    }
    data.plot.width = 900, data.plot.height = 400;
    data.plot.panels = {
        PanelOf(models, mean, &Mean::evaluate, "CPU time of an evaluation, set-up included (ns)"),
        PanelOf(models, mean, &Mean::effort, "relative variance of a sample times its CPU time (ns)")};
    data.checks = LawsOf(models, mean, noisiest, quick);
    data.note = NoteOf(grid, round, fibers.size() - round, noisiest);
    return data;
}

} // namespace cuticle
