// A test of a hair model as one writes it inside pbrt-v3, its headers under their own names.
#include "lowdiscrepancy.h"
#include "materials/hair.h"
#include "pbrt.h"
#include "reflection.h"
#include "rng.h"
#include "sampling.h"
#include "tests/gtest/gtest.h"

#include <cuticle/pbrt3.h> // the same once more, by the name that new code uses

using namespace pbrt;

namespace {

class Glowing : public HairBSDF {
  public:
    using HairBSDF::HairBSDF;
    Spectrum f(const Vector3f &wo, const Vector3f &wi) const { return HairBSDF::f(wo, wi) + Spectrum(1.f); }
};

TEST(Package, UniformAndImportanceSamplingAgree) {
    RNG rng;
    const int count = 64 * 1024;
    const Vector3f wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
    const Spectrum sigma_a =
        HairBSDF::SigmaAFromReflectance(Spectrum(.5), .3) + HairBSDF::SigmaAFromConcentration(.1, .1);
    auto Li = [](const Vector3f &w) -> Spectrum { return w.z * w.z; };
    Spectrum important = 0, uniform = 0.f;
    for (int i = 0; i < count; ++i) {
        const Float h = Clamp(-1 + 2. * RadicalInverse(1, i), -.999999, .999999);
        HairBSDF hair(h, 1.55, sigma_a, .5, .5, 0.f);
        Vector3f wi;
        Float pdf;
        Point2f u = {rng.UniformFloat(), rng.UniformFloat()};
        Spectrum f = hair.Sample_f(wo, &wi, u, &pdf, nullptr);
        if (pdf > 0)
            important += f * Li(wi) * AbsCosTheta(wi) / (count * pdf);
        wi = UniformSampleSphere(u);
        uniform += hair.f(wo, wi) * Li(wi) * AbsCosTheta(wi) / (count * UniformSpherePdf());
    }
    EXPECT_LT(std::abs(important.y() - uniform.y()) / uniform.y(), .05) << important << uniform;
}

TEST(Package, ADerivedClassIsOneOfIts) {
    const Glowing glowing(0, 1.55, 0.f, .3, .3, 2);
    const BxDF &base = glowing;
    const Vector3f w(0, 0, 1);
    EXPECT_FLOAT_EQ(base.f(w, w).y(),
                    glowing.HairBSDF::f(w, w).y() + Pow<0>(2) * Sqr(SafeSqrt(SafeASin(1) * 2 / Pi)));
}

} // namespace
