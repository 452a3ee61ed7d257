// The plots of Marschner and others (2003) that show their model.
#include "fibers/marschner.h"
#include "figures/papers/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

// The curves go all around the plane of the fiber and the light, as in figure 4: theta_r on the light's side,
// 180 degrees minus it beyond. The shift and the width of R are half of what figure 4's simulated fibers
// show, 8 and 5 degrees, since they are counted in theta_h. Table 1 would have -10 to -5 and 5 to 10.
FigureData Marschner10(const FigureOptions &) {
    FigureData data{Table({"theta_i_deg", "angle_deg", "S_red", "S_blue"})};
    data.plot.columns = 2, data.plot.width = 460, data.plot.height = 460;
    MarschnerParameters parameters;
    parameters.sigmaA = {0.126f, 0.209f, 0.411f}; // eumelanin 0.3
    parameters.alpha = {-4, 2, 6};
    parameters.beta = {2.5f, 1.25f, 5};
    parameters.kG = 0.5f;
    const Marschner<double> model(CheckedMarschner(parameters));
    double rMin = 90, rMax = -90, trtMin = 90;
    size_t lobes = 2;
    for (const double thetaI : {45., -45.}) {
        const Vector3d light(std::sin(thetaI * kDegree), std::cos(thetaI * kDegree), 0);
        PlotPanel panel;
        panel.kind = PlotKind::Polar;
        panel.title = thetaI > 0 ? "light from the tip's side (45°)" : "from the root's side (−45°)";
        panel.polarZero = 90, panel.clockwise = true;
        panel.y = {.label = "S (1/sr); root left, tip right", .log = true, .min = 1e-3};
        panel.legend = "below";
        PlotSeries red{.label = "red", .x = {}, .y = {}, .error = {}, .color = 1},
            blue{.label = "blue", .x = {}, .y = {}, .error = {}, .color = 0};
        for (const double angle : Linspace(-89.5, 269.5, 719)) {
            const double a = angle * kDegree;
            if (std::abs(std::cos(a)) < 0.01)
                continue; // along the fiber S is a quotient of two small numbers
            const std::array<double, 3> f = model.Evaluate(light, {std::sin(a), std::cos(a), 0}).fCos;
            const double s = f[0] / std::abs(std::cos(a)), b = f[2] / std::abs(std::cos(a));
            data.table.Add({thetaI, angle, s, b});
            red.x.push_back(angle), red.y.push_back(s);
            blue.x.push_back(angle), blue.y.push_back(b);
        }
        // The lobes on the light's side: where red light has its maxima.
        std::vector<double> peaks;
        for (size_t i = 1; i + 1 < red.x.size() && red.x[i] < 80; ++i)
            if (red.x[i] > -80 && red.y[i] > red.y[i - 1] && red.y[i] >= red.y[i + 1])
                peaks.push_back(red.x[i] + thetaI);
        if (peaks.size() == 2) {
            rMin = std::min(rMin, -peaks[0]), rMax = std::max(rMax, -peaks[0]);
            trtMin = std::min(trtMin, peaks[1]);
        } else {
            lobes = peaks.size();
        }
        panel.series = {red, blue};
        data.plot.panels.push_back(panel);
    }
    data.checks = {{"lobes on the light's side", static_cast<double>(lobes), 2, 2},
                   {"R lies toward the root of the specular direction, at least (degrees)", rMin, 6, 10},
                   {"and at most", rMax, 6, 10},
                   {"TRT lies toward the tip, at least (degrees)", trtMin, 3, 40}};
    data.note =
        fmt::format("R lies {:.1f}° to {:.1f}° toward the root, as figure 4 measures. The paper prints no "
                    "parameters; its Table 1 would have α_R from −10° to −5°, which puts R 10° to 20° "
                    "toward the root. Its lobe toward grazing is broader than ours: the model has M in "
                    "θ_h, here in the form that conserves energy.",
                    rMin, rMax);
    return data;
}

} // namespace cuticle
