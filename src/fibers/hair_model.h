//> Write the hair model once for all kinds of numbers
#pragma once

#include "core/special.h"
#include "fibers/hair_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

namespace cuticle {

//> Say what the letters stand for
// T is float, double or long double. V is one of these, or a register of floats that holds one number for each
// lobe or for each colour; functions of V are what the fast kernels and the plain model share.
//
// theta is the angle from the plane normal to the fiber, sin theta = w.x, positive toward the tip. phi is the angle
// around the fiber. Suffix O: toward the viewer. I: toward the light. T: inside. p counts the segments inside.
inline constexpr int kLobes = 4;
//<

//> Longitudinal scattering $M_p$
//> Map the roughness $\beta_m$ to a variance
// A fit by Chiang et al. 2016 that makes equal steps of beta_m look alike. No lobe is narrower than 2^-15 rad: v of
// 2^-30. Directions in binary32 are known to 2^-24, so even this lobe is 2^9 steps wide, and all laws still hold.
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
// Half the squared distance between the points (cos theta_i, sin theta_i) and (cos theta_o, -sin theta_o), whose
// differences are exact where it matters. In narrow lobes even the last bit of the two lengths would count: the
// part of the distance that points along the radius, r, is taken out.
template <typename V>
CUTICLE_INLINE V OneMinusCosSum(V sinThetaI, V cosThetaI, V sinThetaO, V cosThetaO) {
    const V dc = cosThetaI - cosThetaO, ds = sinThetaI + sinThetaO;
    const V r = V(0.5f) * (dc * (cosThetaI + cosThetaO) + ds * (sinThetaI - sinThetaO));
    return Max(V(0.f), V(0.5f) * (dc * dc + ds * ds - r * r));
}
//<

//> Evaluate $M_p$ in its stable form
// d'Eon et al. 2011 have csch(1/v) / (2v) exp(-sin sin / v) I_0(cos cos / v), which overflows for small v. Pull
// exp(1/v) out of the hyperbolic sine and exp(cos cos / v) out of I_0: what remains of the exponents is
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
// M_p(theta_o, theta_i), pbrt-v3's order of arguments, any v > 0. Its integral over cos theta_i d theta_i is 1.
template <typename T>
T Mp(T cosThetaI, T cosThetaO, T sinThetaI, T sinThetaO, T v) {
    return ScaledMp(cosThetaI, cosThetaO, sinThetaI, sinThetaO, 1 / v, MpNorm(v));
}
//<

//> Sample $M_p$
// M_p is what a von Mises-Fisher lobe around the mirrored direction, on the sphere, leaves of itself in theta
// (d'Eon 2013). Its cosine is 1 + v log(u + (1 - u) exp(-2/v)): kept as the difference x from 1, for in a narrow
// lobe 1 + x rounds to 1. Returns x in [-2, 0].
template <typename T>
T SampleMpCosine(T u, T v) {
    const T e = std::exp(-2 / v), inLog = u + (1 - u) * e;
    const T log = inLog < T(0.5L) ? std::log(inLog) : std::log1p((1 - u) * std::expm1(-2 / v));
    return std::max(T(-2), v * log);
}
//<

//> Turn the sampled cosine into $\sin\theta_i$ and $\cos\theta_i$
// The axis (cos theta_o, -sin theta_o) tilted by the angle of cosine 1 + x, turned about itself by psi. The cosine of
// theta_i is the length of the two other components, right also where theta_i is near 90 degrees.
template <typename V>
struct SinCosine {
    V sin, cos;
};
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
//<

//> Tilt the lobes with the scales
// theta_o + tilt_p replaces theta_o in M_p, before sampling as in evaluation, so that M_p stays a density. R leans
// by 2 alpha toward the root, TT by alpha and TRT by 4 alpha toward the tip; orders beyond lean all ways.
inline constexpr std::array<float, kLobes> kTiltInAlpha = {2, -1, -4, 0};

// alpha, given in degrees and of any size, in turns, with the sign of the convention. Whole turns are taken off first.
template <typename T>
CUTICLE_INLINE T AlphaInTurns(T alpha, ScaleTilt tilt) {
    const T whole = std::abs(alpha) < 360 ? T(0) : std::trunc(alpha / 360);
    return (alpha - 360 * whole) / (tilt == ScaleTilt::RootToTip ? 360 : -360);
}

// sin and cos of theta_o + tilt. An angle beyond the pole, with its negative cosine, is the same height on the other
// side of the fiber: M_p knows heights only.
template <typename V>
CUTICLE_INLINE SinCosine<V> Tilted(V sinThetaO, V cosThetaO, V sinTilt, V cosTilt) {
    const V cosTilted = cosThetaO * cosTilt - sinThetaO * sinTilt;
    return {sinThetaO * cosTilt + cosThetaO * sinTilt, Max(cosTilted, V(0.f) - cosTilted)};
}
//<

//> Attenuation $A_p$
//> Refract into the cylinder
// All in terms of a root that stays finite at grazing angles and for eta = 1,
//     t = sqrt(eta^2 - 1 + cos^2 theta_o cos^2 gamma_o),    a = h cos theta_o,    e^2 = t^2 + a^2:
// e = sqrt(eta^2 - sin^2 theta_o) = eta' cos theta_o, sin gamma_t = h / eta' = a / e, cos gamma_t = t / e. A segment is
// 2 cos gamma_t / cos theta_t radii long, cos theta_t = e / eta, so 2 eta t / e^2. Where the fiber is thinner than air
// (eta < 1) and all light is reflected, t = 0.
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
// f is reflected, 1 - f enters: both without cancellation, since 1 - f vanishes at grazing incidence and f for
// eta = 1. t is eta times the cosine inside.
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
// transmittance: of one segment. A_0 = f, A_p = (1 - f)^2 f^(p-1) T^p, and the last lobe holds the whole rest of
// the series. Its sum has the factor (1 - f) / (1 - f T), 0/0 at the edge of a clear fiber: written as
// (1 - f) / ((1 - f) + f (1 - T)) it is at most 1 everywhere, and the A_p of a clear fiber add up to 1.
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
//<

//> Azimuthal scattering $N_p$
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

//> Compute $\Phi$, the net turn of a path around the fiber
template <typename T>
T Phi(int p, T gammaO, T gammaT) {
    return 2 * T(p) * gammaT - 2 * gammaO + T(p) * kPi<T>;
}
// The same as directions in the plane, vectors of any length. A path that meets the circle at sin gamma_o = h turns
// by -2 gamma_o when it is reflected, and by pi + 2 gamma_t more with every segment: squares and products of complex
// numbers. No angle is formed, so none is rounded or wrapped; no root is needed either, as e drops out.
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
// The distribution function is inverted for |x|, from the mass that lies outside it: near u = 0 and u = 1 a number
// near 0, not one near 1, decides, so the tails are sampled as well as the middle. Never infinite.
template <typename T>
CUTICLE_INLINE T SampleTrimmedLogistic(T u, T s, T tail) {
    const T outside = 2 * std::min(u, 1 - u), m = tail + outside * (1 - tail);
    const T x = s * std::log((2 - m) / std::max(m, std::numeric_limits<T>::min()));
    return std::copysign(std::clamp(x, T(0), kPi<T>), u - T(0.5L));
}
//<

//> Wrap an angle to $[-\pi, \pi]$
// By rounding: one step, also for angles that are enormous; infinity becomes NaN, not an endless loop.
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
//<

//> Split a direction into its angles
// Unit vectors are asked for. cos theta is the length across the fiber, right also where sin theta is nearly 1. The
// azimuth stays a vector (y, z) across the fiber, of any length. Straight along the fiber (closer than 1e-19) it is
// taken as (1, 0).
template <typename T>
struct FiberAngles {
    T sinTheta, cosTheta, y, z;
    // The direction of inclination theta that lies phi further around the fiber.
    CUTICLE_INLINE Vector3<T> Turned(T sin, T cos, T sinPhi, T cosPhi) const {
        const T scale = cos / std::hypot(y, z);
        return {sin, scale * (y * cosPhi - z * sinPhi), scale * (z * cosPhi + y * sinPhi)};
    }
};
template <typename T>
CUTICLE_INLINE FiberAngles<T> AnglesOf(T x, T y, T z) {
    const T cosTheta = std::sqrt(y * y + z * z);
    return {x, cosTheta, cosTheta > 0 ? y : T(1), z};
}
// phi_i - phi_o as a vector of any length, its sine and cosine scaled.
template <typename T>
CUTICLE_INLINE SinCosine<T> RelativeAzimuth(const FiberAngles<T> &o, const FiberAngles<T> &i) {
    return {o.y * i.z - o.z * i.y, o.y * i.y + o.z * i.z};
}
//<

//> Bring a vector in the plane to length 1
// Of any length, also one whose square underflows, as near total reflection; (1, 0) for none.
template <typename T>
CUTICLE_INLINE SinCosine<T> UnitVector(T sin, T cos) {
    const T larger = std::max(std::abs(sin), std::abs(cos));
    if (!(larger > 0))
        return {0, 1};
    const T s = sin / larger, c = cos / larger, inverse = 1 / std::sqrt(s * s + c * c);
    return {s * inverse, c * inverse};
}
//<

//> Weigh colours by their luminance
inline constexpr std::array<float, 3> kLuminance = {0.212671f, 0.715160f, 0.072169f};
template <typename T>
T Luminance(const std::array<T, 3> &c) {
    return T(kLuminance[0]) * c[0] + T(kLuminance[1]) * c[1] + T(kLuminance[2]) * c[2];
}
// Where the A_p of all lobes add up to less, no light leaves.
inline constexpr float kBlack = 1e-38f;
//<

//> Put the model together, plainly
//> Declare the plain model
// One lobe after the other, in the order of the text: what the book explains and what the kernels are tested
// against. Float renders where no kernel fits the processor; double and long double are the reference.
template <typename T>
class HairLobes {
  public:
    explicit HairLobes(const HairParameters &parameters);
    // From what a kernel has prepared.
    explicit HairLobes(const HairSetup &setup)
        : h(setup.h), cosGammaO(setup.cosGammaO),
          eta(setup.eta), sigmaA{setup.sigmaA[0], setup.sigmaA[1], setup.sigmaA[2]}, v(setup.v),
          sinTilt(setup.sinTilt), cosTilt(setup.cosTilt), s(setup.s), npTail(setup.npTail) {}

