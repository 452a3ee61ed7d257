//> Write the BSDF as the text has it
#include "fibers/hair_as_printed.h"

#include "core/special.h"
#include "fibers/models.h"

#include <algorithm>

namespace cuticle::as_printed {

namespace {
//> Reflect at a smooth dielectric
Float Reflectance(Float cosThetaI, Float eta) {
    const Float sinThetaT = std::sqrt(std::max(0.f, 1 - cosThetaI * cosThetaI)) / eta;
    if (sinThetaT >= 1)
        return 1;
    const Float cosThetaT = std::sqrt(std::max(0.f, 1 - sinThetaT * sinThetaT));
    const Float parallel = (eta * cosThetaI - cosThetaT) / (eta * cosThetaI + cosThetaT);
    const Float perpendicular = (cosThetaI - eta * cosThetaT) / (cosThetaI + eta * cosThetaT);
    return (parallel * parallel + perpendicular * perpendicular) / 2;
}
//<

//> Evaluate the trimmed logistic, its limits each time anew
Float LogisticOf(Float x, Float s) {
    x = std::abs(x);
    return std::exp(-x / s) / (s * Sqr(1 + std::exp(-x / s)));
}
Float LogisticBelow(Float x, Float s) { return 1 / (1 + std::exp(-x / s)); }
Float TrimmedToCircle(Float x, Float s) {
    return LogisticOf(x, s) / (LogisticBelow(Pi, s) - LogisticBelow(-Pi, s));
}
// Infinite where the rounded distribution function reaches 1; hence the clamp.
Float SampleTrimmedToCircle(Float u, Float s) {
    const Float below = LogisticBelow(-Pi, s), k = LogisticBelow(Pi, s) - below;
    return std::clamp(-s * std::log(1 / (u * k + below) - 1), -Pi, Pi);
}
//<

//> Turn by a path's net angle
Float NetTurn(int p, Float gammaO, Float gammaT) {
    return 2 * static_cast<Float>(p) * gammaT - 2 * gammaO + static_cast<Float>(p) * Pi;
}
// Steps of a full turn: an infinite angle would never arrive.
Float Np(Float phi, int p, Float s, Float gammaO, Float gammaT) {
    Float dPhi = phi - NetTurn(p, gammaO, gammaT);
    while (dPhi > Pi)
        dPhi -= 2 * Pi;
    while (dPhi < -Pi)
        dPhi += 2 * Pi;
    return TrimmedToCircle(dPhi, s);
}
//<

Float CosTheta(const Vector3f &w) { return std::sqrt(std::max(0.f, 1 - w.x * w.x)); }
Float Azimuth(const Vector3f &w) { return std::atan2(w.z, w.y); }
} // namespace

//> Prepare roughnesses and tilts
HairBSDF::HairBSDF(Float h, Float eta, const Spectrum &sigma_a, Float beta_m, Float beta_n, Float alpha,
                   Tilt tilt)
    : h_(h), gammaO_(std::asin(std::clamp(h, -1.f, 1.f))), eta_(eta), sigmaA_(sigma_a), tilt_(tilt) {
    const auto power = [](Float x, int n) {
        Float result = 1;
        for (; n > 0; --n)
            result *= x;
        return result;
    };
    v_[0] = Sqr(0.726f * beta_m + 0.812f * Sqr(beta_m) + 3.7f * power(beta_m, 20));
    v_[1] = v_[0] / 4, v_[2] = v_[3] = 4 * v_[0];
    s_ = 0.626657069f * (0.265f * beta_n + 1.194f * Sqr(beta_n) + 5.372f * power(beta_n, 22));
    sin2kAlpha_[0] = std::sin(Radians(alpha));
    cos2kAlpha_[0] = std::sqrt(std::max(0.f, 1 - Sqr(sin2kAlpha_[0])));
    for (size_t k = 1; k < 3; ++k) {
        sin2kAlpha_[k] = 2 * cos2kAlpha_[k - 1] * sin2kAlpha_[k - 1];
        cos2kAlpha_[k] = Sqr(cos2kAlpha_[k - 1]) - Sqr(sin2kAlpha_[k - 1]);
    }
}
//<

//> Attenuate, with the plain geometric series
// 0/0 in the last term at the edge of a clear fiber.
std::array<Spectrum, HairBSDF::pMax + 1> HairBSDF::Attenuations(Float sinThetaO, Float cosThetaO,
                                                                Float *gammaT) const {
    const Float sinThetaT = sinThetaO / eta_;
    const Float cosThetaT = std::sqrt(std::max(0.f, 1 - Sqr(sinThetaT)));
    const Float etaPrime = std::sqrt(eta_ * eta_ - Sqr(sinThetaO)) / cosThetaO;
    const Float sinGammaT = h_ / etaPrime;
    const Float cosGammaT = std::sqrt(std::max(0.f, 1 - Sqr(sinGammaT)));
    *gammaT = std::asin(std::clamp(sinGammaT, -1.f, 1.f));
    const Spectrum t = Exp(-sigmaA_ * (2 * cosGammaT / cosThetaT));
    const Float f = Reflectance(cosThetaO * std::sqrt(std::max(0.f, 1 - h_ * h_)), eta_);
    const Spectrum one(1.f);
    const Spectrum second = Sqr(1 - f) * t, third = second * t * f;
    return {Spectrum(f), second, third, third * f * t / (one - t * f)};
}

std::array<Float, HairBSDF::pMax + 1>
HairBSDF::Shares(const std::array<Spectrum, HairBSDF::pMax + 1> &ap) const {
    std::array<Float, pMax + 1> shares;
    Float sum = 0;
    for (size_t p = 0; p <= pMax; ++p)
        sum += shares[p] = ap[p].y();
    for (Float &share : shares)
        share /= sum;
    return shares;
}
//<

//> Rotate by the scales' angle
// R by 2 alpha, TT by -alpha, TRT by -4 alpha, times sign.
std::array<Float, 2> HairBSDF::Turned(int p, Float sinTheta, Float cosTheta, Float sign) const {
    if (p >= pMax)
        return {sinTheta, cosTheta};
    const size_t k = p == 0 ? 1 : p == 1 ? 0 : 2;
    const Float sinA = sign * (p == 0 ? sin2kAlpha_[k] : -sin2kAlpha_[k]), cosA = cos2kAlpha_[k];
    return {sinTheta * cosA + cosTheta * sinA, std::abs(cosTheta * cosA - sinTheta * sinA)};
}
//<

//> Multiply $M_p$ and $N_p$
Float HairBSDF::Lobe(int p, const Vector3f &wo, const Vector3f &wi, Float dPhi, Float gammaT) const {
    std::array<Float, 2> o = {wo.x, CosTheta(wo)}, i = {wi.x, CosTheta(wi)};
    if (tilt_ == Tilt::OnThetaI)
        i = Turned(p, i[0], i[1], 1);
    else if (tilt_ == Tilt::OnThetaO)
        o = Turned(p, o[0], o[1], -1);
    const Float m = Mp(i[1], o[1], i[0], o[0], v_[static_cast<size_t>(p)]);
    return m * (p < pMax ? Np(dPhi, p, s_, gammaO_, gammaT) : 1 / (2 * Pi));
}
//<

//> Evaluate and weigh
Spectrum HairBSDF::f(const Vector3f &wo, const Vector3f &wi) const {
    Float gammaT = 0;
    const auto ap = Attenuations(wo.x, CosTheta(wo), &gammaT);
    const Float dPhi = Azimuth(wi) - Azimuth(wo);
    Spectrum sum;
    for (int p = 0; p <= pMax; ++p)
        sum += ap[static_cast<size_t>(p)] * Lobe(p, wo, wi, dPhi, gammaT);
    return wi.z == 0 ? sum : sum / std::abs(wi.z);
}
Float HairBSDF::Pdf(const Vector3f &wo, const Vector3f &wi) const {
    Float gammaT = 0;
    const auto shares = Shares(Attenuations(wo.x, CosTheta(wo), &gammaT));
    const Float dPhi = Azimuth(wi) - Azimuth(wo);
    Float pdf = 0;
    for (int p = 0; p <= pMax; ++p)
        pdf += shares[static_cast<size_t>(p)] * Lobe(p, wo, wi, dPhi, gammaT);
    return pdf;
}
//<

//> Sample
Spectrum HairBSDF::Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u,
                            Float *pdf) const {
    const Float cosThetaO = CosTheta(wo);
    Float gammaT = 0;
    const auto shares = Shares(Attenuations(wo.x, cosThetaO, &gammaT));
    int p = 0;
    for (Float rest = u[0]; p < pMax && rest >= shares[static_cast<size_t>(p)]; ++p)
        rest -= shares[static_cast<size_t>(p)];
    //> Sample the longitudinal lobe
    // Tilted by the scales before (pbrt-v3), or turned back after (the text).
    std::array<Float, 2> o = {wo.x, cosThetaO};
    if (tilt_ == Tilt::OnThetaO)
        o = Turned(p, o[0], o[1], -1);
    const Float v = v_[static_cast<size_t>(p)];
    const Float cosT = 1 + v * std::log(std::max(u[2], 1e-5f) + (1 - u[2]) * std::exp(-2 / v));
    const Float sinT = std::sqrt(std::max(0.f, 1 - cosT * cosT));
    Float sinThetaI = -cosT * o[0] + sinT * std::cos(2 * Pi * u[3]) * o[1];
    Float cosThetaI = std::sqrt(std::max(0.f, 1 - sinThetaI * sinThetaI));
    if (tilt_ == Tilt::OnThetaI) {
        const std::array<Float, 2> i = Turned(p, sinThetaI, cosThetaI, -1);
        sinThetaI = i[0], cosThetaI = i[1];
    }
    //<
    //> Sample the azimuth
    const Float dPhi =
        p < pMax ? NetTurn(p, gammaO_, gammaT) + SampleTrimmedToCircle(u[1], s_) : 2 * Pi * u[1];
    const Float phiI = Azimuth(wo) + dPhi;
    *wi = {sinThetaI, cosThetaI * std::cos(phiI), cosThetaI * std::sin(phiI)};
    //<
    *pdf = 0;
    for (int q = 0; q <= pMax; ++q)
        *pdf += shares[static_cast<size_t>(q)] * Lobe(q, wo, *wi, dPhi, gammaT);
    return f(wo, *wi);
}
//<

