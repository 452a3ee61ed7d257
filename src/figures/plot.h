// Plots: lines, points with error bars, bands, polar diagrams and heat maps, drawn by gnuplot in one light
// style.
#pragma once

#include "core/color.h"

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cuticle {

// Labels are UTF-8 in gnuplot's "enhanced" notation: {/:Italic S}, x_{min}, 10^{-3}. A text that comes from
// elsewhere (a file's name) goes through PlainText, which takes the special characters' meaning away. Control
// characters become spaces. Nothing that stands in a label is ever run as a command.
std::string PlainText(const std::string &text);

enum class PlotStyle {
    Line,
    Points,
    LinePoints,
    Steps, // horizontal pieces centred on x, for histograms
    Band,  // the region y - error to y + error, translucent, with the line through y
};
enum class PlotDash { Solid, Dashed, Dotted, DashDot };

// One curve. y has x's length; so has error, if not empty: half the height of the error bar, in y's units
// (say in the label what it is: one standard error, two, ...). Points that are NaN or infinite, or not
// positive on a logarithmic axis, are left out and interrupt a line.
struct PlotSeries {
    std::string label; // in the legend; "" keeps the series out of it
    std::vector<double> x, y, error;
    PlotStyle style = PlotStyle::Line;
    int color = -1; // 0 to kPlotColors - 1; -1: by the order of the series
    PlotDash dash = PlotDash::Solid;
    double width = 2; // of the line, in pixels
    int marker = -1;  // 0 to 6: disc, square, triangle, diamond, circle, open square, cross; -1: by order
    std::string mark = ""; // a short text beside every point
    // The mark stands this many characters to the right of its point, and above it. Panels with axes and
    // given ranges choose a free side instead.
    std::array<double, 2> markOffset = {0.7, 0.4};
};
// A palette that people with a colour vision deficiency can tell apart (Okabe and Ito 2008), black last.
inline constexpr int kPlotColors = 8;

// One axis. min and max that are not given come from the data; gnuplot chooses a step of 0. A logarithmic
// axis has no step.
struct PlotAxis {
    std::string label;
    bool log = false;
    std::optional<double> min = {}, max = {};
    double step = 0;
    bool exponents = false; // numbers along the axis are exponents of 10, and shown as such (not with log)
    // Names at places along the axis stand in for numbers; an empty list leaves the axis without either.
    std::optional<std::vector<std::pair<double, std::string>>> names = {};
};

// A straight reference line across the panel: x = at (vertical) or y = at.
struct PlotReferenceLine {
    bool vertical = true;
    double at = 0;
    std::string label;       // beside the line
    bool labelBelow = false; // of a vertical line: at its lower end, not its upper one
};

// A map of equal cells: values in rows of y, `columns` of them in a row. NaN leaves a cell white.
struct PlotHeatMap {
    double xMin = 0, xMax = 1, yMin = 0, yMax = 1; // the outer edges
    size_t columns = 0, rows = 0;
    std::vector<double> values;
    // A picture instead: the colours themselves, linear RGB, in the same order; values is then empty.
    std::vector<Spectrum> colors;
    bool isPicture = false; // cells are square, and there are no axes
    std::string label;      // of the colour scale
    bool log = false;       // values that are not positive are left white
    std::optional<double> min = {}, max = {};
};

enum class PlotKind { Cartesian, Polar, HeatMap, Diagram };

// One panel. Diagram: x and y on one scale, without axes; both ranges must be given. Polar: x is an angle in
// degrees, counter-clockwise (or clockwise) from polarZero (0: right, 90: up), y the radius, which begins at
// y.min in the centre; a logarithmic radius without y.min spans three decades.
struct PlotPanel {
    PlotKind kind = PlotKind::Cartesian;
    std::string title;
    PlotAxis x, y;
    std::vector<PlotSeries> series;
    PlotHeatMap heatMap; // series are drawn over it
    std::vector<PlotReferenceLine> lines;
    std::string legend = "top right"; // gnuplot's words for a place: left, right, top, bottom, outside, below
    // If not 0: the axes end at this share of the panel's width (earlier where a legend needs the room), and
    // the legend stands beyond.
    double right = 0;
    double left = 0; // if not 0: the axes begin at this share of the panel's width
    double polarZero = 0;
    bool clockwise = false;
    double polarFirst = -180, polarLast = 180; // the sector that is shown, 0 to 360 degrees wide
};

// Panels side by side, `columns` in a row. width and height are one panel's, in pixels of the screen (PNG has
// twice as many each way).
struct Plot {
    std::string title;
    std::string caption; // below the panels, broken into lines
    std::vector<PlotPanel> panels;
    int columns = 1;
    int width = 720, height = 480;
};

// Writes the program text for gnuplot; terminal is "svg", "png" or "pdf". Throws Error where lengths do not
// match, a panel has nothing to draw, or a range is empty.
std::string GnuplotText(const Plot &plot, const std::string &terminal);

// Draws the plot with gnuplot, which must be installed (Debian: gnuplot-nox). The file's name ends in .svg,
// .png or .pdf; it appears whole or not at all. Throws Error, with gnuplot's words if it had any.
void WritePlot(const std::string &filename, const Plot &plot);

} // namespace cuticle
