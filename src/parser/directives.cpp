#include "parser/directives.h"

#include "core/error.h"
#include "parser/scene_text.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace cuticle {

namespace {

// In the order of the enumeration.
constexpr std::array<std::string_view, 37> kDirectives{"Accelerator",
                                                       "ActiveTransform",
                                                       "AreaLightSource",
                                                       "AttributeBegin",
                                                       "AttributeEnd",
                                                       "Camera",
                                                       "ConcatTransform",
                                                       "CoordinateSystem",
                                                       "CoordSysTransform",
                                                       "Film",
                                                       "Identity",
                                                       "Include",
                                                       "Integrator",
                                                       "LightSource",
                                                       "LookAt",
                                                       "MakeNamedMaterial",
                                                       "MakeNamedMedium",
                                                       "Material",
                                                       "MediumInterface",
                                                       "NamedMaterial",
                                                       "ObjectBegin",
                                                       "ObjectEnd",
                                                       "ObjectInstance",
                                                       "PixelFilter",
                                                       "ReverseOrientation",
                                                       "Rotate",
                                                       "Sampler",
                                                       "Scale",
                                                       "Shape",
                                                       "Texture",
                                                       "Transform",
                                                       "TransformBegin",
                                                       "TransformEnd",
                                                       "TransformTimes",
                                                       "Translate",
                                                       "WorldBegin",
                                                       "WorldEnd"};
static_assert(kDirectives[static_cast<size_t>(Directive::WorldEnd)] == "WorldEnd");
static_assert(kDirectives[static_cast<size_t>(Directive::Shape)] == "Shape");

constexpr std::array<std::string_view, 4> kV4Directives{"Option", "Attribute", "ColorSpace", "Import"};
constexpr std::array<std::string_view, 5> kV2Directives{"SurfaceIntegrator", "VolumeIntegrator", "Renderer",
                                                        "Volume", "SearchPath"};

} // namespace

bool FindDirective(std::string_view word, Directive *directive) {
    static const std::unordered_map<std::string_view, Directive> map = [] {
        std::unordered_map<std::string_view, Directive> m;
        for (size_t i = 0; i < kDirectives.size(); ++i)
            m[kDirectives[i]] = static_cast<Directive>(i);
        return m;
    }();
    const auto it = map.find(word);
    if (it == map.end())
        return false;
    *directive = it->second;
    return true;
}

std::string UnknownDirectiveMessage(std::string_view word, bool likelyScene) {
    const auto isIn = [&](const auto &names) {
        return std::find(names.begin(), names.end(), word) != names.end();
    };
    const std::string name = Quoted(word);
    if (isIn(kV4Directives))
        return name +
               " is a directive of pbrt-v4: this looks like a pbrt-v4 scene, and Cuticle reads pbrt-v3";
    if (isIn(kV2Directives))
        return fmt::format(
            "{} is a directive of pbrt-v2: this looks like a pbrt-v2 scene, and Cuticle reads pbrt-v3{}",
            name, word == "SurfaceIntegrator" ? " (there it is Integrator)" : "");
    if (likelyScene || word.size() < 32)
        return fmt::format("directive {} is not known. {}", name,
                           Suggestion(word, kDirectives.data(), kDirectives.size()));
    return name + " is no directive: this does not look like a scene file";
}

} // namespace cuticle
