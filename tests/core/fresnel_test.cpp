// Fresnel reflectances: against complex arithmetic, and at their edges.
#include "core/fresnel.h"

#include <gtest/gtest.h>

#include <complex>

namespace cuticle {
namespace {

// Computes Snell and Fresnel with complex numbers, as any book has them.
template <class Real>
Real Reference(Real cosI, std::complex<Real> index) {
    const std::complex<Real> cosT = std::sqrt(Real(1) - (1 - cosI * cosI) / (index * index));
    const Real s = std::norm((cosI - index * cosT) / (cosI + index * cosT)),
               p = std::norm((index * cosI - cosT) / (index * cosI + cosT));
    return (s + p) / 2;
}

TEST(Fresnel, ConductorAgreesWithComplexArithmetic) {
    for (const float eta : {0.04f, 0.2f, 0.9f, 1.f, 1.5f, 3.f, 6.f})
        for (const float k : {0.f, 1e-3f, 0.5f, 1.f, 3.f, 8.f, 20.f})
            for (int i = 1; i <= 100; ++i) {
                const float cosine = static_cast<float>(i) / 100;
                if (k == 0 && eta < 1 && cosine * cosine < 1 - eta * eta) // total reflection
                    continue;
                EXPECT_NEAR(FrConductor(cosine, eta, k), Reference<double>(cosine, {eta, k}), 3e-6)
                    << eta << " + i " << k << " at " << cosine;
            }
}

TEST(Fresnel, ConductorWithoutAbsorptionIsDielectric) {
    for (const float eta : {1.1f, 1.5f, 2.4f})
        for (int i = 0; i <= 50; ++i)
            EXPECT_NEAR(FrConductor(static_cast<float>(i) / 50, eta, 0),
                        FrDielectric(static_cast<float>(i) / 50, eta), 2e-6f);
}

TEST(Fresnel, ConductorIsDefinedAtItsEdges) {
    EXPECT_EQ(FrConductor(0, 0.2f, 3), 1);
    EXPECT_EQ(FrConductor(0.5f, 1, 0), 0);
    EXPECT_EQ(FrConductor(0, 1, 0), 0);
    EXPECT_EQ(FrConductor(1, 0, 0), 1);
    EXPECT_EQ(FrConductor(0.3f, 0, 0), 1);
    EXPECT_NEAR(FrConductor(0.3f, 0, 5), 1, 1e-6f);
}

// Found by fuzzing: an index of 3.4e38 gave infinity over infinity. The reference has exponents to spare.
TEST(Fresnel, ConductorIsFiniteForAllFloats) {
    for (const float eta : {0.f, 1e-38f, 1e-20f, 1.f, 1e10f, 1e20f, 3.4e38f})
        for (const float k : {0.f, 1e-38f, 1e-20f, 1e-3f, 1e10f, 1e20f, 3.4e38f})
            for (const float cosine : {0.f, 1e-30f, 1e-6f, 0.3f, 0.9f, 1.f}) {
                const float r = FrConductor(cosine, eta, k);
                EXPECT_TRUE(r >= 0 && r <= 1) << eta << " + i " << k << " at " << cosine << ": " << r;
                if (cosine > 0 && (k > 1e-6f || eta > 2)) { // apart from total reflection and its border
                    EXPECT_NEAR(r, static_cast<double>(Reference<long double>(cosine, {eta, k})), 3e-6)
                        << eta << " + i " << k << " at " << cosine;
                }
            }
}

TEST(Fresnel, SchlickHasItsEnds) {
    EXPECT_EQ(FrSchlick(Spectrum(0.04f, 0.5f, 0.9f), 1), Spectrum(0.04f, 0.5f, 0.9f));
    EXPECT_EQ(FrSchlick(Spectrum(0.04f, 0.5f, 0.9f), 0), Spectrum(1));
}

} // namespace
} // namespace cuticle
