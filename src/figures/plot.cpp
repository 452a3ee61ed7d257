#include "figures/plot.h"

#include "core/error.h"
#include "files/file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numbers>
#include <spawn.h>
#include <string_view>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

namespace cuticle {

namespace {

constexpr std::array<const char *, kPlotColors> kColors = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                           "#E69F00", "#56B4E9", "#7A6A00", "#222222"};
constexpr std::array<int, 7> kMarkers = {7, 5, 9, 13, 6, 4, 2};
constexpr const char *kInk = "#333333", *kGrid = "#E4E4E4", *kFaint = "#8A8A8A";
// Viridis (Smith and van der Walt 2015), eight of its colours: even steps of lightness.
constexpr const char *kHeatColors = "0 '#440154', 1 '#46327e', 2 '#365c8d', 3 '#277f8e', 4 '#1fa187', "
                                    "5 '#4ac16d', 6 '#a0da39', 7 '#fde725'";

std::string Number(double v) {
    if (!std::isfinite(v))
        return "NaN";
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", v);
    return text;
}

// A string in single quotes: gnuplot substitutes nothing inside it; a quote is written twice.
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

void CheckAxis(const PlotAxis &axis) {
    if ((axis.min && !std::isfinite(*axis.min)) || (axis.max && !std::isfinite(*axis.max)) ||
        (axis.min && axis.max && !(*axis.min < *axis.max)))
        throw Error("a plot's axis \"" + axis.label + "\" has an empty range; min must be below max");
    if (axis.log && ((axis.min && *axis.min <= 0) || (axis.max && *axis.max <= 0)))
        throw Error("a plot's logarithmic axis \"" + axis.label + "\" must begin above 0");
}

void CheckPanel(const PlotPanel &panel) {
    CheckAxis(panel.x);
    CheckAxis(panel.y);
    for (const PlotSeries &s : panel.series)
        if (s.x.size() != s.y.size() || (!s.error.empty() && s.error.size() != s.y.size()))
            throw Error("the plotted series \"" + s.label + "\" has " + std::to_string(s.x.size()) + " x, " +
                        std::to_string(s.y.size()) + " y and " + std::to_string(s.error.size()) + " errors");
    if (!(panel.polarFirst < panel.polarLast && panel.polarLast <= panel.polarFirst + 360))
        throw Error("the sector of a polar plot must be 0 to 360 degrees wide");
    if (panel.kind == PlotKind::HeatMap) {
        const PlotHeatMap &map = panel.heatMap;
        if (map.columns == 0 || map.rows == 0 ||
            (map.colors.empty() ? map.values.size() : map.colors.size()) != map.columns * map.rows)
            throw Error("a heat map of " + std::to_string(map.columns) + " columns and " +
                        std::to_string(map.rows) + " rows has " + std::to_string(map.values.size()) +
                        " values");
    } else if (panel.series.empty()) {
        throw Error("a plot's panel \"" + panel.title + "\" has no series");
    }
}

size_t Cycled(int chosen, size_t order, size_t count) {
    return (chosen < 0 ? order : static_cast<size_t>(chosen)) % count;
}
std::string ColorOf(const PlotSeries &s, size_t order) {
    return std::string(" lc rgb '") + kColors[Cycled(s.color, order, kColors.size())] + "'";
}
std::string LineStyle(const PlotSeries &s, size_t order) {
    constexpr std::array<const char *, 4> dashes = {"1", "(9,5)", "(2,4)", "(10,4,2,4)"};
    return ColorOf(s, order) + " lw " + Number(s.width) + " dt " + dashes[static_cast<size_t>(s.dash)];
}
std::string MarkerStyle(const PlotSeries &s, size_t order) {
    return " pt " + std::to_string(kMarkers[Cycled(s.marker, order, kMarkers.size())]) +
           (s.mark.empty() ? " ps 0.6" : " ps 0.9");
}

std::string LegendOf(const PlotSeries &s) {
    return s.label.empty() ? " notitle" : " title " + Quoted(s.label);
}

// The data of a panel, each series under a name of its own, and the words that plot them.
struct Drawing {
    std::string data, plots;
    int blocks = 0;

