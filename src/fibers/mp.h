//> Longitudinal scattering $M_p$
#pragma once

#include "core/special.h"
#include "fibers/hair_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

//> Map the roughness $\beta_m$ to a variance
// A fit by Chiang et al. 2016 that makes equal steps of beta_m look alike. No lobe is narrower than 2^-15
// rad: v of 2^-30. Directions in binary32 are known to 2^-24, so even this lobe is 2^9 steps wide, and all
// laws still hold.
template <typename T>
inline constexpr T kMinV = T(1) / (1 << 30);

template <typename T>
CUTICLE_INLINE T UnscaledVariance(T betaM) {
    const T b2 = betaM * betaM, b4 = b2 * b2, b8 = b4 * b4, b16 = b8 * b8;
    return Sqr(T(0.726L) * betaM + T(0.812L) * b2 + T(3.7L) * (b16 * b4));
}
// Refraction narrows TT; every reflection inside widens what follows.
template <typename T>
std::array<T, kLobes> LongitudinalVariance(T betaM) {
    const T v = UnscaledVariance(betaM), floor = kMinV<T>;
    return {std::max(v, floor), std::max(v / 4, floor), std::max(4 * v, floor), std::max(4 * v, floor)};
}
//<

//> Compute $1 - \cos(\theta_i + \theta_o)$ without cancellation
// Half the squared distance between the points (cos theta_i, sin theta_i) and (cos theta_o, -sin theta_o),
// whose differences are exact where it matters. In narrow lobes even the last bit of the two lengths would
// count: the part of the distance that points along the radius, r, is taken out.
template <typename V>
CUTICLE_INLINE V OneMinusCosSum(V sinThetaI, V cosThetaI, V sinThetaO, V cosThetaO) {
    const V dc = cosThetaI - cosThetaO, ds = sinThetaI + sinThetaO;
    const V r = V(0.5f) * (dc * (cosThetaI + cosThetaO) + ds * (sinThetaI - sinThetaO));
    return Max(V(0.f), V(0.5f) * (dc * dc + ds * ds - r * r));
}
//<

//> Evaluate $M_p$ in its stable form
// d'Eon et al. 2011 have csch(1/v) / (2v) exp(-sin sin / v) I_0(cos cos / v), which overflows for small v.
// Pull exp(1/v) out of the hyperbolic sine and exp(cos cos / v) out of I_0: what remains of the exponents is
// -(1 - cos(theta_i + theta_o)) / v, never positive. One formula for every v; mpNorm is MpNorm(v).
template <typename V>
CUTICLE_INLINE V ScaledMp(V cosThetaI, V cosThetaO, V sinThetaI, V sinThetaO, V invV, V mpNorm) {
    const ScaledBessel<V> bessel = SplitI0e(cosThetaI * cosThetaO * invV);
    const V exponent = OneMinusCosSum(sinThetaI, cosThetaI, sinThetaO, cosThetaO) * invV + bessel.exponent;
    return Exp(-exponent) * bessel.factor * mpNorm;
}
//<

//> Normalise $M_p$ over $\cos \theta_i \, d\theta_i$
template <typename T>
T MpNorm(T v) {
    return -1 / (v * std::expm1(-2 / v));
}
// M_p(theta_o, theta_i), pbrt-v3's order of arguments, any v > 0. Its integral over cos theta_i d theta_i is
// 1.
template <typename T>
T Mp(T cosThetaI, T cosThetaO, T sinThetaI, T sinThetaO, T v) {
    return ScaledMp(cosThetaI, cosThetaO, sinThetaI, sinThetaO, 1 / v, MpNorm(v));
}
//<

//> Sample $M_p$
// M_p is what a von Mises-Fisher lobe around the mirrored direction, on the sphere, leaves of itself in theta
// (d'Eon 2013). Its cosine is 1 + v log(u + (1 - u) exp(-2/v)): kept as the difference x from 1, for in a
// narrow lobe 1 + x rounds to 1. Returns x in [-2, 0].
template <typename T>
T SampleMpCosine(T u, T v) {
    const T e = std::exp(-2 / v), inLog = u + (1 - u) * e;
    const T log = inLog < T(0.5L) ? std::log(inLog) : std::log1p((1 - u) * std::expm1(-2 / v));
    return std::max(T(-2), v * log);
}
//<

//> Turn the sampled cosine into $\sin\theta_i$ and $\cos\theta_i$
// The axis (cos theta_o, -sin theta_o) tilted by the angle of cosine 1 + x, turned about itself by psi. The
// cosine of theta_i is the length of the two other components, right also where theta_i is near 90 degrees.
template <typename T>
CUTICLE_INLINE SinCosine<T> TurnFromAxis(T x, T sinPsi, T cosPsi, T sinThetaO, T cosThetaO) {
    const T cosT = 1 + x, sinT = std::sqrt(std::max(T(0), -x * (2 + x)));
    const T along = sinT * cosPsi * cosThetaO - cosT * sinThetaO;
    const T across = sinT * cosPsi * sinThetaO + cosT * cosThetaO;
    const T cosTheta = std::sqrt(across * across + sinT * sinPsi * (sinT * sinPsi));
    // One step of Newton's for the length: sine and cosine square to 1 again.
    const T scale = T(1.5L) - T(0.5L) * (along * along + cosTheta * cosTheta);
    return {along * scale, cosTheta * scale};
}
//<

//> Tilt the lobes with the scales
// theta_o + tilt_p replaces theta_o in M_p, before sampling as in evaluation, so that M_p stays a density. R
// leans by 2 alpha toward the root, TT by alpha and TRT by 4 alpha toward the tip; orders beyond lean all
// ways.
inline constexpr std::array<float, kLobes> kTiltInAlpha = {2, -1, -4, 0};

// Returns the tilts in turns, from alpha in degrees and of any finite size, with the sign of the convention.
// Remainders are exact, so of a huge alpha its own angle is left, the same in every kernel; what is rounded
// is a number below half a turn.
template <typename T>
CUTICLE_INLINE std::array<T, kLobes> TiltsInTurns(T alpha, ScaleTilt tilt) {
    const T rest = std::abs(alpha) < 360 ? alpha : std::fmod(alpha, T(360));
    std::array<T, kLobes> turns;
    for (size_t p = 0; p < kLobes; ++p) {
        const T degrees = T(kTiltInAlpha[p]) * rest;
        turns[p] = (std::abs(degrees) <= 180 ? degrees : std::remainder(degrees, T(360))) /
                   (tilt == ScaleTilt::RootToTip ? 360 : -360);
    }
    return turns;
}

// sin and cos of theta_o + tilt. An angle beyond the pole, with its negative cosine, is the same height on
// the other side of the fiber: M_p knows heights only.
template <typename V>
CUTICLE_INLINE SinCosine<V> Tilted(V sinThetaO, V cosThetaO, V sinTilt, V cosTilt) {
    const V cosTilted = cosThetaO * cosTilt - sinThetaO * sinTilt;
    return {sinThetaO * cosTilt + cosThetaO * sinTilt, Max(cosTilted, V(0.f) - cosTilted)};
}
//<

} // namespace cuticle
//<
