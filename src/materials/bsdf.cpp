#include "materials/bsdf.h"

#include "core/sampling.h"

namespace cuticle {

namespace {

float CosTheta(const Vector3f &w) { return w.z; }
float Cos2Theta(const Vector3f &w) { return w.z * w.z; }
float Sin2Theta(const Vector3f &w) { return std::max(0.f, 1 - Cos2Theta(w)); }
float SinTheta(const Vector3f &w) { return std::sqrt(Sin2Theta(w)); }
bool SameHemisphere(const Vector3f &a, const Vector3f &b) { return a.z * b.z > 0; }

Vector3f Faceforward(const Vector3f &v, const Vector3f &w) { return Dot(v, w) < 0 ? -v : v; }

// wi refracted about n (same side as wi), eta = index on wi's side over the other. False: total reflection.
bool Refract(const Vector3f &wi, const Vector3f &n, float eta, Vector3f *wt) {
    const float cosI = Dot(n, wi);
    const float sin2T = eta * eta * std::max(0.f, 1 - cosI * cosI);
    if (sin2T >= 1)
        return false;
    *wt = -wi * eta + n * (eta * cosI - std::sqrt(1 - sin2T));
    return true;
}

// Trowbridge and Reitz's distribution of slopes with Smith's masking, sampled by visible normals (Heitz 2018).
struct TrowbridgeReitz {
    float ax, ay;