    std::string Block(const std::string &rows) {
        std::string name = "$d" + std::to_string(blocks++);
        data += name + " << EOD\n" + rows + "EOD\n";
        return name;
    }
    void Add(const std::string &words) { plots += (plots.empty() ? "plot " : ", \\\n     ") + words; }
};

// x y low high; a point that cannot be drawn becomes a gap.
std::string Rows(const PlotSeries &s, const PlotPanel &panel) {
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
        rows += Number(x) + " " + Number(y) + " " + Number(low) + " " + Number(y + e) + "\n";
    }
    return rows;
}

// The way of drawing that gnuplot calls "with", for lines and points, and their looks.
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

void AddSeries(const PlotSeries &s, size_t order, const std::string &rows, Drawing *drawing) {
    const std::string name = drawing->Block(rows);
    if (s.style == PlotStyle::Band)
        drawing->Add(name + " using 1:3:4 with filledcurves fs transparent solid 0.22 noborder" +
                     ColorOf(s, order) + " notitle");
    else if (!s.error.empty())
        drawing->Add(name + " using 1:2:3:4 with yerrorbars pt 7 ps 0 lw 1" + ColorOf(s, order) + " notitle");
    drawing->Add(name + " using 1:2 " + With(s, order) + LegendOf(s));
    if (!s.mark.empty())
        drawing->Add(name + " using 1:2:(" + Quoted(s.mark) +
                     ") with labels left offset 0.7,0.4 font ',10' tc rgb '" +
                     kColors[Cycled(s.color, order, kColors.size())] + "' notitle");
}

// The numbers 1, 2 and 5 (over more than two decades, where they would meet, 1 and 3) times powers of ten on a logarithmic
// axis, in brackets.
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

std::string ReferenceLines(const PlotPanel &panel) {
    std::string text;
    for (const PlotReferenceLine &line : panel.lines) {
        const std::string at = Number(line.at);
        const std::string from = line.vertical ? at + ", graph 0" : "graph 0, first " + at;
        const std::string to = line.vertical ? at + ", graph 1" : "graph 1, first " + at;
        text.append("set arrow from first ").append(from).append(" to first ").append(to);
        text.append(" nohead back lw 1 dt (5,4) lc rgb '").append(kFaint).append("'\n");
        if (!line.label.empty())
            text += "set label " + Quoted(line.label) + " at " +
                    (line.vertical ? "first " + at + ", graph 0.97 rotate by 90 right offset 0.8,0"
                                   : "graph 0.99, first " + at + " right offset 0,0.5") +
                    " font ',10' textcolor rgb '" + kFaint + "' front\n";
    }
    // "graph 0, first y" and "x, graph 1" carry their own words; "first" before "graph" would be an error.
    for (size_t at = 0; (at = text.find("first graph", at)) != std::string::npos;)
        text.erase(at, 6);
    return text;
}

// For pictures in which both directions have one scale.
const std::string kNoAxes =
    "set size ratio -1\nunset border\nunset grid\nunset logscale\nunset xtics\nunset ytics\n"
    "unset xlabel\nunset ylabel\n";

std::string CartesianText(const PlotPanel &panel) {
    Drawing drawing;
    for (size_t i = 0; i < panel.series.size(); ++i)
        AddSeries(panel.series[i], i, Rows(panel.series[i], panel), &drawing);
    return std::string("set border 3 lw 1 lc rgb '") + kInk + "'\nset grid back lw 1 lt 1 lc rgb '" + kGrid +
           "'\n" + AxisText("x", panel.x) + AxisText("y", panel.y) + ReferenceLines(panel) + drawing.data +
           drawing.plots + "\n";
}

