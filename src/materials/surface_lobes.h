// The scattering of surfaces that are not hair: a sum of lobes, after the reflection chapter of pbrt-v3's
// book.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace cuticle {

// One direction chosen by a BSDF.
struct BSDFSample {
    Vector3f wi; // world space, unit length
    Spectrum f;  // value, 1/sr; for specular lobes f |cos| / pdf is the weight and pdf the lobe's probability
    float pdf = 0; // solid angle density
    bool specular = false;
    bool transmission = false;
    float eta = 1; // relative index passed through on transmission, else 1
};

// A sum of lobes. A value type without heap storage. Directions are local: z is the shading normal.
class SurfaceLobes {
  public:
    // Enough for two materials of eight lobes, mixed; MakeMaterial() refuses mixes that need more.
    static constexpr size_t kMaxLobes = 16;

    // Multiplies all lobes that are added from now on, by which materials are mixed. 1 at first.
    void SetScale(const Spectrum &scale) { scale_ = scale; }
    const Spectrum &Scale() const { return scale_; }

    // Each Add ignores a black colour; more than kMaxLobes lobes fail a CHECK.
    void AddLambertReflection(const Spectrum &r) { Add(LobeKind::LambertReflection, r); }
    void AddLambertTransmission(const Spectrum &t) { Add(LobeKind::LambertTransmission, t); }
    // Adds Oren and Nayar's rough diffuse surface (1994); sigma in degrees, 0 is Lambert's.
    void AddOrenNayar(const Spectrum &r, float sigma);
    // Adds Torrance and Sparrow's facets with Trowbridge and Reitz's distribution (GGX) and the Fresnel
    // factor of a dielectric of index eta, or of a conductor of index eta + i k. alpha: roughness along x
    // and y; below 1e-3 it is taken as that.
    void AddMicrofacetReflection(const Spectrum &r, float alphaX, float alphaY, float eta);
    void AddConductorReflection(const Spectrum &r, float alphaX, float alphaY, const Spectrum &eta,
                                const Spectrum &k);
    // separable: the product of masking and shadowing, as in Disney's model, instead of their
    // height-correlated form.
    void AddMicrofacetTransmission(const Spectrum &t, float alphaX, float alphaY, float eta,
                                   bool separable = false);
    // Adds a perfect mirror; eta = 0: no Fresnel factor.
    void AddSpecularReflection(const Spectrum &r, float eta);
    // Adds sharp refraction with the factor 1 - F; eta = 1 passes straight through.
    void AddSpecularTransmission(const Spectrum &t, float eta);
    // Adds the diffuse base rd under a glossy coat that reflects rs at normal incidence, and the coat itself
    // (Ashikhmin and Shirley 2000; pbrt-v3's FresnelBlend).
    void AddCoatedDiffuse(const Spectrum &rd, const Spectrum &rs);
    void AddCoat(const Spectrum &rs, float alphaX, float alphaY);
    // Adds a lobe of Disney's model (Burley 2012 and 2015); colours have all weights multiplied in.
    void AddDisneyDiffuse(const Spectrum &r) { Add(LobeKind::DisneyDiffuse, r); }
    void AddDisneyFlat(const Spectrum &r, float roughness) { Add(LobeKind::DisneyFlat, r, roughness); }
    void AddDisneyRetro(const Spectrum &r, float roughness) { Add(LobeKind::DisneyRetro, r, roughness); }
    void AddDisneySheen(const Spectrum &r) { Add(LobeKind::DisneySheen, r); }
    // r0: reflectance at normal incidence in Schlick's formula, blended by metallic with a dielectric of
    // index eta.
    void AddDisneySpecular(const Spectrum &r0, float metallic, float eta, float alphaX, float alphaY);
    void AddDisneyClearcoat(float weight, float gloss);

    // The sum of the lobes that reflect, or of those that transmit, and the density of Sample_f. reflect: wo
    // and wi lie on one side of the geometric surface.
    Spectrum f(const Vector3f &wo, const Vector3f &wi, bool reflect, float *pdf) const;
    // Chooses a lobe in proportion to its colour times its Fresnel factor, then a direction. Sets f and pdf
    // of the sample only for specular lobes. False: no direction.
    bool Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const;
    bool HasNonSpecular() const;
    bool Empty() const { return count_ == 0; }
    size_t Count() const { return count_; }

  private:
    enum class LobeKind : uint8_t {
        LambertReflection,
        LambertTransmission,
        OrenNayar,
        MicrofacetReflection,
        ConductorReflection,
        MicrofacetTransmission,
        SpecularReflection,
        SpecularTransmission,
        CoatedDiffuse,
        Coat,
        DisneyDiffuse,
        DisneyFlat,
        DisneyRetro,
        DisneySheen,
        DisneySpecular,
        DisneyClearcoat,
    };
    struct Lobe {
        LobeKind kind = LobeKind::LambertReflection;
        bool separable = false;
        Spectrum color{};
        float a = 0, b = 0; // Oren-Nayar's A, B; or the roughnesses along x, y
        float eta = 1;
        float metallic = 0;
        // A conductor's index eta + i k; a coat's or Disney's metal's reflectance at normal incidence.
        Spectrum etaOrR0{}, k{};
        bool Specular() const {
            return kind == LobeKind::SpecularReflection || kind == LobeKind::SpecularTransmission;
        }
        bool Reflects() const {
            return kind != LobeKind::LambertTransmission && kind != LobeKind::MicrofacetTransmission &&
                   kind != LobeKind::SpecularTransmission;
        }
    };
    using Weights = std::array<float, kMaxLobes>;
    void Add(Lobe lobe);
    void Add(LobeKind kind, const Spectrum &color, float a = 0);
    static Spectrum Evaluate(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateOrenNayar(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateReflectingFacets(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateRefractingFacets(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateCoat(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateClearcoat(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateByHalfAngle(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static float Pdf(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum Fresnel(const Lobe &lobe, float cosTheta);
    static float Weight(const Lobe &lobe, const Vector3f &wo);
    // The probability of each lobe in Sample_f; all 0 where every lobe is black.
    Weights Probabilities(const Vector3f &wo) const;

    std::array<Lobe, kMaxLobes> lobes_{};
    Spectrum scale_{1};
    size_t count_ = 0;
};

} // namespace cuticle
