// Materials: parameters and textures of a scene file, turned into a BSDF at each point.
#pragma once

#include "materials/bsdf.h"
#include "materials/interaction.h"
#include "materials/texture.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"

#include <memory>
#include <span>

namespace cuticle {

// Choices that the command line makes and a scene file cannot.
struct MaterialOptions {
    // Hair as pbrt-v3 has it, where we hold that to be wrong: see HairMaterial, and Scene::SpawnRay.
    bool compatPbrtV3 = false;
    std::string hairModel; // the model of every hair material, whatever the scene says; "": the scene's
};

class Material {
  public:
    virtual ~Material() = default;
    // True if MakeBSDF reads si.strandNormal.
    virtual bool WantsStrandNormals() const { return false; }
    // Sets the BSDF's model. Its frame is already set; a bump map turns it. The BSDF may use what the
    // material holds and must not outlive it.
    virtual void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const = 0;
    // True if the material has a bump map, which curves do not show.
    virtual bool Bumped() const { return false; }
};

// The shading frame at si, turned by a height over the surface (world units, along the normal): Blinn 1978
// as pbrt-v3's Material::Bump, by forward differences. The surface's own curvature is left out of the
// differences: heights are taken to be small beside its radius. Curves, and places where the height is not
// finite, keep their frame.
Frame BumpedFrame(const SurfaceInteraction &si, const Texture<float> &height);

// The table of materials, in material.cpp.
const PluginTable &MaterialPlugins();

// Makes a material by that table; nullptr for "" and "none", which light passes. A type that pbrt-v3 knows
// and we do not render gives one warning and its stated stand-in; an unknown one throws Error with the
// nearest name. made: the scene's materials before this one, of which "mix" mixes two (Error where one of
// them is "" or where they have too many lobes).
std::unique_ptr<Material> MakeMaterial(const MaterialEntity &entity, const TextureTable &textures,
                                       const MaterialOptions &options,
                                       std::span<const std::unique_ptr<Material>> made = {});

} // namespace cuticle