    struct Value {
        std::array<T, 3> fCos; // f |wi.z|
        T pdf;
    };
    // The same for directions given as unit vectors.
    Value Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in [0, 1).
    Value Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const;
    // A_p of each lobe in r, g, b for wo.
    std::array<std::array<T, 3>, kLobes> Attenuations(const Vector3<T> &wo) const;
    // M_p and N_p of lobe p.
    T Longitudinal(size_t p, T sinThetaO, T cosThetaO, T sinThetaI, T cosThetaI) const;
    T Azimuthal(size_t p, T dPhi) const;

    T h, cosGammaO, eta;
    std::array<T, 3> sigmaA;
    std::array<T, kLobes> v, sinTilt, cosTilt;
    T s, npTail;

  private:
    Refraction<T> Refracted(T cosThetaO) const {
        return Refract(cosThetaO, h, cosGammaO, eta, (eta - 1) * (eta + 1));
    }
    Value Gather(const FiberAngles<T> &o, T sinThetaI, T cosThetaI, const std::array<T, kLobes> &dPhi) const;
};
//<

//> Prepare a fiber
template <typename T>
HairLobes<T>::HairLobes(const HairParameters &parameters)
    : h(parameters.h), cosGammaO(std::sqrt((1 - h) * (1 + h))), eta(parameters.eta),
      v(LongitudinalVariance(T(parameters.betaM))), s(AzimuthalScale(T(parameters.betaN))),
      npTail(LogisticTail(s)) {
    for (size_t c = 0; c < 3; ++c)
        sigmaA[c] = T(parameters.sigmaA[c]);
    const T alpha = 2 * kPi<T> * AlphaInTurns(T(parameters.alpha), parameters.tilt);
    for (size_t p = 0; p < kLobes; ++p) {
        sinTilt[p] = std::sin(T(kTiltInAlpha[p]) * alpha);
        cosTilt[p] = std::cos(T(kTiltInAlpha[p]) * alpha);
    }
}
//<

//> Attenuate each lobe and each colour
template <typename T>
std::array<std::array<T, 3>, kLobes> HairLobes<T>::Attenuations(const Vector3<T> &wo) const {
    const Refraction<T> inside = Refracted(AnglesOf(wo.x, wo.y, wo.z).cosTheta);
    const FresnelPair<T> fresnel = Fresnel(inside.cosIncident, inside.t, eta);
    std::array<std::array<T, 3>, kLobes> result;
    for (size_t c = 0; c < 3; ++c) {
        const T depth = sigmaA[c] * inside.length;
        const std::array<T, kLobes> ap =
            Ap(fresnel.f, fresnel.oneMinusF, std::exp(-depth), -std::expm1(-depth));
        for (size_t p = 0; p < kLobes; ++p)
            result[p][c] = ap[p];
    }
    return result;
}
//<

//> Evaluate one lobe
template <typename T>
T HairLobes<T>::Longitudinal(size_t p, T sinThetaO, T cosThetaO, T sinThetaI, T cosThetaI) const {
    const SinCosine<T> tilted = Tilted(sinThetaO, cosThetaO, sinTilt[p], cosTilt[p]);
    return Mp(cosThetaI, tilted.cos, sinThetaI, tilted.sin, v[p]);
}
template <typename T>
T HairLobes<T>::Azimuthal(size_t p, T dPhi) const {
    return p < 3 ? Logistic(dPhi, s) / (1 - npTail) : 1 / (2 * kPi<T>);
}
//<

//> Add the lobes up
// dPhi: the angle of each lobe from its centre. pdf weighs the lobes by the luminance of A_p.
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Gather(const FiberAngles<T> &o, T sinThetaI, T cosThetaI,
                                                  const std::array<T, kLobes> &dPhi) const {
    const auto ap = Attenuations({o.sinTheta, o.cosTheta, T(0)});
    Value value{{0, 0, 0}, 0};
    T sumY = 0;
    for (size_t p = 0; p < kLobes; ++p) {
        const T density =
            Longitudinal(p, o.sinTheta, o.cosTheta, sinThetaI, cosThetaI) * Azimuthal(p, dPhi[p]);
        const T y = Luminance(ap[p]);
        for (size_t c = 0; c < 3; ++c)
            value.fCos[c] += ap[p][c] * density;
        value.pdf += y * density;
        sumY += y;
    }
    value.pdf = sumY < T(kBlack) ? T(0) : value.pdf / sumY;
    return value;
}
//<

//> Evaluate the sum for two directions
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z), i = AnglesOf(wi.x, wi.y, wi.z);
    const SinCosine<T> phi = RelativeAzimuth(o, i);
    const Refraction<T> inside = Refracted(o.cosTheta);
    const PhiInPlane<T> turn = TurnsOfPaths(h, cosGammaO, inside);
    std::array<T, kLobes> dPhi;
    for (size_t p = 0; p < kLobes; ++p)
        dPhi[p] = std::atan2(phi.sin * turn.cos[p] - phi.cos * turn.sin[p],
                             phi.cos * turn.cos[p] + phi.sin * turn.sin[p]);
    return Gather(o, i.sinTheta, i.cosTheta, dPhi);
}
//<

