// The plots of "An Energy-Conserving Hair Reflectance Model" by d'Eon, Francois, Hill, Letteri and Aubry
// (2011).
#include "core/color.h"
#include "fibers/ap.h"
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/longitudinal_forms.h"
#include "fibers/smooth_fiber.h"
#include "figures/papers/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

// The integral of f over [low, high], in pieces of 64 nodes each.
template <typename F>
double Integrate(double low, double high, int pieces, F f) {
    const GaussLegendreRule &rule = GaussLegendre(64);
    const double half = (high - low) / (2 * pieces);
    double sum = 0;
    for (int k = 0; k < pieces; ++k)
        for (size_t i = 0; i < rule.x.size(); ++i)
            sum += half * rule.w[i] * f(low + half * (2 * k + 1 + rule.x[i]));
    return sum;
}

// Absorption of the pure pigments per mm, as Donner and Jensen 2006 have it; lambda in nm.
double EumelaninAbsorption(double lambda) { return 6.6e10 * std::pow(lambda, -3.33); }
double PheomelaninAbsorption(double lambda) { return 2.9e14 * std::pow(lambda, -4.75); }

// XYZ of D65 through a thickness in mm of a mixture, in 40 bands of 10 nm. RGB (1,1,1) if nothing absorbs.
std::array<double, 3> SpectralTransmission(double mm, double pheomelanin) {
    std::array<double, 3> seen = {0, 0, 0};
    double white = 0;
    for (int band = 0; band < 40; ++band) {
        const double lambda = 385 + 10 * band, light = IlluminantD65(lambda);
        const std::array<double, 3> eye = MatchingFunction(lambda);
        const double absorption =
            (1 - pheomelanin) * EumelaninAbsorption(lambda) + pheomelanin * PheomelaninAbsorption(lambda);
        white += light * eye[1];
        for (size_t i = 0; i < 3; ++i)
            seen[i] += light * eye[i] * std::exp(-absorption * mm);
    }
    for (double &x : seen)
        x /= white;
    return seen;
}

// The same by the paper's cross-sections, thickness in their unit.
Spectrum RgbTransmission(double thickness, double pheomelanin) {
    const Spectrum sigma = HairBSDF::SigmaAFromConcentration(static_cast<float>(1 - pheomelanin),
                                                             static_cast<float>(pheomelanin));
    return Exp(sigma * static_cast<float>(-thickness));
}

double PigmentDifference(double thickness, double mmOfUnit, double pheomelanin) {
    return CIEDE2000(XYZToLab(SpectralTransmission(thickness * mmOfUnit, pheomelanin)),
                     XYZToLab(RGBToXYZ(RgbTransmission(thickness, pheomelanin))));
}

// The place of the minimum of f, which has one between low and high, by golden sections.
template <typename F>
double ArgMin(double low, double high, F f) {
    const double golden = (std::sqrt(5.) - 1) / 2;
    for (int step = 0; step < 60; ++step) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
    }
    return (low + high) / 2;
}

} // namespace

