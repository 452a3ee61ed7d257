// Polar diagrams. Circles and spokes are ours, so that they look the same with a logarithmic radius.
#include "core/error.h"
#include "core/vecmath.h"
#include "figures/plot_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle::plot_text {

namespace {

// Places for rings: 1, 2 or 5 times a power of ten apart, about count of them.
double NiceStep(double range, int count) {
    const double raw = range / count, power = std::pow(10, std::floor(std::log10(raw)));
    const double f = raw / power;
    return power * (f < 1.5 ? 1 : f < 3.5 ? 2 : f < 7.5 ? 5 : 10);
}

class PolarScale {
  public:
    explicit PolarScale(const PlotPanel &panel)
        : log_(panel.y.log), sign_(panel.clockwise ? -1 : 1), zero_(panel.polarZero) {
        double largest = 0;
        for (const PlotSeries &s : panel.series)
            for (size_t i = 0; i < s.y.size(); ++i)
                if (std::isfinite(s.y[i]))
                    largest = std::max(largest, s.y[i] + (s.error.empty() || log_ ? 0 : s.error[i]));
        if (!(largest > 0))
            largest = 1;
        max_ = panel.y.max.value_or(log_ ? std::pow(10, std::ceil(std::log10(largest) - 1e-9)) : largest);
        min_ = panel.y.min.value_or(log_ ? max_ * 1e-3 : 0);
        if (!(min_ < max_))
            throw Error("the radius of a polar plot must reach from below its largest value");
        step_ = log_ ? std::max(1., std::round(std::log10(max_ / min_) / 4))
                     : (panel.y.step > 0 ? panel.y.step : NiceStep(max_ - min_, 4));
        if (!log_ && !panel.y.max)
            max_ = min_ + step_ * std::ceil((max_ - min_) / step_ - 1e-9);
    }
    // In [0, 1], or NaN where there is nothing to draw; beyond the ends: the ends.
    double Radius(double r) const {
        if (!std::isfinite(r) || (log_ && r <= 0))
            return NAN;
        const double t = log_ ? std::log(r / min_) / std::log(max_ / min_) : (r - min_) / (max_ - min_);
        return std::clamp(t, 0., 1.);
    }
    double Direction(double degrees) const { return zero_ + sign_ * degrees; }
    std::array<double, 2> At(double degrees, double radius) const {
        const double a = Direction(degrees) * kPi<double> / 180;
        return {radius * std::cos(a), radius * std::sin(a)};
    }
    std::vector<double> Rings() const {
        std::vector<double> rings;
        const double first = std::ceil(std::log10(min_) - 1e-9);
        if (log_)
            for (int i = 0; first + i * step_ <= std::log10(max_) + 1e-9; ++i)
                rings.push_back(std::pow(10, first + i * step_));
        else
            for (int i = 0; min_ + i * step_ <= max_ * (1 + 1e-9); ++i)
                rings.push_back(min_ + i * step_);
        return rings;
    }

