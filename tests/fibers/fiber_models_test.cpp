// All models of the table obey the laws; the general code agrees with the default model.
#include "core/error.h"
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/model_laws.h"
#include "fibers/mp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

namespace cuticle {
namespace {

using std::numbers::pi;

INSTANTIATE_TEST_SUITE_P(All, EveryFiberModel, testing::ValuesIn(Forms()),
                         [](const auto &model) { return model.param.Name(); });

// The same laws hold where a scene has chosen some orders: what is left out is neither evaluated nor sampled.
const FiberForm kTrtAlone{.name = "TRT alone", .own = {{"orders", "TRT"}}};
// Marschner's TRT by itself is all caustics, which the laws' quadrature follows where they are a tenth of the
// light, not the whole.
const FiberForm kWithoutTrt{.name = "R and TT", .own = {{"orders", "R TT"}}, .reciprocal = true};
const FiberForm kBothHighlights{
    .name = "R and TRT", .own = {{"orders", "TRT R"}, {"evaluation", "quadrature"}}, .reciprocal = true};
const FiberForm kRest{.name = "the rest", .own = {{"orders", "rest"}}};
INSTANTIATE_TEST_SUITE_P(SomeOrders, EveryFiberModel,
                         testing::Values(FormCase{FindFiberModel("chiang"), &kTrtAlone},
                                         FormCase{FindFiberModel("chiang"), &kRest},
                                         FormCase{FindFiberModel("marschner"), &kWithoutTrt},
                                         FormCase{FindFiberModel("deon"), &kBothHighlights}),
                         [](const auto &model) { return model.param.Name(); });

// Each order by itself, and all that the scene may name, add up to the fiber as it comes.
TEST(FiberModels, OrdersAddUp) {
    FiberInputs at;
    at.sigmaA = {0.1f, 0.2f, 0.4f};
    const std::vector<std::pair<const char *, std::vector<std::string_view>>> models = {
        {"chiang", {"R", "TT", "TRT", "rest"}},
        {"marschner", {"R", "TT", "TRT"}},
        {"deon", {"R", "TT", "TRT", "TRRT", "rest"}}};
    const auto value = [&](const char *name, const std::vector<OwnValue> &own, double phi) {
        const PreparedFiber fiber(*FindFiberModel(name), at, own);
        FiberStorage storage;
        fiber.Make(0.4f, &storage);
        return storage.Get()->f(Vector3f(laws::Direction(0.2, 0)), Vector3f(laws::Direction(-0.1, phi)));
    };
    for (const auto &[name, orders] : models)
        for (const double phi : {0.3, 1.2, 2.9}) {
            const Spectrum all = value(name, {}, phi);
            Spectrum sum(0);
            for (const std::string_view order : orders)
                sum += value(name, {{"orders", order}}, phi);
            const Spectrum two = value(name, {{"orders", " TRT  R "}}, phi),
                           each = value(name, {{"orders", "R"}}, phi) + value(name, {{"orders", "TRT"}}, phi);
            for (size_t c = 0; c < 3; ++c) {
                EXPECT_GT(all[c], 0);
                EXPECT_NEAR(sum[c], all[c], 2e-4f * all[c]) << name << " " << phi;
                EXPECT_NEAR(two[c], each[c], 1e-5f * each[c] + 1e-9f) << name << " " << phi;
            }
        }
    for (const char *wrong : {"RR", "", "TTT", "TRRRT", "rest TRR"})
        for (const char *name : {"chiang", "marschner"})
            EXPECT_THROW(value(name, {{"orders", wrong}}, 1), Error) << name << " " << wrong;
    EXPECT_THROW(value("marschner", {{"orders", "rest"}}, 1), Error);
    EXPECT_THROW(value("chiang", {{"orders", "R"}, {"tail_share", 0.01f}}, 1), Error);
}

// A far-field model does not know h, and one that does is not said to be one.
TEST(FiberModels, FarFieldsDoNotKnowTheOffset) {
    const Vector3f wo(laws::Direction(0.2, 0)), wi(laws::Direction(-0.3, 1));
    for (const FiberModel &model : FiberModels()) {
        if (model.inCells) // a table that takes seconds; it has no place for h
            continue;
        const PreparedFiber fiber(model, {}, {});
        FiberStorage one, other;
        fiber.Make(0.3f, &one), fiber.Make(-0.6f, &other);
        EXPECT_EQ(one.Get()->f(wo, wi) == other.Get()->f(wo, wi), model.farField) << model.name;
    }
}

// A row's double form is its float form with more digits, in all forms that the laws are asked of.
TEST(FiberModels, DoubleIsTheFloatFormWithMoreDigits) {
    FiberInputs at;
    at.sigmaA = {0.2f, 0.3f, 0.9f}, at.betaM = 0.25f;
    const Vector3d wo = laws::Direction(0.2, 0.6);
    for (const FormCase &c : Forms()) {
        const PreparedFiber fiber(*c.model, at, c.form->own);
        FiberStorage inFloat;
        fiber.Make(c.form->h, &inFloat);
        const auto inDouble = fiber.MakeInDouble(c.form->h);
        double worst = 0;
        for (const Vector3d &wi : {laws::Direction(-0.15, 0.7), laws::Direction(-0.4, 3.6)}) {
            float pdf = 0;
            const Vector3f w(wi);
            const double f = double(inFloat.Get()->FPdf(Vector3f(wo), w, &pdf)[1] * std::abs(w.z));
            const FiberValue<double> exact = inDouble->Evaluate(wo, wi);
            worst = std::max({worst, std::abs(f / exact.fCos[1] - 1), std::abs(double(pdf) / exact.pdf - 1)});
        }
        std::printf("%s: float is within %.1e of double\n", c.Name().c_str(), worst);
        EXPECT_LT(worst, 1e-3) << c.Name();
    }
}

// A name that is taken, and a parameter that a model does not have, are refused.
TEST(FiberModels, MistakesInRowsAreErrors) {
    const FiberModel &first = FiberModels().front();
    EXPECT_THROW(AddFiberModel(first), Error);
    EXPECT_THROW(PreparedFiber(first, {}, {{"exponent", 20.f}}), Error);
    EXPECT_THROW(PreparedFiber(first, {}, {{"lobes", 17}}), Error);
    FiberModel crowded = first;
    crowded.name = "crowded";
    crowded.params.assign(kMaxOwnNumbers + 1, {"x", "float texture", "", "", ""});
    EXPECT_THROW(AddFiberModel(crowded), Error);
    EXPECT_EQ(FindFiberModel("crowded"), nullptr);
}

// A copy is a model of its own, and a new model takes the place of an old one.
TEST(FiberStorage, HoldsOneModelOfAnyKind) {
    FiberStorage empty;
    EXPECT_EQ(FiberStorage(empty).Get(), nullptr);
    const Vector3f wo(laws::Direction(0.2, 0)), wi(laws::Direction(-0.3, 1));
    FiberStorage a;
    a.Emplace<HairBSDF>(0.4f, 1.55f, Spectrum(0.5f), 0.25f, 0.3f, 0.f);
    const Spectrum hair = a.Get()->f(wo, wi);
    FiberStorage b(a);
    EXPECT_NE(a.Get(), b.Get());
    EXPECT_EQ(b.Get()->f(wo, wi), hair);
    b.Emplace<DEonBSDF>(DEonParameters());
    EXPECT_FALSE(b.Get()->f(wo, wi) == hair);
    EXPECT_EQ(a.Get()->f(wo, wi), hair);
}

// HairBSDF's parameters for the general code.
DEonParameters AsChiang(float sigmaA, std::optional<float> h) {
    DEonParameters p;
    p.detector = AzimuthalDetector::Logistic, p.inclination = AttenuationInclination::Viewer;
    p.lobes = 3, p.h = h, p.sigmaA = {sigmaA, sigmaA, sigmaA};
    const auto v = LongitudinalVariance(0.25);
    for (size_t i = 0; i < 3; ++i) {
        p.betaM[i] = static_cast<float>(180 / pi * std::sqrt(v[i]));
        p.betaN[i] = static_cast<float>(180 / std::sqrt(3.) * AzimuthalScale(0.3));
        p.alpha[i] = -2 * kTiltInAlpha[i];
    }
    return p;
}
// With the lobes of the paper, the general near-field code is HairBSDF.
TEST(FiberModels, ChiangWithThreeLobesIsHairBSDF) {
    for (const float h : {-0.9f, 0.f, 0.4f}) {
        const HairBSDF hair(h, 1.55f, Spectrum(0.5f), 0.25f, 0.3f, 2);
        const DEonBSDF general(AsChiang(0.5f, h));
        RNG rng(MixBits(10));
        for (int k = 0; k < 500; ++k) {
            const Vector3f wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()}),
                           wi = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            float a = 0, b = 0;
            const float f = hair.FPdf(wo, wi, &a)[1], g = general.FPdf(wo, wi, &b)[1];
            EXPECT_NEAR(f, g, 1e-3f * f + 1e-6f) << k;
            EXPECT_NEAR(a, b, 1e-3f * a + 1e-6f) << k;
        }
    }
}

