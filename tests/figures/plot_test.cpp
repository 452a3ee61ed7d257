#include "figures/plot.h"

#include "core/error.h"
#include "images/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace cuticle {
namespace {

class PlotFile : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = ::testing::TempDir() + "plotXXXXXX";
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override {
        for (const std::string &name : made_)
            std::remove(name.c_str());
        rmdir(folder_.c_str()); // fails, and the next line too, if a temporary file was left
        EXPECT_NE(access(folder_.c_str(), F_OK), 0) << "a file was left in " << folder_;
    }
    std::string Name(const std::string &file) { return made_.emplace_back(folder_ + "/" + file); }
    static std::string Read(const std::string &name) {
        std::ifstream in(name, std::ios::binary);
        std::ostringstream text;
        text << in.rdbuf();
        return text.str();
    }
    std::string folder_;
    std::vector<std::string> made_;
};

PlotSeries Sine() {
    PlotSeries s;
    s.label = "sine";
    for (int i = 0; i <= 60; ++i) {
        s.x.push_back(6 * i);
        s.y.push_back(1.2 + std::sin(s.x.back() * M_PI / 180));
        s.error.push_back(0.1);
    }
    return s;
}

Plot OnePanel(PlotKind kind, PlotStyle style) {
    Plot plot;
    PlotPanel panel;
    panel.kind = kind;
    panel.series = {Sine()};
    panel.series[0].style = style;
    plot.panels = {panel};
    return plot;
}

// The number of pixels near a colour of the palette.
int PixelsLike(const std::string &png, double r, double g, double b) {
    const Image image = ReadImage(png);
    int count = 0;
    for (size_t i = 0; i + 2 < image.data.size(); i += image.Channels())
        count += std::hypot(image.data[i] - r, image.data[i + 1] - g, image.data[i + 2] - b) < 0.05;
    return count;
}

TEST_F(PlotFile, EveryKindAndStyleDrawsInkOfItsColour) {
    for (const PlotKind kind : {PlotKind::Cartesian, PlotKind::Polar})
        for (const PlotStyle style :
             {PlotStyle::Line, PlotStyle::Points, PlotStyle::LinePoints, PlotStyle::Steps, PlotStyle::Band}) {
            Plot plot = OnePanel(kind, style);
            plot.panels[0].y.log = style == PlotStyle::LinePoints;
            const std::string name = Name("a.png");
            WritePlot(name, plot);
            // #0072B2 in linear light
            EXPECT_GT(PixelsLike(name, 0, 0.168, 0.445), 500) << static_cast<int>(style);
        }
}

TEST_F(PlotFile, AHeatMapShowsItsValues) {
    Plot plot;
    PlotPanel panel;
    panel.kind = PlotKind::HeatMap;
    panel.heatMap.columns = 2, panel.heatMap.rows = 2;
    panel.heatMap.values = {0, 1, NAN, 0};
    plot.panels = {panel, panel};
    plot.columns = 2;
    const std::string name = Name("a.png");
    WritePlot(name, plot);
    // #440154 twice, #fde725 once
    const int low = PixelsLike(name, 0.058, 0.0003, 0.089), high = PixelsLike(name, 0.982, 0.799, 0.0185);
    EXPECT_GT(high, 20000);
    EXPECT_NEAR(static_cast<double>(low) / high, 2, 0.2);
}

TEST_F(PlotFile, SvgAndPdfAreWhatTheirNamesSay) {
    WritePlot(Name("a.svg"), OnePanel(PlotKind::Cartesian, PlotStyle::Line));
    EXPECT_NE(Read(made_.back()).find("<svg"), std::string::npos);
    EXPECT_NE(Read(made_.back()).find("</svg>"), std::string::npos);
    EXPECT_NE(Read(made_.back()).find("sine"), std::string::npos);
    WritePlot(Name("a.pdf"), OnePanel(PlotKind::Polar, PlotStyle::Line));
    EXPECT_EQ(Read(made_.back()).substr(0, 5), "%PDF-");
}

TEST_F(PlotFile, LabelsAreNeverCommands) {
    const std::string trace = Name("trace");
    const std::string evil = "`touch " + trace + "`'; system('touch " + trace + "') #\nsystem(\"touch " +
                             trace + "\")\n$(touch " + trace + ") @x \\";
    for (const std::string &text : {evil, PlainText(evil)}) {
        Plot plot = OnePanel(PlotKind::Cartesian, PlotStyle::Line);
        plot.title = plot.panels[0].title = plot.panels[0].x.label = plot.panels[0].series[0].label = text;
        plot.panels[0].lines = {{true, 90, text}, {false, 1, text}};
        WritePlot(Name("a.svg"), plot);
        EXPECT_NE(access(trace.c_str(), F_OK), 0);
        plot.panels[0].legend = "top'; system('true')";
        EXPECT_THROW(WritePlot(Name("b.svg"), plot), Error);
    }
}

TEST_F(PlotFile, MistakesAreErrorsAndLeaveTheOldFile) {
    const std::string name = Name("a.svg");
    std::ofstream(name) << "old";
    Plot plot = OnePanel(PlotKind::Cartesian, PlotStyle::Line);
    plot.panels[0].series[0].y.pop_back();
    EXPECT_THROW(WritePlot(name, plot), Error);
    plot = OnePanel(PlotKind::Cartesian, PlotStyle::Line);
    plot.panels[0].x.min = plot.panels[0].x.max = 3;
    EXPECT_THROW(WritePlot(name, plot), Error);
    plot.panels[0].x.min = plot.panels[0].x.max = {};
    plot.panels[0].series[0].y.assign(61, NAN); // nothing to draw: gnuplot says so
    EXPECT_THROW(WritePlot(name, plot), Error);
    plot = OnePanel(PlotKind::Polar, PlotStyle::Line);
    plot.panels[0].polarFirst = plot.panels[0].polarLast = 20;
    EXPECT_THROW(WritePlot(name, plot), Error);
    EXPECT_EQ(Read(name), "old");
    EXPECT_THROW(WritePlot(folder_ + "/none/a.svg", OnePanel(PlotKind::Polar, PlotStyle::Line)), Error);
    EXPECT_THROW(WritePlot(folder_ + "/a.gif", OnePanel(PlotKind::Polar, PlotStyle::Line)), Error);
    EXPECT_THROW(WritePlot(folder_ + "/a.svg", Plot()), Error);
}

} // namespace
} // namespace cuticle
