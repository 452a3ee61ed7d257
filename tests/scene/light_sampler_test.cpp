// The choice of a light: probabilities that are what is done, lights that are never forgotten, and the noise
// of many lamps.
#include "scene/light_sampler.h"

#include "core/sampling.h"
#include "parser/plugins.h"
#include "scene/plugins.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <random>

namespace cuticle {
namespace {

// A lamp at a point, bounded as it is told.
class Lamp : public Light {
  public:
    Lamp(LightKind kind, float power, const EmissionBound &bound = {})
        : kind_(kind), power_(power), bound_(bound) {}
    bool Sample_Li(const Point3f &ref, const Point2f &, LightSample *sample) const override {
        const Vector3f way = ref - bound_.box.Center();
        const float d2 = way.LengthSquared();
        *sample = {way / -std::sqrt(d2), 1, std::sqrt(d2), Spectrum(power_ / d2), true};
        return Dot(Normalize(way), bound_.axis) >= std::cos(bound_.normals);
    }
    Spectrum Power() const override { return Spectrum(power_); }
    LightKind Kind() const override { return kind_; }
    EmissionBound Bound() const override { return bound_; }

  private:
    LightKind kind_;
    float power_;
    EmissionBound bound_;
};

EmissionBound At(const Point3f &p) { return {.box = {p, p}}; }

class LightChoice : public ::testing::Test {
  protected:
    void Add(std::unique_ptr<Light> light) {
        pointers_.push_back(light.get());
        lights_.push_back(std::move(light));
    }
    float U() { return std::uniform_real_distribution<float>(0, 1)(random_); }
    Point3f InCube() {
        const float x = U(), y = U(), z = U();
        return {2 * x - 1, 2 * y - 1, 2 * z - 1};
    }
    Vector3f Direction() {
        const float u = U(), v = U();
        return UniformSampleSphere({u, v});
    }
    // Cones and boxes of all sorts, of which some are points.
    void AddLamps(size_t n) {
        for (size_t i = 0; i < n; ++i) {
            EmissionBound bound = At(InCube());
            if (i % 3 == 0)
                bound.box.Extend(bound.box.pMin + Vector3f(U(), U(), U()) * 0.2f);
            if (i % 2 == 0)
                bound.axis = Direction(), bound.normals = U() * Pi, bound.spread = i % 4 ? 0.01f : Pi / 2;
            bound.twoSided = i % 5 == 0;
            Add(std::make_unique<Lamp>(LightKind::Local, std::exp(4 * U()), bound));
        }
    }
    std::mt19937 random_{7};
    std::vector<std::unique_ptr<Light>> lights_;
    std::vector<const Light *> pointers_;
};

TEST_F(LightChoice, DistantLampsByPowerWithAFloor) {
    for (const float power : {1.f, 0.f, 1000.f, 10.f, 0.f})
        Add(std::make_unique<Lamp>(LightKind::Distant, power));
    const LightSampler sampler(pointers_);
    EXPECT_NEAR(sampler.ProbabilityOfKind({}, 0), 0.9 / 1011 + 0.1 / 3, 1e-6);
    EXPECT_NEAR(sampler.ProbabilityOfKind({}, 2), 0.9 * 1000 / 1011 + 0.1 / 3, 1e-6);
    EXPECT_EQ(sampler.ProbabilityOfKind({}, 1), 0);
    EXPECT_EQ(sampler.ProbabilityOfKind({}, 4), 0);
    float probability = 0;
    EXPECT_EQ(sampler.SampleKind(LightKind::Distant, {}, OneMinusEpsilon, &probability), 3)
        << "the last lamp that is lit";
    EXPECT_EQ(LightSampler().SampleKind(LightKind::Distant, {}, 0.5f, &probability), -1);
    EXPECT_EQ(LightSampler({pointers_[1]}).Sample({1, 1, 1}, {}, 0.5f, &probability), -1);
}

TEST_F(LightChoice, SharesByPowerAreThoseOfTheLights) {
    Add(std::make_unique<Lamp>(LightKind::Infinite, 30.f));
    Add(std::make_unique<Lamp>(LightKind::Distant, 10.f));
    Add(std::make_unique<Lamp>(LightKind::Local, 40.f, At({1, 0, 0})));
    Add(std::make_unique<Lamp>(LightKind::Local, 20.f, At({0, 1, 0})));
    const LightShares shares = LightSampler(pointers_).SharesByPower();
    EXPECT_NEAR(shares[0], 0.9 * 0.3 + 0.1 / 4, 1e-6);
    EXPECT_NEAR(shares[1], 0.9 * 0.1 + 0.1 / 4, 1e-6);
    EXPECT_NEAR(shares[2], 0.9 * 0.6 + 0.1 / 2, 1e-6);
}

// Stratified numbers choose every light as often as its probability says, for receivers with and without a
// normal; and where shares leave a rest, none is chosen as often as that.
TEST_F(LightChoice, FrequenciesAreProbabilities) {
    AddLamps(40);
    Add(std::make_unique<Lamp>(LightKind::Infinite, 3.f));
    Add(std::make_unique<Lamp>(LightKind::Distant, 5.f));
    Add(std::make_unique<Lamp>(LightKind::Distant, 1.f));
    const LightSampler sampler(pointers_);
    const LightShares shares{0.1f, 0.2f, 0.4f};
    constexpr int n = 20000;
    for (int r = 0; r < 20; ++r) {
        const LightSampler::Receiver receiver{InCube() * 1.5f, r % 2 ? Vector3f() : Direction()};
        std::vector<double> counts(pointers_.size() + 1);
        for (int i = 0; i < n; ++i) {
            float probability = 0;
            const int light =
                sampler.Sample(shares, receiver, (static_cast<float>(i) + 0.5f) / n, &probability);
            if (light >= 0) {
                ASSERT_NEAR(probability, sampler.Probability(shares, receiver, static_cast<size_t>(light)),
                            1e-5 * static_cast<double>(probability));
            }
            ++counts[light < 0 ? pointers_.size() : static_cast<size_t>(light)];
        }
        double sum = 0;
        for (size_t k = 0; k < pointers_.size(); ++k) {
            const double p{sampler.Probability(shares, receiver, k)};
            EXPECT_NEAR(counts[k] / n, p, 2.5 / n + 1e-5) << k;
            sum += p;
        }
        EXPECT_NEAR(counts[pointers_.size()] / n, 1 - sum, 60. / n);
        EXPECT_NEAR(sum, 0.7, 1e-4);
    }
}

// No lamp that lights a point is forgotten there.
TEST_F(LightChoice, WhatArrivesCanBeChosen) {
    AddLamps(300);
    const LightSampler sampler(pointers_);
    size_t lit = 0;
    for (int r = 0; r < 200; ++r) {
        const LightSampler::Receiver receiver{InCube() * (r % 2 ? 1.f : 30.f),
                                              r % 3 ? Vector3f() : Direction()};
        for (size_t k = 0; k < pointers_.size(); ++k) {
            LightSample sample;
            if (!pointers_[k]->Sample_Li(receiver.p, {}, &sample))
                continue;
            ++lit;
            EXPECT_GT(sampler.ProbabilityOfKind(receiver, k), 0) << k << ", receiver " << r;
        }
    }
    EXPECT_GT(lit, 10000u);
}

// Ten thousand lamps of different power in a cube: the variance of one sample, exact as a sum over all lamps.
TEST_F(LightChoice, NearLampsOfManyAreChosenOften) {
    for (int i = 0; i < 10000; ++i)
        Add(std::make_unique<Lamp>(LightKind::Local, 0.5f + U(), At(InCube())));
    const LightSampler sampler(pointers_);
    const auto relativeVariance = [&](const Point3f &p, const auto &probabilityOf) {
        double sum = 0, squares = 0;
        for (size_t k = 0; k < pointers_.size(); ++k) {
            LightSample sample;
            pointers_[k]->Sample_Li(p, {}, &sample);
            const double L{sample.L[0]};
            sum += L, squares += L * L / probabilityOf(k);
        }
        return squares / (sum * sum) - 1;
    };
    const double power = std::accumulate(pointers_.begin(), pointers_.end(), 0.,
                                         [](double s, const Light *l) { return s + double{l->Power()[0]}; });
    double tree = 0, byPower = 0;
    for (int r = 0; r < 20; ++r) {
        const Point3f p = InCube();
        tree += relativeVariance(p, [&](size_t k) { return double{sampler.ProbabilityOfKind({p, {}}, k)}; });
        byPower += relativeVariance(p, [&](size_t k) { return double{pointers_[k]->Power()[0]} / power; });
    }
    std::cout << fmt::format("relative variance of one sample: {:.3g} by the tree, {:.3g} by power\n",
                             tree / 20, byPower / 20);
    EXPECT_LT(tree, byPower / 8);
}

// All at one point, or one on the other: no division helps, and the tree still ends.
TEST_F(LightChoice, LampsAtOnePointAreToldApartByPower) {
    for (int i = 0; i < 1000; ++i)
        Add(std::make_unique<Lamp>(LightKind::Local, i % 2 ? 3.f : 1.f, At({1, 2, 3})));
    const LightSampler sampler(pointers_);
    for (size_t k = 0; k < 1000; ++k)
        EXPECT_NEAR(sampler.ProbabilityOfKind({{1, 2, 4}, {}}, k), (k % 2 ? 3 : 1) / 2000., 1e-7);
}

} // namespace
} // namespace cuticle