// And its far field is HairBSDF's mean over the width, in every pair of directions.
TEST(FiberModels, ChiangIntegratedOverTheWidthIsItsFarField) {
    const DEonBSDF far(AsChiang(0.3f, std::nullopt));
    const int n = 2000;
    double worst = 0;
    for (const Vector3d &wo : {laws::Direction(0.3, 0.6), laws::Direction(-1.2, 2)})
        for (const Vector3d &wi :
             {laws::Direction(-0.25, 0.9), laws::Direction(1.1, 4), laws::Direction(-0.4, 3.6)}) {
            double mean = 0;
            for (int i = 0; i < n; ++i) {
                const double gamma = (i + 0.5) / n * pi - pi / 2;
                const HairBSDF hair(static_cast<float>(std::sin(gamma)), 1.55f, Spectrum(0.3f), 0.25f, 0.3f,
                                    2);
                mean += static_cast<double>(hair.f(Vector3f(wo), Vector3f(wi))[1]) * std::cos(gamma) * pi /
                        (2 * n);
            }
            const double expected = far.f(Vector3f(wo), Vector3f(wi))[1];
            worst = std::max(worst, std::abs(mean - expected) / expected);
        }
    std::printf("HairBSDF's mean over the width against the far field: at most %.1e off\n", worst);
    EXPECT_LT(worst, 3e-3);
}

} // namespace
} // namespace cuticle
