// The atlas's maps around the fiber: N_p. Faults 10, 11 and 14.
#include "fibers/deon.h"
#include "fibers/gaussian.h"
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"
#include "figures/atlas/atlas.h"

namespace cuticle {

namespace {

// N_p of d'Eon's equation 10 at one azimuth after another, by quadrature over gamma or h.
class RoughPath {
  public:
    // nodes, weights of dh
    RoughPath(int p, double theta, const std::vector<double> &h, const std::vector<double> &weight) {
        const SmoothFiber<double> fiber(std::cos(theta), 1.55);
        for (size_t i = 0; i < h.size(); ++i) {
            const double gamma = std::asin(h[i]);
            turn_.push_back(fiber.Phi(p, gamma));
            weight_.push_back(weight[i] / 2 *
                              fiber.Attenuation(p, gamma, {0, 0, 0}, SegmentLength::Chord)[0]);
        }
    }
    double At(double phi, double beta) const {
        double sum = 0;
        for (size_t i = 0; i < turn_.size(); ++i)
            sum += weight_[i] * GaussianDetector(beta, phi - turn_[i]);
        return sum;
    }

  private:
    std::vector<double> turn_, weight_;
};

// n nodes over the width, or n over each half of it.
RoughPath ByGauss(int p, double theta, size_t n, bool halves) {
    const GaussLegendreRule &rule = GaussLegendre(n);
    std::vector<double> h, w;
    for (size_t i = 0; i < n; ++i) {
        if (!halves) {
            h.push_back(rule.x[i]), w.push_back(rule.w[i]);
            continue;
        }
        for (const double side : {-1., 1.})
            h.push_back(side * (1 + rule.x[i]) / 2), w.push_back(rule.w[i] / 2);
    }
    return {p, theta, h, w};
}
// 300 panels of 6 nodes over gamma: fine for a quarter of a degree.
RoughPath ByManyPanels(int p, double theta) {
    const GaussLegendreRule &rule = GaussLegendre(6);
    std::vector<double> h, w;
    const int panels = 300;
    for (int k = 0; k < panels; ++k)
        for (size_t i = 0; i < rule.x.size(); ++i) {
            const double half = kPi<double> / 2 / panels,
                         gamma = -kPi<double> / 2 + half * (2 * k + 1 + rule.x[i]);
            h.push_back(std::sin(gamma)), w.push_back(half * rule.w[i] * std::cos(gamma));
        }
    return {p, theta, h, w};
}

// Root of the mean squared difference over that of the exact. path: N_p of phi.
template <typename F>
double RelativeRms(const F &path, const RoughPath &exact, double beta) {
    double miss = 0, size = 0;
    const int n = 180;
    for (int k = 0; k < n; ++k) {
        const double phi = 2 * kPi<double> * (k + 0.5) / n, truth = exact.At(phi, beta);
        miss += Sqr(path(phi) - truth), size += truth * truth;
    }
    return std::sqrt(miss / size);
}

AtlasMap QuadratureMap(const AtlasOptions &o, int p, const char *name, const char *lobe) {
    AtlasMap map;
    map.name = std::string("quadrature-") + name;
    map.title = std::string("N_{") + lobe + "} of a clear fiber by quadrature over its width";
    map.quantity = "relative RMS error";
    map.x = {"detector β (degrees)", "beta_deg", -0.6, 1.6, o.quick ? size_t(8) : size_t(22), true};
    map.y = {"θ_d (degrees)", "theta_d_deg", 0, 85, o.quick ? size_t(5) : size_t(17)};
    map.min = 1e-8, map.max = 1;
    const auto fixed = [p](bool halves) {
        return [=](double beta, double theta) {
            const RoughPath path = ByGauss(p, theta * kDegree, 35, halves);
            return RelativeRms([&](double phi) { return path.At(phi, beta * kDegree); },
                               ByManyPanels(p, theta * kDegree), beta * kDegree);
        };
    };
    const auto ours = [p](double beta, double theta) {
        DEonParameters clear;
        clear.sigmaA = {0, 0, 0};
        clear.betaN.fill(static_cast<float>(beta));
        const DEonQuadrature<double> quadrature(clear);
        const auto fiber = quadrature.At(std::cos(theta * kDegree));
        return RelativeRms(
            [&](double phi) { return quadrature.Value(static_cast<size_t>(p), fiber, phi).n[0]; },
            ByManyPanels(p, theta * kDegree), static_cast<double>(clear.betaN[0]) * kDegree);
    };
    map.panels = {{"published: 35 nodes", FillMap(map.x, map.y, fixed(false))},
                  {"35 over each half", FillMap(map.x, map.y, fixed(true))},
                  {"ours: as many as β asks for", FillMap(map.x, map.y, ours)}};
    // where the paper says that 35 are enough
    double worst = 0, best = 0;
    for (size_t i = 0; i < map.x.cells * map.y.cells; ++i)
        if (map.x.At(i % map.x.cells) >= 2) {
            worst = std::max(worst, map.panels[0].values[i]);
            best = std::max(best, map.panels[2].values[i]);
        }
    map.findings = {{10, std::string("largest error of N of ") + lobe + " above 2 degrees", worst, best}};
    return map;
}

AtlasMap WrapMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "wrap", map.title = "Light of a lobe around φ, counted within ±π once, or wrapped";
    map.quantity = "light that is lost";
    map.x = {"detector β (degrees)", "beta_deg", 1, 90, o.quick ? size_t(10) : size_t(40)};
    map.y = {"centre of the lobe (degrees)", "phi_deg", 0, 180, o.quick ? size_t(9) : size_t(36)};
    map.min = 1e-12, map.max = 1;
    map.panels = {{"published: Zinke and Weber",
                   FillMap(map.x, map.y,
                           [](double beta, double phi) {
                               const double scale = 1 / (std::sqrt(2.) * beta);
                               return (std::erfc((180 - phi) * scale) + std::erfc((180 + phi) * scale)) / 2;
                           })},
                  {"ours: wrapped", FillMap(map.x, map.y, [](double beta, double phi) {
                       // the mean over the circle of a smooth periodic function: every point counts alike
                       double sum = 0;
                       const int n = 2000;
                       for (int k = 0; k < n; ++k)
                           sum += GaussianDetector(beta * kDegree, 2 * kPi<double> * k / n - phi * kDegree);
                       return std::abs(1 - sum * 2 * kPi<double> / n);
                   })}};
    // at the end of the map, where half is lost
    const double lost = WorstOf(map.panels[0].values);
    map.findings = {{11, "largest part of a lobe that is lost at +-pi", lost, WorstOf(map.panels[1].values)}};
    return map;
}

// The trimmed logistic against the sum over all turns. Chiang's model is made with the trimmed one, and so is
// ours.
AtlasMap TrimMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "trim", map.title = "The model's own fault, stated: its logistic is trimmed, not wrapped";
    map.quantity = "relative difference";
    map.x = {"β_n", "beta_n", 0.05, 1, o.quick ? size_t(10) : size_t(38)};
    map.y = {"φ from the lobe's centre (degrees)", "phi_deg", 0, 180, o.quick ? size_t(9) : size_t(36)};
    map.min = 1e-6, map.max = 1;
    map.panels = {{"trimmed against wrapped, as published and ours",
                   FillMap(map.x, map.y, [](double betaN, double phi) {
                       const double s = AzimuthalScale(betaN), x = phi * kDegree, pi = kPi<double>;
                       double wrapped = 0;
                       for (int k = -200; k <= 200; ++k)
                           wrapped += Logistic(x + 2 * pi * k, s);
                       return std::abs(TrimmedLogistic(x, s, -pi, pi) / wrapped - 1);
                   })}};
    const double inside = 1 - LogisticTail(AzimuthalScale(1.));
    map.findings = {
        {11, "mass of the logistic within +-pi at beta_n = 1, before the trim", inside, inside, true}};
    return map;
}