// Equation 5: N_R integrates to 1, so that only M_R and the cosines remain; each M_p at the width that the
// paper gives it, beta of theta_h, of 2 theta_h, of the sphere.
FigureData Deon03(const FigureOptions &) {
    struct DrawnForm {
        LongitudinalForm form;
        const char *name, *title;
        double widths; // standard deviation of theta_i + theta_r in beta
    };
    const DrawnForm forms[] = {
        {LongitudinalForm::HalfAngle, "gaussian_theta_h", "g(β; θ_h), Marschner 2003", 2},
        {LongitudinalForm::FullAngle, "gaussian_2_theta_h", "g(β; 2 θ_h), Zinke 2007", 1},
        {LongitudinalForm::Spherical, "spherical", "spherical Gaussian, d'Eon 2011", 1}};
    FigureData data{Table({"M", "beta_deg", "theta_i_deg", "total_reflectance"})};
    data.plot.columns = 3, data.plot.width = 400, data.plot.height = 400;
    double off = 0, doubled = 0, grazing = 0, lost = 0;
    for (const DrawnForm &form : forms) {
        PlotPanel panel;
        panel.title = form.title;
        panel.legend = "top left";
        panel.x = {.label = "θ_i (degrees)", .min = 0, .max = 90, .step = 30};
        panel.y = {.label = "total reflectance", .min = 0, .max = 3.5, .step = 0.5};
        panel.lines = {{.vertical = false, .at = 1, .label = ""}};
        for (const double beta : {2., 5., 10., 20., 40., 60.}) {
            const LongitudinalLobe<double> lobe(form.form, form.widths * beta * kDegree, 0);
            PlotSeries curve;
            // One legend is enough, where there is room for it.
            if (form.form == LongitudinalForm::FullAngle)
                curve.label = fmt::format("β = {:g}°", beta);
            for (const double theta : Linspace(0, 89.5, 180)) {
                const Inclination<double> i{std::sin(theta * kDegree), std::cos(theta * kDegree)};
                const double total = Integrate(-kPi<double> / 2, kPi<double> / 2, 24, [&](double thetaR) {
                    const Inclination<double> r{std::sin(thetaR), std::cos(thetaR)};
                    return lobe.Value(i, r) * r.cos;
                });
                data.table.Add({form.name, beta, theta, total});
                curve.x.push_back(theta), curve.y.push_back(total);
            }
            if (form.form == LongitudinalForm::Spherical)
                for (const double total : curve.y)
                    off = std::max(off, std::abs(total - 1));
            else if (form.form == LongitudinalForm::HalfAngle && beta == 2)
                doubled = curve.y[0];
            else if (form.form == LongitudinalForm::FullAngle && beta == 10)
                grazing = *std::max_element(curve.y.begin(), curve.y.end());
            else if (form.form == LongitudinalForm::FullAngle && beta == 60)
                lost = curve.y[0];
            panel.series.push_back(curve);
        }
        data.plot.panels.push_back(panel);
    }
    data.checks = {
        {"the spherical Gaussian's total is 1, off by at most", off, 0, 1e-4},
        {"the Gaussian in θ_h doubles the light: total at β = 2° and normal incidence", doubled, 1.98, 2.02},
        {"the Gaussian in 2 θ_h adds light at grazing angles: most, at β = 10°", grazing, 1.05, 3},
        {"the Gaussian in 2 θ_h loses light where rough: total at β = 60° and normal incidence", lost, 0.2,
         0.95}};
    data.note = "The paper does not list its β.";
    return data;
}

FigureData Deon04(const FigureOptions &) {
    const double v = 0.02;
    FigureData data{Table({"theta_i_rad", "theta_r_rad", "M_per_sr"})};
    data.plot.width = 620, data.plot.height = 560, data.plot.columns = 2;
    // The same curves, each over its value on the specular cone: they no longer lie on one another.
    PlotPanel apart;
    apart.x = {.label = "θ_r (rad)", .min = 0.6, .max = kPi<double> / 2, .step = 0.2};
    apart.y = {.label = "M_p over its value on the specular cone (dashed)", .min = 0};
    apart.legend = "top left";
    PlotPanel panel;
    panel.kind = PlotKind::Polar;
    panel.y.label = "M_p (1/sr)";
    panel.polarFirst = 0, panel.polarLast = 90;
    panel.legend = "right top";
    std::vector<PlotSeries> cones;
    double before = 0, minShift = 1, minGrowth = 1;
    for (const double thetaI : {-1., -1.1, -1.2, -1.3, -1.4}) {
        const auto m = [&](double thetaR) {
            return Mp(std::cos(thetaI), std::cos(thetaR), std::sin(thetaI), std::sin(thetaR), v);
        };
        PlotSeries curve;
        curve.label = fmt::format("θ_i = {:g} rad", thetaI);
        double peak = 0;
        for (const double thetaR : Linspace(-kPi<double> / 2, kPi<double> / 2, 6284)) {
            data.table.Add({thetaI, thetaR, m(thetaR)});
            curve.x.push_back(thetaR / kDegree), curve.y.push_back(m(thetaR));
            if (m(thetaR) > m(peak))
                peak = thetaR;
        }
        panel.series.push_back(curve);
        for (size_t i = 0; i < curve.x.size(); ++i)
            curve.x[i] *= kDegree, curve.y[i] /= m(-thetaI);
        curve.color = std::array{0, 2, 3, 5, 7}[cones.size()];
        apart.series.push_back(curve);
        PlotSeries mark{.label = "", .x = {-thetaI, -thetaI}, .y = {0, 1}, .error = {}, .color = curve.color};
        mark.dash = PlotDash::Dashed, mark.width = 1;
        apart.series.push_back(mark);
        PlotSeries cone;
        cone.x = {-thetaI / kDegree, -thetaI / kDegree}, cone.y = {0, m(-thetaI)};
        cone.color = 4, cone.width = 1;
        cones.push_back(cone);
        const double shift = peak + thetaI;
        data.note +=
            fmt::format("{}{:.3f}", data.note.empty() ? "The peaks lie beyond the cones by " : ", ", shift);
        minShift = std::min(minShift, shift), minGrowth = std::min(minGrowth, shift - before);
        before = shift;
    }
    data.note += " rad.";
    panel.series.insert(panel.series.end(), cones.begin(), cones.end());
    for (size_t i = 0; i < 5; ++i)
        panel.series[i].color = std::array{0, 2, 3, 5, 7}[i];
    data.plot.panels = {panel, apart};
    data.checks = {{"the peak lies beyond the specular cone, by at least (rad)", minShift, 1e-3, 0.5},
                   {"its distance grows with every step of θ_i, by at least (rad)", minGrowth, 1e-3, 0.5}};
    return data;
}