//> Sample a direction
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Sample(const Vector3<T> &wo, std::array<T, 4> u,
                                                  Vector3<T> *wi) const {
    for (T &x : u)
        x = std::clamp(x, T(kMinU), T(OneMinusEpsilon));
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z);
    const Refraction<T> inside = Refracted(o.cosTheta);
    //> Choose the lobe by its share of the luminance
    const auto ap = Attenuations(wo);
    std::array<T, kLobes> y;
    T sumY = 0;
    for (size_t p = 0; p < kLobes; ++p)
        sumY += y[p] = Luminance(ap[p]);
    size_t q = 0;
    T rest = u[0] * sumY;
    for (size_t p = 0; p < kLobes && rest >= 0; ++p)
        if (y[p] > 0) // never a lobe without light, whatever the rounding
            q = p, rest -= y[p];
    //<
    //> Sample $\theta_i$ about the tilted mirror direction
    const SinCosine<T> axis = Tilted(o.sinTheta, o.cosTheta, sinTilt[q], cosTilt[q]);
    const T x = SampleMpCosine(u[2], v[q]), psi = 2 * kPi<T> * u[3];
    const SinCosine<T> thetaI = TurnFromAxis(x, std::sin(psi), std::cos(psi), axis.sin, axis.cos);
    //<
    //> Sample $\phi_i - \phi_o$ about the turn of the path
    const T dPhiQ = q < 3 ? SampleTrimmedLogistic(u[1], s, npTail) : kPi<T> * (2 * u[1] - 1);
    const PhiInPlane<T> turn = TurnsOfPaths(h, cosGammaO, inside);
    const T c = std::cos(dPhiQ), d = std::sin(dPhiQ);
    const SinCosine<T> phi = UnitVector(d * turn.cos[q] + c * turn.sin[q], c * turn.cos[q] - d * turn.sin[q]);
    *wi = o.Turned(thetaI.sin, thetaI.cos, phi.sin, phi.cos);
    //<
    //> Evaluate at the sampled angles
    // Not at those of *wi: rounding to a vector would change the azimuth by many parts of a narrow lobe's width.
    std::array<T, kLobes> dPhi;
    for (size_t p = 0; p < kLobes; ++p)
        dPhi[p] = p == q ? dPhiQ
                         : std::atan2(phi.sin * turn.cos[p] - phi.cos * turn.sin[p],
                                      phi.cos * turn.cos[p] + phi.sin * turn.sin[p]);
    return Gather(o, thetaI.sin, thetaI.cos, dPhi);
    //<
}
//<
//<

} // namespace cuticle
//<