std::string HeatMapText(const PlotPanel &panel) {
    const PlotHeatMap &map = panel.heatMap;
    const double dx = (map.xMax - map.xMin) / static_cast<double>(map.columns);
    const double dy = (map.yMax - map.yMin) / static_cast<double>(map.rows);
    std::string rows;
    for (size_t j = 0; j < map.rows; ++j)
        for (size_t i = 0; i < map.columns; ++i) {
            rows += Number(map.xMin + (static_cast<double>(i) + 0.5) * dx) + " " +
                    Number(map.yMin + (static_cast<double>(j) + 0.5) * dy);
            if (map.colors.empty()) {
                const double v = map.values[j * map.columns + i];
                rows += " " + Number(map.log && !(v > 0) ? NAN : v);
            } else {
                for (const float c : map.colors[j * map.columns + i].c)
                    rows += " " + Number(std::round(255 * LinearToSRGB(std::clamp(c, 0.f, 1.f))));
            }
            rows += "\n";
        }
    Drawing drawing;
    drawing.Add(drawing.Block(rows) + (map.colors.empty() ? " using 1:2:3 with image notitle"
                                                          : " using 1:2:3:4:5 with rgbimage notitle"));
    for (size_t i = 0; i < panel.series.size(); ++i)
        AddSeries(panel.series[i], i, Rows(panel.series[i], panel), &drawing);
    PlotAxis x = panel.x, y = panel.y, color;
    x.min = map.xMin, x.max = map.xMax, y.min = map.yMin, y.max = map.yMax;
    color.log = map.log, color.min = map.min, color.max = map.max, color.label = map.label;
    return std::string("set border 15 lw 1 lc rgb '") + kInk + "'\nunset grid\nset palette defined (" +
           kHeatColors + ")\n" + (map.colors.empty() ? "set colorbox\n" : "unset colorbox\n") +
           AxisText("x", x) + AxisText("y", y) + AxisText("cb", color) + ReferenceLines(panel) +
           drawing.data + drawing.plots + "\n";
}

// --- polar: circles and spokes are ours, so that they look the same with a logarithmic radius ----------------------

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
        const double a = Direction(degrees) * std::numbers::pi / 180;
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

std::string Point(const std::array<double, 2> &p) { return Number(p[0]) + "," + Number(p[1]); }

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
        char value[24];
        std::snprintf(value, sizeof value, "%.3g", ring);
        // Beside the first spoke of a sector; else where no spoke is.
        auto at = scale.At(full ? 105 : panel.polarFirst, r);
        if (!full)
            at[1] -= 0.025;
        text += "set label " + Quoted(value) + " at " + Point(at) + " center font ',9' textcolor rgb '" +
                kFaint + "' front\n";
    }
    if (!panel.y.label.empty()) {
        const auto box = PolarBounds(panel, scale);
        text += "set label " + Quoted(panel.y.label) + " at " + Number((box[0] + box[2]) / 2) + "," +
                Number(box[1] - (full ? 0.22 : 0.07)) + " center textcolor rgb '" + kInk + "'\n";
    }
    return text;
}

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

std::string DiagramText(const PlotPanel &panel) {
    if (!panel.x.min || !panel.x.max || !panel.y.min || !panel.y.max)
        throw Error("a diagram needs the ranges of x and y");
    Drawing drawing;
    for (size_t i = 0; i < panel.series.size(); ++i)
        AddSeries(panel.series[i], i, Rows(panel.series[i], panel), &drawing);
    return kNoAxes + "set xrange " + AxisRange(panel.x) + "\nset yrange " + AxisRange(panel.y) + "\n" +
           drawing.data + drawing.plots + "\nset size noratio\n";
}

// The words of a legend's place come from a program, not from a user; anything else would be a mistake in it.
std::string LegendPlace(const std::string &words) {
    for (const char c : words)
        if (!(c == ' ' || (c >= 'a' && c <= 'z')))
            throw Error("a legend's place \"" + words + "\" must be words like \"top right\"");
    return words;
}

