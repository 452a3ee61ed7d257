// The scattering at one surface point: a hair model, or a few lobes for everything that is not hair.
#pragma once

#include "core/color.h"
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"
#include "fibers/tabulated.h"

#include <variant>

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

// Lobes of ordinary surfaces, after pbrt-v3's reflection chapter. A value type without heap storage.
class SurfaceLobes {
  public:
    static constexpr int kMaxLobes =
        16; // two materials of eight, mixed; MakeMaterial() sees to it that it is enough

    // All lobes added from now on are multiplied by this: how materials are mixed. 1 at first.
    void SetScale(const Spectrum &scale) { scale_ = scale; }
    const Spectrum &Scale() const { return scale_; }

    // Each Add ignores a black colour and does nothing when kMaxLobes are taken.
    void AddLambertReflection(const Spectrum &r) { Add(Kind::LambertReflection, r); }
    void AddLambertTransmission(const Spectrum &t) { Add(Kind::LambertTransmission, t); }
    // Oren and Nayar's rough diffuse surface; sigma in degrees, 0 is Lambert's.
    void AddOrenNayar(const Spectrum &r, float sigma);
    // Torrance and Sparrow with Trowbridge and Reitz's distribution (GGX): with the Fresnel factor of a dielectric of
    // index eta, or of a conductor of index eta + i k. alpha: roughness along x and y, at least 1e-3.
    void AddMicrofacetReflection(const Spectrum &r, float alphaX, float alphaY, float eta);
    void AddConductorReflection(const Spectrum &r, float alphaX, float alphaY, const Spectrum &eta,
                                const Spectrum &k);
    // separable: masking and shadowing as if they knew nothing of each other, as in Disney's model.
    void AddMicrofacetTransmission(const Spectrum &t, float alphaX, float alphaY, float eta,
                                   bool separable = false);
    // A perfect mirror; eta = 0: no Fresnel factor.
    void AddSpecularReflection(const Spectrum &r, float eta);
    // Refraction with the factor 1 - F; eta = 1 passes straight through.
    void AddSpecularTransmission(const Spectrum &t, float eta);
    // Ashikhmin and Shirley 2000 (pbrt-v3's FresnelBlend): a diffuse base rd under a glossy coat that reflects rs at
    // normal incidence, and the coat itself.
    void AddCoatedDiffuse(const Spectrum &rd, const Spectrum &rs);
    void AddCoat(const Spectrum &rs, float alphaX, float alphaY);
    // The lobes of Disney's model (Burley 2012 and 2015), colours with all weights multiplied in.
    void AddDisneyDiffuse(const Spectrum &r) { Add(Kind::DisneyDiffuse, r); }
    void AddDisneyFlat(const Spectrum &r, float roughness) { Add(Kind::DisneyFlat, r, roughness); }
    void AddDisneyRetro(const Spectrum &r, float roughness) { Add(Kind::DisneyRetro, r, roughness); }
    void AddDisneySheen(const Spectrum &r) { Add(Kind::DisneySheen, r); }
    // r0: reflectance at normal incidence in Schlick's formula, blended by metallic with a dielectric of index eta.
    void AddDisneySpecular(const Spectrum &r0, float metallic, float eta, float alphaX, float alphaY);
    void AddDisneyClearcoat(float weight, float gloss);

    // Local directions (z the shading normal). reflect: wo and wi on one side of the geometric surface.
    Spectrum f(const Vector3f &wo, const Vector3f &wi, bool reflect, float *pdf) const;
    // Chooses a lobe (by its colour, and what Fresnel leaves of it), then a direction. False: none.
    bool Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const;
    bool HasNonSpecular() const;
    bool Empty() const { return count_ == 0; }
    int Count() const { return count_; }

