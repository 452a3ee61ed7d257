#include "scene/bsdf.h"

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
    float G(const Vector3f &wo, const Vector3f &wi) const { return 1 / (1 + Lambda(wo) + Lambda(wi)); }
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

float RoughnessToAlpha(float roughness) {
    const float x = std::log(std::max(roughness, 1e-3f));
    return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

void SurfaceLobes::Add(const Lobe &lobe) {
    if (!lobe.color.IsBlack() && count_ < kMaxLobes)
        lobes_[static_cast<size_t>(count_++)] = lobe;
}
void SurfaceLobes::AddLambertReflection(const Spectrum &r) { Add({Kind::LambertReflection, r}); }
void SurfaceLobes::AddLambertTransmission(const Spectrum &t) { Add({Kind::LambertTransmission, t}); }
void SurfaceLobes::AddOrenNayar(const Spectrum &r, float sigma) {
    if (sigma == 0)
        return AddLambertReflection(r);
    const float s2 = Sqr(Radians(sigma));
    Add({Kind::OrenNayar, r, 1 - s2 / (2 * (s2 + 0.33f)), 0.45f * s2 / (s2 + 0.09f)});
}
void SurfaceLobes::AddMicrofacetReflection(const Spectrum &r, float ax, float ay, float eta) {
    Add({Kind::MicrofacetReflection, r, std::max(ax, 1e-3f), std::max(ay, 1e-3f), eta});
}
void SurfaceLobes::AddMicrofacetTransmission(const Spectrum &t, float ax, float ay, float eta) {
    Add({Kind::MicrofacetTransmission, t, std::max(ax, 1e-3f), std::max(ay, 1e-3f), eta});
}
void SurfaceLobes::AddSpecularReflection(const Spectrum &r, float eta) {
    Add({Kind::SpecularReflection, r, 0, 0, eta});
}
void SurfaceLobes::AddSpecularTransmission(const Spectrum &t, float eta) {
    Add({Kind::SpecularTransmission, t, 0, 0, eta});
}

bool SurfaceLobes::HasNonSpecular() const {
    for (int i = 0; i < count_; ++i)
        if (!lobes_[static_cast<size_t>(i)].Specular())
            return true;
    return false;
}

// pbrt-v3 chooses lobes uniformly; in proportion to their colour, and of mirrors to what Fresnel leaves them, is
// less noisy and as easy.
float SurfaceLobes::Probability(int lobe, const Vector3f &wo) const {
    const auto weight = [&](int i) {
        const Lobe &l = lobes_[static_cast<size_t>(i)];
        float w = l.color.MaxComponentValue();
        if (l.kind == Kind::SpecularReflection && l.eta != 0)
            w *= FrDielectric(wo.z, l.eta);
        else if (l.kind == Kind::SpecularTransmission && l.eta != 1)
            w *= 1 - FrDielectric(wo.z, l.eta);
        return w;
    };
    float sum = 0;
    for (int i = 0; i < count_; ++i)
        sum += weight(i);
    return sum > 0 ? weight(lobe) / sum : 0;
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
    case Kind::MicrofacetReflection: {
        const float cosO = std::abs(CosTheta(wo)), cosI = std::abs(CosTheta(wi));
        Vector3f wh = wi + wo;
        if (cosI == 0 || cosO == 0 || wh.LengthSquared() == 0)
            return {};
        wh = Normalize(wh);
        const TrowbridgeReitz d{lobe.a, lobe.b};
        const float fresnel = FrDielectric(Dot(wi, Faceforward(wh, {0, 0, 1})), lobe.eta);
        return lobe.color * (d.D(wh) * d.G(wo, wi) * fresnel / (4 * cosI * cosO));
    }
    case Kind::MicrofacetTransmission: {
        const float cosO = CosTheta(wo), cosI = CosTheta(wi);
        if (cosI == 0 || cosO == 0)
            return {};
        const float eta = cosO > 0 ? lobe.eta : 1 / lobe.eta;
        Vector3f wh = wo + wi * eta;
        if (wh.LengthSquared() == 0)
            return {};
        wh = Faceforward(Normalize(wh), {0, 0, 1});
        if (Dot(wo, wh) * Dot(wi, wh) > 0)
            return {};
        const TrowbridgeReitz d{lobe.a, lobe.b};
        const float fresnel = FrDielectric(Dot(wo, wh), lobe.eta);
        const float sqrtDenom = Dot(wo, wh) + eta * Dot(wi, wh);
        // Radiance is scaled by the squared index ratio on crossing: eta^2 of the Jacobian cancels against it
        return lobe.color * ((1 - fresnel) * std::abs(d.D(wh) * d.G(wo, wi) * Dot(wi, wh) * Dot(wo, wh) /
                                                      (cosI * cosO * sqrtDenom * sqrtDenom)));
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
        return SameHemisphere(wo, wi) ? std::abs(CosTheta(wi)) / Pi : 0;
    case Kind::LambertTransmission:
        return SameHemisphere(wo, wi) ? 0 : std::abs(CosTheta(wi)) / Pi;
    case Kind::MicrofacetReflection: {
        const Vector3f sum = wo + wi;
        if (!SameHemisphere(wo, wi) || sum.LengthSquared() == 0)
            return 0;
        const Vector3f wh = Normalize(sum);
        return TrowbridgeReitz{lobe.a, lobe.b}.Pdf(wo, wh) / (4 * AbsDot(wo, wh));
    }
    case Kind::MicrofacetTransmission: {
        if (SameHemisphere(wo, wi))
            return 0;
        const float eta = CosTheta(wo) > 0 ? lobe.eta : 1 / lobe.eta;
        const Vector3f sum = wo + wi * eta;
        if (sum.LengthSquared() == 0)
            return 0;
        const Vector3f wh = Normalize(sum);
        if (Dot(wo, wh) * Dot(wi, wh) > 0)
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
    for (int i = 0; i < count_; ++i) {
        const Lobe &lobe = lobes_[static_cast<size_t>(i)];
        if (lobe.Reflects() == reflect)
            sum += Evaluate(lobe, wo, wi);
        *pdf += Probability(i, wo) * Pdf(lobe, wo, wi);
    }
    return sum;
}

bool SurfaceLobes::Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const {
    if (count_ == 0 || wo.z == 0)
        return false;
    int chosen = 0;
    float probability = Probability(0, wo);
    for (float cdf = probability; chosen + 1 < count_ && uLobe >= cdf; cdf += probability)
        probability = Probability(++chosen, wo);
    const Lobe &lobe = lobes_[static_cast<size_t>(chosen)];
    sample->specular = lobe.Specular();
    sample->transmission = !lobe.Reflects();
    sample->eta = 1;

    Vector3f &wi = sample->wi;
    switch (lobe.kind) {
    case Kind::LambertReflection:
    case Kind::OrenNayar:
    case Kind::LambertTransmission:
        wi = CosineSampleHemisphere(u);
        if ((wo.z < 0) == lobe.Reflects())
            wi.z = -wi.z;
        return true;
    case Kind::MicrofacetReflection: {
        const Vector3f wh = TrowbridgeReitz{lobe.a, lobe.b}.Sample_wh(wo, u);
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
        const float fresnel = lobe.eta == 0 ? 1 : FrDielectric(wo.z, lobe.eta);
        sample->pdf = probability;
        sample->f = lobe.color * (fresnel / std::abs(wi.z));
        return true;
    }
    case Kind::SpecularTransmission: {
        const float eta = wo.z > 0 ? lobe.eta : 1 / lobe.eta;
        if (!Refract(wo, {0, 0, std::copysign(1.f, wo.z)}, 1 / eta, &wi))
            return false;
        const float fresnel = lobe.eta == 1 ? 0 : FrDielectric(wo.z, lobe.eta);
        sample->eta = eta;
        sample->pdf = probability;
        // Radiance, not importance: compressed by the squared index ratio
        sample->f = lobe.color * ((1 - fresnel) / (eta * eta * std::abs(wi.z)));
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
        return hair->FPdf(wo, wi, pdf) * std::abs(wi.z);
    if (const auto *s = std::get_if<SurfaceLobes>(&model_)) {
        const bool reflect = Dot(woW, n_) * Dot(wiW, n_) > 0;
        return s->f(wo, wi, reflect, pdf) * std::abs(wi.z);
    }
    if (const FiberBxDF *fiber = Fiber())
        return fiber->FPdf(wo, wi, pdf) * std::abs(wi.z);
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
    if (!(sample->pdf > 0) || sample->f.IsBlack())
        return false;
    sample->wi = Normalize(frame_.FromLocal(wi));
    *weight = sample->f * (std::abs(wi.z) / sample->pdf);
    return true;
}

} // namespace cuticle
