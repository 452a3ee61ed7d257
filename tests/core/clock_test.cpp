#include "core/clock.h"

#include <gtest/gtest.h>

#include <thread>

namespace cuticle {
namespace {

// Sleep costs time on the wall and next to none of the processor.
TEST(Clock, SleepIsWallTimeAndNotCpuTime) {
    const double wall = WallSeconds(), thread = ThreadCpuSeconds();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_GE(WallSeconds() - wall, 0.05);
    EXPECT_LT(ThreadCpuSeconds() - thread, 0.025);
}

// The process counts what another of its threads computes; this thread's clock does not.
TEST(Clock, TheProcessCountsAllThreads) {
    const double process = ProcessCpuSeconds(), thread = ThreadCpuSeconds();
    double other = 0;
    std::thread([&] {
        const double start = ThreadCpuSeconds();
        while ((other = ThreadCpuSeconds() - start) < 0.05) {
        }
    }).join();
    EXPECT_GE(other, 0.05);
    EXPECT_GE(ProcessCpuSeconds() - process, 0.045); // the kernel may count this one in coarser steps
    EXPECT_LT(ThreadCpuSeconds() - thread, 0.025);
}

TEST(Clock, DurationsReadAsPeopleWriteThem) {
    EXPECT_EQ(DurationText(0), "0.0s");
    EXPECT_EQ(DurationText(12.34), "12.3s");
    EXPECT_EQ(DurationText(245), "4m05s");
    EXPECT_EQ(DurationText(9000), "2h30m");
    EXPECT_EQ(DurationText(1e13), "2777777777h46m");
}

} // namespace
} // namespace cuticle
