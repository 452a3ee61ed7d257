// The charts: what they share, and the laws of what each measures. Times are looked at by nobody here.
#include "core/clock.h"
#include "core/error.h"
#include "core/parallel.h"
#include "figures/charts/chart_table.h"
#include "figures/charts/cost.h"
#include "files/file.h"
#include "images/image.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <thread>

#include <unistd.h>

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

// Works for a quarter of a millisecond of this thread's CPU time.
void Work() {
    for (const double start = ThreadCpuSeconds(); ThreadCpuSeconds() < start + 2.5e-4;)
        ;
}

TEST(TimeInTurns, GivesEveryJobItsTurn) {
    std::string order;
    const auto job = [&order](char name) { return [&order, name] { order += name, Work(); }; };
    const std::vector<double> seconds = TimeInTurns({job('a'), job('b')}, 2);
    EXPECT_EQ(order, "ababab");
    ASSERT_EQ(seconds.size(), 2u);
    for (const double s : seconds)
        EXPECT_TRUE(s >= 2.5e-4 && s < 1);
}

TEST(TimeInTurns, MeasuresCpuTimeNotTheWallsAndRepeatsShortJobs) {
    const auto sleep = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)), Work(); };
    int runs = 0;
    const std::vector<double> seconds = TimeInTurns({sleep, [&runs] { ++runs; }}, 1);
    EXPECT_LT(seconds[0], 0.01);
    EXPECT_GT(runs, 100);
    EXPECT_LT(seconds[1], 1e-5);
}

TEST(TimeInTurns, KeepsParallelLoopsOnThisThread) {
    double total = 0;
    const std::vector<double> seconds = TimeInTurns({[&total] {
                                                        std::mutex mutex;
                                                        ParallelFor(8, [&](size_t) {
                                                            Work();
                                                            const std::lock_guard lock(mutex);
                                                            ++total;
                                                        });
                                                    }},
                                                    1);
    EXPECT_EQ(total, 16);
    EXPECT_GE(seconds[0], 8 * 2.5e-4);
}

class EveryChart : public ::testing::TestWithParam<Chart> {};

TEST_P(EveryChart, KeepsItsLaws) {
    FigureOptions options;
    options.quick = true;
    options.scenes = CUTICLE_SOURCE_DIR "/scenes";
    const FigureData data = GetParam().make(options);
    EXPECT_GT(data.table.Rows(), 0u);
    EXPECT_EQ(data.table.Csv().find_first_of("\\{}"), std::string::npos)
        << "gnuplot's marks belong to the plot";
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

// Another renderer beside ours, on a scene of 20 x 10 pixels in a folder whose name a shell would take apart.
class PeerOfOurs : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = ::testing::TempDir() + fmt::format("it's a \"folder\" {}", ::getpid());
        std::filesystem::create_directories(folder_);
        WriteFileAtomically(folder_ + "/curve-types.pbrt", R"(
LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 20 "integer yresolution" 10
WorldBegin LightSource "infinite" Material "hair"
Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2
WorldEnd
)");
        Write("black.exr", 20, 10, 0);
        Write("small.exr", 4, 3, 0);
        Write("broken.exr", 20, 10, NAN);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    FigureData Chart(const std::string &command) const {
        FigureOptions options;
        options.quick = true;
        options.scenes = folder_;
        options.peers = {{"Peer", command}};
        return FindChart("render").make(options);
    }
    // A command that hands in one of the pictures above.
    static std::string HandIn(const std::string &picture) {
        return "cp \"$(dirname {scene})/" + picture + "\" {out}";
    }
    void Fails(const std::string &command, const std::string &words) const {
        try {
            Chart(command);
            FAIL() << command << " passed";
        } catch (const Error &e) {
            EXPECT_NE(std::string(e.what()).find("the peer Peer " + words), std::string::npos) << e.what();
            EXPECT_NE(std::string(e.what()).find("its command: "), std::string::npos) << e.what();
        }
    }

  private:
    void Write(const std::string &name, int width, int height, float value) const {
        Image image(width, height, {"R", "G", "B"});
        for (float &v : image.data)
            v = value;
        WriteImage(folder_ + "/" + name, image);
    }
    std::string folder_;
};

TEST_F(PeerOfOurs, StandsInTheTable) {
    const FigureData data = Chart(HandIn("black.exr"));
    const size_t last = data.table.Rows() - 1;
    EXPECT_EQ(data.table.Text(last, "way"), "Peer");
    EXPECT_GT(data.table.Number(last, "CPU_seconds"), 0);
    // A white sky: every pixel is off by all that it is, b^2 / (b^2 + 0.01), and hair is darker than the sky.
    EXPECT_GT(data.table.Number(last, "relative_MSE"), 0.9);
    EXPECT_LE(data.table.Number(last, "relative_MSE"), 1 / 1.01);
    EXPECT_NE(Chart(HandIn("broken.exr")).note.find("Peer has 200 of curve-types's pixels"),
              std::string::npos);
}

TEST_F(PeerOfOurs, FailsWithAClearMessage) {
    Fails("exit 3", "ended with status 3");
    Fails("no-such-renderer {scene} {out} 2>&-", "ended with status 127");
    Fails("kill -9 $$", "was ended by signal 9");
    Fails("true", "wrote no picture to {out}");
    Fails("echo 'no picture' > {out}", "wrote a picture that cannot be read (");
    Fails(HandIn("small.exr"), "made a picture of 4 x 3 pixels, the scene asks for 20 x 10 pixels");
}

} // namespace
} // namespace cuticle
