#include "figures/papers/fiber_plot.h"

#include <cmath>

namespace cuticle {

namespace {

const char *Label(GoniometerQuantity quantity) {
    return quantity == GoniometerQuantity::S ? "{/:Italic S} (1/sr)" : "{/:Italic p} (1/sr)";
}

// Sorts a curve around the fiber by phi - phi_i in [-pi, pi].
LobeSlice FromLight(const LobeSlice &slice, double phi) {
    const size_t n = slice.angle.size();
    std::vector<std::pair<double, size_t>> order(n);
    for (size_t i = 0; i < n; ++i)
        order[i] = {std::remainder(slice.angle[i] - phi, 2 * kPi<double>), i};
    std::sort(order.begin(), order.end());
    LobeSlice sorted;
    for (const auto &[angle, i] : order) {
        sorted.angle.push_back(angle);
        sorted.value.push_back(slice.value[i]);
        sorted.error.push_back(slice.error[i]);
    }
    return sorted;
}

double ThetaOfCut(const FiberLight &light, const GoniometerView &view) {
    return (view.plane == GoniometerPlane::Cone ? -light.theta : 0) + view.thetaOffset;
}

bool HoldsLight(const FiberHistogram &histogram, size_t c, size_t channel) {
    return c == histogram.Sum() || histogram.Albedo(c, channel) > 1e-6;
}

std::vector<PlotSeries> AllSeries(const FiberHistogram &histogram, const FiberLight &light,
                                  const GoniometerView &view) {
    std::vector<PlotSeries> all;
    for (size_t c = 0; c < histogram.Classes(); ++c) {
        if (!HoldsLight(histogram, c, view.channel))
            continue;
        PlotSeries s =
            LobeSeries(GoniometerSlice(histogram, light, view, c, view.channel), histogram.ClassName(c));
        s.color = c == histogram.Sum() ? kPlotColors - 1 : static_cast<int>(c);
        s.width = c == histogram.Sum() ? 1.2 : 1.8;
        s.dash = c == histogram.Sum() ? PlotDash::Dashed : PlotDash::Solid;
        all.push_back(s);
    }
    return all;
}

// The largest value of all curves, and three decades below a power of ten above it: what is worth seeing.
void SetDecades(const std::vector<PlotSeries> &series, PlotAxis *axis) {
    double largest = 0;
    for (const PlotSeries &s : series)
        for (const double v : s.y)
            largest = std::max(largest, v);
    if (!(largest > 0))
        largest = 1;
    axis->log = true;
    axis->max = std::pow(10, std::ceil(std::log10(largest) * 2) / 2);
    axis->min = *axis->max * 3e-4;
}

Plot CurvePlot(const FiberHistogram &histogram, const FiberLight &light, const GoniometerView &view) {
    const bool incidence = view.plane == GoniometerPlane::Incidence;
    PlotPanel curves;
    curves.series = AllSeries(histogram, light, view);
    curves.x.label = incidence ? "{/Symbol q}_o (degrees; beyond 90: 180 − {/Symbol q}_o, on the far side)"
                               : "{/Symbol f}_o − {/Symbol f}_i (degrees)";
    curves.x.min = incidence ? -90 : -180;
    curves.x.max = incidence ? 270 : 180;
    curves.x.step = incidence ? 45 : 60;
    curves.y.label = std::string(Label(view.quantity)) + " ± 1 standard error";
    curves.legend = "outside right";
    SetDecades(curves.series, &curves.y);
    if (incidence)
        curves.lines = {{true, -light.theta / kDegree, "−{/Symbol q}_i"},
                        {true, 180 + light.theta / kDegree, "−{/Symbol q}_i"}};

    PlotPanel polar = curves;
    polar.kind = PlotKind::Polar;
    polar.lines.clear();
    polar.legend = "off";
    polar.y.label = incidence ? "root left, tip right, light from above" : "light from the right";
    polar.polarZero = incidence ? 90 : 0;
    polar.clockwise = incidence;
    for (PlotSeries &s : polar.series)
        s.error.clear();
    Plot plot;
    plot.panels = {polar, curves};
    plot.columns = 2;
    plot.width = 640, plot.height = 520;
    return plot;
}

Plot HemispherePlot(const FiberHistogram &histogram, const GoniometerView &view) {
    Plot plot;
    const SphereCells &cells = histogram.Cells();
    // Rows of equal height in sin theta are drawn as rows of equal height in theta.
    const size_t rows = cells.rows;
    for (size_t c = 0; c < histogram.Classes(); ++c) {
        if (!HoldsLight(histogram, c, view.channel))
            continue;
        PlotPanel panel;
        panel.kind = PlotKind::HeatMap;
        panel.title = histogram.ClassName(c);
        PlotHeatMap &map = panel.heatMap;
        map.xMin = -180, map.xMax = 180, map.yMin = -90, map.yMax = 90;
        map.columns = cells.columns, map.rows = rows, map.log = true;
        map.label = Label(view.quantity);
        double largest = 0;
        for (size_t i = 0; i < rows; ++i) {
            const double theta =
                ((static_cast<double>(i) + 0.5) / static_cast<double>(rows) - 0.5) * kPi<double>;
            const double scale = view.quantity == GoniometerQuantity::S ? 1 / std::cos(theta) : 1;
            for (size_t j = 0; j < cells.columns; ++j) {
                map.values.push_back(scale * histogram.Density(c, view.channel, cells.RowOf(theta), j));
                largest = std::max(largest, map.values.back());
            }
        }
        map.max = largest > 0 ? largest : 1;
        map.min = *map.max * 1e-4;
        panel.x.label = "{/Symbol f}_o (degrees)", panel.x.step = 60;
        panel.y.label = "{/Symbol q}_o (degrees)", panel.y.step = 30;
        plot.panels.push_back(panel);
    }
    plot.columns = 2;
    plot.width = 600, plot.height = 380;
    return plot;
}

} // namespace

LobeSlice GoniometerSlice(const FiberHistogram &histogram, const FiberLight &light,
                          const GoniometerView &view, size_t c, size_t channel) {
    LobeSlice slice;
    if (view.plane == GoniometerPlane::Incidence)
        slice = histogram.IncidencePlane(c, channel, light.phi, view.halfWidth);
    else
        slice =
            FromLight(histogram.AroundPhi(c, channel, ThetaOfCut(light, view), view.halfWidth), light.phi);
    if (view.quantity == GoniometerQuantity::S)
        for (size_t i = 0; i < slice.angle.size(); ++i) {
            const double cosTheta = view.plane == GoniometerPlane::Incidence
                                        ? std::abs(std::cos(slice.angle[i]))
                                        : std::cos(ThetaOfCut(light, view));
            slice.value[i] /= cosTheta;
            slice.error[i] /= cosTheta;
        }
    return slice;
}

PlotSeries LobeSeries(const LobeSlice &slice, const std::string &label) {
    PlotSeries s;
    s.label = label;
    s.y = slice.value;
    s.error = slice.error;
    for (const double angle : slice.angle)
        s.x.push_back(angle / kDegree);
    return s;
}

Plot GoniometerPlot(const FiberHistogram &histogram, const FiberLight &light, const GoniometerView &view,
                    const std::string &title) {
    Plot plot = view.plane == GoniometerPlane::Hemisphere ? HemispherePlot(histogram, view)
                                                          : CurvePlot(histogram, light, view);
    plot.title = title;
    return plot;
}

} // namespace cuticle