//> Put the printed model behind the interface of models in double
Float SigmaAFromReflectance(Float reflectance, Float betaN) {
    return Sqr(std::log(reflectance) / Polynomial(betaN, 5.969f, -0.215f, 2.532f, -10.73f, 5.574f, 0.245f));
}

namespace {
class Printed final : public FiberInDouble {
  public:
    Printed(const FiberInputs &at, Tilt tilt)
        : hair_(at.h, at.eta, Spectrum(at.sigmaA[0], at.sigmaA[1], at.sigmaA[2]), at.betaM, at.betaN,
                at.alpha, tilt) {}
    FiberValue<double> Evaluate(const Vector3d &wo, const Vector3d &wi) const override {
        const Vector3f o(wo), i(wi);
        return ValueOf(hair_.f(o, i), i, hair_.Pdf(o, i));
    }
    FiberValue<double> Sample(const Vector3d &wo, const std::array<double, 4> &u,
                              Vector3d *wi) const override {
        std::array<Float, 4> numbers;
        for (size_t i = 0; i < 4; ++i)
            numbers[i] = static_cast<Float>(u[i]);
        Vector3f i;
        Float pdf = 0;
        const Spectrum f = hair_.Sample_f(Vector3f(wo), &i, numbers, &pdf);
        *wi = Vector3d(i);
        return ValueOf(f, i, pdf);
    }

  private:
    static FiberValue<double> ValueOf(const Spectrum &f, const Vector3f &wi, Float pdf) {
        const double cosine = wi.z == 0 ? 1 : std::abs(double(wi.z));
        return {{double(f[0]) * cosine, double(f[1]) * cosine, double(f[2]) * cosine}, double(pdf)};
    }
    HairBSDF hair_;
};
} // namespace

std::unique_ptr<FiberInDouble> PrintedFiber(const FiberInputs &at, Tilt tilt) {
    return std::make_unique<Printed>(at, tilt);
}
//<

} // namespace cuticle::as_printed
//<
