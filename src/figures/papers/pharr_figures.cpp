// The plots of Pharr's "The Implementation of a Hair Scattering Model" (2016).
#include "core/quadrature.h"
#include "fibers/mp.h"
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"
#include "figures/papers/paper_figures.h"

#include <fmt/format.h>

#include <cmath>

namespace cuticle {

FigureData Pharr1_9(const FigureOptions &) {
    const double v = 0.02;
    FigureData data{Table({"theta_o_rad", "theta_i_rad", "M_per_sr"})};
    data.plot.width = 380, data.plot.height = 320, data.plot.columns = 3;
    for (const double thetaO : {-1., -1.3, -1.4}) {
        const auto m = [&](double thetaI) {
            return Mp(std::cos(thetaI), std::cos(thetaO), std::sin(thetaI), std::sin(thetaO), v);
        };
        PlotPanel panel;
        panel.title = fmt::format("θ_o = {:g} rad", thetaO);
        panel.x = {.label = "θ_i (rad)", .min = 0, .max = kPi<double> / 2, .step = 0.5};
        panel.y = {.label = "M_p (1/sr)", .min = 0};
        PlotSeries curve;
        double peak = 0;
        for (const double thetaI : Linspace(-kPi<double> / 2, kPi<double> / 2, 3142)) {
            data.table.Add({thetaO, thetaI, m(thetaI)});
            curve.x.push_back(thetaI), curve.y.push_back(m(thetaI));
            if (m(thetaI) > m(peak))
                peak = thetaI;
        }
        panel.series = {curve};
        PlotSeries specular{.label = "", .x = {-thetaO, -thetaO}, .y = {0, m(peak)}, .error = {}, .color = 7};
        specular.dash = PlotDash::Dashed, specular.width = 1.5;
        panel.series.push_back(specular);
        data.plot.panels.push_back(panel);
        const GaussLegendreRule &rule = GaussLegendre(64);
        double mass = 0;
        for (size_t i = 0; i < rule.x.size(); ++i) {
            const double theta = kPi<double> / 2 * rule.x[i];
            mass += kPi<double> / 2 * rule.w[i] * m(theta) * std::cos(theta);
        }
        data.checks.push_back({fmt::format("for θ_o = {:g} rad M_p peaks beyond -θ_o, by (rad)", thetaO),
                               peak + thetaO, 1e-3, kPi<double> / 2 + thetaO});
        data.checks.push_back({fmt::format("for θ_o = {:g} rad the integral of M_p cos θ_i is", thetaO), mass,
                               1 - 1e-9, 1 + 1e-9});
        data.note +=
            fmt::format("{}{:.3f}", data.note.empty() ? "The peaks lie beyond it by " : ", ", peak + thetaO);
    }
    data.note += " rad.";
    return data;
}

FigureData Pharr1_15(const FigureOptions &) {
    const double eta = 1.55;
    FigureData data{Table({"theta_o_deg", "h", "phi_deg"})};
    PlotPanel panel;
    panel.x = {.label = "h", .min = -1, .max = 1, .step = 0.5};
    panel.y = {.label = "Φ(1, h) (degrees)", .min = 0, .max = 360, .step = 60};
    // eta' = 2 here
    const double inclined = std::acos(std::sqrt((Sqr(eta) - 1) / 3));
    std::array<double, 2> cover = {};
    for (const double thetaO : {0., inclined}) {
        const SmoothFiber<double> fiber(std::cos(thetaO), eta);
        PlotSeries curve;
        curve.label = fmt::format("θ_o = {:.1f}°, η' = {:.2f}", Degrees(thetaO), fiber.etaPrime);
        curve.dash = thetaO > 0 ? PlotDash::Dashed : PlotDash::Solid;
        for (const double h : Linspace(-1, 1, 801)) {
            const double phi = Degrees(fiber.Phi(1, std::asin(h)));
            data.table.Add({Degrees(thetaO), h, phi});
            curve.x.push_back(h), curve.y.push_back(phi);
        }
        cover[thetaO > 0] = (curve.y.front() - curve.y.back()) / 360;
        panel.series.push_back(curve);
    }
    data.plot.panels = {panel};
    // Phi(1, -1) - Phi(1, 1) = 2 pi - 4 asin(1 / eta')
    const double exact = 1 - 2 * std::asin(1 / eta) / kPi<double>;
    data.checks = {
        {"the share of the circle that TT covers at θ_o = 0 is 1 - 2 asin(1/η) / π, off by",
         std::abs(cover[0] - exact), 0, 1e-12},
        {"the share of the circle that TT covers at η' = 2", cover[1], 2 / 3. - 1e-9, 2 / 3. + 1e-9}};
    data.note = fmt::format("The paper reads from it that TT covers roughly 2/3 of the circle: at normal "
                            "incidence it is {:.1f}%, and 2/3 where η' = 2, at θ_o = {:.1f}° (dashed).",
                            100 * cover[0], Degrees(inclined));
    return data;
}

FigureData Pharr1_16(const FigureOptions &) {
    FigureData data{Table({"s_rad", "x_rad", "density_per_rad"})};
    PlotPanel panel;
    panel.x = {.label = "x (rad)", .min = -kPi<double>, .max = kPi<double>, .step = 1};
    panel.y = {.label = "l_t(x, s, [-π, π]) (1/rad)", .min = 0};
    for (const double s : {0.5, 0.1}) {
        const auto density = [s](double x) { return TrimmedLogistic(x, s, -kPi<double>, kPi<double>); };
        PlotSeries curve;
        curve.label = fmt::format("s = {:g}", s);
        curve.dash = s < 0.5 ? PlotDash::Dashed : PlotDash::Solid;
        for (const double x : Linspace(-kPi<double>, kPi<double>, 1257)) {
            data.table.Add({s, x, density(x)});
            curve.x.push_back(x), curve.y.push_back(density(x));
        }
        panel.series.push_back(curve);
        // Even, and kinked nowhere: one rule for [0, pi].
        const GaussLegendreRule &rule = GaussLegendre(64);
        double mass = 0;
        for (size_t i = 0; i < rule.x.size(); ++i)
            mass += kPi<double> * rule.w[i] * density(kPi<double> / 2 * (1 + rule.x[i]));
        data.checks.push_back(
            {fmt::format("for s = {:g} the integral over ±π is", s), mass, 1 - 1e-9, 1 + 1e-9});
    }
    data.plot.panels = {panel};
    return data;
}

FigureData Pharr1_17(const FigureOptions &) {
    const double eta = 1.55, s = AzimuthalScale(0.1);
    FigureData data{Table({"h", "phi_deg", "N_per_rad"})};
    data.plot.columns = 2, data.plot.width = 420, data.plot.height = 430;
    const SmoothFiber<double> fiber(1, eta);
    for (const double h : {-0.5, 0.3}) {
        const double gammaO = std::asin(h), gammaT = fiber.GammaT(h),
                     center = WrapAngle(fiber.Phi(1, gammaO));
        PlotPanel panel;
        panel.kind = PlotKind::Polar;
        panel.title = fmt::format("h = {:g}", h);
        panel.y.label = "N_1 (1/rad)";
        PlotSeries curve;
        double mass = 0, peak = 0;
        // An odd number of points puts none on the turn's seam twice.
        const size_t n = 7200;
        for (size_t i = 0; i <= n; ++i) {
            const double phi = kPi<double> * (2 * static_cast<double>(i) / n - 1);
            const double value = Np(phi, 1, s, gammaO, gammaT);
            data.table.Add({h, Degrees(phi), value});
            curve.x.push_back(Degrees(phi)), curve.y.push_back(value);
            mass += i < n ? value * 2 * kPi<double> / n : 0;
            if (value > Np(peak, 1, s, gammaO, gammaT))
                peak = phi;
        }
        panel.series = {curve};
        data.plot.panels.push_back(panel);
        data.checks.push_back(
            {fmt::format("for h = {:g} the integral around the fiber is", h), mass, 1 - 1e-6, 1 + 1e-6});
        data.checks.push_back({fmt::format("for h = {:g} the peak is off Φ(1, h) by (degrees)", h),
                               std::abs(Degrees(WrapAngle(peak - center))), 0, 0.05});
        data.note += fmt::format("{}{:.1f}°", data.note.empty() ? "The peaks lie at Φ(1, h) = " : " and ",
                                 Degrees(center));
    }
    data.note += ".";
    return data;
}

} // namespace cuticle