// A_p averaged over the width. The sum over all p is the geometric series' rest added in closed form.
FigureData Deon05(const FigureOptions &) {
    const double eta = 1.55;
    const std::array<double, 3> clear = {0, 0, 0};
    const std::vector<int> sums = {0, 1, 2, 3, 4, 7, 15};
    const char *names[] = {"R", "R + TT", "R + TT + TRT", "... + TRRT (p ≤ 3)", "p ≤ 4", "p ≤ 7", "p ≤ 15"};
    FigureData data{Table({"theta_i_deg", "most_segments", "total_reflectance"})};
    PlotPanel panel;
    panel.x = {.label = "θ_i (degrees)", .min = 0, .max = 90, .step = 15};
    panel.y = {.label = "total reflectance", .min = 0, .max = 1.05, .step = 0.2};
    panel.legend = "left bottom";
    panel.series.resize(sums.size() + 1);
    double off = 0, minThree = 1, minThreeAt = 0;
    const std::vector<double> thetas = Linspace(0, 89.5, 180);
    for (const double theta : thetas) {
        const SmoothFiber<double> fiber(std::cos(theta * kDegree), eta);
        // The mean over the width of the light that `share` of a path at gamma carries.
        const auto mean = [](auto share) {
            return Integrate(0, kPi<double> / 2, 4,
                             [&](double gamma) { return std::cos(gamma) * share(gamma); });
        };
        double sum = 0;
        for (int p = 0; p <= sums.back(); ++p) {
            sum += mean([&](double g) { return fiber.Attenuation(p, g, clear, SegmentLength::Chord)[0]; });
            const auto at = std::find(sums.begin(), sums.end(), p);
            if (at == sums.end())
                continue;
            const auto k = static_cast<size_t>(at - sums.begin());
            data.table.Add({theta, static_cast<double>(p), sum});
            panel.series[k].label = names[k];
            panel.series[k].x.push_back(theta), panel.series[k].y.push_back(sum);
            if (p == 2 && sum < minThree)
                minThree = sum, minThreeAt = theta;
        }
        const double all = sum + mean([&](double g) {
                               return fiber.Tail(sums.back() + 1, g, clear, SegmentLength::Chord)[0];
                           });
        data.table.Add({theta, INFINITY, all});
        panel.series.back().label = "all p";
        panel.series.back().x.push_back(theta), panel.series.back().y.push_back(all);
        off = std::max(off, std::abs(all - 1));
    }
    panel.series.back().dash = PlotDash::Dashed;
    data.plot.panels = {panel};
    data.checks = {{"R, TT and TRT miss at most (share of the light)", 1 - minThree, 0.12, 0.16},
                   {"the sum over all p is 1, off by at most", off, 0, 1e-4}};
    data.note =
        fmt::format("R, TT and TRT miss up to {:.1f}%, at θ_i = {:.1f}°.", 100 * (1 - minThree), minThreeAt);
    return data;
}

