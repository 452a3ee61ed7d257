// Material "hair": makes the model of a fiber that a scene names, "string model" "NAME", from the table of
// models (fibers/models.h).
//
// Every model starts from the same parameters: the hair's colour, eta, beta_m, beta_n, alpha (HairColor,
// HairShape). Its own parameters, where a scene gives them, come first; where it does not they are derived
// from the common ones by the rules stated in the model's row. So any scene renders with any model.
#pragma once

#include "core/param_info.h"
#include "materials/hair_material.h"

#include <string_view>
#include <vector>

namespace cuticle {

// "chiang", the default, and the others.
std::vector<std::string_view> HairModelNames();
// All parameters of Material "hair": "model" and what is common, then those of each model; a name that
// several models have is there once, as the first of them has it.
std::vector<ParamInfo> HairMaterialParams();

// Makes the model that "string model" names, or options.hairModel where it is set. Error at the parameter for
// an unknown name; a warning for each number out of its range.
std::unique_ptr<Material> MakeHairMaterial(const ParamSet &params, const TextureTable &textures,
                                           const MaterialOptions &options);

} // namespace cuticle
