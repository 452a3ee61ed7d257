#include "materials/surface_lobes.h"

#include "core/check.h"
#include "core/fresnel.h"
#include "core/sampling.h"
#include "materials/microfacet.h"

namespace cuticle {

void SurfaceLobes::Add(Lobe lobe) {
    lobe.color *= scale_;
    if (lobe.color.IsBlack())
        return;
    CHECK_LT(count_, kMaxLobes) << "a material has more lobes than its MaxLobes() says";
    lobes_[count_++] = lobe;
}
void SurfaceLobes::Add(LobeKind kind, const Spectrum &color, float a) {
    Add({.kind = kind, .color = color, .a = a});
}
void SurfaceLobes::AddOrenNayar(const Spectrum &r, float sigma) {
    if (sigma == 0)
        return AddLambertReflection(r);
    const float s2 = Sqr(Radians(sigma));
    Add({.kind = LobeKind::OrenNayar,
         .color = r,
         .a = 1 - s2 / (2 * (s2 + 0.33f)),
         .b = 0.45f * s2 / (s2 + 0.09f)});
}
void SurfaceLobes::AddMicrofacetReflection(const Spectrum &r, float ax, float ay, float eta) {
    Add({.kind = LobeKind::MicrofacetReflection,
         .color = r,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .eta = eta});
}
void SurfaceLobes::AddConductorReflection(const Spectrum &r, float ax, float ay, const Spectrum &eta,
                                          const Spectrum &k) {
    Add({.kind = LobeKind::ConductorReflection,
         .color = r,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .etaOrR0 = eta,
         .k = k});
}
void SurfaceLobes::AddMicrofacetTransmission(const Spectrum &t, float ax, float ay, float eta,
                                             bool separable) {
    // Between nearly equal indices facets bend light by less than a direction's rounding, from which no half
    // vector is found again: light goes straight on.
    if (std::abs(eta - 1) * std::max({ax, ay, 1e-3f}) < 1e-6f)
        return AddSpecularTransmission(t, 1);
    Add({.kind = LobeKind::MicrofacetTransmission,
         .separable = separable,
         .color = t,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .eta = eta});
}
void SurfaceLobes::AddSpecularReflection(const Spectrum &r, float eta) {
    Add({.kind = LobeKind::SpecularReflection, .color = r, .eta = eta});
}
void SurfaceLobes::AddSpecularTransmission(const Spectrum &t, float eta) {
    Add({.kind = LobeKind::SpecularTransmission, .color = t, .eta = eta});
}
void SurfaceLobes::AddCoatedDiffuse(const Spectrum &rd, const Spectrum &rs) {
    Add(LobeKind::CoatedDiffuse, rd * (-rs + Spectrum(1)).Clamp());
}
void SurfaceLobes::AddCoat(const Spectrum &rs, float ax, float ay) {
    if (!rs.IsBlack())
        Add({.kind = LobeKind::Coat,
             .color = Spectrum(1),
             .a = std::max(ax, 1e-3f),
             .b = std::max(ay, 1e-3f),
             .etaOrR0 = rs});
}
void SurfaceLobes::AddDisneySpecular(const Spectrum &r0, float metallic, float eta, float ax, float ay) {
    Add({.kind = LobeKind::DisneySpecular,
         .separable = true,
         .color = Spectrum(1),
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .eta = eta,
         .metallic = metallic,
         .etaOrR0 = r0});
}
void SurfaceLobes::AddDisneyClearcoat(float weight, float gloss) {
    // A quarter: Burley's, unpublished, as pbrt-v3 has it
    Add({.kind = LobeKind::DisneyClearcoat,
         .color = Spectrum(weight / 4),
         .a = Lerp(std::clamp(gloss, 0.f, 1.f), 0.1f, 0.001f),
         .etaOrR0 = Spectrum(0.04f)});
}

bool SurfaceLobes::HasNonSpecular() const {
    for (size_t i = 0; i < count_; ++i)
        if (!lobes_[i].Specular())
            return true;
    return false;
}

// The Fresnel factor of a lobe that has one, else 1.
Spectrum SurfaceLobes::Fresnel(const Lobe &lobe, float cosTheta) {
    switch (lobe.kind) {
    case LobeKind::SpecularReflection:
        return Spectrum(lobe.eta == 0 ? 1 : FrDielectric(cosTheta, lobe.eta));
    case LobeKind::MicrofacetReflection:
        return Spectrum(FrDielectric(cosTheta, lobe.eta));
    case LobeKind::SpecularTransmission:
        return Spectrum(lobe.eta == 1 ? 1 : 1 - FrDielectric(cosTheta, lobe.eta));
    case LobeKind::MicrofacetTransmission:
        return Spectrum(1 - FrDielectric(cosTheta, lobe.eta));
    case LobeKind::ConductorReflection:
        return FrConductor(cosTheta, lobe.etaOrR0, lobe.k);
    case LobeKind::Coat:
    case LobeKind::DisneyClearcoat:
        return FrSchlick(lobe.etaOrR0, std::abs(cosTheta));
    case LobeKind::DisneySpecular:
        return Spectrum(FrDielectric(cosTheta, lobe.eta)) * (1 - lobe.metallic) +
               FrSchlick(lobe.etaOrR0, std::abs(cosTheta)) * lobe.metallic;
    default:
        return Spectrum(1);
    }
}

// The share of a lobe in the choice among lobes. pbrt-v3 chooses uniformly; in proportion to the colour, and
// for mirrors and coats to the Fresnel factor, is less noisy and as easy. Rough lobes keep a tenth, since
// their facets lean and see other angles than the surface.
float SurfaceLobes::Weight(const Lobe &lobe, const Vector3f &wo) {
    const float whole = lobe.color.MaxComponentValue();
    switch (lobe.kind) {
    case LobeKind::MicrofacetReflection:
    case LobeKind::MicrofacetTransmission:
        return whole;
    case LobeKind::Coat:
    case LobeKind::DisneySpecular:
    case LobeKind::DisneyClearcoat:
        return std::max((lobe.color * Fresnel(lobe, wo.z)).MaxComponentValue(), 0.1f * whole);
    default:
        return (lobe.color * Fresnel(lobe, wo.z)).MaxComponentValue();
    }
}

SurfaceLobes::Weights SurfaceLobes::Probabilities(const Vector3f &wo) const {
    Weights weights{};
    float sum = 0;
    for (size_t i = 0; i < count_; ++i)
        sum += weights[i] = Weight(lobes_[i], wo);
    if (sum > 0)
        for (float &w : weights)
            w /= sum;
    return weights;
}

// Evaluates those of Disney's diffuse lobes that depend on the angle between the light and the half vector.
Spectrum SurfaceLobes::EvaluateByHalfAngle(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    const Vector3f sum = wo + wi;
    if (sum.LengthSquared() == 0)
        return {};
    const float cosD = Dot(wi, Normalize(sum)), cosO = std::abs(CosTheta(wo)), cosI = std::abs(CosTheta(wi));
    const float fO = SchlickWeight(cosO), fI = SchlickWeight(cosI);
    if (lobe.kind == LobeKind::DisneySheen)
        return lobe.color * SchlickWeight(cosD);
    if (lobe.kind == LobeKind::DisneyRetro) { // Burley 2015, equation 4
        const float r = 2 * lobe.a * cosD * cosD;
        return lobe.color / Pi * (r * (fO + fI + fO * fI * (r - 1)));
    }
    // Hanrahan and Krueger's single scattering in disguise (Burley 2012); 1.25 roughly keeps the albedo
    const float f90 = cosD * cosD * lobe.a;
    const float f = Lerp(fO, 1.f, f90) * Lerp(fI, 1.f, f90);
    return lobe.color / Pi * (1.25f * (f * (1 / (cosO + cosI) - 0.5f) + 0.5f));
}

Spectrum SurfaceLobes::EvaluateOrenNayar(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    const float sinI = SinTheta(wi), sinO = SinTheta(wo);
    // cos(phi_i - phi_o) of the projected directions, where they have an azimuth
    float maxCos = 0;
    if (sinI > 1e-4f && sinO > 1e-4f)
        maxCos = std::max(0.f, (wi.x * wo.x + wi.y * wo.y) / (sinI * sinO));
    const float absI = std::abs(CosTheta(wi)), absO = std::abs(CosTheta(wo));
    const float sinAlpha = absI > absO ? sinO : sinI;
    const float tanBeta = absI > absO ? sinI / absI : sinO / absO;
    return lobe.color * ((lobe.a + lobe.b * maxCos * sinAlpha * tanBeta) / Pi);
}

Spectrum SurfaceLobes::EvaluateReflectingFacets(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    Vector3f wh = wi + wo;
    if (wh.LengthSquared() == 0)
        return {};
    wh = Normalize(wh);
    const TrowbridgeReitz d{lobe.a, lobe.b};
    return lobe.color * Fresnel(lobe, Dot(wi, Faceforward(wh, {0, 0, 1}))) *
           (d.D(wh) * d.GOver4Cos(wo, wi, lobe.separable));
}

Spectrum SurfaceLobes::EvaluateRefractingFacets(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    const float eta = CosTheta(wo) > 0 ? lobe.eta : 1 / lobe.eta;
    Vector3f wh;
    if (!RefractingHalfVector(wo, wi, eta, &wh))
        return {};
    const TrowbridgeReitz d{lobe.a, lobe.b};
    const float sqrtDenom = Dot(wo, wh) + eta * Dot(wi, wh);
    // Radiance is scaled by the squared index ratio on crossing: eta^2 of the Jacobian cancels against it
    return lobe.color * Fresnel(lobe, Dot(wo, wh)) *
           std::abs(4 * d.D(wh) * d.GOver4Cos(wo, wi, lobe.separable) * Dot(wi, wh) * Dot(wo, wh) /
                    (sqrtDenom * sqrtDenom));
}

Spectrum SurfaceLobes::EvaluateCoat(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    Vector3f wh;
    if (!HalfVector(wo, wi, &wh))
        return {};
    const TrowbridgeReitz d{lobe.a, lobe.b};
    const float cosine = std::max(std::abs(CosTheta(wo)), std::abs(CosTheta(wi)));
    return lobe.color * Fresnel(lobe, Dot(wi, wh)) * (d.D(wh) / (4 * AbsDot(wi, wh) * cosine));
}

Spectrum SurfaceLobes::EvaluateClearcoat(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    Vector3f wh;
    if (!HalfVector(wo, wi, &wh))
        return {};
    // Masking keeps a roughness of 1/4, whatever the gloss (Burley 2012, section 5.6)
    return lobe.color * Fresnel(lobe, Dot(wo, wh)) *
           (GTR1(wh, lobe.a) * SmithOver2Cos(std::abs(CosTheta(wo)), 0.25f) *
            SmithOver2Cos(std::abs(CosTheta(wi)), 0.25f));
}

Spectrum SurfaceLobes::Evaluate(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    switch (lobe.kind) {
    case LobeKind::LambertReflection:
    case LobeKind::LambertTransmission:
        return lobe.color / Pi;
    case LobeKind::OrenNayar:
        return EvaluateOrenNayar(lobe, wo, wi);
    case LobeKind::MicrofacetReflection:
    case LobeKind::ConductorReflection:
    case LobeKind::DisneySpecular:
        return EvaluateReflectingFacets(lobe, wo, wi);
    case LobeKind::MicrofacetTransmission:
        return EvaluateRefractingFacets(lobe, wo, wi);
    case LobeKind::CoatedDiffuse: {
        const auto leave = [](float cosTheta) {
            const float m = 1 - std::abs(cosTheta) / 2;
            return 1 - Sqr(Sqr(m)) * m;
        };
        return lobe.color * (28 / (23 * Pi) * leave(CosTheta(wi)) * leave(CosTheta(wo)));
    }
    case LobeKind::Coat:
        return EvaluateCoat(lobe, wo, wi);
    case LobeKind::DisneyDiffuse:
        // From 1 at normal incidence to 1/2 at grazing (Burley 2015, equation 4)
        return lobe.color / Pi * (1 - SchlickWeight(std::abs(CosTheta(wo))) / 2) *
               (1 - SchlickWeight(std::abs(CosTheta(wi))) / 2);
    case LobeKind::DisneyFlat:
    case LobeKind::DisneyRetro:
    case LobeKind::DisneySheen:
        return EvaluateByHalfAngle(lobe, wo, wi);
    case LobeKind::DisneyClearcoat:
        return EvaluateClearcoat(lobe, wo, wi);
    case LobeKind::SpecularReflection:
    case LobeKind::SpecularTransmission:
        return {};
    }
    return {};
}

float SurfaceLobes::Pdf(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    switch (lobe.kind) {
    case LobeKind::LambertReflection:
    case LobeKind::OrenNayar:
    case LobeKind::CoatedDiffuse:
    case LobeKind::DisneyDiffuse:
    case LobeKind::DisneyFlat:
    case LobeKind::DisneyRetro:
    case LobeKind::DisneySheen:
        return SameHemisphere(wo, wi) ? std::abs(CosTheta(wi)) / Pi : 0;
    case LobeKind::LambertTransmission:
        return SameHemisphere(wo, wi) ? 0 : std::abs(CosTheta(wi)) / Pi;
    case LobeKind::MicrofacetReflection:
    case LobeKind::ConductorReflection:
    case LobeKind::Coat:
    case LobeKind::DisneySpecular: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return 0;
        return TrowbridgeReitz{lobe.a, lobe.b}.Pdf(wo, wh) / (4 * AbsDot(wo, wh));
    }
    case LobeKind::DisneyClearcoat: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return 0;
        return GTR1(wh, lobe.a) * std::abs(CosTheta(wh)) / (4 * AbsDot(wo, wh));
    }
    case LobeKind::MicrofacetTransmission: {
        const float eta = CosTheta(wo) > 0 ? lobe.eta : 1 / lobe.eta;
        Vector3f wh;
        if (!RefractingHalfVector(wo, wi, eta, &wh))
            return 0;
        const float sqrtDenom = Dot(wo, wh) + eta * Dot(wi, wh);
        return TrowbridgeReitz{lobe.a, lobe.b}.Pdf(wo, wh) *
               std::abs(eta * eta * Dot(wi, wh) / Sqr(sqrtDenom));
    }
    case LobeKind::SpecularReflection:
    case LobeKind::SpecularTransmission:
        return 0;
    }
    return 0;
}

