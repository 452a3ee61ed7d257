#include "figures/plot.h"

#include "core/error.h"
#include "figures/gnuplot.h"
#include "figures/plot_layout.h"
#include "figures/plot_text.h"
#include "files/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cuticle {

using namespace plot_text;

namespace {

// Viridis (Smith and van der Walt 2015), eight of its colours: even steps of lightness.
constexpr const char *kHeatColors = "0 '#440154', 1 '#46327e', 2 '#365c8d', 3 '#277f8e', 4 '#1fa187', "
                                    "5 '#4ac16d', 6 '#a0da39', 7 '#fde725'";

void CheckAxis(const PlotAxis &axis) {
    if ((axis.min && !std::isfinite(*axis.min)) || (axis.max && !std::isfinite(*axis.max)) ||
        (axis.min && axis.max && !(*axis.min < *axis.max)))
        throw Error("a plot's axis \"{}\" has an empty range", axis.label)
            .WithRemedy("min must be below max");
    if (axis.log && ((axis.min && *axis.min <= 0) || (axis.max && *axis.max <= 0)))
        throw Error("a plot's logarithmic axis \"{}\" must begin above 0", axis.label);
}

void CheckPanel(const PlotPanel &panel) {
    CheckAxis(panel.x);
    CheckAxis(panel.y);
    for (const PlotSeries &s : panel.series)
        if (s.x.size() != s.y.size() || (!s.error.empty() && s.error.size() != s.y.size()))
            throw Error("the plotted series \"{}\" has {} x, {} y and {} errors", s.label, s.x.size(),
                        s.y.size(), s.error.size());
    if (!(panel.polarFirst < panel.polarLast && panel.polarLast <= panel.polarFirst + 360))
        throw Error("the sector of a polar plot must be 0 to 360 degrees wide");
    if (panel.kind == PlotKind::HeatMap) {
        const PlotHeatMap &map = panel.heatMap;
        if (map.columns == 0 || map.rows == 0 ||
            (map.colors.empty() ? map.values.size() : map.colors.size()) != map.columns * map.rows)
            throw Error("a heat map of {} columns and {} rows has {} values", map.columns, map.rows,
                        map.values.size());
    } else if (panel.series.empty()) {
        throw Error("a plot's panel \"{}\" has no series", panel.title);
    }
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
                    (line.vertical ? "first " + at +
                                         (line.labelBelow ? ", graph 0.03 rotate by 90 left offset 0.8,0"
                                                          : ", graph 0.97 rotate by 90 right offset 0.8,0")
                                   : "graph 0.99, first " + at + " right offset 0,0.5") +
                    " font ',10' textcolor rgb '" + kFaint + "' front\n";
    }
    // "graph 0, first y" and "x, graph 1" carry their own words; "first" before "graph" would be an error.
    for (size_t at = 0; (at = text.find("first graph", at)) != std::string::npos;)
        text.erase(at, 6);
    return text;
}

std::string CartesianText(const PlotPanel &panel) {
    Drawing drawing;
    for (size_t i = 0; i < panel.series.size(); ++i)
        drawing.AddSeries(panel.series[i], i, panel);
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
        drawing.AddSeries(panel.series[i], i, panel);
    PlotAxis x = panel.x, y = panel.y, color;
    x.min = map.xMin, x.max = map.xMax, y.min = map.yMin, y.max = map.yMax;
    if (map.isPicture)
        return kNoAxes + "set xrange " + AxisRange(x) + "\nset yrange " + AxisRange(y) +
               "\nunset colorbox\n" + drawing.data + drawing.plots + "\nset size noratio\n";
    color.log = map.log, color.min = map.min, color.max = map.max, color.label = map.label;
    return std::string("set border 15 lw 1 lc rgb '") + kInk + "'\nunset grid\nset palette defined (" +
           kHeatColors + ")\n" + (map.colors.empty() ? "set colorbox\n" : "unset colorbox\n") +
           AxisText("x", x) + AxisText("y", y) + AxisText("cb", color) + ReferenceLines(panel) +
           drawing.data + drawing.plots + "\n";
}

std::string DiagramText(const PlotPanel &panel) {
    if (!panel.x.min || !panel.x.max || !panel.y.min || !panel.y.max)
        throw Error("a diagram needs the ranges of x and y");
    Drawing drawing;
    for (size_t i = 0; i < panel.series.size(); ++i)
        drawing.AddSeries(panel.series[i], i, panel);
    return kNoAxes + "set xrange " + AxisRange(panel.x) + "\nset yrange " + AxisRange(panel.y) + "\n" +
           drawing.data + drawing.plots + "\nset size noratio\n";
}