FigureData Deon06(const FigureOptions &) {
    DEonParameters parameters;
    parameters.sigmaA = {0, 0, 0};
    parameters.betaN = {25, 25, 25};
    FigureData data{Table({"detector", "phi_deg", "N_TT_per_rad"})};
    PlotPanel panel;
    panel.x = {.label = "φ (degrees)", .min = -180, .max = 180, .step = 60};
    panel.y = {.label = "N_{TT} (1/rad)", .min = 0};
    panel.legend = "top center";
    std::array<double, 2> atPi = {}, light = {};
    double mean = 0;
    for (const bool wrapped : {true, false}) {
        parameters.detector = wrapped ? AzimuthalDetector::Wrapped : AzimuthalDetector::Nearest;
        const DEonQuadrature<double> around(CheckedDEon(parameters));
        const auto fiber = around.At(std::cos(0.8));
        const auto n = [&](double phi) { return around.Value(1, fiber, phi).n[0]; };
        PlotSeries curve;
        curve.label = wrapped ? "Gaussian detector" : "Zinke and Weber 2007";
        curve.dash = wrapped ? PlotDash::Solid : PlotDash::Dashed;
        for (const double degrees : Linspace(-180, 180, 721)) {
            data.table.Add({wrapped ? "wrapped" : "nearest", degrees, n(degrees * kDegree)});
            curve.x.push_back(degrees), curve.y.push_back(n(degrees * kDegree));
        }
        panel.series.push_back(curve);
        atPi[wrapped] = curve.y.back();
        light[wrapped] = Integrate(-kPi<double>, kPi<double>, 4, n);
        if (wrapped)
            mean = Integrate(0, kPi<double> / 2, 4, [&](double gamma) {
                return std::cos(gamma) * fiber.Attenuation(1, gamma, {0, 0, 0}, SegmentLength::Chord)[0];
            });
    }
    data.plot.panels = {panel};
    data.checks = {
        {"at φ = π the older treatment has, of the detector's N_{TT},", atPi[0] / atPi[1], 0.4, 0.6},
        {"the detector holds all light of TT, off by", std::abs(light[1] / mean - 1), 0, 1e-3},
        {"the older treatment holds, of it,", light[0] / mean, 0.5, 0.99},
    };
    data.note = fmt::format("At φ = π that has {:.1f}% of the light, in all {:.1f}%.",
                            100 * atPi[0] / atPi[1], 100 * light[0] / mean);
    return data;
}

// B / R of N_TT at phi = pi, by other means than the model's: a plain sum over the width at normal incidence,
// from Snell's law, the chord and Fresnel's formulas, each ray blurred by a Gaussian with its two images.
// beta in degrees.
static double StraightOnBlueOverRed(const Spectrum &sigmaA, double beta) {
    const double eta = 1.55;
    const int rays = 100000;
    double red = 0, blue = 0;
    for (int i = 0; i < rays; ++i) {
        const double h = (2 * i + 1.) / rays - 1, gammaO = std::asin(h), gammaT = std::asin(h / eta);
        const double s = (std::cos(gammaO) - eta * std::cos(gammaT)) /
                         (std::cos(gammaO) + eta * std::cos(gammaT)),
                     p = (eta * std::cos(gammaO) - std::cos(gammaT)) /
                         (eta * std::cos(gammaO) + std::cos(gammaT));
        double detector = 0;
        for (const int turn : {-1, 0, 1})
            detector += std::exp(-Sqr((2 * (gammaO - gammaT) / kDegree + 360 * turn) / beta) / 2);
        const double weight = Sqr(1 - (s * s + p * p) / 2) * detector, chord = 2 * std::cos(gammaT);
        red += weight * std::exp(-double(sigmaA[0]) * chord),
            blue += weight * std::exp(-double(sigmaA[2]) * chord);
    }
    return blue / red;
}

