#include "core/error.h"
#include "materials/material_makers.h"
#include "materials/microfacet.h"
#include "materials/surface_material.h"

namespace cuticle {

namespace {

// Burley's model of 2012, with the transmission of 2015. Where pbrt-v3 departs from it we do not follow: the
// specular lobe is not multiplied by the colour once more (its issue 224), the clear coat is sampled by its
// own gloss (its pull request 172), and metals transmit nothing, neither sharply nor, when thin, diffusely
// (its issue 313). Not rendered: subsurface scattering. Its stand-in is the diffuse lobe, which is what it
// becomes when the scattering distance goes to 0.
class DisneyMaterial : public SurfaceMaterial {
  public:
    DisneyMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), color_(t.GetSpectrumTexture(p, "color", Spectrum(0.5f))),
          metallic_(t.GetFloatTexture(p, "metallic", 0)), eta_(t.GetFloatTexture(p, "eta", 1.5f)),
          roughness_(t.GetFloatTexture(p, "roughness", 0.5f)),
          specularTint_(t.GetFloatTexture(p, "speculartint", 0)),
          anisotropic_(t.GetFloatTexture(p, "anisotropic", 0)), sheen_(t.GetFloatTexture(p, "sheen", 0)),
          sheenTint_(t.GetFloatTexture(p, "sheentint", 0.5f)),
          clearcoat_(t.GetFloatTexture(p, "clearcoat", 0)),
          clearcoatGloss_(t.GetFloatTexture(p, "clearcoatgloss", 1)),
          specTrans_(t.GetFloatTexture(p, "spectrans", 0)), flatness_(t.GetFloatTexture(p, "flatness", 0)),
          diffTrans_(t.GetFloatTexture(p, "difftrans", 1)), thin_(p.FindBool("thin", false)) {
        const Param *distance = p.Find("scatterdistance");
        (void)t.GetSpectrumTexture(p, "scatterdistance", Spectrum(0));
        const bool zero = !distance || std::all_of(distance->numbers.begin(), distance->numbers.end(),
                                                   [](double v) { return v == 0; });
        if (!thin_ && distance && (distance->type == ParamType::Texture || !zero))
            Warning(distance->loc, "subsurface scattering is not rendered",
                    "\"scatterdistance\" is not rendered; light leaves \"disney\" where it enters");
    }

    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const Spectrum c = Evaluate01(color_, si);
        const float metallic = Weight(metallic_, si), strans = Weight(specTrans_, si),
                    rough = Weight(roughness_, si), eta = std::max(1e-3f, eta_->Evaluate(TexturePointOf(si)));
        const float luminance = c.y();
        const Spectrum tint = luminance > 0 ? c / luminance : Spectrum(1);
        const auto tinted = [&](float amount) { return Spectrum(1 - amount) + tint * amount; };

        // Diffuse, retro-reflection, sheen
        const float diffuse = (1 - metallic) * (1 - strans), through = thin_ ? Weight(diffTrans_, si) / 2 : 0;
        const float flat = thin_ ? Weight(flatness_, si) : 0;
        lobes->AddDisneyDiffuse(c * (diffuse * (1 - flat) * (1 - through)));
        lobes->AddDisneyFlat(c * (diffuse * flat * (1 - through)), rough);
        lobes->AddDisneyRetro(c * diffuse, rough);
        lobes->AddDisneySheen(tinted(Weight(sheenTint_, si)) *
                              (diffuse * std::max(0.f, sheen_->Evaluate(TexturePointOf(si)))));
        lobes->AddLambertTransmission(c * (diffuse * through));

        // Specular reflection and the clear coat over it
        const float aspect = std::sqrt(1 - 0.9f * Weight(anisotropic_, si));
        const float ax = Sqr(rough) / aspect, ay = Sqr(rough) * aspect;
        const Spectrum r0 =
            tinted(Weight(specularTint_, si)) * (Sqr((eta - 1) / (eta + 1)) * (1 - metallic)) + c * metallic;
        lobes->AddDisneySpecular(r0, metallic, eta, ax, ay);
        lobes->AddDisneyClearcoat(std::max(0.f, clearcoat_->Evaluate(TexturePointOf(si))),
                                  Weight(clearcoatGloss_, si));

        // Transmission: the root of the colour, since light mostly goes in and out again. A thin sheet's
        // roughness follows the index (Burley 2015, figure 15).
        const Spectrum t = Sqrt(c) * ((1 - metallic) * strans);
        const float s = thin_ ? Sqr(std::max(0.f, 0.65f * eta - 0.35f)) : 1;
        lobes->AddMicrofacetTransmission(t, s * ax, s * ay, eta, !thin_);
    }

  private:
    static float Weight(const FloatTexture &texture, const SurfaceInteraction &si) {
        return std::clamp(texture->Evaluate(TexturePointOf(si)), 0.f, 1.f);
    }
    SpectrumTexture color_;
    FloatTexture metallic_, eta_, roughness_, specularTint_, anisotropic_, sheen_, sheenTint_, clearcoat_,
        clearcoatGloss_, specTrans_, flatness_, diffTrans_;
    bool thin_;
};

} // namespace

std::unique_ptr<Material> MakeDisney(const MaterialContext &in) {
    return std::make_unique<DisneyMaterial>(in.params, in.textures);
}

} // namespace cuticle
