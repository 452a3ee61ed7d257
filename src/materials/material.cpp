#include "materials/material.h"

#include "core/metal_spectra.h"
#include "core/sampling.h"
#include "materials/hair_models.h"
#include "materials/subsurface.h"

#include <bit>

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

// The roughness along u or v: "uroughness" or "vroughness" where given, else "roughness".
FloatTexture RoughnessAlong(const ParamSet &p, const TextureTable &t, std::string_view name, float standard) {
    return t.GetFloatTexture(p, p.Find(name) ? name : "roughness", standard);
}

// A material made of lobes, with a bump map or without.
class SurfaceMaterial : public Material {
  public:
    SurfaceMaterial(const ParamSet &p, const TextureTable &t)
        : bump_(p.Find("bumpmap") ? t.GetFloatTexture(p, "bumpmap", 0) : nullptr) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const final {
        if (bump_)
            bsdf->SetFrame(BumpedFrame(si, *bump_), si.n);
        AddLobes(si, &bsdf->SetSurface());
    }
    virtual void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const = 0;
    virtual int MaxLobes() const { return 8; } // pbrt-v3's limit, which each of its materials keeps
    bool Bumped() const final { return bump_ != nullptr; }

  protected:
    explicit SurfaceMaterial(FloatTexture bump) : bump_(std::move(bump)) {}
    static const FloatTexture &BumpOf(const SurfaceMaterial &m) { return m.bump_; }

  private:
    FloatTexture bump_;
};

class MatteMaterial : public SurfaceMaterial {
  public:
    MatteMaterial(const ParamSet &p, const TextureTable &t)
        : SurfaceMaterial(p, t), kd_(t.GetSpectrumTexture(p, "Kd", Spectrum(0.5f))),
          sigma_(t.GetFloatTexture(p, "sigma", 0)) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        lobes->AddOrenNayar(Evaluate01(kd_, si), std::clamp(sigma_->Evaluate(PointOf(si)), 0.f, 90.f));
    }
    int MaxLobes() const override { return 1; }

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
        const float alpha = Alpha(roughness_, remap_, si);
        lobes->AddLambertReflection(Evaluate01(kd_, si));
        lobes->AddMicrofacetReflection(Evaluate01(ks_, si), alpha, alpha, 1.5f);
    }
    int MaxLobes() const override { return 2; }

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
        const float alpha = Alpha(roughness_, remap_, si);
        lobes->AddLambertReflection(r * kd);
        lobes->AddLambertTransmission(t * kd);
        lobes->AddMicrofacetReflection(r * ks, alpha, alpha, 1.5f);
        lobes->AddMicrofacetTransmission(t * ks, alpha, alpha, 1.5f);
    }
    int MaxLobes() const override { return 4; }

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
    int MaxLobes() const override { return 1; }

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
        lobes->AddConductorReflection(Spectrum(1), Alpha(uRoughness_, remap_, si),
                                      Alpha(vRoughness_, remap_, si), eta_->Evaluate(PointOf(si)).Clamp(),
                                      k_->Evaluate(PointOf(si)).Clamp());
    }
    int MaxLobes() const override { return 1; }

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
        lobes->AddCoat(ks, Alpha(uRoughness_, remap_, si), Alpha(vRoughness_, remap_, si));
    }
    int MaxLobes() const override { return 2; }

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
        const float eta = std::max(1e-3f, eta_->Evaluate(PointOf(si)));
        const Spectrum r = Evaluate01(kr_, si), t = Evaluate01(kt_, si);
        if (uRoughness_->Evaluate(PointOf(si)) == 0 && vRoughness_->Evaluate(PointOf(si)) == 0) {
            lobes->AddSpecularReflection(r, eta);
            lobes->AddSpecularTransmission(t, eta);
        } else {
            const float ax = Alpha(uRoughness_, remap_, si), ay = Alpha(vRoughness_, remap_, si);
            lobes->AddMicrofacetReflection(r, ax, ay, eta);
            lobes->AddMicrofacetTransmission(t, ax, ay, eta);
        }
    }
    int MaxLobes() const override { return 2; }

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
        const float eta = std::max(1e-3f, eta_->Evaluate(PointOf(si)));
        const Spectrum opacity = Evaluate01(opacity_, si);
        // What is not opaque lets light straight through
        lobes->AddSpecularTransmission((-opacity + Spectrum(1)).Clamp(), 1);
        lobes->AddLambertReflection(opacity * Evaluate01(kd_, si));
        lobes->AddMicrofacetReflection(opacity * Evaluate01(ks_, si), Alpha(uRoughness_, remap_, si),
                                       Alpha(vRoughness_, remap_, si), eta);
        lobes->AddSpecularReflection(opacity * Evaluate01(kr_, si), eta);
        lobes->AddSpecularTransmission(opacity * Evaluate01(kt_, si), eta);
    }
    int MaxLobes() const override { return 5; }

  private:
    SpectrumTexture kd_, ks_, kr_, kt_, opacity_;
    FloatTexture eta_, uRoughness_, vRoughness_;
    bool remap_;
};

