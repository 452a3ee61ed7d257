// A pilot finds the minimum of a function that is known, and learns nothing from what tells nothing.
#include "render/light_pilot.h"

#include "render/plugins.h"
#include "render/renderer.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

class KnownLight : public Light {
  public:
    explicit KnownLight(LightKind kind) : kind_(kind) {}
    bool Sample_Li(const Point3f &, const Point2f &, LightSample *) const override { return false; }
    Spectrum Power() const override { return Spectrum(1.f); }
    LightKind Kind() const override { return kind_; }
    EmissionBound Bound() const override { return {.box = {{0, 0, 0}, {1, 1, 1}}}; }

  private:
    LightKind kind_;
};

class LightPilot : public ::testing::Test {
  protected:
    // Paths of one vertex where the kinds give these luminances.
    LightShares LearnFrom(const LightPilotPath &path) {
        std::vector<LightPilotPath> paths(200, path);
        return LearnLightShares(paths, pilot_, sampler_);
    }
    Pilot pilot_{.cells = {10, 10}, .samples = 2, .ray = nullptr};
    KnownLight sky_{LightKind::Infinite}, sun_{LightKind::Distant}, lamp_{LightKind::Local};
    LightSampler sampler_{{&sky_, &sun_, &lamp_}};
};

// With delta lights a and b the variance is a^2/p + b^2/q - (a + b)^2, least at p : q = a : b.
TEST_F(LightPilot, FindsTheKnownMinimum) {
    LightPilotPath path;
    path.sampled.push_back({});
    path.sampled[0][1] = {3, 1, 0};
    path.sampled[0][2] = {1, 1, 0};
    const LightShares shares = LearnFrom(path);
    EXPECT_EQ(shares[0], 0.1f) << "the sky gives nothing";
    EXPECT_NEAR(shares[1] / shares[2], 3, 0.3);
    EXPECT_NEAR(shares[0] + shares[1] + shares[2], 1, 0.05) << "no noise but the choice: more is better";
}

// A picture without noise leaves nothing to gain, whatever rounding makes of its variance: the cost is never
// below zero, where each step would look like a gain for ever. Here the two paths of a cell find the same
// light in another order, so that their sums differ by rounding alone.
TEST_F(LightPilot, EndsWhereNothingIsNoisy) {
    for (int i = 1; i < 200; ++i) {
        std::vector<LightPilotPath> paths(200);
        const float light[] = {0.1f * static_cast<float>(i), 1e-10f / 3, 1e-9f / 7};
        for (size_t k = 0; k < paths.size(); ++k)
            for (size_t j = 0; j < 3; ++j)
                paths[k].found.push_back({light[k % 2 ? 2 - j : j], 1, -1, LightKind::Infinite});
        EXPECT_GE(LightShareCost(paths, pilot_, {1, 0, 0}), 0) << i;
        EXPECT_GE(LearnLightShares(paths, pilot_, sampler_)[0], 0.1f);
    }
}

// Light that paths find by themselves without noise need not be sampled at all.
TEST_F(LightPilot, DoesNotSampleWhatIsFoundAnyway) {
    LightPilotPath path;
    path.found.push_back({1, 1e-3f, 1e3f, LightKind::Infinite});
    path.sampled.push_back({});
    path.sampled[0][0] = {1e-3f, 1e-3f, 1e3f};
    const LightShares shares = LearnFrom(path);
    EXPECT_LE(shares[0], 0.11f);
    EXPECT_LE(shares[1] + shares[2], 0.21f);
}

// Every kind of light keeps a share, and kinds that are not there get none.
TEST_F(LightPilot, KeepsAMinShare) {
    const LightShares shares = LearnFrom({});
    for (const float share : shares)
        EXPECT_GE(share, 0.0999f);
    std::vector<LightPilotPath> paths(200);
    EXPECT_EQ(LearnLightShares(paths, pilot_, LightSampler({&sky_}))[2], 0);
}

// The function that is made small is the variance of the estimate: against a count over all choices.
TEST_F(LightPilot, MeanAndVarianceAreThoseOfTheEstimate) {
    LightPilotPath one, two;
    one.sampled = {{{{2, 0.5f, 0.25f}, {1, 1, 0}, {}}}, {{{}, {4, 1, 0}, {1, 2, 2}}}};
    one.found = {{0.5f, 0.5f, 1, LightKind::Infinite}, {3, 1, -1, LightKind::Local}};
    const LightShares shares{0.25f, 0.5f, 0.125f};
    const auto heuristic = [](double a, double b) { return a * a / (a * a + b * b); };
    // By hand: every outcome of both choices, with its probability.
    const double first[4] = {2 / 0.25 * heuristic(0.125, 0.25), 1 / 0.5, 0, 0},
                 p[4] = {0.25, 0.5, 0.125, 0.125};
    const double second[4] = {0, 4 / 0.5, 1 / 0.125 * heuristic(0.25, 2), 0};
    const double found = 0.5 * heuristic(1, 0.125) + 3;
    double mean = 0, square = 0;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = first[i] + second[j] + found;
            mean += p[i] * p[j] * x, square += p[i] * p[j] * x * x;
        }
    // Two paths in a cell, the other is black: v = (mean / 2)^2 * 2 + variance / 2, weighed by the brightness
    // of paths that take every light.
    const std::vector<LightPilotPath> paths{one, two};
    const Pilot pilot{.cells = {1, 1}, .samples = 2, .ray = nullptr};
    const double all = (2 * heuristic(0.5, 0.25) + 1 + 4 + heuristic(2, 2) + 0.5 * heuristic(1, 0.5) + 3) / 2;
    const double expected =
        (mean * mean / 2 + (square - mean * mean) / 2) / (1.25 * all * all) * (1 + 0.5 * 0.875);
    EXPECT_NEAR(LightShareCost(paths, pilot, shares), expected, 1e-5 * expected);
}

// A dim sky beside a small lamp: the pilot hardly samples the sky, and says so.
TEST(LightPilotRender, SparesTheDimSky) {
    const char *text =
        "Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 32 "
        "Sampler \"sobol\" \"integer pixelsamples\" 64 Integrator \"path\" \"integer maxdepth\" 3 "
        "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 30 WorldBegin "
        "LightSource \"infinite\" \"rgb L\" [.1 .1 .1] "
        "LightSource \"point\" \"point from\" [2 2 -3] \"rgb I\" [30 30 30] "
        "Material \"hair\" \"float eumelanin\" .3 Shape \"curve\" \"point P\" [-1 -1 0 -1 1 0 1 -1 0 1 1 0] "
        "\"float width\" .3 WorldEnd";
    SceneDescription description = ParseSceneText(AllPlugins(), text, "test.pbrt");
    const Scene scene(&description, {});
    RenderStats stats;
    Render(description, scene, {}, &stats);
    float infinite = 0, local = 0;
    ASSERT_EQ(std::sscanf(stats.learned.c_str(), "lights sampled: infinite %f, distant 0, local %f",
                          &infinite, &local),
              2)
        << stats.learned;
    EXPECT_LT(infinite, 0.2f); // by power it would be more than half
    EXPECT_GT(local, 0.6f);
}

} // namespace
} // namespace cuticle
