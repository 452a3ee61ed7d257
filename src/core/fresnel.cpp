#include "core/fresnel.h"

#include <cmath>

namespace cuticle {

float FrDielectric(float cosThetaI, float eta) {
    cosThetaI = std::clamp(cosThetaI, -1.f, 1.f);
    if (cosThetaI < 0) {
        eta = 1 / eta;
        cosThetaI = -cosThetaI;
    }
    const float sin2T = (1 - cosThetaI * cosThetaI) / (eta * eta);
    if (sin2T >= 1)
        return 1;
    const float cosT = std::sqrt(1 - sin2T);
    const float parallel = (eta * cosThetaI - cosT) / (eta * cosThetaI + cosT);
    const float perpendicular = (cosThetaI - eta * cosT) / (cosThetaI + eta * cosT);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// In double: the fourth powers of all floats are finite there, so that no index overflows to infinity over
// infinity.
float FrConductor(float cosThetaI, float etaI, float kI) {
    const double eta = etaI, k = kI;
    const double cosI = std::min(std::abs(static_cast<double>(cosThetaI)), 1.0), cos2 = cosI * cosI,
                 sin2 = 1 - cos2;
    // a + i b: the square root of (eta + i k)^2 - sin^2, without the cancellation of a small a beside a
    // large b
    const double t0 = eta * eta - k * k - sin2;
    const double a2b2 = std::sqrt(t0 * t0 + Sqr(2 * eta * k));
    const double larger = std::sqrt((a2b2 + std::abs(t0)) / 2);
    const double a = t0 >= 0 ? larger : eta * k / larger;
    const double t1 = a2b2 + cos2, t2 = 2 * cosI * a;
    if (!(t1 + t2 > 0)) // along a surface that has the index of its outside
        return 0;
    const double perpendicular = (t1 - t2) / (t1 + t2);
    const double t3 = cos2 * a2b2 + sin2 * sin2, t4 = t2 * sin2;
    const double parallel = t3 + t4 > 0 ? perpendicular * (t3 - t4) / (t3 + t4) : perpendicular;
    return static_cast<float>((perpendicular + parallel) / 2);
}

Spectrum FrConductor(float cosThetaI, const Spectrum &eta, const Spectrum &k) {
    Spectrum r;
    for (int i = 0; i < 3; ++i)
        r[i] = FrConductor(cosThetaI, eta[i], k[i]);
    return r;
}

} // namespace cuticle