// Burley's model of 2012, with the transmission of 2015. Where pbrt-v3 departs from it we do not follow: the specular
// lobe is not multiplied by the colour once more (its issue 224), the clear coat is sampled by its own gloss (its pull
// request 172), and metals transmit nothing, neither sharply nor, when thin, diffusely (its issue 313).
// Not rendered: subsurface scattering. Its stand-in is the diffuse lobe, which is what it becomes when the
// scattering distance goes to 0.
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
                    rough = Weight(roughness_, si), eta = std::max(1e-3f, eta_->Evaluate(PointOf(si)));
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
                              (diffuse * std::max(0.f, sheen_->Evaluate(PointOf(si)))));
        lobes->AddLambertTransmission(c * (diffuse * through));

        // Specular reflection and the clear coat over it
        const float aspect = std::sqrt(1 - 0.9f * Weight(anisotropic_, si));
        const float ax = Sqr(rough) / aspect, ay = Sqr(rough) * aspect;
        const Spectrum r0 =
            tinted(Weight(specularTint_, si)) * (Sqr((eta - 1) / (eta + 1)) * (1 - metallic)) + c * metallic;
        lobes->AddDisneySpecular(r0, metallic, eta, ax, ay);
        lobes->AddDisneyClearcoat(std::max(0.f, clearcoat_->Evaluate(PointOf(si))),
                                  Weight(clearcoatGloss_, si));

        // Transmission: the root of the colour, since light mostly goes in and out again. A thin sheet's roughness
        // follows the index (Burley 2015, figure 15).
        const Spectrum t = Sqrt(c) * ((1 - metallic) * strans);
        const float s = thin_ ? Sqr(std::max(0.f, 0.65f * eta - 0.35f)) : 1;
        lobes->AddMicrofacetTransmission(t, s * ax, s * ay, eta, !thin_);
    }

  private:
    static float Weight(const FloatTexture &texture, const SurfaceInteraction &si) {
        return std::clamp(texture->Evaluate(PointOf(si)), 0.f, 1.f);
    }
    SpectrumTexture color_;
    FloatTexture metallic_, eta_, roughness_, specularTint_, anisotropic_, sheen_, sheenTint_, clearcoat_,
        clearcoatGloss_, specTrans_, flatness_, diffTrans_;
    bool thin_;
};

