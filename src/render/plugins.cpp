#include "render/plugins.h"

#include "materials/material.h"
#include "materials/texture.h"
#include "scene/plugins.h"

namespace cuticle {

namespace {

constexpr std::string_view kOurOwn = "read; our own accelerators are used";
constexpr std::string_view kNoEffect = "read; without effect";
constexpr ParamInfo kBvhParams[] = {{"maxnodeprims", "integer", "", "4", kNoEffect},
                                    {"splitmethod", "string", "", "sah", kNoEffect}};
constexpr ParamInfo kKdTreeParams[] = {{"intersectcost", "integer", "", "80", kNoEffect},
                                       {"traversalcost", "integer", "", "1", kNoEffect},
                                       {"emptybonus", "float", "", "0.5", kNoEffect},
                                       {"maxprims", "integer", "", "1", kNoEffect},
                                       {"maxdepth", "integer", "", "-1", kNoEffect}};

} // namespace

// To add an accelerator that a scene may choose: a row here, and its choice where the scene is built.
const PluginTable &AcceleratorPlugins() {
    static const PluginTable table{PluginKind::Accelerator,
                                   {{"bvh", kBvhParams, kOurOwn}, {"kdtree", kKdTreeParams, kOurOwn}},
                                   {},
                                   {"grid", "none"},
                                   "read; both mean our own"};
    return table;
}

const PluginTables &AllPlugins() {
    static const PluginTables tables{&CameraPlugins(), &SamplerPlugins(),    &FilmPlugins(),
                                     &FilterPlugins(), &IntegratorPlugins(), &AcceleratorPlugins(),
                                     &ShapePlugins(),  &MaterialPlugins(),   &TexturePlugins(),
                                     &LightPlugins(),  &AreaLightPlugins(),  &MediumPlugins()};
    return tables;
}

} // namespace cuticle
