//> Offer the hair model to code written for pbrt-v3
// This header lets code that was written against pbrt-v3's hair scattering compile against Cuticle: namespace
// pbrt holds the names that such code, its unit tests among it, takes from pbrt-v3's headers. Installed as
// cuticle/pbrt3.h; with the target cuticle::pbrt3 the headers' own names (materials/hair.h, rng.h) mean it.
#pragma once

#include "core/fresnel.h"
#include "core/sampling.h"
#include "fibers/ap.h"
#include "fibers/hair.h"
#include "fibers/mp.h"
#include "fibers/np.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace pbrt {

//> Take over what has pbrt-v3's names already
using cuticle::Float;
using cuticle::Normal3f;
using cuticle::Point2f;
using cuticle::Point2i;
using cuticle::Point3f;
using cuticle::Vector2f;
using cuticle::Vector3f;

using cuticle::AbsDot;
using cuticle::CoordinateSystem;
using cuticle::Cross;
using cuticle::Dot;
using cuticle::Normalize;

using cuticle::ConcentricSampleDisk;
using cuticle::CosineHemispherePdf;
using cuticle::CosineSampleHemisphere;
using cuticle::Degrees;
using cuticle::DemuxFloat;
using cuticle::MixBits;
using cuticle::PowerHeuristic;
using cuticle::Radians;
using cuticle::UniformConePdf;
using cuticle::UniformHemispherePdf;
using cuticle::UniformSampleCone;
using cuticle::UniformSampleHemisphere;
using cuticle::UniformSampleSphere;
using cuticle::UniformSampleTriangle;
using cuticle::UniformSpherePdf;

using cuticle::BSDF_ALL;
using cuticle::BSDF_DIFFUSE;
using cuticle::BSDF_GLOSSY;
using cuticle::BSDF_REFLECTION;
using cuticle::BSDF_SPECULAR;
using cuticle::BSDF_TRANSMISSION;
using cuticle::BxDFType;

using cuticle::Infinity;
using cuticle::OneMinusEpsilon;
using cuticle::Pi;
inline constexpr Float InvPi = 1 / Pi, Inv2Pi = 1 / (2 * Pi), Inv4Pi = 1 / (4 * Pi);
inline constexpr Float PiOver2 = Pi / 2, PiOver4 = Pi / 4, Sqrt2 = std::numbers::sqrt2_v<Float>;
inline constexpr Float SqrtPiOver8 = 0.626657069f;
inline constexpr Float MaxFloat = std::numeric_limits<Float>::max();
inline constexpr Float MachineEpsilon = std::numeric_limits<Float>::epsilon() / 2;
inline constexpr int pMax = cuticle::HairBSDF::pMax;
//<

//> Compute small powers and guarded functions
// Arguments of any arithmetic type become a Float, as in pbrt-v3.
inline constexpr Float Sqr(Float v) { return v * v; }
// v^n, n >= 0, by repeated squaring.
template <int n>
constexpr Float Pow(Float v) {
    static_assert(n >= 0, "Pow<n> takes whole powers from 0 up");
    if constexpr (n == 0) {
        return 1;
    } else {
        const Float half = Pow<n / 2>(v);
        return n % 2 == 0 ? half * half : half * half * v;
    }
}
// x a little outside of the function's domain, by rounding, counts as its end; NaN stays NaN.
inline Float SafeASin(Float x) { return std::asin(x < -1 ? Float(-1) : x > 1 ? Float(1) : x); }
inline Float SafeACos(Float x) { return std::acos(x < -1 ? Float(-1) : x > 1 ? Float(1) : x); }
inline Float SafeSqrt(Float x) { return std::sqrt(x < 0 ? Float(0) : x); }
// low, high and value may be of three types; the value's is returned.
template <typename T, typename U, typename V>
constexpr T Clamp(T value, U low, V high) {
    using Widest = std::common_type_t<T, U, V>;
    const auto wide = static_cast<Widest>(value);
    return wide < static_cast<Widest>(low)    ? static_cast<T>(low)
           : wide > static_cast<Widest>(high) ? static_cast<T>(high)
                                              : value;
}
inline constexpr Float Lerp(Float t, Float a, Float b) { return (1 - t) * a + t * b; }
//<