// The stand-in of materials that light enters and leaves elsewhere: a diffuse body of the reflectance that a deep piece
// of the material has, under the boundary that the scene describes.
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
        if (uRoughness_->Evaluate(PointOf(si)) == 0 && vRoughness_->Evaluate(PointOf(si)) == 0)
            lobes->AddSpecularReflection(kr, eta_);
        else
            lobes->AddMicrofacetReflection(kr, Alpha(uRoughness_, remap_, si), Alpha(vRoughness_, remap_, si),
                                           eta_);
    }
    int MaxLobes() const override { return 2; }

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
        // The named media have reduced coefficients already. How large the body is beside them, "scale", does not
        // count for a half space.
        const float g = p.FindFloat("g", 0);
        reduction_ = !name.empty() && medium ? 1 : std::clamp(1 - g, 0.f, 2.f);
        (void)p.FindFloat("scale", 1);
    }

  private:
    Spectrum Body(const SurfaceInteraction &si) const override {
        const Spectrum a = sigmaA_->Evaluate(PointOf(si)).Clamp(),
                       s = sigmaS_->Evaluate(PointOf(si)).Clamp() * reduction_;
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

// Two materials of lobes: all lobes of both, as in pbrt-v3, which also takes the first one's bump map for both.
class MixMaterial : public SurfaceMaterial {
  public:
    MixMaterial(SpectrumTexture amount, const SurfaceMaterial *first, const SurfaceMaterial *second)
        : SurfaceMaterial(BumpOf(*first)), amount_(std::move(amount)), first_(first), second_(second) {}
    void AddLobes(const SurfaceInteraction &si, SurfaceLobes *lobes) const override {
        const Spectrum outer = lobes->Scale(), amount = Evaluate01(amount_, si);
        lobes->SetScale(outer * amount);
        first_->AddLobes(si, lobes);
        lobes->SetScale(outer * (-amount + Spectrum(1)));
        second_->AddLobes(si, lobes);
        lobes->SetScale(outer);
    }
    int MaxLobes() const override { return first_->MaxLobes() + second_->MaxLobes(); }

  private:
    SpectrumTexture amount_;
    const SurfaceMaterial *first_, *second_;
};

// A mix of which hair is a part. Hair is no lobe among others: at each place one of the two is chosen, with the
// probability of its amount, by a hash of the place and the direction, so that the mean over many rays is the mix.
class ChosenMixMaterial : public Material {
  public:
    ChosenMixMaterial(SpectrumTexture amount, const Material *first, const Material *second, uint64_t salt)
        : amount_(std::move(amount)), first_(first), second_(second), salt_(salt) {}
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        const Spectrum amount = Evaluate01(amount_, si);
        const float p = std::clamp((amount[0] + amount[1] + amount[2]) / 3, 0.f, 1.f);
        const bool first = Random(si) < p;
        bsdf->SetScale(bsdf->Scale() * (first ? amount / p : (-amount + Spectrum(1)) / (1 - p)));
        (first ? first_ : second_)->MakeBSDF(si, bsdf);
    }
    bool Bumped() const override { return first_->Bumped() || second_->Bumped(); }
    bool WantsStrandNormals() const override {
        return first_->WantsStrandNormals() || second_->WantsStrandNormals();
    }

  private:
    float Random(const SurfaceInteraction &si) const { // in [0, 1)
        uint64_t hash = MixBits(salt_);
        for (const Vector3f &v : {si.p, si.wo})
            for (int i = 0; i < 3; ++i)
                hash = MixBits(hash ^ std::bit_cast<uint32_t>(v[i]));
        return static_cast<float>(hash >> 40) * 0x1p-24f;
    }
    SpectrumTexture amount_;
    const Material *first_, *second_;
    uint64_t salt_;
};

struct MaterialContext {
    const MaterialEntity &entity;
    const ParamSet &params;
    const TextureTable &textures;
    const MaterialOptions &options;
    std::span<const std::unique_ptr<Material>> made;
};

std::unique_ptr<Material> MakeMix(const MaterialContext &in) {
    SpectrumTexture amount = in.textures.GetSpectrumTexture(in.params, "amount", Spectrum(0.5f));
    std::array<const Material *, 2> parts{};
    std::array<const SurfaceMaterial *, 2> surfaces{};
    static constexpr std::array<std::string_view, 2> names = {"namedmaterial1", "namedmaterial2"};
    for (size_t i = 0; i < 2; ++i) {
        const std::string name = in.params.FindString(names[i], "");
        const int index = in.entity.mixed[i];
        if (index >= 0 && static_cast<size_t>(index) < in.made.size())
            parts[i] = in.made[static_cast<size_t>(index)].get();
        if (!parts[i])
            throw Error(in.params.loc, "material \"mix\" mixes two materials that scatter light; \"" + name +
                                           "\" is no material, and light passes it");
        surfaces[i] = dynamic_cast<const SurfaceMaterial *>(parts[i]);
    }
    if (!surfaces[0] || !surfaces[1])
        return std::make_unique<ChosenMixMaterial>(std::move(amount), parts[0], parts[1], in.made.size());
    if (surfaces[1]->Bumped())
        Warning(in.params.loc, "bump map of a mix's second material",
                "a \"mix\" has the bump map of its first material; that of the second is not rendered");
    auto mix = std::make_unique<MixMaterial>(std::move(amount), surfaces[0], surfaces[1]);
    if (mix->MaxLobes() > SurfaceLobes::kMaxLobes)
        throw Error(in.params.loc, "this \"mix\" has " + std::to_string(mix->MaxLobes()) +
                                       " lobes with all that is mixed in it; there may be at most " +
                                       std::to_string(SurfaceLobes::kMaxLobes));
    return mix;
}

std::unique_ptr<Material> MakeHair(const MaterialContext &in) {
    if (in.params.Find("bumpmap", ParamType::Texture))
        Warning(in.params.loc, "bump maps on hair are not rendered",
                "\"bumpmap\" is not rendered on hair; the fiber stays smooth");
    return MakeHairMaterial(in.params, in.textures, in.options);
}

// Known by a table of measurements that is not read.
std::unique_ptr<Material> MakeFourier(const MaterialContext &in) {
    (void)in.params.FindString("bsdffile", "");
    return std::make_unique<MatteMaterial>(in.params, in.textures);
}

