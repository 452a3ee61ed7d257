// The names of pbrt-v3's directives, and what a word that is none of them is told.
#pragma once

#include <string>
#include <string_view>

namespace cuticle {

// To add one: here, its name in directives.cpp at the same place, and its case in
// SceneParser::ParseDirective.
enum class Directive {
    Accelerator,
    ActiveTransform,
    AreaLightSource,
    AttributeBegin,
    AttributeEnd,
    Camera,
    ConcatTransform,
    CoordinateSystem,
    CoordSysTransform,
    Film,
    Identity,
    Include,
    Integrator,
    LightSource,
    LookAt,
    MakeNamedMaterial,
    MakeNamedMedium,
    Material,
    MediumInterface,
    NamedMaterial,
    ObjectBegin,
    ObjectEnd,
    ObjectInstance,
    PixelFilter,
    ReverseOrientation,
    Rotate,
    Sampler,
    Scale,
    Shape,
    Texture,
    Transform,
    TransformBegin,
    TransformEnd,
    TransformTimes,
    Translate,
    WorldBegin,
    WorldEnd,
};

// False for a word that is no directive.
bool FindDirective(std::string_view word, Directive *directive);

// Says what is wrong with a word where a directive belongs: it is of pbrt-v4 or pbrt-v2, or misspelled.
// likelyScene: what was read before looks like a scene; else a long word is taken for no scene at all.
std::string UnknownDirectiveMessage(std::string_view word, bool likelyScene);

} // namespace cuticle