AtlasMap CausticMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "caustic", map.title = "Width in h of what lands on Marschner's caustic";
    map.quantity = "Δh, of a half width of 1";
    map.x = {"η'", "eta_prime", 1.3, 2, o.quick ? size_t(14) : size_t(56)};
    map.y = {"w_c (degrees)", "wc_deg", 0.5, 25, o.quick ? size_t(10) : size_t(49)};
    map.min = 0.05, map.max = 50;
    const auto width = [](double eta, double wc) {
        const SmoothFiber<double> fiber(1, eta);
        const double h = std::sin(fiber.TurningPoint(2));
        return 2 * std::sqrt(2 * wc * kDegree / std::abs(fiber.PhiCurvature(2, h)));
    };
    map.panels = {
        {"without the cap", FillMap(map.x, map.y, width)},
        {"with Δh_M = 0.5, as published and ours",
         FillMap(map.x, map.y, [&](double eta, double wc) { return std::min(0.5, width(eta, wc)); })}};
    double ruled = 2;
    for (const double eta : Linspace(1.3, 2, 701))
        if (width(eta, 1.5) > 0.5) {
            ruled = eta;
            break;
        }
    map.findings = {{14, "largest width in h: as the curvature has it; as capped",
                     WorstOf(map.panels[0].values), WorstOf(map.panels[1].values)},
                    {14, "eta' from which on the cap rules at w_c = 1.5 degrees", ruled, ruled}};
    return map;
}

} // namespace

std::vector<AtlasMap> AzimuthalMaps(const AtlasOptions &options) {
    return {QuadratureMap(options, 0, "r", "R"),
            QuadratureMap(options, 1, "tt", "TT"),
            QuadratureMap(options, 2, "trt", "TRT"),
            WrapMap(options),
            TrimMap(options),
            CausticMap(options)};
}

} // namespace cuticle