//> Ask a direction for its angles to the normal
// w is of unit length in the local frame, z the normal: pbrt-v3's angles, not those of a fiber.
inline Float CosTheta(const Vector3f &w) { return w.z; }
inline Float Cos2Theta(const Vector3f &w) { return w.z * w.z; }
inline Float AbsCosTheta(const Vector3f &w) { return std::abs(w.z); }
inline Float Sin2Theta(const Vector3f &w) { return std::max(Float(0), 1 - Cos2Theta(w)); }
inline Float SinTheta(const Vector3f &w) { return std::sqrt(Sin2Theta(w)); }
inline Float TanTheta(const Vector3f &w) { return SinTheta(w) / CosTheta(w); }
inline Float Tan2Theta(const Vector3f &w) { return Sin2Theta(w) / Cos2Theta(w); }
// At the pole the azimuth is taken as 0.
inline Float CosPhi(const Vector3f &w) {
    const Float sinTheta = SinTheta(w);
    return sinTheta == 0 ? 1 : Clamp(w.x / sinTheta, -1, 1);
}
inline Float SinPhi(const Vector3f &w) {
    const Float sinTheta = SinTheta(w);
    return sinTheta == 0 ? 0 : Clamp(w.y / sinTheta, -1, 1);
}
inline bool SameHemisphere(const Vector3f &w, const Vector3f &wp) { return w.z * wp.z > 0; }
inline Vector3f Reflect(const Vector3f &wo, const Vector3f &n) { return 2 * Dot(wo, n) * n - wo; }
inline Vector3f SphericalDirection(Float sinTheta, Float cosTheta, Float phi) {
    return {sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta};
}
inline Float SphericalTheta(const Vector3f &w) { return SafeACos(w.z); }
inline Float SphericalPhi(const Vector3f &w) {
    const Float phi = std::atan2(w.y, w.x);
    return phi < 0 ? phi + 2 * Pi : phi;
}
//<

//> Make a colour of one number, or of Cuticle's colour
// RGB, with pbrt-v3's conversions: `Spectrum s = 0.25`, `s * 2`, a number returned where a Spectrum is due.
class Spectrum : public cuticle::RGBSpectrum {
  public:
    static constexpr int nSamples = 3;
    constexpr Spectrum(Float v = 0) : RGBSpectrum(v) {}
    constexpr Spectrum(const RGBSpectrum &rgb) : RGBSpectrum(rgb) {}
    static Spectrum FromRGB(const Float rgb[3]) { return RGBSpectrum::FromRGB(rgb); }
    void ToRGB(Float rgb[3]) const { std::copy(c.begin(), c.end(), rgb); }

    // Members, so that they hide those of the base: results are Spectrum again, and convert as it does.
    constexpr Spectrum operator-() const { return RGBSpectrum::operator-(); }
    constexpr Spectrum operator+(const Spectrum &b) const { return RGBSpectrum::operator+(b); }
    constexpr Spectrum operator-(const Spectrum &b) const { return RGBSpectrum::operator-(b); }
    constexpr Spectrum operator*(const Spectrum &b) const { return RGBSpectrum::operator*(b); }
    constexpr Spectrum operator/(const Spectrum &b) const { return RGBSpectrum::operator/(b); }
    constexpr Spectrum operator*(Float s) const { return RGBSpectrum::operator*(s); }
    constexpr Spectrum operator/(Float s) const { return RGBSpectrum::operator/(s); }
    friend constexpr Spectrum operator*(Float s, const Spectrum &b) { return b * s; }
    constexpr Spectrum &operator+=(const Spectrum &b) { return *this = *this + b; }
    constexpr Spectrum &operator-=(const Spectrum &b) { return *this = *this - b; }
    constexpr Spectrum &operator*=(const Spectrum &b) { return *this = *this * b; }
    constexpr Spectrum &operator*=(Float s) { return *this = *this * s; }
    constexpr Spectrum &operator/=(Float s) { return *this = *this / s; }
    constexpr Spectrum &operator/=(const Spectrum &b) { return *this = *this / b; }
    constexpr bool operator==(const Spectrum &b) const { return c == b.c; }
    Spectrum Clamp(Float low = 0, Float high = Infinity) const { return RGBSpectrum::Clamp(low, high); }
    friend Spectrum Sqrt(const Spectrum &s) { return cuticle::Sqrt(static_cast<const RGBSpectrum &>(s)); }
    friend Spectrum Exp(const Spectrum &s) { return cuticle::Exp(static_cast<const RGBSpectrum &>(s)); }
};
using RGBSpectrum = Spectrum;
//<

