// Distributions of microfacets, and directions in the local frame of a surface, whose z axis is the shading
// normal.
#pragma once

#include "core/vecmath.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

inline float CosTheta(const Vector3f &w) { return w.z; }
inline float Cos2Theta(const Vector3f &w) { return w.z * w.z; }
inline float Sin2Theta(const Vector3f &w) { return std::max(0.f, 1 - Cos2Theta(w)); }
inline float SinTheta(const Vector3f &w) { return std::sqrt(Sin2Theta(w)); }
// True for a direction that rounding cannot tell from one in the surface: nothing is scattered from or to it,
// and the quotients of the lobes stay finite for all others.
inline bool InSurface(const Vector3f &w) { return !(std::abs(w.z) > 1e-10f); }
inline bool SameHemisphere(const Vector3f &a, const Vector3f &b) { return a.z * b.z > 0; }
// v, turned to the side of w.
inline Vector3f Faceforward(const Vector3f &v, const Vector3f &w) { return Dot(v, w) < 0 ? -v : v; }

// Refracts wi about n (on the side of wi); eta = index on wi's side over the other. False: total reflection.
bool Refract(const Vector3f &wi, const Vector3f &n, float eta, Vector3f *wt);
// Finds the half vector of a reflection. False where there is none: opposite sides, or opposite directions.
bool HalfVector(const Vector3f &wo, const Vector3f &wi, Vector3f *wh);
// Finds the normal, on the upper side, of the facets that refract wo into wi; eta = index on wi's side over
// wo's. False where there is none: both on one side, no crossing, or facets that face away from a direction
// (pbrt-v3 lets these scatter, in one direction and not in the other).
bool RefractingHalfVector(const Vector3f &wo, const Vector3f &wi, float eta, Vector3f *wh);

// pbrt-v3's mapping of a perceptual roughness in [0, 1] to the alpha of Trowbridge and Reitz.
float RoughnessToAlpha(float roughness);

// Trowbridge and Reitz's distribution of slopes (GGX) with Smith's masking, sampled by visible normals
// (Heitz 2018, "Sampling the GGX Distribution of Visible Normals"). ax, ay: roughness along x and y, > 0.
struct TrowbridgeReitz {
    float ax, ay;

    // The length of w, stretched by the roughness: |cos theta| (1 + 2 Lambda) of Smith's masking, and finite
    // for directions in the surface, where Lambda is not.
    float Stretched(const Vector3f &w) const {
        return std::sqrt(Sqr(ax * w.x) + Sqr(ay * w.y) + Cos2Theta(w));
    }
    // Masking and shadowing over 4 |cos theta_o cos theta_i|, by height-correlated Smith; separable: the
    // product of one factor for each. Without the quotient of numbers that vanish at grazing angles.
    float GOver4Cos(const Vector3f &wo, const Vector3f &wi, bool separable = false) const {
        const float cosO = std::abs(CosTheta(wo)), cosI = std::abs(CosTheta(wi));
        const float stretchedO = Stretched(wo), stretchedI = Stretched(wi);
        return separable ? 1 / ((cosO + stretchedO) * (cosI + stretchedI))
                         : 1 / (2 * (cosI * stretchedO + cosO * stretchedI));
    }
    float D(const Vector3f &wh) const {
        const float k = Sqr(wh.x / ax) + Sqr(wh.y / ay) + Sqr(wh.z);
        return 1 / (Pi * ax * ay * k * k);
    }
    // The density of Sample_wh, per steradian of wh.
    float Pdf(const Vector3f &wo, const Vector3f &wh) const {
        return 2 * D(wh) * AbsDot(wo, wh) / (std::abs(CosTheta(wo)) + Stretched(wo));
    }
    // A visible normal on the side of wo. u in [0,1)^2.
    Vector3f Sample_wh(const Vector3f &wo, const Point2f &u) const;
};

// Burley's distribution of the clear coat, whose tails are longer than GGX's (Burley 2012, equation 4).
// alpha in (0, 1).
float GTR1(const Vector3f &wh, float alpha);
// A normal on the upper side with density GTR1(wh) cos theta. u in [0,1)^2.
Vector3f SampleGTR1(float alpha, const Point2f &u);
// Smith's masking of GGX over twice the cosine, so that two of them hold the denominator of the microfacet
// formula.
float SmithOver2Cos(float cosTheta, float alpha);

} // namespace cuticle
