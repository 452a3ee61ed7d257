// The scattering at one surface point: a hair model, or a few lobes for everything that is not hair.
#pragma once

#include "core/color.h"
#include "fibers/hair.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"

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
    // Each Add ignores a black colour and does nothing when kMaxLobes are taken.
    void AddLambertReflection(const Spectrum &r);
    void AddLambertTransmission(const Spectrum &t);
    // Oren and Nayar's rough diffuse surface; sigma in degrees, 0 is Lambert's.
    void AddOrenNayar(const Spectrum &r, float sigma);
    // Torrance and Sparrow with Trowbridge and Reitz's distribution (GGX), dielectric Fresnel of index eta.
    void AddMicrofacetReflection(const Spectrum &r, float alphaX, float alphaY, float eta);
    void AddMicrofacetTransmission(const Spectrum &t, float alphaX, float alphaY, float eta);
    // A perfect mirror; eta = 0: no Fresnel factor.
    void AddSpecularReflection(const Spectrum &r, float eta);
    // Refraction with the factor 1 - F; eta = 1 passes straight through.
    void AddSpecularTransmission(const Spectrum &t, float eta);

    // Local directions (z the shading normal). reflect: wo and wi on one side of the geometric surface.
    Spectrum f(const Vector3f &wo, const Vector3f &wi, bool reflect, float *pdf) const;
    // Chooses a lobe (in proportion to its colour at normal incidence), then a direction. False: none.
    bool Sample_f(const Vector3f &wo, float uLobe, const Point2f &u, BSDFSample *sample) const;
    bool HasNonSpecular() const;
    bool Empty() const { return count_ == 0; }

  private:
    enum class Kind : uint8_t {
        LambertReflection,
        LambertTransmission,
        OrenNayar,
        MicrofacetReflection,
        MicrofacetTransmission,
        SpecularReflection,
        SpecularTransmission,
    };
    struct Lobe {
        Kind kind = Kind::LambertReflection;
        Spectrum color;
        float a = 0, b = 0; // Oren-Nayar's A, B; or the roughnesses along x, y
        float eta = 1;
        bool Specular() const {
            return kind == Kind::SpecularReflection || kind == Kind::SpecularTransmission;
        }
        bool Reflects() const {
            return kind != Kind::LambertTransmission && kind != Kind::MicrofacetTransmission &&
                   kind != Kind::SpecularTransmission;
        }
    };
    static constexpr int kMaxLobes = 6;
    void Add(const Lobe &lobe);
    static Spectrum Evaluate(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    static float Pdf(const Lobe &lobe, const Vector3f &wo, const Vector3f &wi);
    float Probability(int lobe, const Vector3f &wo) const;

    std::array<Lobe, kMaxLobes> lobes_{};
    int count_ = 0;
};

// Unpolarised Fresnel reflectance of a smooth dielectric; cosThetaI < 0: from inside. eta = inside / outside.
float FrDielectric(float cosThetaI, float eta);
// pbrt-v3's mapping of a perceptual roughness in [0, 1] to GGX alpha.
float RoughnessToAlpha(float roughness);

class BSDF {
  public:
    // x, y, z: shading frame; n: geometric normal on the same side as the shading one.
    void SetFrame(const Frame &shading, const Normal3f &n) { frame_ = shading, n_ = n; }
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

    // True if light sampling can contribute.
    bool HasNonSpecular() const;
    bool IsHair() const { return std::holds_alternative<HairBSDF>(model_) || Fiber(); }
    // f times |cos theta_i| and the density of Sample_f, for world directions of unit length.
    Spectrum FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const;
    // Chooses a direction; weight = f |cos| / pdf. False where there is none.
    bool Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                  Spectrum *weight) const;

  private:
    // The model of a fiber, if it is another than HairBSDF, which is asked first and without indirection: else null.
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
    Frame frame_;
    Normal3f n_;
    std::variant<std::monostate, SurfaceLobes, HairBSDF, KajiyaKayBSDF, MarschnerBSDF> model_;
};

} // namespace cuticle
