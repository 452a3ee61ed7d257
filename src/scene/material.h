// Materials: parameters and textures of a scene file, turned into a BSDF at each point.
#pragma once

#include "scene/bsdf.h"
#include "scene/interaction.h"
#include "scene/scene_description.h"
#include "scene/texture.h"

#include <memory>

namespace cuticle {

// Choices that a scene file does not make: the command line does.
struct MaterialOptions {
    bool compatPbrtV3 = false; // hair as pbrt-v3 has it, where we hold that to be wrong: see HairMaterial
    std::string hairModel;     // for every hair material, whatever the scene says; "": the scene's
};

class Material {
  public:
    virtual ~Material() = default;
    // True if MakeBSDF reads si.strandNormal.
    virtual bool WantsStrandNormals() const { return false; }
    // Fills the BSDF's model; its frame is already set.
    virtual void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const = 0;
};

// By the table of names in material.cpp. nullptr for "" and "none". A type that pbrt-v3 knows and we do not render gives
// one warning and its stated stand-in; an unknown one throws Error with the nearest name.
std::unique_ptr<Material> MakeMaterial(const MaterialEntity &entity, const TextureTable &textures,
                                       const MaterialOptions &options);

} // namespace cuticle