using Maker = std::unique_ptr<Material> (*)(const MaterialContext &);

template <class M>
std::unique_ptr<Material> Make(const MaterialContext &in) {
    return std::make_unique<M>(in.params, in.textures);
}

// To add a material: its class above, a row here. The rows stand in the order of the manual; one without a maker is
// pbrt's null material, which light passes.
const PluginRow<Maker> kMaterials[] = {
    {{.name = "hair"}, MakeHair},
    {{.name = "matte"}, Make<MatteMaterial>},
    {{.name = "plastic"}, Make<PlasticMaterial>},
    {{.name = "mirror"}, Make<MirrorMaterial>},
    {{.name = "glass"}, Make<GlassMaterial>},
    {{.name = "uber"}, Make<UberMaterial>},
    {{.name = "metal"}, Make<MetalMaterial>},
    {{.name = "substrate"}, Make<SubstrateMaterial>},
    {{.name = "translucent"}, Make<TranslucentMaterial>},
    {{.name = "disney"}, Make<DisneyMaterial>},
    {{.name = "mix"}, MakeMix},
    {{.name = ""}, nullptr},
    {{.name = "none"}, nullptr},
    {{.name = "subsurface", .standIn = "a coated diffuse surface of the reflectance that the medium implies"},
     Make<SubsurfaceMaterial>},
    {{.name = "kdsubsurface", .standIn = "a coated diffuse surface of the colour \"Kd\""},
     Make<KdSubsurfaceMaterial>},
    {{.name = "fourier", .standIn = "a matte surface of reflectance 0.5"}, MakeFourier},
};

} // namespace

Frame BumpedFrame(const SurfaceInteraction &si, const Texture<float> &height) {
    if (si.isCurve)
        return si.shading;
    // The tangents of the smooth surface that the shading normal describes
    const Vector3f &n = si.shading.z;
    const Vector3f u = si.dpdu - n * Dot(n, si.dpdu), v = si.dpdv - n * Dot(n, si.dpdv);
    // A step of about half a pixel as the ray sees it, far above the rounding of p, and never longer than pbrt-v3's
    // where it knows no pixel
    const float largest = std::max({std::abs(si.p.x), std::abs(si.p.y), std::abs(si.p.z)});
    const float step = std::max(5e-4f * si.t, 2e-4f * largest);
    const float du = std::min(step / u.Length(), 0.01f), dv = std::min(step / v.Length(), 0.01f);
    const float here = height.Evaluate(PointOf(si));
    const float slopeU = (height.Evaluate({si.p + u * du, {si.uv.x + du, si.uv.y}}) - here) / du;
    const float slopeV = (height.Evaluate({si.p + v * dv, {si.uv.x, si.uv.y + dv}}) - here) / dv;

    const Vector3f bumpedU = u + n * slopeU, bumpedV = v + n * slopeV;
    const Vector3f across = Cross(bumpedU, bumpedV);
    const float length = across.Length();
    if (!(length > 0) || !std::isfinite(length))
        return si.shading;
    Frame frame;
    frame.z = across * ((Dot(across, si.n) < 0 ? -1 : 1) / length);
    frame.x = Normalize(bumpedU);
    frame.y = Cross(frame.z, frame.x);
    return frame;
}

const PluginTable &MaterialPlugins() {
    static const PluginTable table{PluginKind::Material,
                                   PluginInfos(kMaterials),
                                   {"coateddiffuse", "coatedconductor", "conductor", "dielectric", "diffuse",
                                    "diffusetransmission", "interface", "thindielectric", "measured"},
                                   {"shinymetal"},
                                   "bump maps on all surfaces but hair"};
    return table;
}

std::unique_ptr<Material> MakeMaterial(const MaterialEntity &entity, const TextureTable &textures,
                                       const MaterialOptions &options,
                                       std::span<const std::unique_ptr<Material>> made) {
    const PluginRow<Maker> *row = FindPluginRow(kMaterials, entity.type);
    if (!row) {
        const std::vector<std::string_view> names = MaterialPlugins().Names();
        throw Error(entity.params.loc, "unknown material \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
    }
    if (!row->make)
        return nullptr;
    if (!row->info.standIn.empty())
        Warning(entity.params.loc, fmt::format("material \"{}\" is not rendered", entity.type),
                fmt::format("material \"{}\" is not rendered; {} is used instead", entity.type,
                            row->info.standIn));
    auto material = row->make({entity, entity.params, textures, options, made});
    entity.params.ReportUnused(fmt::format("Material \"{}\"", entity.type));
    return material;
}

} // namespace cuticle
