// The models of a fiber that a scene may choose: Material "hair" "string model" "NAME".
//
// Every model starts from the same parameters: the hair's colour, eta, beta_m, beta_n, alpha (HairColor, HairShape). Its
// own parameters, where a scene gives them, come first; where it does not they are derived from the common ones by
// the rules stated at each model in hair_models.cpp. So any scene renders with any model.
#pragma once

#include "materials/hair_material.h"

#include <span>

namespace cuticle {

// "chiang", the default, and the others.
std::span<const std::string_view> HairModelNames();

// By "string model", or options.hairModel where it is set. Error at the parameter for an unknown name.
std::unique_ptr<Material> MakeHairMaterial(const ParamSet &params, const TextureTable &textures,
                                           const MaterialOptions &options);

} // namespace cuticle
