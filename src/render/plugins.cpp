#include "render/plugins.h"

#include "materials/material.h"
#include "materials/texture.h"
#include "scene/plugins.h"

namespace cuticle {

// To add a sampler: a row here, and its making in render/sampler.cpp.
const PluginTable &SamplerPlugins() {
    static const PluginTable table{PluginKind::Sampler,
                                   {{.name = "halton"},
                                    {.name = "sobol"},
                                    {.name = "random"},
                                    {.name = "stratified"},
                                    {.name = "02sequence"},
                                    {.name = "lowdiscrepancy"},
                                    {.name = "maxmindist"}},
                                   {"independent", "zsobol", "paddedsobol", "pmj02bn"},
                                   {"adaptive", "bestcandidate"},
                                   "each but random is one Owen-scrambled Sobol' sampler"};
    return table;
}

const PluginTable &FilmPlugins() {
    static const PluginTable table{PluginKind::Film, {{.name = "image"}}, {"rgb", "gbuffer", "spectral"}};
    return table;
}

// To add a filter: a row here, and its shape in render/filter.cpp.
const PluginTable &FilterPlugins() {
    static const PluginTable table{PluginKind::Filter,
                                   {{.name = "box"},
                                    {.name = "gaussian"},
                                    {.name = "mitchell"},
                                    {.name = "sinc"},
                                    {.name = "triangle"}}};
    return table;
}

// To add an integrator: a row here, and its making in render/integrator.cpp.
const PluginTable &IntegratorPlugins() {
    static const PluginTable table{PluginKind::Integrator,
                                   {{.name = "path"},
                                    {.name = "directlighting"},
                                    {.name = "whitted"},
                                    {.name = "volpath", .standIn = "path"},
                                    {.name = "bdpt", .standIn = "path"},
                                    {.name = "mlt", .standIn = "path"},
                                    {.name = "sppm", .standIn = "path"},
                                    {.name = "ambientocclusion", .standIn = "path"},
                                    {.name = "ao", .standIn = "path"}},
                                   {"simplepath", "simplevolpath", "lightpath", "randomwalk", "function"},
                                   {"photonmap", "exphotonmap", "igi", "irradiancecache", "diffuseprt",
                                    "glossyprt", "useprobes", "dipolesubsurface"}};
    return table;
}

const PluginTable &AcceleratorPlugins() {
    static const PluginTable table{PluginKind::Accelerator,
                                   {{.name = "bvh"}, {.name = "kdtree"}},
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
