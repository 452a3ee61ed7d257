// What the parser knows of materials' parameters.
// The entry points of parsing itself, ParseScene and ParseSceneText, are declared in scene/scene_description.h.
#pragma once

#include <span>
#include <string_view>

namespace cuticle {

// The parameters that a material of this type reads; a shape that gives one of them overrides the material's. Empty
// for a type that has none or is not known.
std::span<const std::string_view> MaterialParameters(std::string_view materialType);

} // namespace cuticle