FigureData Deon08(const FigureOptions &) {
    const Spectrum brown = HairBSDF::SigmaAFromConcentration(1.3f, 0);
    FigureData data{Table({"beta_deg", "phi_deg", "N_R", "N_G", "N_B"})};
    data.plot.width = 900, data.plot.height = 220;
    PlotPanel ratio;
    ratio.x = {.label = "φ (degrees)", .min = -180, .max = 180, .step = 60};
    ratio.y = {.label = "N_{TT}, B / R", .min = 0, .max = 0.2, .step = 0.05};
    ratio.legend = "bottom center";
    ratio.left = 0.1;
    std::array<double, 2> atPi = {};
    for (const bool rough : {false, true}) {
        DEonParameters parameters;
        parameters.sigmaA = brown.c;
        parameters.betaN.fill(rough ? 25.f : 0.5f);
        const DEonQuadrature<double> around(CheckedDEon(parameters));
        const auto fiber = around.At(1);
        PlotPanel strip;
        strip.kind = PlotKind::HeatMap;
        strip.x = {.label = "", .min = -180, .max = 180, .step = 60};
        strip.y.names = {{{0.5, rough ? "β = 25°" : "β = 0.5°"}}};
        strip.left = 0.1;
        PlotHeatMap &map = strip.heatMap;
        map.columns = 721, map.rows = 2, map.xMin = -180.25, map.xMax = 180.25;
        PlotSeries curve;
        curve.label = rough ? "β = 25°" : "β = 0.5°";
        for (const double degrees : Linspace(-180, 180, map.columns)) {
            const std::array<double, 3> n = around.Value(1, fiber, degrees * kDegree).n;
            data.table.Add({rough ? 25. : 0.5, degrees, n[0], n[1], n[2]});
            map.colors.emplace_back(static_cast<float>(n[0]), static_cast<float>(n[1]),
                                    static_cast<float>(n[2]));
            // Each column by itself, as bright as the others: the colour shows, and where there is no light
            // there is none.
            const double largest = *std::max_element(n.begin(), n.end());
            map.colors.back() *= largest > 1e-4 ? static_cast<float>(1 / largest) : 0.f;
            curve.x.push_back(degrees), curve.y.push_back(n[0] > 1e-4 ? n[2] / n[0] : NAN);
            if (degrees == 180)
                atPi[rough] = n[2] / n[0];
        }
        const std::vector<Spectrum> row = map.colors; // gnuplot draws no picture of one row
        map.colors.insert(map.colors.end(), row.begin(), row.end());
        ratio.series.push_back(curve);
        data.plot.panels.push_back(strip);
    }
    data.plot.panels.push_back(ratio);
    const double shift = StraightOnBlueOverRed(brown, 25) / StraightOnBlueOverRed(brown, 0.5);
    data.checks = {
        {"straight on (φ = π), B / R of the smooth fiber over that of light through its middle, exp(-2 (σ_B "
         "− "
         "σ_R))",
         atPi[0] / std::exp(-2 * (double(brown[2]) - double(brown[0]))), 0.999, 1.001},
        {"B / R of the rough one over that of a sum over its width",
         atPi[1] / StraightOnBlueOverRed(brown, 25), 0.999, 1.001},
        {"so the colour shifts toward blue, B / R growing by the factor", atPi[1] / atPi[0], shift * 0.999,
         shift * 1.001},
    };
    data.note =
        fmt::format("Straight on, B / R is {:.3f} smooth and {:.3f} rough. The paper shows brightness, too, "
                    "in which the shift is hard to see.",
                    atPi[0], atPi[1]);
    return data;
}

