// A render as a job: what goes in and what comes out.
#include "render/job.h"

#include "core/check.h"
#include "core/error.h"
#include "render/plugins.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace cuticle {
namespace {

// A hair before a sky, 20 x 10 pixels.
const std::string kScene = R"(LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 20 "integer yresolution" 10
Sampler "halton" "integer pixelsamples" 8
WorldBegin LightSource "infinite" Material "hair"
Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2
WorldEnd)";

JobResult RunText(const std::string &text, const JobOptions &options) {
    SceneDescription description = ParseSceneText(AllPlugins(), text, "hair.pbrt");
    const Scene scene(&description, SceneOptions());
    return RunJob(description, scene, options);
}

// Fails a CHECK in one sample of one pixel, or is no number there.
class FaultyIntegrator : public Integrator {
  public:
    explicit FaultyIntegrator(bool checks) : checks_(checks) {}
    Spectrum Li(const Ray &, const Scene &, PixelSampler &, RayCounts &) const override {
        const bool here = seen_++ == 20 * 5 * 8 + 3;
        if (checks_)
            CHECK(!here) << "the fault that was made";
        return Spectrum(here ? std::numeric_limits<float>::quiet_NaN() : 1.f);
    }

  private:
    bool checks_;
    mutable int seen_ = 0; // for one thread
};

TEST(JobDeathTest, AFailedCheckNamesSceneAndPixelAndSample) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    InstallCheckHandler();
    const FaultyIntegrator faulty(true);
    JobOptions options;
    options.threads = 1;
    options.ownIntegrator = &faulty;
    EXPECT_DEATH(
        RunText(kScene, options),
        "the fault that was made(.|\n)*while rendering hair.pbrt, pixel \\([0-9]+, [0-9]+\\), sample [0-7]");
}

TEST(Job, TellsHowFarItIs) {
    struct Log : ProgressSink {
        void Report(uint64_t done, uint64_t total) override {
            EXPECT_GT(done, last);
            EXPECT_EQ(total, 20u * 10 * 6);
            last = done;
        }
        uint64_t last = 0;
    } log;
    JobOptions options;
    options.progress = &log;
    options.samples = SampleRange{2, 8};
    const JobResult job = RunText(kScene, options);
    EXPECT_EQ(log.last, 20u * 10 * 6);
    EXPECT_TRUE(job.complete);
    EXPECT_EQ(job.SamplesReached(), 6);
    EXPECT_EQ(job.film.MinSamples(), 6);
    EXPECT_EQ(job.spp, 8);
    EXPECT_GE(job.rays.rays, 20u * 10 * 6);
}

// Its warnings go where the job says, also those of the threads that help.
TEST(Job, WarnsWhereItIsTold) {
    struct Sink : WarningSink {
        void Warn(const FileLoc &, const std::string &kind, const std::string &message) override {
            EXPECT_EQ(kind, "sample that is not finite");
            messages.push_back(message);
        }
        std::vector<std::string> messages;
    } sink;
    const FaultyIntegrator faulty(false);
    JobOptions options;
    options.threads = 1;
    options.ownIntegrator = &faulty;
    options.warnings = &sink;
    const JobResult job = RunText(kScene, options);
    EXPECT_EQ(job.nanSamples, 1u);
    EXPECT_EQ(job.film.MinSamples(), 7);
    EXPECT_EQ(job.SamplesReached(), 8); // all were taken
    ASSERT_EQ(sink.messages.size(), 1u);
    EXPECT_NE(sink.messages[0].find("left out at pixel ("), std::string::npos) << sink.messages[0];
}

TEST(Job, StopsWhereItIsInterrupted) {
    const std::atomic<bool> interrupted = true;
    JobOptions options;
    options.interrupted = &interrupted;
    const JobResult job = RunText(kScene, options);
    EXPECT_FALSE(job.complete);
    EXPECT_EQ(job.SamplesReached(), 0);
    EXPECT_EQ(job.rays.rays, 0u);
}

TEST(Job, RefusesSamplesBeyondTheRender) {
    for (const SampleRange range :
         {SampleRange{0, 9}, SampleRange{-1, 3}, SampleRange{4, 4}, SampleRange{5, 4}}) {
        JobOptions options;
        options.samples = range;
        EXPECT_THROW(RunText(kScene, options), Error) << range.first << " to " << range.last;
    }
}

} // namespace
} // namespace cuticle
