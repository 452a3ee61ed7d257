#include "core/error.h"
#include "core/fresnel.h"
#include "materials/material_makers.h"
#include "materials/microfacet.h"
#include "materials/subsurface.h"
#include "materials/surface_material.h"

namespace cuticle {

namespace {

// The stand-in of materials that light enters and leaves elsewhere: a diffuse body of the reflectance that a
// deep piece of the material has, under the boundary that the scene describes.
class BodyMaterial : public SurfaceMaterial {
  public:
    BodyMaterial(const ParamSet &p, const TextureTable &t, float standardEta)
        : SurfaceMaterial(p, t), eta_(std::max(1e-3f, p.FindFloat("eta", standardEta))),
          kr_(t.GetSpectrumTexture(p, "Kr", Spectrum(1))), kt_(t.GetSpectrumTexture(p, "Kt", Spectrum(1))),
          uRoughness_(t.GetFloatTexture(p, "uroughness", 0)),
          vRoughness_(t.GetFloatTexture(p, "vroughness", 0)), remap_(p.FindBool("remaproughness", true)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const Spectrum kr = Evaluate01(kr_, si);
        lobes->AddCoatedDiffuse(Body(si) * Evaluate01(kt_, si), kr * FrDielectric(1, eta_));
        if (uRoughness_->Evaluate(TexturePointOf(si)) == 0 && vRoughness_->Evaluate(TexturePointOf(si)) == 0)
            lobes->AddSpecularReflection(kr, eta_);
        else
            lobes->AddMicrofacetReflection(kr, EvaluateAlpha(uRoughness_, remap_, si),
                                           EvaluateAlpha(vRoughness_, remap_, si), eta_);
    }
    size_t MaxLobes() const override { return 2; }

  protected:
    virtual Spectrum Body(const SurfaceInteraction &si) const = 0;
    float eta_;

  private:
    SpectrumTexture kr_, kt_;
    FloatTexture uRoughness_, vRoughness_;
    bool remap_;
};

class SubsurfaceMaterial : public BodyMaterial {
  public:
    SubsurfaceMaterial(const ParamSet &p, const TextureTable &t) : BodyMaterial(p, t, 1.33f) {
        const std::string name = p.FindString("name", "");
        const auto medium = FindScatteringMedium(name.empty() ? "Wholemilk" : name);
        if (!medium)
            Warning(p.loc, "unknown scattering medium",
                    "no medium \"" + name + "\" is known; the coefficients of whole milk are used instead");
        const ScatteringMedium m = medium ? *medium : *FindScatteringMedium("Wholemilk");
        sigmaA_ = t.GetSpectrumTexture(p, "sigma_a", m.sigmaA);
        sigmaS_ = t.GetSpectrumTexture(p, "sigma_s", m.reducedSigmaS);
        // The named media have reduced coefficients already. How large the body is beside them, "scale",
        // does not count for a half space.
        const float g = p.FindFloat("g", 0);
        reduction_ = !name.empty() && medium ? 1 : std::clamp(1 - g, 0.f, 2.f);
        (void)p.FindFloat("scale", 1);
    }

  private:
    Spectrum Body(const SurfaceInteraction &si) const override {
        const Spectrum a = sigmaA_->Evaluate(TexturePointOf(si)).Clamp(),
                       s = sigmaS_->Evaluate(TexturePointOf(si)).Clamp() * reduction_;
        Spectrum r;
        for (int i = 0; i < 3; ++i)
            r[i] = s[i] > 0 ? DipoleReflectance(s[i] / (s[i] + a[i]), eta_) : 0;
        return r;
    }
    SpectrumTexture sigmaA_, sigmaS_;
    float reduction_ = 1;
};

class KdSubsurfaceMaterial : public BodyMaterial {
  public:
    KdSubsurfaceMaterial(const ParamSet &p, const TextureTable &t)
        : BodyMaterial(p, t, 1.33f), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.5f))) {
        // How far light wanders, and how: without effect on the stand-in
        (void)t.GetSpectrumTexture(p, "mfp", Spectrum(1));
        (void)p.FindFloat("g", 0);
        (void)p.FindFloat("scale", 1);
    }

  private:
    Spectrum Body(const SurfaceInteraction &si) const override { return Evaluate01(kd_, si); }
    SpectrumTexture kd_;
};

} // namespace

std::unique_ptr<Material> MakeSubsurface(const MaterialContext &in) {
    return std::make_unique<SubsurfaceMaterial>(in.params, in.textures);
}
std::unique_ptr<Material> MakeKdSubsurface(const MaterialContext &in) {
    return std::make_unique<KdSubsurfaceMaterial>(in.params, in.textures);
}

} // namespace cuticle
