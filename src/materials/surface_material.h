// SurfaceMaterial: what the materials that are made of lobes share.
#pragma once

#include "materials/material.h"

#include <algorithm>
#include <memory>
#include <string_view>

namespace cuticle {

using FloatTexture = std::shared_ptr<const Texture<float>>;
using SpectrumTexture = std::shared_ptr<const Texture<Spectrum>>;

// A reflectance or transmittance, clamped to [0, 1] as in pbrt-v3: more would make light from nothing.
inline Spectrum Evaluate01(const SpectrumTexture &t, const SurfaceInteraction &si) {
    return t->Evaluate(TexturePointOf(si)).Clamp(0, 1);
}

// The alpha of Trowbridge and Reitz. remap: the texture holds a perceptual roughness ("remaproughness").
inline float EvaluateAlpha(const FloatTexture &roughness, bool remap, const SurfaceInteraction &si) {
    const float r = roughness->Evaluate(TexturePointOf(si));
    return remap ? RoughnessToAlpha(r) : r;
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
    // The largest number of lobes that AddLobes adds; 8 is the limit of pbrt-v3, which each of its materials
    // keeps.
    virtual size_t MaxLobes() const { return 8; }
    bool Bumped() const final { return bump_ != nullptr; }

  protected:
    explicit SurfaceMaterial(FloatTexture bump) : bump_(std::move(bump)) {}
    static const FloatTexture &BumpOf(const SurfaceMaterial &m) { return m.bump_; }

  private:
    FloatTexture bump_;
};

} // namespace cuticle
