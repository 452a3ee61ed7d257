// Pieces of gnuplot's program text that all kinds of panels are made of: numbers, strings, colours, axes,
// series. Only the plots themselves include this.
#pragma once

#include "figures/plot.h"

#include <array>
#include <string>

namespace cuticle::plot_text {

inline constexpr std::array<const char *, kPlotColors> kColors = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                                  "#E69F00", "#56B4E9", "#7A6A00", "#222222"};
// Colours of letters and axes, of grids, and of what stands back.
inline constexpr const char *kInk = "#333333", *kGrid = "#E4E4E4", *kFaint = "#8A8A8A";

// Nine digits; "NaN" for what is not finite.
std::string Number(double v);
// "x,y".
std::string Point(const std::array<double, 2> &p);
// A string in single quotes, in which gnuplot substitutes nothing; a quote is written twice, control
// characters become blanks.
std::string Quoted(const std::string &text);

// "[min:max]", a star for an end that is not given.
std::string AxisRange(const PlotAxis &axis);
// All settings of the axis that gnuplot calls `name` (x, y, or cb, the colour scale).
std::string AxisText(const char *name, const PlotAxis &axis);
// Settings for panels in which both directions have one scale.
extern const std::string kNoAxes;

// The index `chosen`, or `order` where that is -1, wrapped into [0, count).
size_t Cycled(int chosen, size_t order, size_t count);
// " lc rgb ..." of a series that is the order-th of its panel.
std::string ColorOf(const PlotSeries &s, size_t order);
// " title ..." or " notitle".
std::string LegendOf(const PlotSeries &s);
// How gnuplot draws the lines and points of a series: "with ..." and their looks.
std::string With(const PlotSeries &s, size_t order);

// The data of a panel, each series under a name of its own, and the words that plot them.
struct Drawing {
    std::string data, plots;
    int blocks = 0;

    // Adds rows of numbers and returns their name.
    std::string Block(const std::string &rows);
    // Adds an item to the plot command.
    void Add(const std::string &words);
    // Adds the order-th series of a Cartesian panel: error bars or band, lines and points, marks.
    void AddSeries(const PlotSeries &s, size_t order, const PlotPanel &panel);
};

// The panel as a polar diagram.
std::string PolarText(const PlotPanel &panel);

} // namespace cuticle::plot_text
