#include "materials/microfacet.h"

#include "core/sampling.h"

namespace cuticle {

bool Refract(const Vector3f &wi, const Vector3f &n, float eta, Vector3f *wt) {
    const float cosI = Dot(n, wi);
    const float sin2T = eta * eta * std::max(0.f, 1 - cosI * cosI);
    if (sin2T >= 1)
        return false;
    *wt = -wi * eta + n * (eta * cosI - std::sqrt(1 - sin2T));
    return true;
}

bool HalfVector(const Vector3f &wo, const Vector3f &wi, Vector3f *wh) {
    const Vector3f sum = wo + wi;
    if (!SameHemisphere(wo, wi) || sum.LengthSquared() == 0)
        return false;
    *wh = Normalize(sum);
    return true;
}

bool RefractingHalfVector(const Vector3f &wo, const Vector3f &wi, float eta, Vector3f *wh) {
    const Vector3f sum = wo + wi * eta;
    if (!(CosTheta(wo) * CosTheta(wi) < 0) || sum.LengthSquared() == 0)
        return false;
    *wh = Faceforward(Normalize(sum), {0, 0, 1});
    return Dot(wo, *wh) * CosTheta(wo) > 0 && Dot(wi, *wh) * CosTheta(wi) > 0;
}

float RoughnessToAlpha(float roughness) {
    const float x = std::log(std::max(roughness, 1e-3f));
    return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

Vector3f TrowbridgeReitz::Sample_wh(const Vector3f &wo, const Point2f &u) const {
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

float SmithOver2Cos(float cosTheta, float alpha) {
    const float alpha2 = alpha * alpha, cos2 = cosTheta * cosTheta;
    return 1 / (cosTheta + std::sqrt(alpha2 + cos2 - alpha2 * cos2));
}

} // namespace cuticle