    // Slope variance along the azimuth of w, times tan^2 theta; without division at the pole.
    float ScaledTan2(const Vector3f &w) const {
        return (Sqr(ax * w.x) + Sqr(ay * w.y)) / std::max(Cos2Theta(w), 1e-16f);
    }
    float Lambda(const Vector3f &w) const { return (std::sqrt(1 + ScaledTan2(w)) - 1) / 2; }
    float G(const Vector3f &wo, const Vector3f &wi, bool separable = false) const {
        return separable ? 1 / ((1 + Lambda(wo)) * (1 + Lambda(wi))) : 1 / (1 + Lambda(wo) + Lambda(wi));
    }
    float D(const Vector3f &wh) const {
        const float k = Sqr(wh.x / ax) + Sqr(wh.y / ay) + Sqr(wh.z);
        return 1 / (Pi * ax * ay * k * k);
    }
    float Pdf(const Vector3f &wo, const Vector3f &wh) const {
        return D(wh) * AbsDot(wo, wh) / ((1 + Lambda(wo)) * std::max(std::abs(CosTheta(wo)), 1e-8f));
    }
    Vector3f Sample_wh(const Vector3f &wo, const Point2f &u) const {
        // Stretch the view direction so that the surface becomes the hemisphere of normals
        const bool flip = wo.z < 0;
        const Vector3f w = flip ? -wo : wo;
        const Vector3f v = Normalize(Vector3f(ax * w.x, ay * w.y, w.z));
        Frame f = Frame::FromZ(v);
        const float r = std::sqrt(u.x), phi = 2 * Pi * u.y;
        const float t1 = r * std::cos(phi);
        const float s = 0.5f * (1 + v.z);
        // f's axes may lean anywhere in the plane; Heitz's first axis is horizontal
        if (v.z < 0.9999f) {
            f.x = Normalize(Cross(Vector3f(0, 0, 1), v));
            f.y = Cross(v, f.x);
        }
        const float t2 = (1 - s) * std::sqrt(std::max(0.f, 1 - t1 * t1)) + s * r * std::sin(phi);
        const Vector3f n = f.FromLocal({t1, t2, std::sqrt(std::max(0.f, 1 - t1 * t1 - t2 * t2))});
        const Vector3f wh = Normalize(Vector3f(ax * n.x, ay * n.y, std::max(1e-6f, n.z)));
        return flip ? -wh : wh;
    }
};

// Schlick's (1 - cos)^5.
float SchlickWeight(float cosTheta) {
    const float m = std::clamp(1 - cosTheta, 0.f, 1.f);
    return Sqr(Sqr(m)) * m;
}

// Burley's clear coat: the tails of GTR1 are longer than GGX's. alpha in (0, 1).
float GTR1(const Vector3f &wh, float alpha) {
    const float alpha2 = alpha * alpha, sin2 = wh.x * wh.x + wh.y * wh.y;
    return (alpha2 - 1) / (Pi * std::log(alpha2) * (sin2 + alpha2 * Cos2Theta(wh)));
}

Vector3f SampleGTR1(float alpha, const Point2f &u) {
    const float alpha2 = alpha * alpha;
    const float sin2 = std::clamp((std::pow(alpha2, 1 - u.x) - alpha2) / (1 - alpha2), 0.f, 1.f);
    const float sinTheta = std::sqrt(sin2), phi = 2 * Pi * u.y;
    return {sinTheta * std::cos(phi), sinTheta * std::sin(phi), std::sqrt(1 - sin2)};
}

// Smith's masking of GGX, over twice the cosine: so two of them hold the microfacet formula's denominator.
float SmithOver2Cos(float cosTheta, float alpha) {
    const float alpha2 = alpha * alpha, cos2 = cosTheta * cosTheta;
    return 1 / (cosTheta + std::sqrt(alpha2 + cos2 - alpha2 * cos2));
}

// The half vector of a reflection. False where there is none: opposite sides, or opposite directions.
bool HalfVector(const Vector3f &wo, const Vector3f &wi, Vector3f *wh) {
    const Vector3f sum = wo + wi;
    if (!SameHemisphere(wo, wi) || sum.LengthSquared() == 0)
        return false;
    *wh = Normalize(sum);
    return true;
}

// The normal, on the upper side, of the facets that refract wo into wi. False where there is none: one side, no crossing,
// or facets that turn their back on a direction (pbrt-v3 lets these scatter, in one direction and not the other).
bool RefractingHalfVector(const Vector3f &wo, const Vector3f &wi, float eta, Vector3f *wh) {
    const Vector3f sum = wo + wi * eta;
    if (!(CosTheta(wo) * CosTheta(wi) < 0) || sum.LengthSquared() == 0)
        return false;
    *wh = Faceforward(Normalize(sum), {0, 0, 1});
    return Dot(wo, *wh) * CosTheta(wo) > 0 && Dot(wi, *wh) * CosTheta(wi) > 0;
}

} // namespace

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

float FrConductor(float cosThetaI, float eta, float k) {
    const float cosI = std::min(std::abs(cosThetaI), 1.f), cos2 = cosI * cosI, sin2 = 1 - cos2;
    // a + i b: the square root of (eta + i k)^2 - sin^2, without the cancellation of a small a beside a large b
    const float t0 = eta * eta - k * k - sin2;
    const float a2b2 = std::sqrt(t0 * t0 + Sqr(2 * eta * k));
    const float larger = std::sqrt((a2b2 + std::abs(t0)) / 2);
    const float a = t0 >= 0 ? larger : eta * k / larger;
    const float t1 = a2b2 + cos2, t2 = 2 * cosI * a;
    if (!(t1 + t2 > 0)) // along a surface that has the index of its outside
        return 0;
    const float perpendicular = (t1 - t2) / (t1 + t2);
    const float t3 = cos2 * a2b2 + sin2 * sin2, t4 = t2 * sin2;
    const float parallel = t3 + t4 > 0 ? perpendicular * (t3 - t4) / (t3 + t4) : perpendicular;
    return (perpendicular + parallel) / 2;
}

Spectrum FrConductor(float cosThetaI, const Spectrum &eta, const Spectrum &k) {
    Spectrum r;
    for (int i = 0; i < 3; ++i)
        r[i] = FrConductor(cosThetaI, eta[i], k[i]);
    return r;
}

Spectrum FrSchlick(const Spectrum &r0, float cosTheta) {
    const float w = SchlickWeight(cosTheta);
    return r0 * (1 - w) + Spectrum(w);
}

float RoughnessToAlpha(float roughness) {
    const float x = std::log(std::max(roughness, 1e-3f));
    return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

void SurfaceLobes::Add(Lobe lobe) {
    lobe.color *= scale_;
    if (!lobe.color.IsBlack() && count_ < kMaxLobes)
        lobes_[static_cast<size_t>(count_++)] = lobe;
}
void SurfaceLobes::Add(Kind kind, const Spectrum &color, float a) {
    Add({.kind = kind, .color = color, .a = a});
}
void SurfaceLobes::AddOrenNayar(const Spectrum &r, float sigma) {
    if (sigma == 0)
        return AddLambertReflection(r);
    const float s2 = Sqr(Radians(sigma));
    Add({.kind = Kind::OrenNayar,
         .color = r,
         .a = 1 - s2 / (2 * (s2 + 0.33f)),
         .b = 0.45f * s2 / (s2 + 0.09f)});
}
void SurfaceLobes::AddMicrofacetReflection(const Spectrum &r, float ax, float ay, float eta) {
    Add({.kind = Kind::MicrofacetReflection,
         .color = r,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .eta = eta});
}
void SurfaceLobes::AddConductorReflection(const Spectrum &r, float ax, float ay, const Spectrum &eta,
                                          const Spectrum &k) {
    Add({.kind = Kind::ConductorReflection,
         .color = r,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .etaOrR0 = eta,
         .k = k});
}
void SurfaceLobes::AddMicrofacetTransmission(const Spectrum &t, float ax, float ay, float eta,
                                             bool separable) {
    Add({.kind = Kind::MicrofacetTransmission,
         .separable = separable,
         .color = t,
         .a = std::max(ax, 1e-3f),
         .b = std::max(ay, 1e-3f),
         .eta = eta});
}
void SurfaceLobes::AddSpecularReflection(const Spectrum &r, float eta) {
    Add({.kind = Kind::SpecularReflection, .color = r, .eta = eta});
}
void SurfaceLobes::AddSpecularTransmission(const Spectrum &t, float eta) {
    Add({.kind = Kind::SpecularTransmission, .color = t, .eta = eta});
}
void SurfaceLobes::AddCoatedDiffuse(const Spectrum &rd, const Spectrum &rs) {
    Add(Kind::CoatedDiffuse, rd * (-rs + Spectrum(1)).Clamp());
}
void SurfaceLobes::AddCoat(const Spectrum &rs, float ax, float ay) {
    if (!rs.IsBlack())
        Add({.kind = Kind::Coat,
             .color = Spectrum(1),
             .a = std::max(ax, 1e-3f),
             .b = std::max(ay, 1e-3f),
             .etaOrR0 = rs});
}
void SurfaceLobes::AddDisneySpecular(const Spectrum &r0, float metallic, float eta, float ax, float ay) {
    Add({.kind = Kind::DisneySpecular,
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
    Add({.kind = Kind::DisneyClearcoat,
         .color = Spectrum(weight / 4),
         .a = Lerp(std::clamp(gloss, 0.f, 1.f), 0.1f, 0.001f),
         .etaOrR0 = Spectrum(0.04f)});
}

bool SurfaceLobes::HasNonSpecular() const {
    for (int i = 0; i < count_; ++i)
        if (!lobes_[static_cast<size_t>(i)].Specular())
            return true;
    return false;
}

// The Fresnel factor of a lobe that has one, else 1.
Spectrum SurfaceLobes::Fresnel(const Lobe &lobe, float cosTheta) {
    switch (lobe.kind) {
    case Kind::SpecularReflection:
        return Spectrum(lobe.eta == 0 ? 1 : FrDielectric(cosTheta, lobe.eta));
    case Kind::MicrofacetReflection:
        return Spectrum(FrDielectric(cosTheta, lobe.eta));
    case Kind::SpecularTransmission:
        return Spectrum(lobe.eta == 1 ? 1 : 1 - FrDielectric(cosTheta, lobe.eta));
    case Kind::MicrofacetTransmission:
        return Spectrum(1 - FrDielectric(cosTheta, lobe.eta));
    case Kind::ConductorReflection:
        return FrConductor(cosTheta, lobe.etaOrR0, lobe.k);
    case Kind::Coat:
    case Kind::DisneyClearcoat:
        return FrSchlick(lobe.etaOrR0, std::abs(cosTheta));
    case Kind::DisneySpecular:
        return Spectrum(FrDielectric(cosTheta, lobe.eta)) * (1 - lobe.metallic) +
               FrSchlick(lobe.etaOrR0, std::abs(cosTheta)) * lobe.metallic;
    default:
        return Spectrum(1);
    }
}

// pbrt-v3 chooses lobes uniformly; in proportion to their colour, and of mirrors and coats to what Fresnel leaves
// them, is less noisy and as easy. Rough lobes keep a tenth: their facets lean, and see other angles than the surface.
float SurfaceLobes::Weight(const Lobe &lobe, const Vector3f &wo) {
    const float whole = lobe.color.MaxComponentValue();
    switch (lobe.kind) {
    case Kind::MicrofacetReflection:
    case Kind::MicrofacetTransmission:
        return whole;
    case Kind::Coat:
    case Kind::DisneySpecular:
    case Kind::DisneyClearcoat:
        return std::max((lobe.color * Fresnel(lobe, wo.z)).MaxComponentValue(), 0.1f * whole);
    default:
        return (lobe.color * Fresnel(lobe, wo.z)).MaxComponentValue();
    }
}

SurfaceLobes::Weights SurfaceLobes::Probabilities(const Vector3f &wo) const {
    Weights weights{};
    float sum = 0;
    for (size_t i = 0; i < static_cast<size_t>(count_); ++i)
        sum += weights[i] = Weight(lobes_[i], wo);
    if (sum > 0)
        for (float &w : weights)
            w /= sum;
    return weights;
}

// Disney's diffuse lobes that look at the angle between the light and the half vector.
Spectrum SurfaceLobes::EvaluateByHalfAngle(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    const Vector3f sum = wo + wi;
    if (sum.LengthSquared() == 0)
        return {};
    const float cosD = Dot(wi, Normalize(sum)), cosO = std::abs(CosTheta(wo)), cosI = std::abs(CosTheta(wi));
    const float fO = SchlickWeight(cosO), fI = SchlickWeight(cosI);
    if (lobe.kind == Kind::DisneySheen)
        return lobe.color * SchlickWeight(cosD);
    if (lobe.kind == Kind::DisneyRetro) { // Burley 2015, equation 4
        const float r = 2 * lobe.a * cosD * cosD;
        return lobe.color / Pi * (r * (fO + fI + fO * fI * (r - 1)));
    }
    // Hanrahan and Krueger's single scattering in disguise (Burley 2012); 1.25 roughly keeps the albedo
    const float f90 = cosD * cosD * lobe.a;
    const float f = Lerp(fO, 1.f, f90) * Lerp(fI, 1.f, f90);
    return lobe.color / Pi * (1.25f * (f * (1 / (cosO + cosI) - 0.5f) + 0.5f));
}

Spectrum SurfaceLobes::Evaluate(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    switch (lobe.kind) {
    case Kind::LambertReflection:
    case Kind::LambertTransmission:
        return lobe.color / Pi;
    case Kind::OrenNayar: {
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
    case Kind::MicrofacetReflection:
    case Kind::ConductorReflection:
    case Kind::DisneySpecular: {
        const float cosO = std::abs(CosTheta(wo)), cosI = std::abs(CosTheta(wi));
        Vector3f wh = wi + wo;
        if (cosI == 0 || cosO == 0 || wh.LengthSquared() == 0)
            return {};
        wh = Normalize(wh);
        const TrowbridgeReitz d{lobe.a, lobe.b};
        return lobe.color * Fresnel(lobe, Dot(wi, Faceforward(wh, {0, 0, 1}))) *
               (d.D(wh) * d.G(wo, wi, lobe.separable) / (4 * cosI * cosO));
    }
    case Kind::MicrofacetTransmission: {
        const float cosO = CosTheta(wo), cosI = CosTheta(wi), eta = cosO > 0 ? lobe.eta : 1 / lobe.eta;
        Vector3f wh;
        if (!RefractingHalfVector(wo, wi, eta, &wh))
            return {};
        const TrowbridgeReitz d{lobe.a, lobe.b};
        const float sqrtDenom = Dot(wo, wh) + eta * Dot(wi, wh);
        // Radiance is scaled by the squared index ratio on crossing: eta^2 of the Jacobian cancels against it
        return lobe.color * Fresnel(lobe, Dot(wo, wh)) *
               std::abs(d.D(wh) * d.G(wo, wi, lobe.separable) * Dot(wi, wh) * Dot(wo, wh) /
                        (cosI * cosO * sqrtDenom * sqrtDenom));
    }
    case Kind::CoatedDiffuse: {
        const auto leave = [](float cosTheta) {
            const float m = 1 - std::abs(cosTheta) / 2;
            return 1 - Sqr(Sqr(m)) * m;
        };
        return lobe.color * (28 / (23 * Pi) * leave(CosTheta(wi)) * leave(CosTheta(wo)));
    }
    case Kind::Coat: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return {};
        const TrowbridgeReitz d{lobe.a, lobe.b};
        const float cosine = std::max(std::abs(CosTheta(wo)), std::abs(CosTheta(wi)));
        return lobe.color * Fresnel(lobe, Dot(wi, wh)) * (d.D(wh) / (4 * AbsDot(wi, wh) * cosine));
    }
    case Kind::DisneyDiffuse:
        // From 1 at normal incidence to 1/2 at grazing (Burley 2015, equation 4)
        return lobe.color / Pi * (1 - SchlickWeight(std::abs(CosTheta(wo))) / 2) *
               (1 - SchlickWeight(std::abs(CosTheta(wi))) / 2);
    case Kind::DisneyFlat:
    case Kind::DisneyRetro:
    case Kind::DisneySheen:
        return EvaluateByHalfAngle(lobe, wo, wi);
    case Kind::DisneyClearcoat: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return {};
        // Masking keeps a roughness of 1/4, whatever the gloss (Burley 2012, section 5.6)
        return lobe.color * Fresnel(lobe, Dot(wo, wh)) *
               (GTR1(wh, lobe.a) * SmithOver2Cos(std::abs(CosTheta(wo)), 0.25f) *
                SmithOver2Cos(std::abs(CosTheta(wi)), 0.25f));
    }
    case Kind::SpecularReflection:
    case Kind::SpecularTransmission:
        return {};
    }
    return {};
}

float SurfaceLobes::Pdf(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi) {
    switch (lobe.kind) {
    case Kind::LambertReflection:
    case Kind::OrenNayar:
    case Kind::CoatedDiffuse:
    case Kind::DisneyDiffuse:
    case Kind::DisneyFlat:
    case Kind::DisneyRetro:
    case Kind::DisneySheen:
        return SameHemisphere(wo, wi) ? std::abs(CosTheta(wi)) / Pi : 0;
    case Kind::LambertTransmission:
        return SameHemisphere(wo, wi) ? 0 : std::abs(CosTheta(wi)) / Pi;
    case Kind::MicrofacetReflection:
    case Kind::ConductorReflection:
    case Kind::Coat:
    case Kind::DisneySpecular: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return 0;
        return TrowbridgeReitz{lobe.a, lobe.b}.Pdf(wo, wh) / (4 * AbsDot(wo, wh));
    }
    case Kind::DisneyClearcoat: {
        Vector3f wh;
        if (!HalfVector(wo, wi, &wh))
            return 0;
        return GTR1(wh, lobe.a) * std::abs(CosTheta(wh)) / (4 * AbsDot(wo, wh));
    }
    case Kind::MicrofacetTransmission: {
        const float eta = CosTheta(wo) > 0 ? lobe.eta : 1 / lobe.eta;
        Vector3f wh;
        if (!RefractingHalfVector(wo, wi, eta, &wh))
            return 0;
        const float sqrtDenom = Dot(wo, wh) + eta * Dot(wi, wh);
        return TrowbridgeReitz{lobe.a, lobe.b}.Pdf(wo, wh) *
               std::abs(eta * eta * Dot(wi, wh) / Sqr(sqrtDenom));
    }
    case Kind::SpecularReflection:
    case Kind::SpecularTransmission:
        return 0;
    }
    return 0;
}

Spectrum SurfaceLobes::f(const Vector3f &wo, const Vector3f &wi, bool reflect, float *pdf) const {
    Spectrum sum;
    *pdf = 0;
    if (wo.z == 0)
        return sum;
    const Weights probabilities = Probabilities(wo);
    for (size_t i = 0; i < static_cast<size_t>(count_); ++i) {
        if (lobes_[i].Reflects() == reflect)
            sum += Evaluate(lobes_[i], wo, wi);
        *pdf += probabilities[i] * Pdf(lobes_[i], wo, wi);
    }
    return sum;
}

bool SurfaceLobes::Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const {
    if (count_ == 0 || wo.z == 0)
        return false;
    const Weights probabilities = Probabilities(wo);
    size_t chosen = 0;
    for (float cdf = probabilities[0]; chosen + 1 < static_cast<size_t>(count_) && uLobe >= cdf;)
        cdf += probabilities[++chosen];
    const Lobe &lobe = lobes_[chosen];
    sample->specular = lobe.Specular();
    sample->transmission = !lobe.Reflects();
    sample->eta = 1;

    Vector3f &wi = sample->wi;
    switch (lobe.kind) {
    case Kind::LambertReflection:
    case Kind::OrenNayar:
    case Kind::CoatedDiffuse:
    case Kind::DisneyDiffuse:
    case Kind::DisneyFlat:
    case Kind::DisneyRetro:
    case Kind::DisneySheen:
    case Kind::LambertTransmission:
        wi = CosineSampleHemisphere(u);
        if ((wo.z < 0) == lobe.Reflects())
            wi.z = -wi.z;
        return true;
    case Kind::MicrofacetReflection:
    case Kind::ConductorReflection:
    case Kind::Coat:
    case Kind::DisneySpecular:
    case Kind::DisneyClearcoat: {
        const Vector3f wh = lobe.kind == Kind::DisneyClearcoat
                                ? Faceforward(SampleGTR1(lobe.a, u), {0, 0, wo.z})
                                : TrowbridgeReitz{lobe.a, lobe.b}.Sample_wh(wo, u);
        wi = wh * (2 * Dot(wo, wh)) - wo;
        return SameHemisphere(wo, wi);
    }
    case Kind::MicrofacetTransmission: {
        const Vector3f wh = TrowbridgeReitz{lobe.a, lobe.b}.Sample_wh(wo, u);
        const float eta = wo.z > 0 ? lobe.eta : 1 / lobe.eta;
        sample->eta = eta;
        return Dot(wo, wh) >= 0 && Refract(wo, wh, 1 / eta, &wi) && !SameHemisphere(wo, wi);
    }
    case Kind::SpecularReflection: {
        wi = {-wo.x, -wo.y, wo.z};
        sample->pdf = probabilities[chosen];
        sample->f = lobe.color * Fresnel(lobe, wo.z) / std::abs(wi.z);
        return true;
    }
    case Kind::SpecularTransmission: {
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

bool BSDF::HasNonSpecular() const {
    if (const auto *s = std::get_if<SurfaceLobes>(&model_))
        return s->HasNonSpecular();
    return IsHair();
}

Spectrum BSDF::FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const {
    const Vector3f wo = frame_.ToLocal(woW), wi = frame_.ToLocal(wiW);
    *pdf = 0;
    if (const auto *hair = std::get_if<HairBSDF>(&model_))
        return scale_ * hair->FPdf(wo, wi, pdf) * std::abs(wi.z);
    if (const auto *s = std::get_if<SurfaceLobes>(&model_)) {
        const bool reflect = Dot(woW, n_) * Dot(wiW, n_) > 0;
        return scale_ * s->f(wo, wi, reflect, pdf) * std::abs(wi.z);
    }
    if (const FiberBxDF *fiber = Fiber())
        return scale_ * fiber->FPdf(wo, wi, pdf) * std::abs(wi.z);
    return {};
}

bool BSDF::Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                    Spectrum *weight) const {
    const Vector3f wo = frame_.ToLocal(woW);
    Vector3f wi;
    const auto fromFiber = [&](const auto &fiber) {
        sample->f = fiber.Sample_f(wo, &wi, u, &sample->pdf);
        sample->specular = false;
        sample->transmission = wi.z * wo.z < 0;
        sample->eta = 1;
    };
    if (const auto *hair = std::get_if<HairBSDF>(&model_)) {
        fromFiber(*hair);
    } else if (const auto *s = std::get_if<SurfaceLobes>(&model_)) {
        if (!s->Sample_f(wo, u[0], {u[1], u[2]}, sample))
            return false;
        wi = sample->wi;
        if (!sample->specular) {
            const bool reflect = Dot(frame_.FromLocal(wi), n_) * Dot(woW, n_) > 0;
            sample->f = s->f(wo, wi, reflect, &sample->pdf);
        }
    } else if (const FiberBxDF *fiber = Fiber()) {
        fromFiber(*fiber);
    } else {
        return false;
    }
    sample->f *= scale_;
    if (!(sample->pdf > 0) || sample->f.IsBlack())
        return false;
    sample->wi = Normalize(frame_.FromLocal(wi));
    *weight = sample->f * (std::abs(wi.z) / sample->pdf);
    return true;
}

} // namespace cuticle
