#include "scene/material.h"

#include "scene/hair_models.h"

#include <functional>

namespace cuticle {

namespace {

using FloatTexture = std::shared_ptr<const Texture<float>>;
using SpectrumTexture = std::shared_ptr<const Texture<Spectrum>>;

TexturePoint PointOf(const SurfaceInteraction &si) { return {si.p, si.uv, si.strandColors}; }

// Reflectances and transmittances are clamped to [0, 1] as in pbrt-v3: more would make light from nothing.
Spectrum Evaluate01(const SpectrumTexture &t, const SurfaceInteraction &si) {
    return t->Evaluate(PointOf(si)).Clamp(0, 1);
}

float Alpha(const FloatTexture &roughness, bool remap, const SurfaceInteraction &si) {
    const float r = roughness->Evaluate(PointOf(si));
    return remap ? RoughnessToAlpha(r) : r;
}

class MatteMaterial : public Material {
  public:
    MatteMaterial(const ParamSet &p, const TextureTable &t)
        : kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.5f))), sigma_(t.GetFloatTexture(p, "sigma", 0)) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        bsdf->SetSurface().AddOrenNayar(Evaluate01(kd_, si),
                                        std::clamp(sigma_->Evaluate(PointOf(si)), 0.f, 90.f));
    }

  private:
    SpectrumTexture kd_;
    FloatTexture sigma_;
};

class PlasticMaterial : public Material {
  public:
    PlasticMaterial(const ParamSet &p, const TextureTable &t)
        : kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.25f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.25f))),
          roughness_(t.GetFloatTexture(p, "roughness", 0.1f)), remap_(p.FindBool("remaproughness", true)) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        SurfaceLobes &lobes = bsdf->SetSurface();
        const float alpha = Alpha(roughness_, remap_, si);
        lobes.AddLambertReflection(Evaluate01(kd_, si));
        lobes.AddMicrofacetReflection(Evaluate01(ks_, si), alpha, alpha, 1.5f);
    }

  private:
    SpectrumTexture kd_, ks_;
    FloatTexture roughness_;
    bool remap_;
};

class MirrorMaterial : public Material {
  public:
    MirrorMaterial(const ParamSet &p, const TextureTable &t)
        : kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(0.9f))) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        bsdf->SetSurface().AddSpecularReflection(Evaluate01(kr_, si), 0);
    }

  private:
    SpectrumTexture kr_;
};

// "eta" and the older spelling "index" are one parameter.
FloatTexture IndexOfRefraction(const ParamSet &p, const TextureTable &t) {
    return t.GetFloatTexture(p, !p.Find("eta") && p.Find("index") ? "index" : "eta", 1.5f);
}

class GlassMaterial : public Material {
  public:
    GlassMaterial(const ParamSet &p, const TextureTable &t)
        : kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(1))), kt_(t.GetSpectrumTexture(p, "Kt", Spectrum(1))),
          eta_(IndexOfRefraction(p, t)), uRoughness_(t.GetFloatTexture(p, "uroughness", 0)),
          vRoughness_(t.GetFloatTexture(p, "vroughness", 0)), remap_(p.FindBool("remaproughness", true)) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        SurfaceLobes &lobes = bsdf->SetSurface();
        const float eta = std::max(1e-3f, eta_->Evaluate(PointOf(si)));
        const Spectrum r = Evaluate01(kr_, si), t = Evaluate01(kt_, si);
        if (uRoughness_->Evaluate(PointOf(si)) == 0 && vRoughness_->Evaluate(PointOf(si)) == 0) {
            lobes.AddSpecularReflection(r, eta);
            lobes.AddSpecularTransmission(t, eta);
        } else {
            const float ax = Alpha(uRoughness_, remap_, si), ay = Alpha(vRoughness_, remap_, si);
            lobes.AddMicrofacetReflection(r, ax, ay, eta);
            lobes.AddMicrofacetTransmission(t, ax, ay, eta);
        }
    }

  private:
    SpectrumTexture kr_, kt_;
    FloatTexture eta_, uRoughness_, vRoughness_;
    bool remap_;
};