// The words of a legend's place come from a program, not from a user; anything else would be a mistake in it.
std::string LegendPlace(const std::string &words) {
    for (const char c : words)
        if (!(c == ' ' || (c >= 'a' && c <= 'z')))
            throw Error("a legend's place \"{}\" must be words like \"top right\"", words);
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

// The settings of the whole picture, which is width x height pixels large.
std::string TerminalText(const std::string &terminal, int width, int height) {
    std::string text;
    if (terminal == "svg")
        text = fmt::format("set terminal svg enhanced size {},{}", width, height);
    else if (terminal == "png") // twice the pixels, and everything twice as large
        text = fmt::format("set terminal pngcairo enhanced size {},{} fontscale 2 linewidth 2 pointscale 2",
                           2 * width, 2 * height);
    else // 96 pixels to the inch
        text = fmt::format("set terminal pdfcairo enhanced size {},{}", Number(width / 96.),
                           Number(height / 96.));
    return text + fmt::format(" font 'DejaVu Sans,12' background rgb 'white'\nset encoding utf8\n"
                              "set tics textcolor rgb '{0}'\nset key textcolor rgb '{0}'\n",
                              kInk);
}

std::string TerminalOf(const std::string &filename) {
    for (const char *ending : {"svg", "png", "pdf"})
        if (filename.ends_with(std::string(".") + ending))
            return ending;
    throw Error("the plot's name \"{}\" must end in .svg, .png or .pdf", filename);
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

std::string GnuplotText(const Plot &asked, const std::string &terminal) {
    if (asked.panels.empty() || asked.columns < 1 || asked.width < 100 || asked.height < 100)
        throw Error("a plot needs a panel, a column and at least 100 x 100 pixels");
    Plot plot = asked;
    FitLegends(&plot);
    const int panels = static_cast<int>(plot.panels.size()), columns = std::min(plot.columns, panels);
    const int rows = (panels + columns - 1) / columns, width = columns * plot.width;
    const std::vector<std::string> caption =
        BrokenLines(plot.caption, static_cast<size_t>((width - 2 * kCaptionMargin) * 2 / 13));
    const int captionHeight =
        caption.empty() ? 0 : static_cast<int>(caption.size()) * kCaptionLine + kCaptionMargin;
    const int height = rows * plot.height + captionHeight + (plot.title.empty() ? 0 : kTitleHeight);
    // The title, the rows of panels, the caption's lines: in fractions of the whole height, from the bottom.
    const auto part = [height](int pixels) { return Number(static_cast<double>(pixels) / height); };
    std::string text = TerminalText(terminal, width, height) + "set multiplot\n";
    for (int i = 0; i < panels; ++i) {
        PlotPanel &panel = plot.panels[static_cast<size_t>(i)];
        PlaceMarks(&panel, plot.width, plot.height);
        const int row = i / columns, column = i % columns;
        text += fmt::format(
            "set origin {},{}\nset size {},{}\n", Number(static_cast<double>(column) / columns),
            part(captionHeight + (rows - 1 - row) * plot.height), Number(1. / columns), part(plot.height));
        const auto margin = [&](const char *name, double share) {
            return share > 0 ? fmt::format("set {} at screen {}\n", name, Number((column + share) / columns))
                             : fmt::format("set {} -1\n", name);
        };
        std::string besides = margin("rmargin", panel.right) + margin("lmargin", panel.left);
        if (i == 0 && !plot.title.empty())
            besides +=
                fmt::format("set label {} at screen 0.5, screen {} center font ',15' textcolor rgb '{}'\n",
                            Quoted(plot.title), part(height - kTitleHeight / 2), kInk);
        for (int k = 0; i == 0 && k < static_cast<int>(caption.size()); ++k)
            besides += fmt::format("set label {} at screen {}, screen {} left font ',9' textcolor rgb '{}'\n",
                                   Quoted(caption[static_cast<size_t>(k)]),
                                   Number(static_cast<double>(kCaptionMargin) / width),
                                   part(captionHeight - kCaptionLine / 2 - k * kCaptionLine), kInk);
        text += PanelText(panel, besides);
    }
    return text + "unset multiplot\n";
}

void WritePlot(const std::string &filename, const Plot &plot) {
    const std::string terminal = TerminalOf(filename);
    OutputFile file(filename); // before the work: a folder that is missing is said at once
    file.Write(RunGnuplot(GnuplotText(plot, terminal)));
    file.Commit();
}

} // namespace cuticle
