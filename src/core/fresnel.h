// Fresnel reflectances of smooth boundaries.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"

#include <algorithm>

namespace cuticle {

// Unpolarised reflectance of a dielectric; cosThetaI < 0: from inside. eta = index inside / index outside, >
// 0.
float FrDielectric(float cosThetaI, float eta);
// Unpolarised reflectance of a conductor whose index, relative to the outside, is eta + i k (both >= 0). The
// sign of cosThetaI does not count.
float FrConductor(float cosThetaI, float eta, float k);
Spectrum FrConductor(float cosThetaI, const Spectrum &eta, const Spectrum &k);

// Schlick's (1 - cos)^5, 0 at normal incidence and 1 at grazing (Schlick 1994).
inline float SchlickWeight(float cosTheta) {
    const float m = std::clamp(1 - cosTheta, 0.f, 1.f);
    return Sqr(Sqr(m)) * m;
}
// Schlick's approximation: r0 at normal incidence, 1 at grazing.
inline Spectrum FrSchlick(const Spectrum &r0, float cosTheta) {
    const float w = SchlickWeight(cosTheta);
    return r0 * (1 - w) + Spectrum(w);
}

} // namespace cuticle
