//> Azimuthal scattering $N_p$
#pragma once

#include "core/special.h"
#include "core/vecmath.h"
#include "fibers/hair_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

//> Map the roughness $\beta_n$ to a logistic scale
template <typename T>
inline constexpr T kMinS = T(1) / (1 << 16);

template <typename T>
CUTICLE_INLINE T AzimuthalScale(T betaN) {
    const T b2 = betaN * betaN, b4 = b2 * b2, b8 = b4 * b4, b16 = b8 * b8;
    const T sqrtPiOver8 = T(0.626657068657750125603941L);
    const T s = sqrtPiOver8 * (T(0.265L) * betaN + T(1.194L) * b2 + T(5.372L) * (b16 * b4 * b2));
    return std::max(s, kMinS<T>);
}
//<

template <typename T>
struct Refraction; // chapter 6, in ap.h

//> Compute $\Phi$, the net turn of a path around the fiber
template <typename T>
T Phi(int p, T gammaO, T gammaT) {
    return 2 * T(p) * gammaT - 2 * gammaO + T(p) * kPi<T>;
}
// The same as directions in the plane, vectors of any length. A path that meets the circle at sin gamma_o = h
// turns by -2 gamma_o when it is reflected, and by pi + 2 gamma_t more with every segment: squares and
// products of complex numbers. No angle is formed, so none is rounded or wrapped; no root is needed either,
// as e drops out.
template <typename T>
struct PhiInPlane {
    std::array<T, kLobes> cos, sin;
};
template <typename T>
CUTICLE_INLINE PhiInPlane<T> TurnsOfPaths(T h, T cosGammaO, const Refraction<T> &inside) {
    const T segmentCos = inside.a * inside.a - inside.t * inside.t, segmentSin = -2 * inside.a * inside.t;
    const T cos0 = cosGammaO * cosGammaO - h * h, sin0 = -2 * h * cosGammaO;
    const T cos1 = cos0 * segmentCos - sin0 * segmentSin, sin1 = sin0 * segmentCos + cos0 * segmentSin;
    const T cos2 = cos1 * segmentCos - sin1 * segmentSin, sin2 = sin1 * segmentCos + cos1 * segmentSin;
    return {{cos0, cos1, cos2, 1}, {sin0, sin1, sin2, 0}}; // the last lobe is uniform in azimuth
}
//<

//> Evaluate the logistic function
// exp(-|x|/s) / (s (1 + exp(-|x|/s))^2); 1/s = 0 is the constant norm / 4.
template <typename V>
CUTICLE_INLINE V ScaledLogistic(V absX, V invS, V norm) {
    const V e = Exp(V(0.f) - absX * invS), onePlusE = V(1.f) + e;
    return norm * e / (onePlusE * onePlusE);
}
template <typename T>
T Logistic(T x, T s) {
    return ScaledLogistic(std::abs(x), 1 / s, 1 / s);
}
template <typename T>
T LogisticCDF(T x, T s) {
    return 1 / (1 + std::exp(-x / s));
}
//<

//> Trim the logistic to an interval
// Normalised over [a, b], s > 0. x outside is not looked for.
template <typename T>
T TrimmedLogistic(T x, T s, T a, T b) {
    return Logistic(x, s) / (LogisticCDF(b, s) - LogisticCDF(a, s));
}
// Twice the mass beyond pi, 2 E / (1 + E) with E = exp(-pi/s): what the trim to [-pi, pi] leaves out.
template <typename T>
T LogisticTail(T s) {
    const T e = std::exp(-kPi<T> / s);
    return 2 * e / (1 + e);
}
//<

//> Sample the logistic trimmed to $[-\pi, \pi]$
// The distribution function is inverted for |x|, from the mass that lies outside it: near u = 0 and u = 1 a
// number near 0, not one near 1, decides, so the tails are sampled as well as the middle. Never infinite.
template <typename T>
CUTICLE_INLINE T SampleTrimmedLogistic(T u, T s, T tail) {
    const T outside = 2 * std::min(u, 1 - u), m = tail + outside * (1 - tail);
    const T x = s * std::log((2 - m) / std::max(m, std::numeric_limits<T>::min()));
    return std::copysign(std::clamp(x, T(0), kPi<T>), u - T(0.5L));
}
//<

//> Wrap an angle to $[-\pi, \pi]$
// Rounds the number of turns: one step, also for angles that are enormous; infinity becomes NaN, not an
// endless loop.
template <typename T>
T WrapAngle(T x) {
    return std::clamp(x - 2 * kPi<T> * std::nearbyint(x / (2 * kPi<T>)), -kPi<T>, kPi<T>);
}
//<

//> Evaluate $N_p$
template <typename T>
T Np(T phi, int p, T s, T gammaO, T gammaT) {
    return TrimmedLogistic(WrapAngle(phi - Phi(p, gammaO, gammaT)), s, -kPi<T>, kPi<T>);
}
//<

} // namespace cuticle
//<
