//> Keep the formulas as they were printed
// This file keeps what Pharr's text of 2016 and d'Eon's paper of M_p say, faults included, each named where
// it stands: for tests, charts and what a scene asks for as printed. The model that renders is in
// mp.h, ap.h, np.h and hair_model.h.
#pragma once

#include "fibers/bxdf.h"

#include <array>
#include <cmath>

namespace cuticle {
struct FiberInputs;
}

namespace cuticle::as_printed {

//> Sum ten terms of $I_0$
// Sum of (x/2)^(2k) / k!^2. Used up to x = 12, where ten terms fall short by 2%. d'Eon 2011, equation 15, has
// eleven.
template <typename T, int terms = 10>
T I0(T x) {
    T term = 1, sum = 0;
    for (int k = 1; k <= terms; ++k) {
        sum += term;
        term *= x * x / T(4 * k * k);
    }
    return sum;
}
//<

//> Approximate $\log I_0$
// d'Eon 2013, for x > 12. The asymptotic series asks for 1/(8x) beside the square root; printed inside the
// factor one half, it counts half: 0.57% low at x = 12.
template <typename T>
T LogI0(T x) {
    if (x > 12)
        return x + T(0.5L) * (-std::log(2 * kPi<T>) + std::log(1 / x) + 1 / (8 * x));
    return std::log(I0(x));
}
//<

//> Switch between two forms of $M_p$
// The logarithms cancel in binary32: 5% wrong at a roughness of 0.005, NaN at 0.
template <typename T>
T Mp(T cosThetaI, T cosThetaO, T sinThetaI, T sinThetaO, T v) {
    const T a = cosThetaI * cosThetaO / v, b = sinThetaI * sinThetaO / v;
    if (v <= T(0.1L))
        return std::exp(LogI0(a) - b - 1 / v + T(0.6931L) + std::log(1 / (2 * v)));
    return std::exp(-b) * I0(a) / (std::sinh(1 / v) * 2 * v);
}
//<

//> Take $M_p$ from d'Eon's paper word for word
// d'Eon 2011, equations 7 and 15, for any v. Eleven terms are all of I_0 up to an argument of about 12:
// beyond, light is lost. In binary32 sinh(1/v) overflows below v = 0.0113: nothing is left, and no number
// where the exponential overflows as well.
template <typename T>
T MpOf2011(T cosThetaI, T cosThetaO, T sinThetaI, T sinThetaO, T v) {
    return std::exp(-sinThetaI * sinThetaO / v) * I0<T, 11>(cosThetaI * cosThetaO / v) /
           (std::sinh(1 / v) * 2 * v);
}
//<

//> Take it with the exponentials together
// The same number as exact arithmetic has it, light lost and all, for v of 1e-9 and more: exp(-sin sin / v)
// and the hyperbolic sine meet before either overflows, and the series, whose argument is at most 1/v, fits a
// double. What a scene gets that asks for the printed form.
template <typename T>
T MpOf2011InRange(T cosThetaI, T cosThetaO, T sinThetaI, T sinThetaO, T v) {
    const double w = 1 / static_cast<double>(v);
    const double exponent = std::min(0., -(1 + double(sinThetaI) * double(sinThetaO)) * w);
    const double series = I0<double, 11>(double(cosThetaI) * double(cosThetaO) * w);
    return static_cast<T>(std::exp(exponent) * series * w / -std::expm1(-2 * w));
}
//<

//> Say where the scales tilt
// OnThetaI: Pharr's text rotates theta_i at evaluation, after sampling; cos theta d theta is not kept and
// energy with it. OnThetaO: pbrt-v3's program, exact, but toward the tip. None: alpha is ignored.
enum class Tilt { None, OnThetaI, OnThetaO };
//<

//> Declare the BSDF as the text has it
// One lobe after the other, one transcendental function at a time: what the lanes are measured against. Its
// parameters must lie where it works: h in (-1, 1), roughnesses in (0, 1], sigma_a > 0 or |h| < 1.
class HairBSDF {
  public:
    static const int pMax = 3;
    HairBSDF(Float h, Float eta, const Spectrum &sigma_a, Float beta_m, Float beta_n, Float alpha,
             Tilt tilt = Tilt::OnThetaO);
    Spectrum f(const Vector3f &wo, const Vector3f &wi) const;
    Float Pdf(const Vector3f &wo, const Vector3f &wi) const;
    // u: lobe, azimuth and two numbers for theta_i.
    Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u, Float *pdf) const;

  private:
    std::array<Spectrum, pMax + 1> Attenuations(Float sinThetaO, Float cosThetaO, Float *gammaT) const;
    std::array<Float, pMax + 1> Shares(const std::array<Spectrum, pMax + 1> &ap) const;
    // The angle of lobe p, tilted, as sine and cosine.
    std::array<Float, 2> Turned(int p, Float sinTheta, Float cosTheta, Float sign) const;
    Float Lobe(int p, const Vector3f &wo, const Vector3f &wi, Float dPhi, Float gammaT) const;

    Float h_, gammaO_, eta_;
    Spectrum sigmaA_;
    Tilt tilt_;
    Float s_;
    std::array<Float, pMax + 1> v_;
    std::array<Float, 3> sin2kAlpha_, cos2kAlpha_;
};
//<

//> Offer the printed model beside ours
// Chiang's fit of a colour, nothing clamped.
Float SigmaAFromReflectance(Float reflectance, Float betaN);
// Makes the BSDF above, in float, behind the interface of models in double. No parameter is clamped.
std::unique_ptr<FiberInDouble> PrintedFiber(const FiberInputs &at, Tilt tilt);
//<

} // namespace cuticle::as_printed
//<
