// The tabulated model: its sampling is exact whatever the table holds, its energy is the simulator's, and
// between the table's directions and absorptions it stays near the simulator.
#include "fibers/tabulated.h"

#include "core/error.h"
#include "core/sampling.h"
#include "fibers/fiber_laws.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>

namespace cuticle {
namespace {

using laws::Direction;

FiberDescription Hair(double axisRatio, std::vector<double> levels) {
    FiberDescription fiber;
    fiber.axisRatio = axisRatio, fiber.alpha = 2 * kPi<double> / 180;
    fiber.roughnessU = 0.2, fiber.roughnessV = 0.15;
    fiber.sigmaA = std::move(levels);
    return fiber;
}
constexpr uint64_t kSamples =
    8192; // for each direction of the viewer; of an ellipse, which has more of them, less

// The integral of the model over the sphere, in blocks of `block` x `block` cells: exact, since between the
// middles and edges of cells it is linear in rows and columns.
struct Blocks {
    std::vector<double> pdf;
    std::array<double, 3> energy = {0, 0, 0};
};
constexpr size_t kBlock = 4, kAcross = FiberTable::kColumns / kBlock, kAlong = FiberTable::kRows / kBlock;
Blocks Integrate(const Tabulated<double> &model, const Vector3d &wo) {
    Blocks blocks;
    blocks.pdf.resize(kAlong * kAcross);
    SphereCells halves = FiberTable::Cells(std::asin(wo.x));
    halves.rows *= 2, halves.columns *= 2;
    const double phiO = std::atan2(wo.z, wo.y);
    for (size_t i = 0; i < halves.rows; ++i)
        for (size_t j = 0; j < halves.columns; ++j) {
            const double theta = halves.Theta(i);
            const double weight = (halves.ThetaEdge(i + 1) - halves.ThetaEdge(i)) * 2 * kPi<double> /
                                  static_cast<double>(halves.columns) * std::cos(theta);
            const FiberValue<double> value = model.Evaluate(wo, Direction(theta, phiO + halves.Phi(j)));
            blocks.pdf[i / (2 * kBlock) * kAcross + j / (2 * kBlock)] += weight * value.pdf;
            for (size_t c = 0; c < 3; ++c)
                blocks.energy[c] += weight * value.fCos[c];
        }
    return blocks;
}

struct View {
    double axisRatio, theta, phi, axis;
};
const View kViews[] = {{1, 0.31, 0.6, 0},    {1, -1.2, 1, 0},    {1, 1.56, 2, 0},      {1, 0, 0, 0},
                       {0.7, 0.2, 0.5, 0.3}, {0.7, -0.6, -2, 1}, {0.7, 0.9, 2.5, 0.4}, {0.7, -1.45, 1, 2.5}};
const std::array<double, 3> kColors = {0.1, 0.3, 0.9};
std::shared_ptr<const FiberTable> TableOf(double axisRatio) {
    static std::map<double, std::shared_ptr<const FiberTable>> tables; // each is used by several tests
    auto &table = tables[axisRatio];
    if (!table)
        table =
            FiberTable::Cached(Hair(axisRatio, {0, 0.1, 0.5, 1}), axisRatio == 1 ? kSamples : kSamples / 4);
    return table;
}

TEST(Tabulated, SamplesFollowThePdf) {
    const int n = 100000;
    const double significance = 0.01 / std::size(kViews); // that any fails by chance: 1%
    for (const View &v : kViews) {
        const auto table = TableOf(v.axisRatio);
        const Tabulated<double> model(table.get(), kColors, v.axis);
        const TabulatedBSDF bsdf(table.get(), Spectrum(0.1f, 0.3f, 0.9f), static_cast<float>(v.axis));
        const Vector3d wo = Direction(v.theta, v.phi);
        const Blocks blocks = Integrate(model, wo);
        const SphereCells cells = FiberTable::Cells(v.theta);
        std::vector<double> counted(blocks.pdf.size());
        double sum = 0, largest = 0, mismatch = 0;
        for (const double p : blocks.pdf)
            sum += p;
        EXPECT_NEAR(sum, 1, 1e-5) << v.theta;
        RNG rng(MixBits(7));
        for (int k = 0; k < n; ++k) {
            Vector3f wi;
            float pdf = 0;
            const Spectrum f = bsdf.Sample_f(
                Vector3f(wo), &wi,
                {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
            ASSERT_GT(pdf, 0);
            const Vector3d w(wi);
            for (int c = 0; c < 3; ++c)
                largest = std::max(largest, double(f[c]) * std::abs(w.z) / double(pdf));
            if (k % 16 == 0) {
                const double exact = model.Evaluate(wo, w).pdf;
                mismatch = std::max(mismatch, std::abs(double(pdf) - exact) / (exact + 1e-3));
            }
            const double theta = std::atan2(w.x, std::hypot(w.y, w.z));
            ++counted[cells.RowOf(theta) / kBlock * kAcross +
                      cells.ColumnOf(std::atan2(w.z, w.y) - v.phi) / kBlock];
        }
        double chiSquared = 0, e = 0, o = 0;
        size_t count = 0;
        for (size_t b = 0; b < counted.size(); ++b) {
            e += n * blocks.pdf[b], o += counted[b];
            if (e >= 8) {
                chiSquared += Sqr(o - e) / e, ++count;
                e = o = 0;
            }
        }
        const double p = boost::math::gamma_q(static_cast<double>(count - 1) / 2, chiSquared / 2);
        std::printf(
            "theta %5.2f, axis ratio %g: p %.3f of %zu cells, n = %d; largest weight %.3f, mismatch %.1e\n",
            v.theta, v.axisRatio, p, count, n, largest, mismatch);
        EXPECT_GT(p, significance);
        EXPECT_LT(largest, 3.001); // sampled by the mean of three colours
        EXPECT_LT(mismatch, 0.01);
    }
}

// As much light leaves as the table says, and of a clear fiber everything, but for the noise of Russian
// roulette.
TEST(Tabulated, EnergyIsTheSimulators) {
    double worst = 0;
    for (const View &v : kViews) {
        const auto table = TableOf(v.axisRatio);
        const Tabulated<double> clear(table.get(), {0, 0, 0}, v.axis), colored(table.get(), kColors, v.axis);
        const Vector3d wo = Direction(v.theta, v.phi);
        const double all = Integrate(clear, wo).energy[0];
        worst = std::max(worst, std::abs(all - 1));
        EXPECT_NEAR(all, 1, 2e-3) << v.theta;
        const std::array<double, 3> energy = Integrate(colored, wo).energy;
        EXPECT_TRUE(energy[0] > energy[1] && energy[1] > energy[2]) << "it absorbs";
    }
    std::printf("a clear fiber returns all light but for %.1e\n", worst);
}

// Total variation, in cells of 10 by 10 degrees, between the model and a new simulation: half the sum of all
// differences, 0 to 1.
double Distance(const Tabulated<double> &model, const FiberDescription &fiber, const FiberLight &viewer) {
    FiberMeasurement m;
    m.samples = 100000, m.seed = 99, m.cells = {18, 36};
    const FiberHistogram truth = SimulateFiber(fiber, viewer, m);
    const Vector3d wo = Direction(viewer.theta, viewer.phi);
    const size_t fine = 8;
    const SphereCells parts = {18 * fine, 36 * fine};
    std::vector<double> share(m.cells.Count());
    for (size_t i = 0; i < parts.rows; ++i)
        for (size_t j = 0; j < parts.columns; ++j)
            share[i / fine * 36 + j / fine] +=
                parts.SolidAngle(i) * model.Evaluate(wo, Direction(parts.Theta(i), parts.Phi(j))).fCos[0];
    double sum = 0;
    for (size_t c = 0; c < share.size(); ++c)
        sum +=
            std::abs(share[c] - truth.Density(truth.Sum(), 0, c / 36, c % 36) * m.cells.SolidAngle(c / 36));
    return sum / 2;
}

// Between the grid's directions, in all quadrants of an ellipse.
TEST(Tabulated, AgreesWithTheSimulator) {
    std::map<double, std::pair<double, double>> range; // least and most, by axis ratio
    for (const View &v : kViews) {
        FiberDescription fiber = Hair(v.axisRatio, {0.1});
        fiber.rotation = v.axis;
        const auto table = TableOf(v.axisRatio);
        const Tabulated<double> model(table.get(), {0.1, 0.1, 0.1}, v.axis);
        const double distance = Distance(model, fiber, {v.theta, v.phi, {}});
        auto &[least, most] = range.try_emplace(v.axisRatio, distance, distance).first->second;
        least = std::min(least, distance), most = std::max(most, distance);
        EXPECT_LT(distance, v.axisRatio == 1 ? 0.03 : 0.06) << v.theta << " " << v.axisRatio;
    }
    for (const auto &[ratio, shares] : range)
        std::printf("axis ratio %g: %.4f to %.4f of the light is elsewhere\n", ratio, shares.first,
                    shares.second);
}

// Linear in exp(-2 sigma), as Tabulated has it.
struct LevelBlend {
    double low, between, high;
    double HighWeight() const { return std::expm1(-2 * (between - low)) / std::expm1(-2 * (high - low)); }
    double Of(double atLow, double atHigh) const { return atLow + HighWeight() * (atHigh - atLow); }
    // What it makes wrong of a path of length l, as a share of the path's light before absorption.
    double MissOf(double l) const {
        return Of(std::exp(-low * l), std::exp(-high * l)) - std::exp(-between * l);
    }
    // The greatest miss over the light that such a path keeps of `reference` and loses at `opaque`.
    double WorstAgainst(double reference, double opaque) const {
        double worst = 0;
        for (double l = 1e-4; l * low < 60; l *= 1.01)
            worst = std::max(worst, std::abs(MissOf(l)) / (std::exp(-reference * l) - std::exp(-opaque * l)));
        return worst;
    }
};

// All levels of a table share their paths, so that the interpolation's error has no noise: it is the sum of
// the errors of single paths. A path's error, whatever its length, is at most a known part of what it
// contributes at another level of the table, beyond what does not pass through the fiber; so the sum's is
// that part of the difference of two totals. Of several such bounds the least counts, and floats' rounding.
TEST(Tabulated, AbsorptionIsInterpolated) {
    const double opaque = 1000;
    for (const double low : {0.05, 0.2, 0.8, 3.2}) {
        const LevelBlend blend{low, low * std::pow(2., 0.25),
                               low * std::sqrt(2.)}; // steps as in hair_models.cpp
        enum { Clear, Half, Low, Between, High, Opaque };
        const std::vector<double> levels = {0, low / 2, blend.low, blend.between, blend.high, opaque};
        const FiberTable table(Hair(1, levels), 512);
        double worst = 0, worstRelative = 0, nearest = 0;
        for (size_t entry = 0; entry < FiberTable::kThetas; ++entry) {
            const auto total = [&](size_t level) { return double(table.Total(entry, level)); };
            const double miss = std::abs(blend.Of(total(Low), total(High)) - total(Between));
            double bound = 1;
            for (const size_t reference : {Clear, Half, Low})
                bound = std::min(bound, blend.WorstAgainst(levels[reference], opaque) *
                                            (total(reference) - total(Opaque)));
            EXPECT_LE(miss, bound + 1e-5) << "sigma_a " << blend.between << ", entry " << entry;
            worst = std::max(worst, miss), worstRelative = std::max(worstRelative, miss / total(Between));
            nearest = std::max(nearest, miss / bound);
        }
        std::printf(
            "sigma_a %g: interpolated within %.5f of the light, %.5f of what leaves; %.2f of the bound\n",
            blend.between, worst, worstRelative, nearest);
        // So does the model, here for a viewer of the grid, with the same paths.
        const FiberTable ends(Hair(1, {blend.low, blend.high}), 512);
        const size_t entry = 23;
        const double theta = kPi<double> * ((entry + 0.5) / FiberTable::kThetas - 0.5);
        EXPECT_NEAR(Integrate(Tabulated<double>(&ends, {blend.between, blend.low, blend.high}, 0),
                              Direction(theta, 0))
                        .energy[0],
                    blend.Of(double(ends.Total(entry, 0)), double(ends.Total(entry, 1))), 1e-5);
    }
}

// The levels of a hair of many colours hold the energy between them as well as at them: against tables of the
// very absorptions, which trace the same paths (the clear level decides which are followed), so that there is
// no noise between the two.
TEST(Tabulated, EnergyBetweenLevelsIsThatOfItsOwnTable) {
    std::vector<double> steps = {0, 0.05 / 16, 0.05 / 8}; // as in tabulated_row.cpp
    for (int i = -4; i <= 16; ++i)
        steps.push_back(0.05 * std::pow(2., i / 2.));
    const std::vector<double> between = {0,    0.001, 0.01, 0.02, 0.04, 0.06, 0.12,
                                         0.15, 0.17,  0.24, 0.6,  1.2,  3,    9};
    const FiberTable table(Hair(1, steps), 512), own(Hair(1, between), 512);
    double worst = 0, linear = 0;
    for (size_t level = 1; level < between.size(); ++level)
        for (const size_t entry : {0, 4, 11, 18, 23, 30, 34}) {
            const double theta = kPi<double> * ((double(entry) + 0.5) / FiberTable::kThetas - 0.5);
            const double sigma = between[level], exact = double(own.Total(entry, level));
            const double energy =
                Integrate(Tabulated<double>(&table, {sigma, sigma, sigma}, 0), Direction(theta, 0)).energy[0];
            EXPECT_NEAR(energy, exact, 2e-3 * exact) << sigma << " " << theta;
            worst = std::max(worst, std::abs(energy / exact - 1));
            const size_t above =
                static_cast<size_t>(std::upper_bound(steps.begin(), steps.end(), sigma) - steps.begin());
            const LevelBlend blend{steps[above - 1], sigma, steps[above]};
            const double mixed =
                blend.Of(double(table.Total(entry, above - 1)), double(table.Total(entry, above)));
            linear = std::max(linear, std::abs(mixed / exact - 1));
        }
    std::printf("energy between levels: within %.5f of its own table's; blended linearly %.5f\n", worst,
                linear);
    EXPECT_GT(linear, 2e-3) << "else the test asks nothing";
}

TEST(Tabulated, SharesTablesAndRefusesNonsense) {
    const auto table = TableOf(1);
    EXPECT_EQ(FiberTable::Cached(Hair(1, {0, 0.1, 0.5, 1}), kSamples), table);
    EXPECT_NE(FiberTable::Cached(Hair(1, {0, 0.1}), 64), table);
    EXPECT_THROW(FiberTable(Hair(1, {0.1, 0.1}), 64), Error);
    EXPECT_THROW(FiberTable(Hair(1, {}), 64), Error);
    EXPECT_THROW(TabulatedBSDF(table.get(), Spectrum(NAN), 0), Error);
    // Along the axis, and with numbers at the ends of their range, everything stays finite.
    const TabulatedBSDF bsdf(table.get(), Spectrum(5), 0);
    for (const Vector3f &wo : {Vector3f(1, 0, 0), Vector3f(-1, 0, 0), Vector3f(0, 0, 1)})
        for (const float u : {0.f, OneMinusEpsilon}) {
            Vector3f wi;
            float pdf = 0;
            const Spectrum f = bsdf.Sample_f(wo, &wi, {u, u, u, u}, &pdf);
            EXPECT_TRUE(std::isfinite(f[0]) && std::isfinite(pdf) && pdf >= 0) << wo.x << " " << u;
            EXPECT_NEAR(wi.Length(), 1, 1e-5);
            EXPECT_TRUE(std::isfinite(bsdf.f(wo, Vector3f(1, 0, 0))[0]));
        }
    EXPECT_TRUE(std::isnan(bsdf.f(Vector3f(NAN, 0, 1), Vector3f(0, 0, 1))[0])) << "nanTaint is carried on";
}

} // namespace
} // namespace cuticle