  private:
    bool log_;
    double sign_, zero_, min_ = 0, max_ = 1, step_ = 1;
};

// The rectangle around the sector that is shown, in units of the radius: low x, low y, high x, high y.
std::array<double, 4> PolarBounds(const PlotPanel &panel, const PolarScale &scale) {
    std::array<double, 4> box = {0, 0, 0, 0};
    for (int i = 0; panel.polarFirst + i <= panel.polarLast; ++i) {
        const auto p = scale.At(panel.polarFirst + i, 1);
        box = {std::min(box[0], p[0]), std::min(box[1], p[1]), std::max(box[2], p[0]),
               std::max(box[3], p[1])};
    }
    return box;
}

std::string PolarGrid(const PlotPanel &panel, const PolarScale &scale) {
    const bool full = panel.polarLast - panel.polarFirst >= 360;
    const double step = panel.polarLast - panel.polarFirst <= 90 ? 15 : 30;
    std::string text;
    const double first = step * std::ceil(panel.polarFirst / step);
    const int spokes = static_cast<int>(std::floor((panel.polarLast - first) / step)) + (full ? 0 : 1);
    for (int i = 0; i < spokes; ++i) {
        const double degrees = first + i * step;
        text += "set arrow from 0,0 to " + Point(scale.At(degrees, 1)) + " nohead back lw 1 lc rgb '" +
                kGrid + "'\n";
        auto at = scale.At(degrees, full ? 1.06 : 1.03);
        at[1] *= full ? 1.03 : 1.015; // letters are taller than the gap
        const char *align = at[0] > 0.2 ? "left" : at[0] < -0.2 ? "right" : "center";
        text += "set label " + Quoted(Number(degrees == -180 ? 180 : degrees) + "°") + " at " + Point(at) +
                " " + align + " font ',11' textcolor rgb '" + kInk + "'\n";
    }
    // Angles of arcs count from the right, upward.
    const std::array<double, 2> ends = {scale.Direction(panel.polarFirst), scale.Direction(panel.polarLast)};
    const std::string arc = full ? ""
                                 : " arc [" + Number(std::min(ends[0], ends[1])) + ":" +
                                       Number(std::max(ends[0], ends[1])) + "] nowedge";
    for (const double ring : scale.Rings()) {
        const double r = scale.Radius(ring);
        if (r <= 0)
            continue;
        text += "set object circle at 0,0 size " + Number(r) + arc + " back fs empty border lc rgb '" +
                (r > 1 - 1e-9 ? kFaint : kGrid) + "' lw 1\n";
        // Beside the first spoke of a sector; else where no spoke is.
        auto at = scale.At(full ? 105 : panel.polarFirst, r);
        if (!full)
            at[1] -= 0.025;
        text += "set label " + Quoted(fmt::format("{:.3g}", ring)) + " at " + Point(at) +
                " center font ',9' textcolor rgb '" + kFaint + "' front\n";
    }
    if (!panel.y.label.empty()) {
        const auto box = PolarBounds(panel, scale);
        text += "set label " + Quoted(panel.y.label) + " at " + Number((box[0] + box[2]) / 2) + "," +
                Number(box[1] - (full ? 0.22 : 0.07)) + " center textcolor rgb '" + kInk + "'\n";
    }
    return text;
}

} // namespace

std::string PolarText(const PlotPanel &panel) {
    const PolarScale scale(panel);
    Drawing drawing;
    for (size_t i = 0; i < panel.series.size(); ++i) {
        const PlotSeries &s = panel.series[i];
        std::string line, bars;
        for (size_t k = 0; k < s.x.size(); ++k) {
            const double r = scale.Radius(s.y[k]);
            if (!std::isfinite(r)) {
                line += "\n";
                continue;
            }
            const auto p = scale.At(s.x[k], r);
            line += Number(p[0]) + " " + Number(p[1]) + "\n";
            if (s.error.empty())
                continue;
            const double low = scale.Radius(s.y[k] - s.error[k]), high = scale.Radius(s.y[k] + s.error[k]);
            for (const double end : {std::isfinite(low) ? low : 0, high}) {
                const auto q = scale.At(s.x[k], end);
                bars += Number(q[0]) + " " + Number(q[1]) + "\n";
            }
            bars += "\n";
        }
        if (!bars.empty())
            drawing.Add(drawing.Block(bars) + " using 1:2 with lines lw 1" + ColorOf(s, i) + " notitle");
        PlotSeries drawn = s;
        if (s.style == PlotStyle::Steps)
            drawn.style = PlotStyle::Line;
        drawing.Add(drawing.Block(line) + " using 1:2 " + With(drawn, i) + LegendOf(s));
    }
    const auto box = PolarBounds(panel, scale);
    const double edge = panel.polarLast - panel.polarFirst >= 360 ? 0.2 : 0.1;
    const std::string ranges = "set xrange [" + Number(box[0] - edge) + ":" + Number(box[2] + edge) +
                               "]\nset yrange [" + Number(box[1] - edge) + ":" + Number(box[3] + edge) +
                               "]\n";
    return kNoAxes + ranges + PolarGrid(panel, scale) + drawing.data + drawing.plots + "\nset size noratio\n";
}

} // namespace cuticle::plot_text
