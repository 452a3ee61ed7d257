//> Declare the hair material
#pragma once

#include "fibers/models.h"
#include "materials/material.h"

namespace cuticle {

//> Hold the hair's colour
// Absorption over the fiber. Parameters, pbrt-v3's names and defaults: sigma_a (1 / fiber radius), color or
// reflectance (of a dense head, Chiang et al. 2016), eumelanin, pheomelanin (concentrations). Colour is taken
// from the first of sigma_a, color, melanin that the scene gives; more than one is a warning. None: eumelanin
// 1.3, brown.
class HairColor {
  public:
    HairColor(const ParamSet &params, const TextureTable &textures);
    // The absorption coefficient at a point, 1 / fiber radius. betaN: for color, which is fitted to it.
    Spectrum SigmaA(const TexturePoint &point, Float betaN) const;
    bool Varies() const { return varies_; } // given by a texture

  private:
    bool varies_ = false;
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

//> Hold a model's own textures
// Those parameters of the model's row that may vary over the fiber and that the scene gives, with their slots
// in FiberInputs. Colours are shares of the light: beyond [0, 1] they are taken as the nearest, with one
// warning.
class OwnTextures {
  public:
    OwnTextures(const FiberModel &model, const ParamSet &params, const TextureTable &textures);
    void EvaluateAt(const TexturePoint &point, FiberInputs *at) const;

  private:
    std::vector<std::pair<size_t, std::shared_ptr<const Texture<float>>>> numbers_;
    std::vector<std::pair<size_t, std::shared_ptr<const Texture<Spectrum>>>> colors_;
};
//<

//> Declare the material of a fiber
// "hair": at every point, a model of the table (fibers/models.h) with the scene's parameters.
class HairMaterial : public Material {
  public:
    // Reads the parameters of the model's row. Error where the model refuses them.
    HairMaterial(const FiberModel &model, const ParamSet &params, const TextureTable &textures,
                 const MaterialOptions &options);
    bool WantsStrandNormals() const override { return maker_->NeedsAxis(); }
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override;
    // Evaluates what the model starts from at a point.
    FiberInputs InputsAt(const SurfaceInteraction &si) const;
    const FiberMaker &Maker() const { return *maker_; }

  private:
    HairColor color_;
    HairShape shape_;
    OwnTextures own_;
    bool compatPbrtV3_;
    FiberOrigin origin_; // for warnings
    std::unique_ptr<FiberMaker> maker_;
};
//<

} // namespace cuticle
//<
