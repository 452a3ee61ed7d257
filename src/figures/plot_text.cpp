#include "figures/plot_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle::plot_text {

namespace {

constexpr std::array<int, 7> kMarkers = {7, 5, 9, 13, 6, 4, 2};

std::string LineStyle(const PlotSeries &s, size_t order) {
    constexpr std::array<const char *, 4> dashes = {"1", "(9,5)", "(2,4)", "(10,4,2,4)"};
    return ColorOf(s, order) + " lw " + Number(s.width) + " dt " + dashes[static_cast<size_t>(s.dash)];
}
std::string MarkerStyle(const PlotSeries &s, size_t order) {
    return fmt::format(" pt {} ps {}", kMarkers[Cycled(s.marker, order, kMarkers.size())],
                       s.mark.empty() ? 0.6 : 0.9);
}

// Rows "x y low high" of a series; a point that cannot be drawn becomes a gap.
std::string SeriesRows(const PlotSeries &s, const PlotPanel &panel) {
    std::string rows;
    for (size_t i = 0; i < s.x.size(); ++i) {
        const double x = s.x[i], y = s.y[i], e = s.error.empty() ? 0 : s.error[i];
        if (!std::isfinite(x) || !std::isfinite(y) || (panel.x.log && x <= 0) || (panel.y.log && y <= 0)) {
            rows += "\n";
            continue;
        }
        // On a logarithmic axis a bar that reaches 0 goes down to the edge of the plot.
        double low = y - e;
        if (panel.y.log && !(low > 0))
            low = panel.y.min ? std::min(*panel.y.min, y) : y * 1e-2;
        rows += fmt::format("{} {} {} {}\n", Number(x), Number(y), Number(low), Number(y + e));
    }
    return rows;
}

// Tics of a logarithmic axis, in brackets: 1, 2 and 5 times powers of ten; over more than two decades, where
// these would meet, 1 and 3 times.
std::string LogTics(double min, double max) {
    const std::vector<double> steps =
        max / min > 100 ? std::vector<double>{1, 3} : std::vector<double>{1, 2, 5};
    std::string tics;
    const int last = static_cast<int>(std::floor(std::log10(max)));
    for (int decade = static_cast<int>(std::floor(std::log10(min))); decade <= last; ++decade)
        for (const double step : steps)
            if (const double x = step * std::pow(10, decade); x >= min && x <= max)
                tics += (tics.empty() ? "(" : ", ") + Number(x);
    return tics.empty() ? "autofreq" : tics + ")";
}

std::string NamedTics(const std::vector<std::pair<double, std::string>> &names) {
    std::string tics;
    for (const auto &[at, name] : names)
        tics += (tics.empty() ? "" : ", ") + Quoted(name) + " " + Number(at);
    return "(" + tics + ")";
}

} // namespace

std::string Number(double v) { return std::isfinite(v) ? fmt::format("{:.9g}", v) : "NaN"; }

std::string Point(const std::array<double, 2> &p) { return Number(p[0]) + "," + Number(p[1]); }

std::string Quoted(const std::string &text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'')
            out += "''";
        else
            out += static_cast<unsigned char>(c) < 32 || c == 127 ? ' ' : c;
    }
    return out + "'";
}

std::string AxisRange(const PlotAxis &axis) {
    return "[" + (axis.min ? Number(*axis.min) : "*") + ":" + (axis.max ? Number(*axis.max) : "*") + "]";
}

std::string AxisText(const char *name, const PlotAxis &axis) {
    // Less than three decades: plain numbers.
    const bool plain = !axis.log || (axis.min && axis.max && *axis.max / *axis.min < 1e3);
    std::string text = std::string(axis.log ? "set" : "unset") + " logscale " + name + "\nset format " +
                       name +
                       (axis.exponents ? " '10^{%g}'\n"
                        : plain        ? " '%g'\n"
                                       : " '10^{%T}'\n");
    text += std::string("set ") + name + "range " + AxisRange(axis) + "\n";
    text += std::string("set ") + name + "tics nomirror out scale 0.6,0.3 " +
            (axis.names                                ? NamedTics(*axis.names)
             : !plain || (!axis.log && axis.step <= 0) ? "autofreq"
             : axis.log                                ? LogTics(*axis.min, *axis.max)
                                                       : Number(axis.step)) +
            "\n";
    text += std::string(axis.log && !plain ? "set m" : "unset m") + name + "tics\n";
    text += std::string("set ") + name + "label " + Quoted(axis.label) + "\n";
    return text;
}

const std::string kNoAxes =
    "set size ratio -1\nunset border\nunset grid\nunset logscale\nunset xtics\nunset ytics\n"
    "unset xlabel\nunset ylabel\n";

size_t Cycled(int chosen, size_t order, size_t count) {
    return (chosen < 0 ? order : static_cast<size_t>(chosen)) % count;
}
std::string ColorOf(const PlotSeries &s, size_t order) {
    return std::string(" lc rgb '") + kColors[Cycled(s.color, order, kColors.size())] + "'";
}
std::string LegendOf(const PlotSeries &s) {
    return s.label.empty() ? " notitle" : " title " + Quoted(s.label);
}

std::string With(const PlotSeries &s, size_t order) {
    switch (s.style) {
    case PlotStyle::Points:
        return "with points" + ColorOf(s, order) + MarkerStyle(s, order);
    case PlotStyle::LinePoints:
        return "with linespoints" + LineStyle(s, order) + MarkerStyle(s, order);
    case PlotStyle::Steps:
        return "with histeps" + LineStyle(s, order);
    case PlotStyle::Line:
    case PlotStyle::Band:
        break;
    }
    return "with lines" + LineStyle(s, order);
}

std::string Drawing::Block(const std::string &rows) {
    std::string name = fmt::format("$d{}", blocks++);
    data += name + " << EOD\n" + rows + "EOD\n";
    return name;
}

void Drawing::Add(const std::string &words) { plots += (plots.empty() ? "plot " : ", \\\n     ") + words; }

void Drawing::AddSeries(const PlotSeries &s, size_t order, const PlotPanel &panel) {
    const std::string name = Block(SeriesRows(s, panel));
    if (s.style == PlotStyle::Band)
        Add(name + " using 1:3:4 with filledcurves fs transparent solid 0.22 noborder" + ColorOf(s, order) +
            " notitle");
    else if (!s.error.empty())
        Add(name + " using 1:2:3:4 with yerrorbars pt 7 ps 0 lw 1" + ColorOf(s, order) + " notitle");
    Add(name + " using 1:2 " + With(s, order) + LegendOf(s));
    if (!s.mark.empty())
        Add(fmt::format("{} using 1:2:({}) with labels {} offset {},{} font ',10' tc rgb '{}' notitle", name,
                        Quoted(s.mark), s.markOffset[0] < 0 ? "right" : "left", Number(s.markOffset[0]),
                        Number(s.markOffset[1]), kColors[Cycled(s.color, order, kColors.size())]));
}

} // namespace cuticle::plot_text