Spectrum SurfaceLobes::f(const Vector3f &wo, const Vector3f &wi, bool reflect, float *pdf) const {
    Spectrum sum;
    *pdf = 0;
    if (InSurface(wo) || InSurface(wi))
        return sum;
    const Weights probabilities = Probabilities(wo);
    for (size_t i = 0; i < count_; ++i) {
        if (lobes_[i].Reflects() == reflect)
            sum += Evaluate(lobes_[i], wo, wi);
        *pdf += probabilities[i] * Pdf(lobes_[i], wo, wi);
    }
    return sum;
}

bool SurfaceLobes::Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const {
    if (count_ == 0 || InSurface(wo))
        return false;
    const Weights probabilities = Probabilities(wo);
    size_t chosen = 0;
    for (float cdf = probabilities[0]; chosen + 1 < count_ && uLobe >= cdf;)
        cdf += probabilities[++chosen];
    const Lobe &lobe = lobes_[chosen];
    sample->specular = lobe.Specular();
    sample->transmission = !lobe.Reflects();
    sample->eta = 1;

    Vector3f &wi = sample->wi;
    switch (lobe.kind) {
    case LobeKind::LambertReflection:
    case LobeKind::OrenNayar:
    case LobeKind::CoatedDiffuse:
    case LobeKind::DisneyDiffuse:
    case LobeKind::DisneyFlat:
    case LobeKind::DisneyRetro:
    case LobeKind::DisneySheen:
    case LobeKind::LambertTransmission:
        wi = CosineSampleHemisphere(u);
        if ((wo.z < 0) == lobe.Reflects())
            wi.z = -wi.z;
        return true;
    case LobeKind::MicrofacetReflection:
    case LobeKind::ConductorReflection:
    case LobeKind::Coat:
    case LobeKind::DisneySpecular:
    case LobeKind::DisneyClearcoat: {
        const Vector3f wh = lobe.kind == LobeKind::DisneyClearcoat
                                ? Faceforward(SampleGTR1(lobe.a, u), {0, 0, wo.z})
                                : TrowbridgeReitz{lobe.a, lobe.b}.Sample_wh(wo, u);
        wi = wh * (2 * Dot(wo, wh)) - wo;
        return SameHemisphere(wo, wi);
    }
    case LobeKind::MicrofacetTransmission: {
        const Vector3f wh = TrowbridgeReitz{lobe.a, lobe.b}.Sample_wh(wo, u);
        const float eta = wo.z > 0 ? lobe.eta : 1 / lobe.eta;
        sample->eta = eta;
        return Dot(wo, wh) >= 0 && Refract(wo, wh, 1 / eta, &wi) && !SameHemisphere(wo, wi);
    }
    case LobeKind::SpecularReflection: {
        wi = {-wo.x, -wo.y, wo.z};
        sample->pdf = probabilities[chosen];
        sample->f = lobe.color * Fresnel(lobe, wo.z) / std::abs(wi.z);
        return true;
    }
    case LobeKind::SpecularTransmission: {
        const float eta = wo.z > 0 ? lobe.eta : 1 / lobe.eta;
        if (!Refract(wo, {0, 0, std::copysign(1.f, wo.z)}, 1 / eta, &wi))
            return false;
        sample->eta = eta;
        sample->pdf = probabilities[chosen];
        // Radiance, not importance: compressed by the squared index ratio
        sample->f = lobe.color * Fresnel(lobe, wo.z) / (eta * eta * std::abs(wi.z));
        return true;
    }
    }
    return false;
}

} // namespace cuticle