//> Draw random numbers, the generator made without a seed
// One stream for each sequence; the numbers are uniform but are not those that pbrt-v3 draws.
class RNG : public cuticle::RNG {
  public:
    RNG(uint64_t sequence = 0) : cuticle::RNG(sequence) {}
    void SetSequence(uint64_t sequence) { *this = RNG(sequence); }
    using cuticle::RNG::UniformUInt32;
    // In [0, b), each value equally likely; b > 0.
    uint32_t UniformUInt32(uint32_t b) {
        const uint32_t biased = (~b + 1u) % b; // so many low numbers would favour some values
        while (true)
            if (const uint32_t r = UniformUInt32(); r >= biased)
                return r % b;
    }
    template <typename Iterator>
    void Shuffle(Iterator begin, Iterator end) {
        for (auto n = end - begin; n > 1; --n)
            std::iter_swap(begin + (n - 1), begin + UniformUInt32(static_cast<uint32_t>(n)));
    }
};
//<

//> Spread points evenly over the square
// The primes below 8000: more than the first 1000, which pbrt-v3's helpers know.
inline const std::vector<int> &Primes() {
    static const std::vector<int> primes = [] {
        std::vector<int> found;
        for (int n = 2; n < 8000; ++n)
            if (std::none_of(found.begin(), found.end(), [n](int p) { return n % p == 0; }))
                found.push_back(n);
        return found;
    }();
    return primes;
}
inline constexpr int PrimeTableSize = 1000;
// The digits of a in the base Primes()[baseIndex], mirrored at the point; in [0, 1). baseIndex: 0 for base 2,
// 1 for 3, 2 for 5, ..., below PrimeTableSize.
inline Float RadicalInverse(int baseIndex, uint64_t a) {
    const auto base = static_cast<uint64_t>(Primes().at(static_cast<size_t>(baseIndex)));
    const double digit = 1 / static_cast<double>(base);
    double inverse = 0, place = digit;
    for (; a != 0; a /= base, place *= digit)
        inverse += static_cast<double>(a % base) * place;
    return std::min(static_cast<Float>(inverse), OneMinusEpsilon);
}
inline uint32_t ReverseBits32(uint32_t n) {
    uint32_t reversed = 0;
    for (int bit = 0; bit < 32; ++bit)
        reversed |= ((n >> bit) & 1u) << (31 - bit);
    return reversed;
}
// samples[i]: one point in each of n cells of [0, 1), or of nx * ny cells of the square; in their middles
// without jitter.
inline void StratifiedSample1D(Float *samples, int n, RNG &rng, bool jitter = true) {
    for (int i = 0; i < n; ++i) {
        const Float at = static_cast<Float>(i) + (jitter ? rng.UniformFloat() : 0.5f);
        samples[i] = std::min(at / static_cast<Float>(n), OneMinusEpsilon);
    }
}
inline void StratifiedSample2D(Point2f *samples, int nx, int ny, RNG &rng, bool jitter = true) {
    const auto in = [&](int i, int n) {
        const Float at = static_cast<Float>(i) + (jitter ? rng.UniformFloat() : 0.5f);
        return std::min(at / static_cast<Float>(n), OneMinusEpsilon);
    };
    for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) {
            const Float u = in(x, nx);
            *samples++ = Point2f(u, in(y, ny));
        }
}
//<

//> Declare the base of scattering functions, as pbrt-v3 has it
// Derive from it and give f and ToString; sampling then follows the cosine on wo's side of the surface.
class BxDF {
  public:
    BxDF(BxDFType t) : type(t) {}
    virtual ~BxDF() = default;
    bool MatchesFlags(BxDFType t) const { return (type & t) == type; }
    // 1/sr, without the cosine.
    virtual Spectrum f(const Vector3f &wo, const Vector3f &wi) const = 0;
    // *pdf, in 1/sr, is 0 where no direction was found.
    virtual Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                              BxDFType *sampledType = nullptr) const {
        *wi = CosineSampleHemisphere(u);
        if (wo.z < 0)
            wi->z = -wi->z;
        *pdf = Pdf(wo, *wi);
        if (sampledType)
            *sampledType = type;
        return f(wo, *wi);
    }
    virtual Float Pdf(const Vector3f &wo, const Vector3f &wi) const {
        return SameHemisphere(wo, wi) ? AbsCosTheta(wi) * InvPi : 0;
    }
    virtual std::string ToString() const = 0;

    const BxDFType type;
};
inline std::ostream &operator<<(std::ostream &os, const BxDF &bxdf) { return os << bxdf.ToString(); }
//<

