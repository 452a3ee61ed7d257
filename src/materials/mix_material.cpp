#include "core/check.h"
#include "core/error.h"
#include "core/sampling.h"
#include "materials/material_makers.h"
#include "materials/microfacet.h"
#include "materials/surface_material.h"

#include <array>
#include <bit>

namespace cuticle {

namespace {

// Two materials of lobes: all lobes of both, as in pbrt-v3, which also takes the first one's bump map for
// both.
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
    size_t MaxLobes() const override { return first_->MaxLobes() + second_->MaxLobes(); }

  private:
    SpectrumTexture amount_;
    const SurfaceMaterial *first_, *second_;
};

// A mix of which hair is a part. Hair is no lobe among others: at each place one of the two is chosen, with
// the probability of its amount, by a hash of the place and the direction, so that the mean over many rays
// is the mix.
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

} // namespace

std::unique_ptr<Material> MakeMix(const MaterialContext &in) {
    SpectrumTexture amount = in.textures.GetSpectrumTexture(in.params, "amount", Spectrum(0.5f));
    std::array<const Material *, 2> parts{};
    std::array<const SurfaceMaterial *, 2> surfaces{};
    static constexpr std::array<std::string_view, 2> names = {"namedmaterial1", "namedmaterial2"};
    for (size_t i = 0; i < 2; ++i) {
        const std::string name = in.params.FindString(names[i], "");
        if (const int index = in.entity.mixed[i]; index >= 0) {
            CHECK_LT(static_cast<size_t>(index), in.made.size())
                << "a mix names a material that is made after it";
            parts[i] = in.made[static_cast<size_t>(index)].get();
        }
        if (!parts[i])
            throw Error(
                in.params.loc,
                "material \"mix\" mixes two materials that scatter light; \"{}\" is no material, and light "
                "passes it",
                name);
        surfaces[i] = dynamic_cast<const SurfaceMaterial *>(parts[i]);
    }
    if (!surfaces[0] || !surfaces[1])
        return std::make_unique<ChosenMixMaterial>(std::move(amount), parts[0], parts[1], in.made.size());
    if (surfaces[1]->Bumped())
        Warning(in.params.loc, "bump map of a mix's second material",
                "a \"mix\" has the bump map of its first material; that of the second is not rendered");
    auto mix = std::make_unique<MixMaterial>(std::move(amount), surfaces[0], surfaces[1]);
    if (mix->MaxLobes() > SurfaceLobes::kMaxLobes)
        throw Error(in.params.loc,
                    "this \"mix\" has {} lobes with all that is mixed in it; there may be at most {}",
                    mix->MaxLobes(), SurfaceLobes::kMaxLobes);
    return mix;
}

} // namespace cuticle
