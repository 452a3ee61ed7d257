#include "core/metal_spectra.h"
#include "materials/material_makers.h"
#include "materials/microfacet.h"
#include "materials/surface_material.h"

namespace cuticle {

namespace {

// Reads the roughness along u or v: "uroughness" or "vroughness" where given, else "roughness".
FloatTexture RoughnessAlong(const ParamSet &p, const TextureTable &t, std::string_view name, float standard) {
    return t.GetFloatTexture(p, p.Find(name) ? name : "roughness", standard);
}

class MatteMaterial : public SurfaceMaterial {
  public:
    MatteMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.5f))),
          sigma_(t.GetFloatTexture(p, "sigma", 0)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        lobes->AddOrenNayar(Evaluate01(kd_, si), std::clamp(sigma_->Evaluate(TexturePointOf(si)), 0.f, 90.f));
    }
    size_t MaxLobes() const override { return 1; }

  private:
    SpectrumTexture kd_;
    FloatTexture sigma_;
};

class PlasticMaterial : public SurfaceMaterial {
  public:
    PlasticMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.25f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.25f))),
          roughness_(t.GetFloatTexture(p, "roughness", 0.1f)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const float alpha = EvaluateAlpha(roughness_, remap_, si);
        lobes->AddLambertReflection(Evaluate01(kd_, si));
        lobes->AddMicrofacetReflection(Evaluate01(ks_, si), alpha, alpha, 1.5f);
    }
    size_t MaxLobes() const override { return 2; }

  private:
    SpectrumTexture kd_, ks_;
    FloatTexture roughness_;
    bool remap_;
};

class TranslucentMaterial : public SurfaceMaterial {
  public:
    TranslucentMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.25f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.25f))),
          reflect_(t.GetSpectrumTexture(p, "reflect", Spectrum(0.5f))),
          transmit_(t.GetSpectrumTexture(p, "transmit", Spectrum(0.5f))),
          roughness_(t.GetFloatTexture(p, "roughness", 0.1f)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const Spectrum r = Evaluate01(reflect_, si), t = Evaluate01(transmit_, si);
        const Spectrum kd = Evaluate01(kd_, si), ks = Evaluate01(ks_, si);
        const float alpha = EvaluateAlpha(roughness_, remap_, si);
        lobes->AddLambertReflection(r * kd);
        lobes->AddLambertTransmission(t * kd);
        lobes->AddMicrofacetReflection(r * ks, alpha, alpha, 1.5f);
        lobes->AddMicrofacetTransmission(t * ks, alpha, alpha, 1.5f);
    }
    size_t MaxLobes() const override { return 4; }

  private:
    SpectrumTexture kd_, ks_, reflect_, transmit_;
    FloatTexture roughness_;
    bool remap_;
};

class MirrorMaterial : public SurfaceMaterial {
  public:
    MirrorMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(0.9f))) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        lobes->AddSpecularReflection(Evaluate01(kr_, si), 0);
    }
    size_t MaxLobes() const override { return 1; }

  private:
    SpectrumTexture kr_;
};

class MetalMaterial : public SurfaceMaterial {
  public:
    MetalMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), eta_(t.GetSpectrumTexture(p, "eta", MetalRGB("Cu", OpticalConstant::Eta))),
          k_(t.GetSpectrumTexture(p, "k", MetalRGB("Cu", OpticalConstant::K))),
          uRoughness_(RoughnessAlong(p, t, "uroughness", 0.01f)),
          vRoughness_(RoughnessAlong(p, t, "vroughness", 0.01f)), remap_(p.FindBool("remaproughness", true)) {
    }
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        lobes->AddConductorReflection(
            Spectrum(1), EvaluateAlpha(uRoughness_, remap_, si), EvaluateAlpha(vRoughness_, remap_, si),
            eta_->Evaluate(TexturePointOf(si)).Clamp(), k_->Evaluate(TexturePointOf(si)).Clamp());
    }
    size_t MaxLobes() const override { return 1; }

  private:
    SpectrumTexture eta_, k_;
    FloatTexture uRoughness_, vRoughness_;
    bool remap_;
};

