// The makers of materials, for the table in material.cpp.
#pragma once

#include "materials/material.h"

#include <memory>
#include <span>

namespace cuticle {

// Everything that a maker may read.
struct MaterialContext {
    const MaterialEntity &entity;
    const ParamSet &params; // of entity
    const TextureTable &textures;
    const MaterialOptions &options;
    std::span<const std::unique_ptr<Material>> made; // the scene's materials before this one
};

// In surface_materials.cpp:
std::unique_ptr<Material> MakeMatte(const MaterialContext &in);
std::unique_ptr<Material> MakePlastic(const MaterialContext &in);
std::unique_ptr<Material> MakeTranslucent(const MaterialContext &in);
std::unique_ptr<Material> MakeMirror(const MaterialContext &in);
std::unique_ptr<Material> MakeMetal(const MaterialContext &in);
std::unique_ptr<Material> MakeSubstrate(const MaterialContext &in);
std::unique_ptr<Material> MakeGlass(const MaterialContext &in);
std::unique_ptr<Material> MakeUber(const MaterialContext &in);
// In disney_material.cpp:
std::unique_ptr<Material> MakeDisney(const MaterialContext &in);
// In subsurface_materials.cpp; stand-ins, see there:
std::unique_ptr<Material> MakeSubsurface(const MaterialContext &in);
std::unique_ptr<Material> MakeKdSubsurface(const MaterialContext &in);
// In mix_material.cpp. Error where one of the two lets light pass, or where they have too many lobes:
std::unique_ptr<Material> MakeMix(const MaterialContext &in);

} // namespace cuticle
