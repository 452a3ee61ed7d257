// The names that pbrt-v3's directives take, for the parser, which refuses all others, and for whoever lists them.
// The entry points of parsing itself, ParseScene and ParseSceneText, are declared in scene/scene_description.h.
#pragma once

#include <span>
#include <string_view>

namespace cuticle {

enum class PluginKind {
    Camera,
    Sampler,
    Film,
    Filter,
    Integrator,
    Accelerator,
    Shape,
    Material,
    Texture,
    Light,
    AreaLight,
    Medium
};

// pbrt-v3's plug-ins of one kind, and ours beside them (Shape "hairfile"), whether Cuticle renders them or not.
std::span<const std::string_view> KnownPlugins(PluginKind kind);

// The parameters that a material of this type reads; a shape that gives one of them overrides the material's. Empty
// for a type that has none or is not known.
std::span<const std::string_view> MaterialParameters(std::string_view materialType);

} // namespace cuticle