class UberMaterial : public Material {
  public:
    UberMaterial(const ParamSet &p, const TextureTable &t)
        : kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.25f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.25f))),
          kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(0))), kt_(t.GetSpectrumTexture(p, "Kt", Spectrum(0))),
          opacity_(t.GetSpectrumTexture(p, "opacity", Spectrum(1))), eta_(IndexOfRefraction(p, t)),
          uRoughness_(t.GetFloatTexture(p, p.Find("uroughness") ? "uroughness" : "roughness", 0.1f)),
          vRoughness_(t.GetFloatTexture(p, p.Find("vroughness") ? "vroughness" : "roughness", 0.1f)),
          remap_(p.FindBool("remaproughness", true)) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        SurfaceLobes &lobes = bsdf->SetSurface();
        const float eta = std::max(1e-3f, eta_->Evaluate(PointOf(si)));
        const Spectrum opacity = Evaluate01(opacity_, si);
        // What is not opaque lets light straight through
        lobes.AddSpecularTransmission((-opacity + Spectrum(1)).Clamp(), 1);
        lobes.AddLambertReflection(opacity * Evaluate01(kd_, si));
        lobes.AddMicrofacetReflection(opacity * Evaluate01(ks_, si), Alpha(uRoughness_, remap_, si),
                                      Alpha(vRoughness_, remap_, si), eta);
        lobes.AddSpecularReflection(opacity * Evaluate01(kr_, si), eta);
        lobes.AddSpecularTransmission(opacity * Evaluate01(kt_, si), eta);
    }

  private:
    SpectrumTexture kd_, ks_, kr_, kt_, opacity_;
    FloatTexture eta_, uRoughness_, vRoughness_;
    bool remap_;
};

using Maker = std::unique_ptr<Material> (*)(const ParamSet &, const TextureTable &, const MaterialOptions &);

template <class M>
std::unique_ptr<Material> Make(const ParamSet &p, const TextureTable &t, const MaterialOptions &) {
    return std::make_unique<M>(p, t);
}

struct MaterialName {
    std::string_view name;
    Maker make;
    std::string_view standIn; // of a material that is known and not rendered
};

// All of pbrt-v3's materials. A stand-in takes the colour parameters that it shares with the material.
constexpr MaterialName kMaterials[] = {
    {"hair", MakeHairMaterial, ""},
    {"matte", Make<MatteMaterial>, ""},
    {"plastic", Make<PlasticMaterial>, ""},
    {"mirror", Make<MirrorMaterial>, ""},
    {"glass", Make<GlassMaterial>, ""},
    {"uber", Make<UberMaterial>, ""},
    {"metal", Make<MirrorMaterial>, "mirror"},
    {"substrate", Make<PlasticMaterial>, "plastic"},
    {"translucent", Make<MatteMaterial>, "matte"},
    {"mix", Make<MatteMaterial>, "matte"},
    {"disney", Make<MatteMaterial>, "matte"},
    {"subsurface", Make<MatteMaterial>, "matte"},
    {"kdsubsurface", Make<MatteMaterial>, "matte"},
    {"fourier", Make<MatteMaterial>, "matte"},
};

} // namespace

std::unique_ptr<Material> MakeMaterial(const MaterialEntity &entity, const TextureTable &textures,
                                       const MaterialOptions &options) {
    if (entity.type.empty() || entity.type == "none")
        return nullptr;
    for (const MaterialName &m : kMaterials) {
        if (m.name != entity.type)
            continue;
        if (!m.standIn.empty())
            Warning(entity.params.loc, "material \"" + entity.type + "\" is not rendered",
                    "material \"" + entity.type + "\" is not rendered; \"" + std::string(m.standIn) +
                        "\" is used instead");
        if (entity.params.Find("bumpmap"))
            Warning(entity.params.loc, "bump maps are not rendered",
                    "\"bumpmap\" is not rendered; the surface stays smooth");
        auto material = m.make(entity.params, textures, options);
        if (m.standIn.empty()) {
            (void)entity.params.Find("bumpmap", ParamType::Texture); // spoken of above
            entity.params.ReportUnused("Material \"" + entity.type + "\"");
        }
        return material;
    }
    std::vector<std::string_view> names;
    for (const MaterialName &m : kMaterials)
        names.push_back(m.name);
    throw Error(entity.params.loc, "unknown material \"" + entity.type + "\"." +
                                       Suggestion(entity.type, names.data(), names.size()));
}

} // namespace cuticle
