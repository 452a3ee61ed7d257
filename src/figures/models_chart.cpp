// Every model of a fiber against the simulated fiber, its free parameters fitted.
#include "core/sampling.h"
#include "fibers/deon.h"
#include "fibers/fiber_simulator.h"
#include "fibers/hair.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"
#include "figures/charts.h"
#include "figures/cost.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cuticle {

namespace {

constexpr double kDegree = kPi<double> / 180;
using Parameters = std::vector<double>;

// The grid's fiber: roughness (Beckmann's, both ways), absorption per radius, tilt.
struct Fiber {
    double roughness, sigmaA, alpha; // alpha in degrees
};
std::array<float, 3> Grey(double x) {
    const auto f = static_cast<float>(x);
    return {f, f, f};
}

// --- the models: what is fitted, in logarithms but for tilts --------------------------------------------------------

// The value f |cos| for a pair of directions: viewer's and light's.
using Scattering = std::function<double(const Vector3d &, const Vector3d &)>;
struct Model {
    const char *name;
    int family;
    Parameters start;
    std::function<Scattering(const Fiber &, const Parameters &)> farField;
    // As a renderer has it at a hit, h across the fiber.
    std::function<std::unique_ptr<FiberBxDF>(const Fiber &, const Parameters &, float h)> atHit;
};

Spectrum Scaled(double logarithm) { return Spectrum(static_cast<float>(std::exp(logarithm))); }

MarschnerParameters MarschnerOf(const Fiber &fiber, const Parameters &x) {
    MarschnerParameters p;
    p.sigmaA = Grey(fiber.sigmaA);
    for (size_t i = 0; i < 3; ++i)
        p.beta[i] = static_cast<float>(std::exp(x[i]));
    const auto alpha = static_cast<float>(x[3]);
    p.alpha = {-alpha, alpha / 2, 3 * alpha / 2};
    p.kG = static_cast<float>(std::exp(x[4])), p.wc = static_cast<float>(std::exp(x[5]));
    return CheckedMarschner(p);
}
DEonParameters DEonOf(const Fiber &fiber, const Parameters &x) {
    DEonParameters p;
    p.sigmaA = Grey(fiber.sigmaA);
    for (size_t i = 0; i < 3; ++i)
        p.betaM[i] = static_cast<float>(std::exp(x[i]));
    const auto alpha = static_cast<float>(x[3]);
    p.alpha = {-2 * alpha, alpha, 4 * alpha};
    // Narrower than 2 degrees is nothing that the simulation's cells tell apart, and dear.
    const auto betaN = [&](double logarithm) {
        return std::max(2.f, static_cast<float>(std::exp(logarithm)));
    };
    p.betaN = {betaN(x[4]), betaN(x[4]), betaN(x[4] + x[5])};
    return CheckedDEon(p);
}
HairParameters ChiangOf(const Fiber &fiber, const Parameters &x, float h) {
    const auto unit = [](double logarithm) { return static_cast<float>(std::min(1., std::exp(logarithm))); };
    return {
        h, 1.55f, Grey(fiber.sigmaA), unit(x[0]), unit(x[1]), static_cast<float>(x[2]), ScaleTilt::RootToTip};
}

// The mean over the width of the near-field model.
Scattering ChiangFarField(const Fiber &fiber, const Parameters &x) {
    std::vector<HairLobes<double>> lobes;
    std::vector<double> weights;
    const GaussLegendreRule &rule = GaussLegendre(20);
    for (size_t i = 0; i < rule.x.size(); ++i) {
        const double gamma = kPi<double> / 2 * rule.x[i];
        lobes.emplace_back(ChiangOf(fiber, x, static_cast<float>(std::sin(gamma))));
        weights.push_back(kPi<double> / 4 * rule.w[i] * std::cos(gamma));
    }
    return [lobes, weights](const Vector3d &wo, const Vector3d &wi) {
        double sum = 0;
        for (size_t i = 0; i < lobes.size(); ++i)
            sum += weights[i] * lobes[i].Evaluate(wo, wi).fCos[0];
        return sum;
    };
}

const std::vector<Model> &Models() {
    static const std::vector<Model> models = {
        {"Kajiya-Kay",
         1,
         {-1, -3, 4},
         [](const Fiber &, const Parameters &x) -> Scattering {
             const auto grey = [](double l) {
                 return std::array<double, 3>{std::exp(l), std::exp(l), std::exp(l)};
             };
             const KajiyaKay<double> model(grey(x[0]), grey(x[1]), std::exp(std::min(x[2], 12.)));
             return
                 [model](const Vector3d &wo, const Vector3d &wi) { return model.Evaluate(wo, wi).fCos[0]; };
         },
         [](const Fiber &, const Parameters &x, float) -> std::unique_ptr<FiberBxDF> {
             return std::make_unique<KajiyaKayBSDF>(Scaled(x[0]), Scaled(x[1]),
                                                    static_cast<float>(std::exp(std::min(x[2], 12.))));
         }},
        {"Marschner",
         4,
         {1.5, 1.5, 2, 3, 0, 2},
         [](const Fiber &fiber, const Parameters &x) -> Scattering {
             const Marschner<double> model(MarschnerOf(fiber, x));
             return
                 [model](const Vector3d &wo, const Vector3d &wi) { return model.Evaluate(wo, wi).fCos[0]; };
         },
         [](const Fiber &fiber, const Parameters &x, float) -> std::unique_ptr<FiberBxDF> {
             return std::make_unique<MarschnerBSDF>(MarschnerOf(fiber, x));
         }},
        {"d'Eon, quadrature",
         3,
         {2, 2, 2.5, 3, 2, 0},
         [](const Fiber &fiber, const Parameters &x) -> Scattering {
             const DEonParameters p = DEonOf(fiber, x);
             const DEon<double, DEonQuadrature<double>> model(p, DEonQuadrature<double>(p));
             return
                 [model](const Vector3d &wo, const Vector3d &wi) { return model.Evaluate(wo, wi).fCos[0]; };
         },
         [](const Fiber &fiber, const Parameters &x, float) -> std::unique_ptr<FiberBxDF> {
             return std::make_unique<DEonBSDF>(DEonOf(fiber, x));
         }},
        {"Chiang (ours)",
         0,
         {-1.5, -1.5, 3},
         ChiangFarField,
         [](const Fiber &fiber, const Parameters &x, float h) -> std::unique_ptr<FiberBxDF> {
             const HairParameters p = ChiangOf(fiber, x, h);
             return std::make_unique<HairBSDF>(h, p.eta, Spectrum(p.sigmaA[0]), p.betaM, p.betaN, p.alpha);
         }},
    };
    return models;
}

// --- the truth ------------------------------------------------------------------------------------------------------

// A simulated fiber, lit from some inclinations; its densities and the share of noise in them.
struct Place {
    Vector3d light, w;
    double density, error, solidAngle;
};
std::vector<Place> Simulate(const Fiber &fiber, bool quick) {
    FiberDescription description;
    description.alpha = fiber.alpha * kDegree;
    description.roughnessU = description.roughnessV = fiber.roughness;
    description.sigmaA = {fiber.sigmaA};
    std::vector<Place> places;
    for (const double theta : {0., 45.}) {
        FiberMeasurement measurement;
        measurement.samples = quick ? 200'000 : 2'000'000;
        measurement.cells = {quick ? size_t(30) : size_t(60), quick ? size_t(24) : size_t(48), false};
        const SphereCells &cells = measurement.cells;
        const FiberHistogram histogram = SimulateFiber(description, {theta * kDegree, 0, {}}, measurement);
        const auto direction = [](double t, double phi) {
            return Vector3d(std::sin(t), std::cos(t) * std::cos(phi), std::cos(t) * std::sin(phi));
        };
        for (size_t row = 0; row < cells.rows; ++row)
            for (size_t column = 0; column < cells.columns; ++column)
                places.push_back(
                    {direction(theta * kDegree, 0), direction(cells.Theta(row), cells.Phi(column)),
                     histogram.Density(histogram.Sum(), 0, row, column),
                     histogram.DensityError(histogram.Sum(), 0, row, column), cells.SolidAngle(row)});
    }
    return places;
}

// Root mean square over the sphere relative to the density's, of every stride-th place.
double RelativeError(const std::vector<Place> &places, size_t stride, const Scattering &f) {
    double off = 0, all = 0;
    for (size_t i = 0; i < places.size(); i += stride) {
        const Place &p = places[i];
        off += Sqr(f(p.light, p.w) - p.density) * p.solidAngle, all += Sqr(p.density) * p.solidAngle;
    }
    const double error = std::sqrt(off / all);
    return std::isfinite(error) ? error : 1e9;
}
double Noise(const std::vector<Place> &places) {
    double off = 0, all = 0;
    for (const Place &p : places)
        off += Sqr(p.error) * p.solidAngle, all += Sqr(p.density) * p.solidAngle;
    return std::sqrt(off / all);
}

// --- fitting --------------------------------------------------------------------------------------------------------

// Nelder and Mead 1965, with their coefficients; evaluations of f at most.
template <typename F>
Parameters LeastOf(const Parameters &start, int evaluations, F f) {
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

// --- cost -----------------------------------------------------------------------------------------------------------

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

// Variance of a sample's weight f |cos| / pdf in units of its squared mean.
double RelativeVariance(const Model &model, const Fiber &fiber, const Parameters &x,
                        const std::vector<Query> &queries) {
    double sum = 0, squares = 0;
    for (const Query &q : queries) {
        Vector3f wi;
        Float pdf = 0;
        const Spectrum f = model.atHit(fiber, x, q.h)->Sample_f(q.wo, &wi, q.u, &pdf);
        const double weight = pdf > 0 ? static_cast<double>(f[0] * std::abs(wi.z) / pdf) : 0;
        sum += weight, squares += weight * weight;
    }
    const auto n = static_cast<double>(queries.size());
    return squares / n / Sqr(sum / n) - 1;
}

} // namespace

FigureData ModelsChart(const FigureOptions &options) {
    std::vector<Fiber> fibers;
    for (const double roughness : {0.1, 0.3})
        for (const double sigmaA : {0.05, 0.5})
            for (const double alpha : {0., 3.})
                fibers.push_back({roughness, sigmaA, alpha});
    if (options.quick)
        fibers = {{0.3, 0.2, 3}};
    const std::vector<Model> &models = Models();

    FigureData data{
        Table({"roughness", "sigma_a", "alpha_deg", "model", "relative_RMS_error", "noise_of_the_simulation",
               "ns_of_an_evaluation", "ns_of_a_sample", "relative_variance_of_a_sample"}),
        {},
        "",
        {}};
    const std::vector<Query> queries = Queries(options.quick ? 2000 : 20000);
    std::vector<double> error(models.size()), evaluation(models.size()), effort(models.size());
    double noisiest = 0;
    for (const Fiber &fiber : fibers) {
        const std::vector<Place> places = Simulate(fiber, options.quick);
        const double noise = Noise(places);
        noisiest = std::max(noisiest, noise);
        std::vector<Parameters> fitted;
        std::vector<std::function<void()>> jobs;
        for (const Model &m : models) {
            // An odd stride, so that all azimuths and inclinations have their turn.
            fitted.push_back(LeastOf(m.start, options.quick ? 80 : 200, [&](const Parameters &x) {
                return RelativeError(places, options.quick ? 5 : 7, m.farField(fiber, x));
            }));
        }
        for (size_t k = 0; k < models.size(); ++k) {
            jobs.push_back([&, k] {
                for (const Query &q : queries) {
                    Float pdf = 0;
                    Keep(models[k].atHit(fiber, fitted[k], q.h)->FPdf(q.wo, q.wi, &pdf));
                }
            });
            jobs.push_back([&, k] {
                for (const Query &q : queries) {
                    Float pdf = 0;
                    Vector3f wi;
                    Keep(models[k].atHit(fiber, fitted[k], q.h)->Sample_f(q.wo, &wi, q.u, &pdf));
                }
            });
        }
        const std::vector<double> seconds = TimeInTurns(jobs, options.quick ? 1 : 3);
        for (size_t k = 0; k < models.size(); ++k) {
            const double e = RelativeError(places, 1, models[k].farField(fiber, fitted[k])),
                         variance = RelativeVariance(models[k], fiber, fitted[k], queries),
                         toNs = 1e9 / static_cast<double>(queries.size()), nsEvaluate = toNs * seconds[2 * k],
                         nsSample = toNs * seconds[2 * k + 1];
            data.table.Add({fiber.roughness, fiber.sigmaA, fiber.alpha, models[k].name, e, noise, nsEvaluate,
                            nsSample, variance});
            const auto share = 1 / static_cast<double>(fibers.size());
            error[k] += e * share, evaluation[k] += nsEvaluate * share,
                effort[k] += variance * nsSample * share;
        }
    }
    std::vector<CostPoint> byTime, byEffort;
    for (size_t k = 0; k < models.size(); ++k) {
        byTime.push_back({models[k].name, evaluation[k], error[k], models[k].family});
        byEffort.push_back({models[k].name, effort[k], error[k], models[k].family});
    }
    data.plot.width = 900, data.plot.height = 400;
    data.plot.panels = {
        CostPanel("", "time of an evaluation, set-up included (ns)", "relative RMS error", byTime, 0.01, 2),
        CostPanel("", "relative variance of a sample times its time (ns)", "relative RMS error", byEffort,
                  0.01, 2)};
    data.checks = {
        {"the simulation's own noise is at most (relative RMS)", noisiest, 0, options.quick ? 0.2 : 0.05},
        {"some model of the three since 2003 is nearer than Kajiya and Kay's: error over theirs",
         std::min({error[1], error[2], error[3]}) / error[0], 0, 0.9},
    };
    data.note = Printed("%.0f fibers, each lit at θ = 0 and 45°; ", static_cast<double>(fibers.size())) +
                Printed("the simulation's own noise is at most %.1g.", noisiest);
    return data;
}

} // namespace cuticle
