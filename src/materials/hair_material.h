//> Declare the hair material
#pragma once

#include "materials/material.h"

namespace cuticle {

//> Hold the hair's colour
// Absorption over the fiber. Parameters, pbrt-v3's names and defaults: sigma_a (1 / fiber radius), color or reflectance
// (of a dense head, Chiang et al. 2016), eumelanin, pheomelanin (concentrations). Colour is taken from the first of
// sigma_a, color, melanin that the scene gives; more than one is a warning. None: eumelanin 1.3, brown.
class HairColor {
  public:
    HairColor(const ParamSet &params, const TextureTable &textures);
    // The absorption coefficient at a point, 1 / fiber radius. betaN: for color, which is fitted to it.
    Spectrum SigmaA(const TexturePoint &point, Float betaN) const;

  private:
    std::shared_ptr<const Texture<Spectrum>> sigmaA_, color_;
    std::shared_ptr<const Texture<float>> eumelanin_, pheomelanin_;
};
//<

//> Hold the shape of its lobes
// Textures over the fiber: eta 1.55, beta_m 0.3, beta_n 0.3, alpha 2 degrees (pbrt-v3's names and defaults).
struct HairShape {
    HairShape(const ParamSet &params, const TextureTable &textures);
    std::shared_ptr<const Texture<float>> eta, betaM, betaN, alpha;
};
//<

//> Declare the material of the default model
// "hair": a HairBSDF at every point.
class HairMaterial : public Material {
  public:
    HairMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &options);
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override;

  private:
    HairColor color_;
    HairShape shape_;
    MaterialOptions options_;
};
//<

} // namespace cuticle
//<
