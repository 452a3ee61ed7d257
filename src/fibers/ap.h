//> Attenuation $A_p$
#pragma once

#include "core/special.h"
#include "fibers/hair_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

//> Refract into the cylinder
// All in terms of a root that stays finite at grazing angles and for eta = 1,
//     t = sqrt(eta^2 - 1 + cos^2 theta_o cos^2 gamma_o),    a = h cos theta_o,    e^2 = t^2 + a^2:
// e = sqrt(eta^2 - sin^2 theta_o) = eta' cos theta_o, sin gamma_t = h / eta' = a / e, cos gamma_t = t / e. A
// segment is 2 cos gamma_t / cos theta_t radii long, cos theta_t = e / eta, so 2 eta t / e^2. Where the fiber
// is thinner than air (eta < 1) and all light is reflected, t = 0.
template <typename T>
struct Refraction {
    T cosIncident, t, a, length;
    T SinGammaT() const { return a / std::sqrt(t * t + a * a); }
};
template <typename T>
CUTICLE_INLINE Refraction<T> Refract(T cosThetaO, T h, T cosGammaO, T eta, T etaSquaredMinusOne) {
    // Cosines of exactly 0, and theta_o closer than 1e-6 to the axis, are moved off it: the limits at grazing
    // incidence are then taken by themselves.
    const T cosO = std::max(cosThetaO, T(1e-6L)), cosIncident = cosO * std::max(cosGammaO, T(1e-9L));
    const T t = std::sqrt(std::max(T(0), etaSquaredMinusOne + cosIncident * cosIncident)), a = h * cosO;
    return {cosIncident, t, a, 2 * eta * t / std::max(T(1e-30L), t * t + a * a)};
}
//<

//> Compute Fresnel's reflectance and its complement
// f is reflected, 1 - f enters: both without cancellation, since 1 - f vanishes at grazing incidence and f
// for eta = 1. t is eta times the cosine inside.
template <typename T>
struct FresnelPair {
    T f, oneMinusF;
};
template <typename T>
CUTICLE_INLINE FresnelPair<T> Fresnel(T cosIncident, T t, T eta) {
    const T etaC = eta * eta * cosIncident;
    const T a = 1 / (cosIncident + t), b = 1 / (etaC + t);
    const T rs = (cosIncident - t) * a, rp = (etaC - t) * b;
    return {(rs * rs + rp * rp) / 2, 2 * (cosIncident * a * (t * a) + etaC * b * (t * b))};
}
//<

//> Attenuate the lobes
// transmittance: of one segment. A_0 = f, A_p = (1 - f)^2 f^(p-1) T^p, and the last lobe holds the whole rest
// of the series. Its sum has the factor (1 - f) / (1 - f T), 0/0 at the edge of a clear fiber: written as (1
// - f) / ((1 - f) + f (1 - T)) it is at most 1 everywhere, and the A_p of a clear fiber add up to 1.
template <typename V>
CUTICLE_INLINE std::array<V, kLobes> Ap(V f, V oneMinusF, V transmittance, V oneMinusTransmittance) {
    std::array<V, kLobes> ap;
    ap[0] = f;
    ap[1] = oneMinusF * oneMinusF * transmittance;
    ap[2] = ap[1] * transmittance * f;
    const V rest = oneMinusF / Max(V(1e-30f), oneMinusF + f * oneMinusTransmittance);
    ap[3] = oneMinusF * rest * f * f * (transmittance * transmittance * transmittance);
    return ap;
}
//<

//> Weigh colours by their luminance
inline constexpr std::array<float, 3> kLuminance = {0.212671f, 0.715160f, 0.072169f};
template <typename T>
T Luminance(const std::array<T, 3> &c) {
    return T(kLuminance[0]) * c[0] + T(kLuminance[1]) * c[1] + T(kLuminance[2]) * c[2];
}
// No light leaves where the A_p of all lobes add up to less.
inline constexpr float kBlack = 1e-38f;
//<

} // namespace cuticle
//<