//> Offer HairBSDF for derived classes, with pbrt-v3's colours
// cuticle::HairBSDF, whose comments say what the parameters mean and what bad ones do; every method may be
// overridden. The scales tilt as they are measured; pbrt-v3's other way is ScaleTilt::PbrtV3.
class HairBSDF : public BxDF {
  public:
    HairBSDF(Float h, Float eta, const Spectrum &sigma_a, Float beta_m, Float beta_n, Float alpha,
             cuticle::ScaleTilt tilt = cuticle::ScaleTilt::RootToTip)
        : BxDF(static_cast<BxDFType>(BSDF_GLOSSY | BSDF_REFLECTION | BSDF_TRANSMISSION)),
          hair_(h, eta, sigma_a, beta_m, beta_n, alpha, tilt) {}
    Spectrum f(const Vector3f &wo, const Vector3f &wi) const override { return hair_.f(wo, wi); }
    Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                      BxDFType *sampledType = nullptr) const override {
        return hair_.Sample_f(wo, wi, u, pdf, sampledType);
    }
    Float Pdf(const Vector3f &wo, const Vector3f &wi) const override { return hair_.Pdf(wo, wi); }
    std::string ToString() const override { return hair_.ToString(); }
    static Spectrum SigmaAFromConcentration(Float ce, Float cp = 0) {
        return cuticle::HairBSDF::SigmaAFromConcentration(ce, cp);
    }
    static Spectrum SigmaAFromReflectance(const Spectrum &c, Float beta_n) {
        return cuticle::HairBSDF::SigmaAFromReflectance(c, beta_n);
    }
    // The same without pbrt-v3's conversions: four random numbers a sample, value and density at once.
    const cuticle::HairBSDF &Native() const { return hair_; }

  private:
    cuticle::HairBSDF hair_;
};
//<

//> Give the factors of the model their names in pbrt-v3
inline Float Mp(Float cosThetaI, Float cosThetaO, Float sinThetaI, Float sinThetaO, Float v) {
    return cuticle::Mp(cosThetaI, cosThetaO, sinThetaI, sinThetaO, v);
}
inline Float I0(Float x) { return cuticle::I0e(std::abs(x)) * std::exp(std::abs(x)); }
inline Float LogI0(Float x) { return std::log(cuticle::I0e(std::abs(x))) + std::abs(x); }
inline Float Phi(int p, Float gammaO, Float gammaT) { return cuticle::Phi(p, gammaO, gammaT); }
inline Float Logistic(Float x, Float s) { return cuticle::Logistic(x, s); }
inline Float LogisticCDF(Float x, Float s) { return cuticle::LogisticCDF(x, s); }
inline Float TrimmedLogistic(Float x, Float s, Float a, Float b) {
    return cuticle::TrimmedLogistic(x, s, a, b);
}
// Over any interval; the model's own sampler knows [-pi, pi] only, and keeps more digits there.
inline Float SampleTrimmedLogistic(Float u, Float s, Float a, Float b) {
    const double low = 1 / (1 + std::exp(-double(a) / s)), high = 1 / (1 + std::exp(-double(b) / s));
    const double mass = low + u * (high - low);
    return Clamp(static_cast<Float>(-s * std::log(1 / mass - 1)), a, b);
}
inline Float Np(Float phi, int p, Float s, Float gammaO, Float gammaT) {
    return cuticle::Np(phi, p, s, gammaO, gammaT);
}
inline Float FrDielectric(Float cosThetaI, Float etaI, Float etaT) {
    return cuticle::FrDielectric(cosThetaI, etaT / etaI);
}
// T: the transmittance of one segment. The last of the pMax + 1 shares holds all longer paths.
inline std::array<Spectrum, pMax + 1> Ap(Float cosThetaO, Float eta, Float h, const Spectrum &T) {
    const Float cosGammaO = SafeSqrt((1 - h) * (1 + h));
    const auto inside = cuticle::Refract(cosThetaO, h, cosGammaO, eta, (eta - 1) * (eta + 1));
    const auto fresnel = cuticle::Fresnel(inside.cosIncident, inside.t, eta);
    std::array<Spectrum, pMax + 1> ap;
    for (size_t channel = 0; channel < 3; ++channel) {
        const auto shares = cuticle::Ap(fresnel.f, fresnel.oneMinusF, T[channel], 1 - T[channel]);
        for (size_t p = 0; p <= pMax; ++p)
            ap[p][channel] = shares[p];
    }
    return ap;
}
//<

} // namespace pbrt
//<
