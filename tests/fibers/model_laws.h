// The laws that hold for every model of a fiber, as tests that ask any row of the table in the forms that it
// names. A program that includes this states which: INSTANTIATE_TEST_SUITE_P(Name, EveryFiberModel,
// ValuesIn(...)).
#pragma once

#include "fibers/fiber_laws.h"
#include "fibers/model_edges.h"
#include "fibers/models.h"
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

namespace cuticle {

// One form of a model, of those that its row names.
struct FormCase {
    const FiberModel *model;
    const FiberForm *form;
    std::string Name() const { // letters, digits and underscores, as googletest has them
        std::string name(model->name);
        if (!form->name.empty())
            name += "_" + std::string(form->name);
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == ' ' || c == '-'; }, '_');
        return name;
    }
};
// Roughnesses that the laws' quadrature follows, and no tilt.
class FormOfModel {
  public:
    FormOfModel(const FormCase &c, float sigmaA) : fiber_(*c.model, InputsOf(sigmaA), c.form->own) {
        fiber_.Make(c.form->h, &storage_);
    }
    const FiberBxDF &operator*() const { return *storage_.Get(); }
    const FiberBxDF *operator->() const { return storage_.Get(); }

  private:
    static FiberInputs InputsOf(float sigmaA) {
        FiberInputs at;
        at.sigmaA = {sigmaA, sigmaA, sigmaA}, at.betaM = 0.25f, at.betaN = 0.3f, at.alpha = 0;
        return at;
    }
    PreparedFiber fiber_;
    FiberStorage storage_;
};

// All forms of the table that are lawful.
inline std::vector<FormCase> Forms() {
    std::vector<FormCase> forms;
    for (const FiberModel &model : FiberModels())
        for (const FiberForm &form : model.forms)
            if (form.lawful)
                forms.push_back({&model, &form});
    return forms;
}

inline laws::Reference ReferenceOf(const FiberBxDF &bsdf) {
    return [&bsdf](const Vector3d &wo, const Vector3d &wi) {
        float pdf = 0;
        const Vector3f w(wi);
        const Spectrum f = bsdf.FPdf(Vector3f(wo), w, &pdf) * std::max(std::abs(w.z), 1e-20f);
        return FiberValue<double>{{f[0], f[1], f[2]}, pdf};
    };
}
// Peaks fit for lobes of 0.1 and wider, and for the caustics of smooth fibers.
inline laws::Peaks PeaksAt(const FormCase &c, double theta) {
    laws::Peaks peaks{{{-theta, 0.15}}, {{0.6, 0.2}, {0.6 + std::numbers::pi, 0.3}}};
    const SmoothFiber<double> fiber(std::cos(theta), 1.55);
    const double caustic = WrapAngle(fiber.Phi(2, fiber.TurningPoint(2)));
    if (c.model->caustics)
        for (const double sign : {-1., 1.})
            peaks.phi.push_back({0.6 + sign * caustic, 0.02});
    return peaks;
}
inline double EnergyOf(const FiberBxDF &bsdf, const FormCase &model, double theta) {
    return laws::OverSphere(ReferenceOf(bsdf), laws::Direction(theta, 0.6), PeaksAt(model, theta), 1.3)
        .energy[1];
}

class EveryFiberModel : public testing::TestWithParam<FormCase> {};

// A white fiber returns all light, where its paper says so, from every side.
TEST_P(EveryFiberModel, Energy) {
    const FormCase &model = GetParam();
    const FormOfModel white(model, 0), brown(model, 0.5f);
    const double tolerance = model.form->energyTolerance;
    std::printf("%s:", model.Name().c_str());
    for (const double theta : {0.2, -1.4}) {
        const double energy = EnergyOf(*white, model, theta);
        std::printf(" %.5f", energy);
        if (tolerance > 0) {
            EXPECT_NEAR(energy, 1, tolerance) << theta;
        }
        EXPECT_LE(EnergyOf(*brown, model, theta), energy);
    }
    std::printf(" of the light at 11, -80 degrees\n");
}