// Stripes of the pigments' colours over the thickness, at one share of pheomelanin below the other; unit in
// mm.
static PlotPanel PigmentStripes(const std::vector<double> &thicknesses, double unit) {
    PlotPanel panel;
    panel.kind = PlotKind::HeatMap;
    panel.x = {.label = "thickness", .min = 0, .max = thicknesses.back(), .step = 1};
    panel.y.names = {{{-0.15, "eumelanin: bands"},
                      {-0.05, "RGB"},
                      {0.5, "mixtures: bands"},
                      {1.05, "RGB"},
                      {1.15, "pheomelanin: bands"}}};
    panel.left = 0.2;
    PlotHeatMap &map = panel.heatMap;
    map.columns = thicknesses.size(), map.rows = 120;
    // Share of pheomelanin; rows from the top. The pure pigments have strips of their own above and below.
    map.xMax = thicknesses.back(), map.yMin = 1.2, map.yMax = -0.2;
    for (size_t row = 0; row < map.rows; ++row) {
        const double y = map.yMin + (static_cast<double>(row) + 0.5) * (map.yMax - map.yMin) / 120;
        const bool byRgb = (y < 0 && y > -0.1) || (y > 1 && y < 1.1);
        for (const double x : thicknesses) {
            const double share = std::clamp(y, 0., 1.);
            map.colors.push_back(byRgb ? RgbTransmission(x, share)
                                       : XYZToRGB(SpectralTransmission(x * unit, share)));
        }
    }
    return panel;
}

// The cross-sections' unit is not given; the one that fits the spectra best is found here: the smallest mean
// CIEDE2000 over thickness and both pigments.
FigureData Deon09(const FigureOptions &options) {
    const double thickest = 8;
    const std::vector<double> thicknesses = Linspace(0, thickest, options.quick ? 33 : 161);
    const auto meanDifference = [&](double mmOfUnit) {
        double sum = 0;
        for (const double x : thicknesses)
            sum += PigmentDifference(x, mmOfUnit, 0) + PigmentDifference(x, mmOfUnit, 1);
        return sum / (2 * static_cast<double>(thicknesses.size()));
    };
    const double unit = ArgMin(1 / 200., 1 / 20., meanDifference);

    FigureData data{Table({"pheomelanin_share", "thickness", "spectral_R", "spectral_G", "spectral_B",
                           "rgb_R", "rgb_G", "rgb_B", "CIEDE2000"})};
    data.plot.width = 900, data.plot.height = 380;
    PlotPanel difference;
    difference.x = {.label = "thickness", .min = 0, .max = thickest, .step = 1};
    difference.left = 0.2;
    difference.y = {.label = "CIEDE2000", .min = 0};
    difference.legend = "top left";
    double largest = 0;
    for (const double share : {0., 0.5, 1.}) {
        PlotSeries curve;
        curve.label = share == 0 ? "eumelanin" : share == 1 ? "pheomelanin" : "half of each";
        for (const double x : thicknesses) {
            const Spectrum bands = XYZToRGB(SpectralTransmission(x * unit, share)),
                           rgb = RgbTransmission(x, share);
            const double e = PigmentDifference(x, unit, share);
            data.table.Add({share, x, bands[0], bands[1], bands[2], rgb[0], rgb[1], rgb[2], e});
            curve.x.push_back(x), curve.y.push_back(e);
            largest = std::max(largest, e);
        }
        difference.series.push_back(curve);
    }
    data.plot.panels = {PigmentStripes(thicknesses, unit), difference};
    const double mean = meanDifference(unit);
    const Spectrum white = XYZToRGB(SpectralTransmission(0, 0));
    data.checks = {
        {"without pigment the bands give white, off by at most",
         std::max({std::abs(white[0] - 1), std::abs(white[1] - 1), std::abs(white[2] - 1)}), 0, 0.01},
        {"mean CIEDE2000 of spectral and RGB colours of pure pigments", mean, 0, 2.5},
        {"greatest CIEDE2000", largest, 0, 5},
    };
    data.note =
        fmt::format("The unit that fits best is {:.4f} mm of pure pigment: CIEDE2000 is then {:.1f} "
                    "in the mean and {:.1f} at most. The paper finds the edge difficult to notice; side by "
                    "side a difference of 1 is just noticed, so here it can be seen in places: its "
                    "thicknesses, and so its unit, are not printed.",
                    unit, mean, largest);
    return data;
}

} // namespace cuticle
