// The charts: what they share, and the laws of what each measures. Times are looked at by nobody here.
#include "core/file.h"
#include "figures/cost.h"
#include "figures/figure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace cuticle {
namespace {

TEST(ParetoFront, HoldsWhatNothingBeats) {
    const std::vector<CostPoint> points = {
        {"slow and good", 9, 1},  {"fast and bad", 1, 9},      {"beaten", 9.5, 1.5},
        {"middle", 4, 4},         {"fails", 0.1, INFINITY},    {"no number", 0.2, NAN},
        {"twin of middle", 4, 4}, {"as dear as middle", 4, 5},
    };
    EXPECT_EQ(ParetoFront(points), (std::vector<size_t>{1, 3, 0}));
    EXPECT_TRUE(ParetoFront({}).empty());
}

TEST(TimeInTurns, GivesEveryJobItsTurn) {
    std::string order;
    const std::vector<double> seconds = TimeInTurns({[&] { order += 'a'; }, [&] { order += 'b'; }}, 2);
    EXPECT_EQ(order, "ababab");
    ASSERT_EQ(seconds.size(), 2u);
    for (const double s : seconds)
        EXPECT_TRUE(s >= 0 && s < 1);
}

class EveryChart : public ::testing::TestWithParam<Chart> {};

TEST_P(EveryChart, KeepsItsLaws) {
    FigureOptions options;
    options.quick = true;
    options.scenes = CUTICLE_SOURCE_DIR "/scenes";
    const FigureData data = GetParam().make(options);
    EXPECT_GT(data.table.Rows(), 0u);
    EXPECT_FALSE(data.checks.empty()) << "a chart carries at least one law";
    for (const FigureCheck &check : data.checks)
        EXPECT_TRUE(check.Holds()) << check.law << " " << check.value << ", asked for " << check.low << " to "
                                   << check.high;
    // Every method is named in the picture (those whose names hold no mark of gnuplot's notation).
    const std::string folder = ::testing::TempDir() + "chart_" + GetParam().name;
    WriteFigure(folder, "chart", "", data);
    const std::string svg = ReadFile(folder + "/chart.svg", "the chart");
    for (const PlotPanel &panel : data.plot.panels)
        for (const PlotSeries &s : panel.series)
            if (s.label.find_first_of("_^{}\\&'") == std::string::npos) {
                EXPECT_NE(svg.find(s.label), std::string::npos) << s.label;
            }
    std::filesystem::remove_all(folder);
}
INSTANTIATE_TEST_SUITE_P(All, EveryChart, ::testing::ValuesIn(Charts().begin(), Charts().end()),
                         [](const auto &tested) { return std::string(tested.param.name); });

} // namespace
} // namespace cuticle