// besides: words for what is drawn with the panel, outside of it.
std::string PanelText(const PlotPanel &panel, const std::string &besides) {
    CheckPanel(panel);
    std::string text =
        "unset arrow\nunset label\nunset object\nunset colorbox\n" + besides + "set title " +
        Quoted(panel.title) + "\nset key " +
        (panel.right > 0 ? "at graph 1.02, graph 1.03 left top maxrows 60" : LegendPlace(panel.legend)) +
        " Left reverse spacing 1.15 samplen 2.2\n";
    switch (panel.kind) {
    case PlotKind::Cartesian:
        return text + CartesianText(panel);
    case PlotKind::Polar:
        return text + PolarText(panel);
    case PlotKind::HeatMap:
        return text + HeatMapText(panel);
    case PlotKind::Diagram:
        return text + DiagramText(panel);
    }
    return text;
}

// Heights of the title and of a line of the caption, and the caption's distance from the edges, in pixels.
constexpr int kTitleHeight = 40, kCaptionLine = 18, kCaptionMargin = 16;

// Breaks a text at its blanks into lines of at most `most` letters (longer words stay whole). Marks of the enhanced
// notation count as letters.
std::vector<std::string> Lines(const std::string &text, int most) {
    std::vector<std::string> lines;
    int letters = 0;
    for (size_t at = 0; at < text.size();) {
        size_t end = std::min(text.find(' ', at), text.size());
        const std::string word = text.substr(at, end - at);
        // Bytes that continue a letter of UTF-8 begin with the bits 10.
        const auto length = static_cast<int>(std::count_if(
            word.begin(), word.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
        if (lines.empty() || letters + 1 + length > most)
            lines.push_back(word), letters = length;
        else
            lines.back() += " " + word, letters += 1 + length;
        at = end + 1;
    }
    return lines;
}

// --- running gnuplot -------------------------------------------------------------------------------------------

struct CloseFile {
    void operator()(std::FILE *f) const { std::fclose(f); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

TemporaryFile MakeTemporaryFile() {
    TemporaryFile file(std::tmpfile());
    if (!file)
        throw Error(std::string("cannot make a temporary file for a plot: ") + std::strerror(errno));
    return file;
}

std::string Contents(std::FILE *file) {
    std::string text;
    std::rewind(file);
    std::array<char, 65536> buffer;
    for (size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), file)) > 0;)
        text.append(buffer.data(), n);
    return text;
}

// Runs gnuplot on a program text and returns what it draws. No shell, no start-up files; text, drawing and complaints
// go through unnamed files, so that neither side ever waits for the other.
std::string RunGnuplot(const std::string &text) {
    const TemporaryFile in = MakeTemporaryFile(), out = MakeTemporaryFile(), complaints = MakeTemporaryFile();
    if (std::fwrite(text.data(), 1, text.size(), in.get()) != text.size() || std::fflush(in.get()) != 0)
        throw Error(std::string("cannot hand a plot to gnuplot: ") + std::strerror(errno));
    std::rewind(in.get());

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(complaints.get()), STDERR_FILENO);
    std::string program = "gnuplot", noDefaults = "-d";
    const std::array<char *, 3> words = {program.data(), noDefaults.data(), nullptr};
    pid_t child = 0;
    const int failure = posix_spawnp(&child, "gnuplot", &actions, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        throw Error(
            std::string("cannot run gnuplot, which draws plots (Debian: apt-get install gnuplot-nox): ") +
            std::strerror(failure));
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            throw Error(std::string("lost sight of gnuplot: ") + std::strerror(errno));
    std::string drawing = Contents(out.get());
    const std::string said = Contents(complaints.get());
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || drawing.empty())
        throw Error("gnuplot could not draw the plot: " + (said.empty() ? "it said nothing" : said));
    return drawing;
}

std::string TerminalOf(const std::string &filename) {
    for (const char *ending : {"svg", "png", "pdf"})
        if (filename.ends_with(std::string(".") + ending))
            return ending;
    throw Error("the plot's name \"" + filename + "\" must end in .svg, .png or .pdf");
}

} // namespace

