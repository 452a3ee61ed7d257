// Fresnel reflectances: against complex arithmetic, and at their edges.
#include "core/fresnel.h"

#include <gtest/gtest.h>

#include <complex>

namespace cuticle {
namespace {

// Computes Snell and Fresnel with complex numbers, as any book has them.
double Reference(double cosI, std::complex<double> index) {
    const std::complex<double> cosT = std::sqrt(1. - (1 - cosI * cosI) / (index * index));
    const double s = std::norm((cosI - index * cosT) / (cosI + index * cosT)),
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
                EXPECT_NEAR(FrConductor(cosine, eta, k), Reference(cosine, {eta, k}), 3e-6)
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

TEST(Fresnel, SchlickHasItsEnds) {
    EXPECT_EQ(FrSchlick(Spectrum(0.04f, 0.5f, 0.9f), 1), Spectrum(0.04f, 0.5f, 0.9f));
    EXPECT_EQ(FrSchlick(Spectrum(0.04f, 0.5f, 0.9f), 0), Spectrum(1));
}

} // namespace
} // namespace cuticle
