// Legends stay inside the picture, and letters beside points keep clear of each other.
#include "figures/plot_layout.h"

#include "images/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace cuticle {
namespace {

PlotSeries PointAt(double x, double y, const std::string &mark) {
    PlotSeries s;
    s.style = PlotStyle::Points;
    s.x = {x}, s.y = {y};
    s.mark = mark, s.label = mark;
    return s;
}

// Axes from 0 to 1, which end at 0.55 of a panel of 900 pixels.
Plot PlotOf(const std::vector<PlotSeries> &series) {
    PlotPanel panel;
    panel.right = 0.55;
    panel.x.min = panel.y.min = 0, panel.x.max = panel.y.max = 1;
    panel.series = series;
    Plot plot;
    plot.panels = {panel};
    plot.width = 900, plot.height = 400;
    return plot;
}

TEST(PlotLayout, CaptionsBreakAtBlanks) {
    EXPECT_EQ(BrokenLines("one two three", 8), (std::vector<std::string>{"one two", "three"}));
    EXPECT_EQ(BrokenLines("βββ γγγ", 7), (std::vector<std::string>{"βββ γγγ"})) << "letters count, not bytes";
    EXPECT_EQ(BrokenLines("unbreakable", 3), (std::vector<std::string>{"unbreakable"}));
    EXPECT_TRUE(BrokenLines("", 10).empty());
}

TEST(PlotLayout, AxesMakeRoomForLongLegends) {
    Plot plot = PlotOf({PointAt(0.5, 0.5, "a")});
    FitLegends(&plot);
    EXPECT_EQ(plot.panels[0].right, 0.55);
    // The panels of one right end together.
    const std::string lengthy(60, 'w');
    plot.panels.push_back(plot.panels[0]);
    plot.panels[1].series[0].label = lengthy;
    FitLegends(&plot);
    EXPECT_EQ(plot.panels[0].right, plot.panels[1].right);
    EXPECT_GE((1 - plot.panels[0].right) * plot.width, TextWidth(lengthy));
}

TEST(PlotLayout, ALegendOfWideLettersIsNotCut) {
    Plot plot = PlotOf({PointAt(0.5, 0.5, "a")});
    plot.panels[0].series[0].label = "polished, double (0.93% miscounted), WWWWW";
    const std::string name = ::testing::TempDir() + "legend.png";
    WritePlot(name, plot);
    const Image image = ReadImage(name);
    std::remove(name.c_str());
    const auto width = static_cast<size_t>(image.width), channels = image.Channels();
    for (size_t i = 0; i < image.data.size(); i += channels)
        if (i / channels % width + 4 >= width) {
            ASSERT_GT(image.data[i], 0.9f) << "ink at the right edge";
        }
}

TEST(PlotLayout, LettersStandBesidePointsNotOnThem) {
    // Two points at one place, one at the right edge, one whose usual side a line crosses.
    PlotSeries line;
    line.x = {0.2, 0.3, 0.4, 0.5}, line.y = {0.2, 0.4, INFINITY, NAN};
    Plot plot = PlotOf({PointAt(0.5, 0.5, "a"), PointAt(0.5, 0.5, "b"), PointAt(0.999, 0.8, "c"),
                        PointAt(0.2, 0.2, "d"), line});
    PlotPanel &panel = plot.panels[0];
    PlaceMarks(&panel, plot.width, plot.height);
    const std::array<double, 2> usual = {0.7, 0.4};
    EXPECT_EQ(panel.series[0].markOffset, usual);
    EXPECT_NE(panel.series[1].markOffset, usual);
    EXPECT_LT(panel.series[2].markOffset[0], 0) << "to the left, within the axes";
    EXPECT_NE(panel.series[3].markOffset, usual);

    panel.x.max = {};
    panel.series[1].markOffset = usual;
    PlaceMarks(&panel, plot.width, plot.height);
    EXPECT_EQ(panel.series[1].markOffset, usual) << "without ranges nothing is known of the places";
}

// In a diagram, too: the usual side of a point, where a stroke runs, is left to the stroke.
TEST(PlotLayout, LettersOfADiagramStandOffItsStrokes) {
    PlotSeries stroke;
    stroke.x = {0.2, 0.9}, stroke.y = {0.2, 0.9};
    Plot plot = PlotOf({PointAt(0.5, 0.5, "wide text"), stroke, PointAt(0.2, 0.8, "free")});
    PlotPanel &panel = plot.panels[0];
    panel.kind = PlotKind::Diagram;
    PlaceMarks(&panel, plot.width, plot.height);
    const std::array<double, 2> usual = {0.7, 0.4};
    EXPECT_NE(panel.series[0].markOffset, usual);
    EXPECT_EQ(panel.series[2].markOffset, usual);
}

} // namespace
} // namespace cuticle
