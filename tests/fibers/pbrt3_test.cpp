// Code as someone would have written it against pbrt-v3: it names nothing outside of namespace pbrt, converts
// numbers as pbrt-v3's types do, and derives from its classes. Each name of fibers/pbrt3.h is used once.
#include "fibers/pbrt3.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <sstream>

// pbrt-v3 is compiled without these, and such code relies on it.
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wfloat-conversion"

using namespace pbrt;

namespace {

TEST(Pbrt3, SmallPowersAndGuardedFunctions) {
    EXPECT_EQ(Sqr(3), 9);
    EXPECT_EQ(Pow<0>(7), 1);
    EXPECT_EQ(Pow<1>(7), 7);
    EXPECT_EQ(Pow<2>(-3), 9);
    EXPECT_EQ(Pow<5>(2), 32);
    EXPECT_EQ(Pow<20>(2), 1048576);
    EXPECT_EQ(Pow<22>(-1), 1);
    EXPECT_EQ(SafeSqrt(-1e-7), 0);
    EXPECT_EQ(SafeSqrt(4), 2);
    EXPECT_TRUE(std::isnan(SafeSqrt(std::nanf(""))));
    EXPECT_FLOAT_EQ(SafeASin(1.0001), PiOver2);
    EXPECT_FLOAT_EQ(SafeASin(-1.0001), -PiOver2);
    EXPECT_FLOAT_EQ(SafeACos(-2), Pi);
    EXPECT_FLOAT_EQ(std::sin(SafeASin(0.25)), 0.25f);
    EXPECT_TRUE(std::isnan(SafeASin(std::nanf(""))));
    const Float clamped = Clamp(-1 + 2. * 1, -.999999, .999999);
    EXPECT_FLOAT_EQ(clamped, .999999f);
    EXPECT_EQ(Clamp(5, 0, 3.5), 3) << "the type is the value's";
    EXPECT_EQ(Lerp(0.25, 0, 8), 2);
    EXPECT_FLOAT_EQ(Radians(180), Pi);
    EXPECT_FLOAT_EQ(Degrees(Pi), 180);
    EXPECT_FLOAT_EQ(InvPi * Pi + Inv2Pi * 2 * Pi + Inv4Pi * 4 * Pi, 3);
    EXPECT_FLOAT_EQ(PiOver4 * 4, Pi);
    EXPECT_FLOAT_EQ(Sqrt2 * Sqrt2, 2);
    EXPECT_FLOAT_EQ(SqrtPiOver8 * SqrtPiOver8 * 8, Pi);
    EXPECT_EQ(1 - MachineEpsilon, OneMinusEpsilon);
    EXPECT_LT(MaxFloat, Infinity);
}

TEST(Pbrt3, AnglesToTheNormal) {
    const Vector3f w = SphericalDirection(0.6, 0.8, PiOver4);
    EXPECT_FLOAT_EQ(CosTheta(w), 0.8f);
    EXPECT_FLOAT_EQ(AbsCosTheta(-w), 0.8f);
    EXPECT_FLOAT_EQ(Cos2Theta(w) + Sin2Theta(w), 1);
    EXPECT_FLOAT_EQ(SinTheta(w), 0.6f);
    EXPECT_FLOAT_EQ(TanTheta(w), 0.75f);
    EXPECT_FLOAT_EQ(Tan2Theta(w), 0.5625f);
    EXPECT_NEAR(CosPhi(w), std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(SinPhi(w), std::sqrt(0.5), 1e-6);
    EXPECT_EQ(CosPhi(Vector3f(0, 0, 1)), 1);
    EXPECT_EQ(SinPhi(Vector3f(0, 0, 1)), 0);
    EXPECT_NEAR(SphericalTheta(w), std::acos(0.8), 1e-6);
    EXPECT_NEAR(SphericalPhi(w), PiOver4, 1e-6);
    EXPECT_NEAR(SphericalPhi(Vector3f(0, -1, 0)), 1.5 * Pi, 1e-6);
    EXPECT_TRUE(SameHemisphere(w, Vector3f(0, 0, 1)));
    EXPECT_FALSE(SameHemisphere(w, -w));
    const Vector3f r = Reflect(w, Vector3f(0, 0, 1));
    EXPECT_FLOAT_EQ(r.x, -w.x);
    EXPECT_FLOAT_EQ(r.z, w.z);
    EXPECT_FLOAT_EQ(FrDielectric(1, 1, 1.5), 0.04f);
    EXPECT_FLOAT_EQ(FrDielectric(-1, 1, 1.5), 0.04f);
    EXPECT_FLOAT_EQ(FrDielectric(-0.1, 1, 1.5), 1) << "total reflection from inside";
}

TEST(Pbrt3, GeometryHasItsNames) {
    const Point3f p(1, 0, 0);
    const Normal3f n(0, 1, 0);
    EXPECT_EQ(Cross(p, n), Vector3f(0, 0, 1));
    EXPECT_EQ(Dot(p, n) + AbsDot(p, -p), 1);
    Vector3f s, t;
    CoordinateSystem(Normalize(Vector3f(0, 0, 5)), &s, &t);
    EXPECT_FLOAT_EQ(Dot(Cross(Vector3f(0, 0, 1), s), t), 1);
    EXPECT_EQ(Point2i(1, 2)[1] + static_cast<int>(Vector2f(3, 4).x), 5);
}

TEST(Pbrt3, ASpectrumIsMadeFromOneNumber) {
    Spectrum sum = 0.f, quarter = .25, whole = 1;
    sum += quarter * 2 + 0.5 * whole;
    EXPECT_EQ(sum, Spectrum(1.f));
    const std::function<Spectrum(const Vector3f &)> Li = [](const Vector3f &w) -> Spectrum {
        return w.z * w.z;
    };
    sum += quarter * Li(Vector3f(0, 0, 2)) * 2.0 / (4 * 0.5f);
    EXPECT_EQ(sum, 2.f);
    sum = true ? sum * quarter : 0.f;
    EXPECT_EQ(sum, .5);
    sum *= 4;
    sum *= quarter;
    sum /= 2;
    sum /= quarter;
    sum -= 0.5f;
    EXPECT_EQ(sum, 0.5f);
    EXPECT_FALSE(sum.IsBlack());
    EXPECT_TRUE((sum - sum).IsBlack());
    EXPECT_FLOAT_EQ(sum.y(), 0.5f);
    EXPECT_EQ(Sqrt(quarter), 0.5);
    EXPECT_EQ(Exp(Spectrum(0)), 1);
    EXPECT_EQ((-sum).Clamp(), 0);
    EXPECT_FALSE(sum.HasNaNs());
    Float rgb[3] = {1, 2, 3}, back[3];
    const RGBSpectrum colour = Spectrum::FromRGB(rgb);
    colour.ToRGB(back);
    EXPECT_EQ(back[2], 3);
    EXPECT_EQ(colour[1], 2);
    EXPECT_EQ(Spectrum::nSamples, 3);
    EXPECT_EQ(colour.MaxComponentValue(), 3);
    std::ostringstream shown;
    shown << colour << Vector3f(0, 0, 1) << Point2f(0, 1);
    EXPECT_NE(shown.str().find('3'), std::string::npos);
}

TEST(Pbrt3, ADefaultGeneratorDrawsUniformNumbers) {
    RNG rng, other(1);
    double sum = 0;
    const int n = 100000;
    int equal = 0, low = 0;
    for (int i = 0; i < n; ++i) {
        const Float u = rng.UniformFloat();
        ASSERT_TRUE(u >= 0 && u <= OneMinusEpsilon);
        sum += u;
        equal += rng.UniformUInt32() == other.UniformUInt32();
        low += rng.UniformUInt32(3) == 0;
    }
    EXPECT_NEAR(sum / n, 0.5, 5 / std::sqrt(12. * n));
    EXPECT_NEAR(low / double(n), 1 / 3., 5 * std::sqrt(2 / 9. / n));
    EXPECT_LT(equal, 5);
    std::vector<int> cards(52);
    for (size_t i = 0; i < cards.size(); ++i)
        cards[i] = static_cast<int>(i);
    rng.Shuffle(cards.begin(), cards.end());
    EXPECT_EQ(std::set<int>(cards.begin(), cards.end()).size(), 52u);
    other.SetSequence(0);
    EXPECT_EQ(other.UniformUInt32(), RNG().UniformUInt32());
}

TEST(Pbrt3, PointsSpreadEvenly) {
    EXPECT_FLOAT_EQ(RadicalInverse(0, 6), 0.375) << "110 in base 2, mirrored: .011";
    EXPECT_FLOAT_EQ(RadicalInverse(1, 5), 7 / 9.) << "12 in base 3, mirrored: .21";
    EXPECT_EQ(RadicalInverse(2, 0), 0);
    EXPECT_LE(RadicalInverse(0, ~uint64_t(0)), OneMinusEpsilon);
    EXPECT_EQ(Primes()[PrimeTableSize - 1], 7919) << "the thousandth prime";
    EXPECT_EQ(ReverseBits32(1), 0x80000000u);
    RNG rng;
    Float line[8];
    Point2f square[6];
    StratifiedSample1D(line, 8, rng);
    StratifiedSample2D(square, 3, 2, rng);
    for (int i = 0; i < 8; ++i)
        EXPECT_EQ(static_cast<int>(line[i] * 8), i);
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(static_cast<int>(square[i].x * 3) + 3 * static_cast<int>(square[i].y * 2), i);
    StratifiedSample1D(line, 8, rng, false);
    EXPECT_EQ(line[0], 1 / 16.f);
}

// The integral of the density is 1, so the mean of 1 / pdf over samples is the area; for each warp.
TEST(Pbrt3, WarpsFollowTheirDensities) {
    EXPECT_FLOAT_EQ(UniformSpherePdf(), Inv4Pi);
    EXPECT_FLOAT_EQ(UniformHemispherePdf(), Inv2Pi);
    EXPECT_FLOAT_EQ(UniformConePdf(0), Inv2Pi);
    EXPECT_FLOAT_EQ(CosineHemispherePdf(1), InvPi);
    EXPECT_FLOAT_EQ(PowerHeuristic(2, 1), 0.8f);
    RNG rng;
    double sphere = 0, half = 0, cosine = 0, cone = 0, disk = 0, triangle = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        const Point2f u = {rng.UniformFloat(), rng.UniformFloat()};
        sphere += Sqr(UniformSampleSphere(u).z) / n; // 1/3
        half += UniformSampleHemisphere(u).z / n;    // 1/2
        cosine += CosineSampleHemisphere(u).z / n;   // 2/3
        cone += UniformSampleCone(u, 0.5).z / n;     // 3/4
        disk += Sqr(ConcentricSampleDisk(u).x) / n;  // 1/4
        triangle += UniformSampleTriangle(u).x / n;  // 1/3
        ASSERT_LT(DemuxFloat(u[0])[0], 1);
    }
    EXPECT_NEAR(sphere, 1 / 3., 0.01);
    EXPECT_NEAR(half, 1 / 2., 0.01);
    EXPECT_NEAR(cosine, 2 / 3., 0.01);
    EXPECT_NEAR(cone, 3 / 4., 0.01);
    EXPECT_NEAR(disk, 1 / 4., 0.01);
    EXPECT_NEAR(triangle, 1 / 3., 0.01);
    EXPECT_NE(MixBits(1), MixBits(2));
}

// Fibers that absorb nothing return all light, by uniform directions and by the model's own.
TEST(Pbrt3, AWhiteFurnaceAsPbrtV3WouldTestIt) {
    RNG rng;
    for (Float beta_m = .3; beta_m < 1; beta_m += .3)
        for (Float beta_n = .3; beta_n < 1; beta_n += .3) {
            const Vector3f wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            Spectrum uniform = 0., sampled = 0.f;
            const int count = 20000;
            for (int i = 0; i < count; ++i) {
                const Float h = Clamp(-1 + 2. * rng.UniformFloat(), -.999999, .999999);
                Spectrum sigma_a = 0.f;
                HairBSDF hair(h, 1.55, sigma_a, beta_m, beta_n, 0.f);
                Vector3f wi = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
                uniform += hair.f(wo, wi) * AbsCosTheta(wi);
                Float pdf;
                Point2f u = {rng.UniformFloat(), rng.UniformFloat()};
                BxDFType sampledType;
                const Spectrum f = hair.Sample_f(wo, &wi, u, &pdf, &sampledType);
                ASSERT_GT(pdf, 0);
                ASSERT_NEAR(f.y() * AbsCosTheta(wi) / pdf, 1, 1e-3) << hair << u << wi;
                ASSERT_NEAR(hair.Pdf(wo, wi) / pdf, 1, 2e-2);
                sampled += f * AbsCosTheta(wi) / pdf;
            }
            EXPECT_NEAR(uniform.y() / (count * UniformSpherePdf()), 1, 0.15) << beta_m << " " << beta_n;
            EXPECT_NEAR(sampled.y() / count, 1, 1e-4);
        }
}

TEST(Pbrt3, ColoursBecomeAbsorption) {
    const Spectrum blonde = HairBSDF::SigmaAFromConcentration(.3, 0);
    EXPECT_EQ(blonde, HairBSDF::SigmaAFromConcentration(.3));
    EXPECT_FLOAT_EQ(blonde[0], 0.3f * 0.419f);
    EXPECT_FLOAT_EQ(HairBSDF::SigmaAFromConcentration(0, 2)[2], 2 * 1.05f);
    EXPECT_LT(HairBSDF::SigmaAFromReflectance(.9, .3).y(), HairBSDF::SigmaAFromReflectance(.1, .3).y());
}

// A class of somebody's own: hair that is half as bright, which nobody asked the original to allow.
class DimHair : public HairBSDF {
  public:
    using HairBSDF::HairBSDF;
    Spectrum f(const Vector3f &wo, const Vector3f &wi) const override { return HairBSDF::f(wo, wi) * .5; }
    std::string ToString() const override { return "dim " + HairBSDF::ToString(); }
};
// And a surface that scatters evenly, by the base's sampling.
class Chalk : public BxDF {
  public:
    Chalk() : BxDF(BxDFType(BSDF_REFLECTION | BSDF_DIFFUSE)) {}
    Spectrum f(const Vector3f &, const Vector3f &) const override { return InvPi; }
    std::string ToString() const override { return "[ Chalk ]"; }
};

TEST(Pbrt3, OneMayDeriveFromItsClasses) {
    const HairBSDF hair(.2, 1.55, .5, .3, .3, 2);
    const DimHair dim(.2, 1.55, .5, .3, .3, 2);
    const BxDF &base = dim;
    const Vector3f wo(.6, 0, .8), wi(-.48, .6, .64);
    EXPECT_FLOAT_EQ(base.f(wo, wi).y(), 0.5f * hair.f(wo, wi).y());
    EXPECT_EQ(base.Pdf(wo, wi), hair.Pdf(wo, wi));
    EXPECT_EQ(base.ToString().substr(0, 4), "dim ");
    EXPECT_TRUE(base.MatchesFlags(BSDF_ALL));
    EXPECT_FALSE(base.MatchesFlags(BxDFType(BSDF_SPECULAR | BSDF_REFLECTION)));
    Float pdf;
    EXPECT_EQ(hair.Native().FPdf(wo, wi, &pdf), hair.f(wo, wi));
    EXPECT_EQ(pdf, hair.Pdf(wo, wi));
    const Chalk chalk;
    Vector3f sampled;
    EXPECT_EQ(chalk.Sample_f(-wo, &sampled, Point2f(.3, .4), &pdf), Spectrum(InvPi));
    EXPECT_TRUE(SameHemisphere(sampled, -wo));
    EXPECT_FLOAT_EQ(pdf, AbsCosTheta(sampled) * InvPi);
    EXPECT_TRUE(chalk.MatchesFlags(BxDFType(BSDF_REFLECTION | BSDF_DIFFUSE)));
}

// The factors put together are the model: what chapter 8's sum says, by pbrt-v3's functions.
TEST(Pbrt3, FactorsMultiplyToTheModel) {
    const Float h = .3, eta = 1.55, beta_m = .3, beta_n = .4;
    const Spectrum sigma_a = .2;
    const HairBSDF hair(h, eta, sigma_a, beta_m, beta_n, 0);
    const Vector3f wo = Normalize(Vector3f(.3, .2, .9)), wi = Normalize(Vector3f(-.1, .5, -.8));
    const Float cosO = std::sqrt(1 - Sqr(wo.x)), cosI = std::sqrt(1 - Sqr(wi.x));
    const Float etap = std::sqrt(eta * eta - Sqr(wo.x)) / cosO;
    const Float gammaO = SafeASin(h), gammaT = SafeASin(h / etap);
    const Float cosThetaT = SafeSqrt(1 - Sqr(wo.x / eta));
    const auto ap = Ap(cosO, eta, h, Exp(-sigma_a * (2 * std::cos(gammaT) / cosThetaT)));
    const Float v0 = Sqr(.726 * beta_m + .812 * Sqr(beta_m) + 3.7 * Pow<20>(beta_m));
    const Float v[pMax + 1] = {v0, v0 / 4, 4 * v0, 4 * v0};
    const Float s = SqrtPiOver8 * (.265 * beta_n + 1.194 * Sqr(beta_n) + 5.372 * Pow<22>(beta_n));
    const Float phi = std::atan2(wi.z, wi.y) - std::atan2(wo.z, wo.y);
    Spectrum sum = 0;
    for (int p = 0; p <= pMax; ++p)
        sum += Mp(cosI, cosO, wi.x, wo.x, v[p]) * ap[size_t(p)] *
               (p < pMax ? Np(phi, p, s, gammaO, gammaT) : Inv2Pi);
    const Spectrum whole = hair.f(wo, wi) * AbsCosTheta(wi);
    EXPECT_NEAR(sum.y() / whole.y(), 1, 1e-4);
    EXPECT_FLOAT_EQ(Phi(1, 0, 0), Pi);
    EXPECT_FLOAT_EQ(TrimmedLogistic(.1, s, -Pi, Pi),
                    Logistic(.1, s) / (LogisticCDF(Pi, s) - LogisticCDF(-Pi, s)));
    EXPECT_NEAR(SampleTrimmedLogistic(.5, s, -Pi, Pi), 0, 1e-5);
    EXPECT_NEAR(SampleTrimmedLogistic(0, s, -1, 2), -1, 1e-5);
    EXPECT_NEAR(SampleTrimmedLogistic(1, s, -1, 2), 2, 1e-4);
    EXPECT_NEAR(I0(2), 2.2795853, 1e-5);
    EXPECT_NEAR(LogI0(100), 96.7797327, 1e-4);
}

} // namespace
