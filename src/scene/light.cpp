#include "scene/light.h"

#include "core/error.h"
#include "core/sampling.h"
#include "scene/light_makers.h"
#include "scene/plugins.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

Spectrum ScaledLightValue(const ParamSet &params, std::string_view name, std::string_view light) {
    Spectrum value = params.FindSpectrum(name, Spectrum(1.f)) * params.FindSpectrum("scale", Spectrum(1.f));
    for (int i = 0; i < 3; ++i)
        if (!(value[i] >= 0 && value[i] <= kMaxLightValue)) {
            const float used = value[i] > kMaxLightValue && value[i] < Infinity ? kMaxLightValue : 0;
            Warning(params.loc, "light value out of range",
                    fmt::format("{} light: {} times scale has the value {:f}, which is set to {}", light,
                                name, value[i], used > 0 ? "1e18" : "0"));
            value[i] = used;
        }
    return value;
}

float WorldRadius(const Bounds3f &b) {
    const float r = b.IsEmpty() ? 0 : b.Diagonal().Length() / 2;
    return r > 0 && r < Infinity ? r : 1;
}

void RequireInvertible(const LightEntity &entity) {
    if (entity.ctm.IsSingular())
        throw Error(entity.params.loc, "{} light: its transformation has no inverse", entity.type);
}

namespace {

// --- the tables of lights -----------------------------------------------------------------------------

constexpr ParamInfo kScale{"scale", "spectrum", "", "1", "factor on the light", 0};
constexpr ParamInfo kIntensity{"I", "spectrum", "W/sr", "1", "intensity", 0, kMaxLightValue};
constexpr ParamInfo kRadiance{"L", "spectrum", "W/(m^2 sr)", "1", "radiance", 0, kMaxLightValue};
constexpr ParamInfo kFrom{"from", "point3", "lengths of the scene", "0 0 0", "place of the light"};
constexpr ParamInfo kTo{"to", "point3", "lengths of the scene", "0 0 1", "the point that the light looks at"};
constexpr ParamInfo kSamples{"samples", "integer", "", "1",
                             "samples a hit, for Integrator \"directlighting\""};
constexpr ParamInfo kNSamples{"nsamples", "integer", "", "1", "an older name of samples"};
constexpr ParamInfo kInfiniteParams[] = {
    kRadiance,
    kScale,
    {"mapname", "string", "", "",
     "picture of the sphere: theta from +z down its rows, phi from +x along them"},
    kSamples,
    kNSamples,
};
constexpr ParamInfo kDistantParams[] = {
    {"L", "spectrum", "W/m^2", "1", "irradiance on a plane across the light", 0, kMaxLightValue},
    kScale,
    {"from", "point3", "lengths of the scene", "0 0 0", "the light shines from here ..."},
    {"to", "point3", "lengths of the scene", "0 0 1", "... towards here"},
};
constexpr ParamInfo kPointParams[] = {kIntensity, kScale, kFrom};
constexpr ParamInfo kSpotParams[] = {
    kIntensity,
    kScale,
    kFrom,
    kTo,
    {"coneangle", "float", "degrees", "30", "half the angle of the cone", 0, 180},
    {"conedeltaangle", "float", "degrees", "5", "where the light begins to fall off, inside the cone's edge",
     0},
};
constexpr ParamInfo kGoniometricParams[] = {
    kIntensity,
    kScale,
    {"mapname", "string", "", "",
     "picture of the intensity: theta from +y down its rows, phi from +x along them"},
};
constexpr ParamInfo kProjectionParams[] = {
    kIntensity,
    kScale,
    {"fov", "float", "degrees", "45", "angle over the picture's shorter side", 0, 180},
    {"mapname", "string", "", "", "the picture"},
};
constexpr ParamInfo kDiffuseAreaParams[] = {
    kRadiance,
    kScale,
    {"twosided", "bool", "", "false", "whether both sides emit, and not only that of the normal"},
    kSamples,
    kNSamples,
};

using LightMaker = std::unique_ptr<Light> (*)(const LightEntity &, const Bounds3f &worldBound);

// To add a light: its class and maker in a file beside this one, declared in light_makers.h, and a row here.
constexpr PluginRow<LightMaker> kLights[] = {
    {{.name = "infinite",
      .params = kInfiniteParams,
      .meaning = "light from all around, constant or a picture",
      .directional = true},
     MakeInfinite},
    {{.name = "exinfinite",
      .params = kInfiniteParams,
      .meaning = "an older name of infinite",
      .directional = true},
     MakeInfinite},
    {{.name = "distant",
      .params = kDistantParams,
      .meaning = "light from one direction",
      .directional = true},
     MakeDistant},
    {{"point", kPointParams, "a point that shines in all directions alike"}, MakePoint},
    {{"spot", kSpotParams, "a point that shines in a cone"}, MakeSpot},
    {{"goniometric", kGoniometricParams, "a point whose intensity is a picture of the sphere"},
     MakeGoniometric},
    {{"projection", kProjectionParams, "a slide projector"}, MakeProjection},
};
// To add an area light: a row here, and its making in MakeAreaLight (area_light.cpp).
constexpr PluginInfo kAreaLights[] = {
    {"diffuse", kDiffuseAreaParams, "a surface that emits the same radiance everywhere"},
    {"area", kDiffuseAreaParams, "an older name of diffuse"},
};

} // namespace

const PluginTable &LightPlugins() {
    static const PluginTable table{
        PluginKind::Light,
        PluginInfos(kLights),
        {},
        {"infinitesample"},
        "maps are sampled by importance; how often which kind is asked is learned from a pilot, near ones of "
        "many are found by a tree"};
    return table;
}

const PluginTable &AreaLightPlugins() {
    static const PluginTable table{PluginKind::AreaLight,
                                   {std::begin(kAreaLights), std::end(kAreaLights)},
                                   {},
                                   {},
                                   "on surfaces; on curves and inside objects it is one warning"};
    return table;
}

std::unique_ptr<Light> MakeLight(const LightEntity &entity, const Bounds3f &worldBound) {
    const PlaceScope here(entity.params.loc);
    if (const PluginRow<LightMaker> *row = FindPluginRow(kLights, entity.type))
        return row->make(entity, worldBound);
    const std::vector<std::string_view> names = LightPlugins().Names();
    throw Error(entity.params.loc, "unknown light \"{}\"", entity.type)
        .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
}

} // namespace cuticle