std::string PlainText(const std::string &text) {
    std::string out;
    for (const char c : text) {
        if (std::strchr("\\{}_^@&~", c) != nullptr && c != '\0')
            out += '\\';
        out += c;
    }
    return out;
}

std::string GnuplotText(const Plot &plot, const std::string &terminal) {
    if (plot.panels.empty() || plot.columns < 1 || plot.width < 100 || plot.height < 100)
        throw Error("a plot needs a panel, a column and at least 100 x 100 pixels");
    const int columns = std::min(plot.columns, static_cast<int>(plot.panels.size()));
    const int rows = (static_cast<int>(plot.panels.size()) + columns - 1) / columns;
    const int width = columns * plot.width;
    const std::vector<std::string> caption = Lines(plot.caption, (width - 2 * kCaptionMargin) * 2 / 13);
    const int captionHeight =
        caption.empty() ? 0 : static_cast<int>(caption.size()) * kCaptionLine + kCaptionMargin;
    const int height = rows * plot.height + captionHeight + (plot.title.empty() ? 0 : kTitleHeight);
    const std::string font = "font 'DejaVu Sans,12'";
    std::string text;
    if (terminal == "svg")
        text = "set terminal svg enhanced size " + std::to_string(width) + "," + std::to_string(height) +
               " " + font + " background rgb 'white'\n";
    else if (terminal == "png") // twice the pixels, and everything twice as large
        text = "set terminal pngcairo enhanced size " + std::to_string(2 * width) + "," +
               std::to_string(2 * height) + " fontscale 2 linewidth 2 pointscale 2 " + font +
               " background rgb 'white'\n";
    else // 96 pixels to the inch
        text = "set terminal pdfcairo enhanced size " + Number(width / 96.) + "," + Number(height / 96.) +
               " " + font + " background rgb 'white'\n";
    text += std::string("set encoding utf8\nset tics textcolor rgb '") + kInk + "'\nset key textcolor rgb '" +
            kInk + "'\n";
    // The title, the rows of panels, the caption's lines: in fractions of the whole height, from the bottom.
    const auto part = [height](int pixels) { return static_cast<double>(pixels) / height; };
    text += "set multiplot\n";
    for (int i = 0; i < static_cast<int>(plot.panels.size()); ++i) {
        const int row = i / columns, column = i % columns,
                  bottom = captionHeight + (rows - 1 - row) * plot.height;
        text += "set origin " + Number(static_cast<double>(column) / columns) + "," + Number(part(bottom)) +
                "\nset size " + Number(1. / columns) + "," + Number(part(plot.height)) + "\n";
        const PlotPanel &panel = plot.panels[static_cast<size_t>(i)];
        std::string besides = panel.right > 0
                                  ? "set rmargin at screen " + Number((column + panel.right) / columns) + "\n"
                                  : "set rmargin -1\n";
        besides += panel.left > 0 ? "set lmargin at screen " + Number((column + panel.left) / columns) + "\n"
                                  : "set lmargin -1\n";
        if (i == 0 && !plot.title.empty())
            besides += "set label " + Quoted(plot.title) + " at screen 0.5, screen " +
                       Number(1 - part(kTitleHeight / 2)) + " center font ',15' textcolor rgb '" + kInk +
                       "'\n";
        for (size_t k = 0; i == 0 && k < caption.size(); ++k)
            besides += "set label " + Quoted(caption[k]) + " at screen " +
                       Number(static_cast<double>(kCaptionMargin) / width) + ", screen " +
                       Number(part(captionHeight - kCaptionLine / 2 - static_cast<int>(k) * kCaptionLine)) +
                       " left font ',9' textcolor rgb '" + kInk + "'\n";
        text += PanelText(panel, besides);
    }
    text += "unset multiplot\n";
    return text;
}

void WritePlot(const std::string &filename, const Plot &plot) {
    const std::string terminal = TerminalOf(filename);
    OutputFile file(filename); // before the work: a folder that is missing is said at once
    file.Write(RunGnuplot(GnuplotText(plot, terminal)));
    file.Commit();
}

} // namespace cuticle