  private:
    enum class Kind : uint8_t {
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
        Kind kind = Kind::LambertReflection;
        bool separable = false;
        Spectrum color{};
        float a = 0, b = 0; // Oren-Nayar's A, B; or the roughnesses along x, y
        float eta = 1;
        float metallic = 0;
        // Of a conductor: its index eta + i k. Of a coat or Disney's metal: its reflectance at normal incidence.
        Spectrum etaOrR0{}, k{};
        bool Specular() const {
            return kind == Kind::SpecularReflection || kind == Kind::SpecularTransmission;
        }
        bool Reflects() const {
            return kind != Kind::LambertTransmission && kind != Kind::MicrofacetTransmission &&
                   kind != Kind::SpecularTransmission;
        }
    };
    using Weights = std::array<float, kMaxLobes>;
    void Add(Lobe lobe);
    void Add(Kind kind, const Spectrum &color, float a = 0);
    static Spectrum Evaluate(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum EvaluateByHalfAngle(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static float Pdf(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static Spectrum Fresnel(const Lobe &lobe, float cosTheta);
    static float Weight(const Lobe &lobe, const Vector3f &wo);
    // With which each lobe is chosen; all 0 where nothing is left to choose.
    Weights Probabilities(const Vector3f &wo) const;

    std::array<Lobe, kMaxLobes> lobes_{};
    Spectrum scale_{1};
    int count_ = 0;
};

// Unpolarised Fresnel reflectance of a smooth dielectric; cosThetaI < 0: from inside. eta = inside / outside.
float FrDielectric(float cosThetaI, float eta);
// The same of a conductor whose index, relative to the outside, is eta + i k (both >= 0); the sign of cosThetaI does not count.
float FrConductor(float cosThetaI, float eta, float k);
Spectrum FrConductor(float cosThetaI, const Spectrum &eta, const Spectrum &k);
// Schlick's approximation: r0 at normal incidence, 1 at grazing.
Spectrum FrSchlick(const Spectrum &r0, float cosTheta);
// pbrt-v3's mapping of a perceptual roughness in [0, 1] to GGX alpha.
float RoughnessToAlpha(float roughness);

class BSDF {
  public:
    // x, y, z: shading frame; n: geometric normal on the same side as the shading one.
    void SetFrame(const Frame &shading, const Normal3f &n) { frame_ = shading, n_ = n; }
    const Frame &ShadingFrame() const { return frame_; }
    template <class... Args>
    void SetHair(Args &&...args) {
        model_.template emplace<HairBSDF>(std::forward<Args>(args)...);
    }
    // Any other model of a fiber, one of those in model_.
    template <class Model, class... Args>
    void SetFiber(Args &&...args) {
        model_.template emplace<Model>(std::forward<Args>(args)...);
    }
    SurfaceLobes &SetSurface() { return model_.template emplace<SurfaceLobes>(); }

    // A factor on everything that the model scatters, 1 at first.
    void SetScale(const Spectrum &scale) { scale_ = scale; }
    const Spectrum &Scale() const { return scale_; }

    // True if light sampling can contribute.
    bool HasNonSpecular() const;
    bool IsHair() const { return std::holds_alternative<HairBSDF>(model_) || Fiber(); }
    // The model of a fiber; null for everything else.
    const FiberBxDF *Fiber() const {
        return std::visit(
            [](const auto &model) -> const FiberBxDF * {
                if constexpr (std::is_base_of_v<FiberBxDF, std::decay_t<decltype(model)>>)
                    return &model;
                else
                    return nullptr;
            },
            model_);
    }
    // f times |cos theta_i| and the density of Sample_f, for world directions of unit length.
    Spectrum FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const;
    // Chooses a direction; weight = f |cos| / pdf. False where there is none.
    bool Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                  Spectrum *weight) const;

  private:
    Frame frame_;
    Normal3f n_;
    Spectrum scale_{1};
    std::variant<std::monostate, SurfaceLobes, HairBSDF, KajiyaKayBSDF, MarschnerBSDF, DEonBSDF,
                 TabulatedDEonBSDF, ChosenLobesBSDF, TabulatedBSDF>
        model_;
};

} // namespace cuticle