class SubstrateMaterial : public SurfaceMaterial {
  public:
    SubstrateMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.5f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.5f))),
          uRoughness_(t.GetFloatTexture(p, "uroughness", 0.1f)),
          vRoughness_(t.GetFloatTexture(p, "vroughness", 0.1f)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const Spectrum ks = Evaluate01(ks_, si);
        lobes->AddCoatedDiffuse(Evaluate01(kd_, si), ks);
        lobes->AddCoat(ks, EvaluateAlpha(uRoughness_, remap_, si), EvaluateAlpha(vRoughness_, remap_, si));
    }
    size_t MaxLobes() const override { return 2; }

  private:
    SpectrumTexture kd_, ks_;
    FloatTexture uRoughness_, vRoughness_;
    bool remap_;
};

// "eta" and the older spelling "index" are one parameter.
FloatTexture IndexOfRefraction(const ParamSet &p, const TextureTable &t) {
    return t.GetFloatTexture(p, !p.Find("eta") && p.Find("index") ? "index" : "eta", 1.5f);
}

class GlassMaterial : public SurfaceMaterial {
  public:
    GlassMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(1))),
          kt_(t.GetSpectrumTexture(p, "Kt", Spectrum(1))), eta_(IndexOfRefraction(p, t)),
          uRoughness_(t.GetFloatTexture(p, "uroughness", 0)),
          vRoughness_(t.GetFloatTexture(p, "vroughness", 0)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const float eta = std::max(1e-3f, eta_->Evaluate(TexturePointOf(si)));
        const Spectrum r = Evaluate01(kr_, si), t = Evaluate01(kt_, si);
        if (uRoughness_->Evaluate(TexturePointOf(si)) == 0 &&
            vRoughness_->Evaluate(TexturePointOf(si)) == 0) {
            lobes->AddSpecularReflection(r, eta);
            lobes->AddSpecularTransmission(t, eta);
        } else {
            const float ax = EvaluateAlpha(uRoughness_, remap_, si),
                        ay = EvaluateAlpha(vRoughness_, remap_, si);
            lobes->AddMicrofacetReflection(r, ax, ay, eta);
            lobes->AddMicrofacetTransmission(t, ax, ay, eta);
        }
    }
    size_t MaxLobes() const override { return 2; }

  private:
    SpectrumTexture kr_, kt_;
    FloatTexture eta_, uRoughness_, vRoughness_;
    bool remap_;
};

class UberMaterial : public SurfaceMaterial {
  public:
    UberMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.25f))),
          ks_(t.GetSpectrumTexture(p, "Ks", Spectrum(0.25f))),
          kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(0))), kt_(t.GetSpectrumTexture(p, "Kt", Spectrum(0))),
          opacity_(t.GetSpectrumTexture(p, "opacity", Spectrum(1))), eta_(IndexOfRefraction(p, t)),
          uRoughness_(RoughnessAlong(p, t, "uroughness", 0.1f)),
          vRoughness_(RoughnessAlong(p, t, "vroughness", 0.1f)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const float eta = std::max(1e-3f, eta_->Evaluate(TexturePointOf(si)));
        const Spectrum opacity = Evaluate01(opacity_, si);
        // What is not opaque lets light straight through
        lobes->AddSpecularTransmission((-opacity + Spectrum(1)).Clamp(), 1);
        lobes->AddLambertReflection(opacity * Evaluate01(kd_, si));
        lobes->AddMicrofacetReflection(opacity * Evaluate01(ks_, si), EvaluateAlpha(uRoughness_, remap_, si),
                                       EvaluateAlpha(vRoughness_, remap_, si), eta);
        lobes->AddSpecularReflection(opacity * Evaluate01(kr_, si), eta);
        lobes->AddSpecularTransmission(opacity * Evaluate01(kt_, si), eta);
    }
    size_t MaxLobes() const override { return 5; }

  private:
    SpectrumTexture kd_, ks_, kr_, kt_, opacity_;
    FloatTexture eta_, uRoughness_, vRoughness_;
    bool remap_;
};

} // namespace

std::unique_ptr<Material> MakeMatte(const MaterialContext &in) {
    return std::make_unique<MatteMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakePlastic(const MaterialContext &in) {
    return std::make_unique<PlasticMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeTranslucent(const MaterialContext &in) {
    return std::make_unique<TranslucentMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeMirror(const MaterialContext &in) {
    return std::make_unique<MirrorMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeMetal(const MaterialContext &in) {
    return std::make_unique<MetalMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeSubstrate(const MaterialContext &in) {
    return std::make_unique<SubstrateMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeGlass(const MaterialContext &in) {
    return std::make_unique<GlassMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeUber(const MaterialContext &in) {
    return std::make_unique<UberMaterial>(in.params, in.textures);
}

} // namespace cuticle