// Samples follow the density, the density is one, and the weights' mean is the energy: 5 standard errors, n
// samples.
TEST_P(EveryFiberModel, Sampling) {
    const FormCase &model = GetParam();
    const FormOfModel bsdf(model, 0.2f);
    const int n = 50000;
    const double theta = 0.9;
    const Vector3d wo = laws::Direction(theta, 0.6);
    const laws::SampleTest result =
        laws::ChiSquared(*bsdf, ReferenceOf(*bsdf), wo, PeaksAt(model, theta), 5, n);
    EXPECT_GT(result.p, 0.01 / static_cast<double>(Forms().size())) << "n " << n;
    EXPECT_NEAR(result.pdf, 1, 2e-3);
    EXPECT_LT(result.largestWeight, 12);
    const double energy = EnergyOf(*bsdf, model, theta);
    RNG rng(MixBits(6));
    double sum = 0, squares = 0;
    for (int k = 0; k < n; ++k) {
        Vector3f wi;
        float pdf = 0;
        const Spectrum f = bsdf->Sample_f(
            Vector3f(wo), &wi,
            std::array{rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
        const double weight = pdf > 0 ? static_cast<double>(f[1] * std::abs(wi.z) / pdf) : 0.;
        sum += weight, squares += weight * weight;
    }
    const double mean = sum / n, variance = std::max(0., squares / n - mean * mean);
    EXPECT_NEAR(mean, energy, 5 * std::sqrt(variance / n) + 1e-3 * energy) << "n " << n;
    std::printf("%s: p %.3f, largest weight %.2f, variance of the weights %.4f\n", model.Name().c_str(),
                result.p, result.largestWeight, variance);
}

// No value or density is negative or NaN, from anywhere to anywhere.
TEST_P(EveryFiberModel, IsFiniteAndNotNegative) {
    for (const float sigmaA : {0.f, 1.f, 1e6f}) {
        const FormOfModel bsdf(GetParam(), sigmaA);
        RNG rng(MixBits(8));
        for (int k = 0; k < 3000; ++k) {
            Vector3f w[2];
            for (Vector3f &d : w) {
                d = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
                if (k % 3 == 0) // near the ends of the fiber
                    d = Normalize(Vector3f(std::copysign(1.f, d.x), 1e-5f * d.y, 1e-5f * d.z));
            }
            float pdf = 0;
            const Spectrum f = bsdf->FPdf(w[0], w[1], &pdf);
            EXPECT_TRUE(f.IsFinite() && std::isfinite(pdf) && pdf >= 0 && std::min({f[0], f[1], f[2]}) >= 0)
                << f[0] << " " << pdf << " sigma_a " << sigmaA << " k " << k;
        }
    }
}

// Random numbers at the two ends of [0, 1), views along the fiber too, and its two edges: a sample has a
// direction of unit length, and value and density are those of that direction, finite and not negative; in
// double as well.
TEST_P(EveryFiberModel, SamplesHoldAtTheEndsAndOnTheAxis) {
    const FormCase &model = GetParam();
    const float half = std::sqrt(0.5f);
    const Vector3f kViews[] = {
        {1, 0, 0}, {-1, 0, 0},      {1, 1e-7f, 0},   {-1, 0, -1e-20f},  {0, 1, 0},
        {0, 0, 1}, {0, half, half}, {half, 0, half}, {-half, -half, 0}, {-0.6f, 0.48f, 0.64f}};
    for (const float sigmaA : {0.f, 0.3f, 1e6f})
        for (const float h : {model.form->h, -1.f, 1.f}) {
            FiberInputs at;
            at.sigmaA = {sigmaA, sigmaA, sigmaA}, at.betaM = 0.25f, at.betaN = 0.3f;
            const PreparedFiber fiber(*model.model, at, model.form->own);
            FiberStorage storage;
            fiber.Make(h, &storage);
            const auto inDouble = fiber.MakeInDouble(h);
            edges::Chooser chooser(17);
            for (const Vector3f &wo : kViews)
                for (int k = 0; k < 300; ++k) {
                    edges::Query q{h, wo, -wo, {}};
                    for (float &u : q.u)
                        u = chooser.OneIn(4) ? chooser.Uniform() : chooser.Of(kEndsOfU);
                    const std::string text = edges::Text(q);
                    ASSERT_EQ(edges::FaultAt(*storage.Get(), q), "") << sigmaA << " " << text;
                    Vector3f wi;
                    float pdf = 0, again = 0;
                    const Spectrum f = storage.Get()->Sample_f(wo, &wi, q.u, &pdf);
                    const Spectrum same = storage.Get()->FPdf(wo, wi, &again);
                    const bool nearAxis = std::hypot(wi.y, wi.z) < 1e-3f;
                    if (pdf > 1e-6f && !model.model->caustics && !nearAxis) {
                        EXPECT_NEAR(again / pdf, 1, 0.02) << text;
                        EXPECT_NEAR(same[1], f[1], 0.02 * double(f[1]) + 1e-6) << text;
                    }
                    Vector3d exact;
                    const FiberValue<double> value =
                        inDouble->Sample(Vector3d(wo), {q.u[0], q.u[1], q.u[2], q.u[3]}, &exact);
                    ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf >= 0) << value.pdf << text;
                    for (const double c : value.fCos)
                        ASSERT_TRUE(std::isfinite(c) && c >= 0) << c << text;
                    ASSERT_NEAR(exact.Length(), 1, 1e-6) << text;
                }
        }
}

// A law of some models; of the others it is stated that they break it, by more than a tenth somewhere.
TEST_P(EveryFiberModel, Reciprocity) {
    const FormOfModel bsdf(GetParam(), 0.3f);
    const laws::Reference value = ReferenceOf(*bsdf);
    const bool holdsCosine = GetParam().model->cosineInside, reciprocal = GetParam().form->reciprocal;
    RNG rng(MixBits(9));
    const auto u = [&rng] { return static_cast<double>(rng.UniformFloat()); };
    double worst = 0;
    for (int k = 0; k < 300; ++k) {
        const Vector3d a = laws::Direction(2.4 * u() - 1.2, 6.28 * u()),
                       b = laws::Direction(2.4 * u() - 1.2, 6.28 * u());
        // d'Eon's M_p holds the cosines; Marschner's S does not.
        const double forth = value(a, b).fCos[0] / (holdsCosine ? 1 : std::hypot(b.y, b.z)),
                     back = value(b, a).fCos[0] / (holdsCosine ? 1 : std::hypot(a.y, a.z));
        if (reciprocal) {
            EXPECT_NEAR(forth, back, 3e-3 * (forth + back) + 1e-5);
        }
        worst = std::max(worst, std::abs(forth - back) / (forth + back + 1e-5));
    }
    if (!reciprocal) {
        EXPECT_GT(worst, 0.1);
    }
}

} // namespace cuticle
