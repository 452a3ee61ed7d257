//> Turn names into integrators
#include "render/integrator.h"

#include "render/hair_light.h"
#include "render/path.h"
#include "render/plugins.h"

#include <algorithm>

namespace cuticle {

//> Read which lights "directlighting" samples
static constexpr std::string_view kStrategies[] = {"all", "one"};
static PathIntegrator::LightStrategy ReadStrategy(const ParamSet &params) {
    const std::string name = params.FindString("strategy", "all");
    if (name == "all")
        return PathIntegrator::LightStrategy::All;
    if (name == "one")
        return PathIntegrator::LightStrategy::One;
    Warning(params.Find("strategy")->loc, "unknown strategy",
            fmt::format("unknown strategy \"{}\"; it is \"all\", as in pbrt-v3. {}", name,
                        Suggestion(name, kStrategies, std::size(kStrategies))));
    return PathIntegrator::LightStrategy::All;
}
//<

//> Read the path integrator's settings from the scene
static PathIntegrator::Settings PathSettings(const ParamSet &params, bool directOnly) {
    PathIntegrator::Settings s;
    s.maxDepth = params.FindInt("maxdepth", 5);
    if (s.maxDepth < 0)
        throw Error(params.loc, "\"maxdepth\" must be 0 or more, not {}", s.maxDepth);
    s.directOnly = directOnly;
    s.separateLightRay = params.FindBool("separatelightray", false); // ours
    if (directOnly)
        s.lights = ReadStrategy(params);
    else
        s.rrThreshold = params.FindFloat("rrthreshold", 1);
    (void)params.FindString("lightsamplestrategy", "power"); // a matter of noise, not of the picture
    return s;
}
//<

//> Make path integrators of each kind
using IntegratorMaker = std::unique_ptr<Integrator> (*)(const ParamSet &params);

static std::unique_ptr<Integrator> MakePath(const ParamSet &params) {
    return std::make_unique<PathIntegrator>(PathSettings(params, false));
}
// pbrt-v3's "whitted" adds up direct light and follows mirrors and glass: the picture of "directlighting".
static std::unique_ptr<Integrator> MakeDirect(const ParamSet &params) {
    return std::make_unique<PathIntegrator>(PathSettings(params, true));
}
//<

//> Read how hair is lit
static constexpr std::string_view kHairShadows[] = {"opaque", "traced", "deepmap"};

static std::unique_ptr<Integrator> MakeHairLight(const ParamSet &params) {
    HairLightIntegrator::Settings s;
    const std::string shadow = params.FindString("shadow", "opaque");
    const auto found = std::find(std::begin(kHairShadows), std::end(kHairShadows), shadow);
    if (found == std::end(kHairShadows))
        throw Error(params.Find("shadow")->loc, "unknown shadow \"{}\"", shadow)
            .WithRemedy(Suggestion(shadow, kHairShadows, std::size(kHairShadows)));
    s.shadow = static_cast<HairLightIntegrator::Shadow>(found - kHairShadows);
    const auto number = [&](const char *name, float byDefault, float low, float high) {
        const float v = params.FindFloat(name, byDefault);
        if (!(v >= low && v <= high))
            throw Error(params.Find(name)->loc, "\"{}\" is {}", name, v)
                .WithRemedy("it must be {} to {}", low, high);
        return v;
    };
    const auto whole = [&](const char *name, int byDefault, int low, int high) {
        const int v = params.FindInt(name, byDefault);
        if (v < low || v > high)
            throw Error(params.Find(name)->loc, "\"{}\" is {}", name, v)
                .WithRemedy("it must be {} to {}", low, high);
        return v;
    };
    s.map.opacity = number("opacity", 0.5f, 0, 1);
    s.map.error = number("maperror", 0.01f, 0, 1);
    s.map.side = static_cast<size_t>(whole("mapresolution", 256, 1, 8192));
    s.map.samples = static_cast<size_t>(whole("mapsamples", 2, 1, 16));
    s.shellNormals = params.FindBool("shellnormals", false);
    s.shellCell = number("shellcell", 0, 0, kMaxCoordinate);
    s.wrap = number("wrap", 0, 0, 1);
    s.maxDepth = whole("maxdepth", 5, 0, std::numeric_limits<int>::max());
    return std::make_unique<HairLightIntegrator>(s);
}
//<

//> List the parameters of the integrators
static constexpr ParamInfo kMaxDepth{
    "maxdepth", "integer", "", "5", "scattering events after the camera ray; 0: only lights seen directly",
    0};
static constexpr ParamInfo kLightSampling{"lightsamplestrategy", "string", "", "power",
                                          "read; without effect"};
static constexpr ParamInfo kSeparateRay{"separatelightray", "bool", "", "false",
                                        "ours: look for lights by a ray of its own, as pbrt-v3 does"};
static constexpr ParamInfo kPathParams[] = {
    kMaxDepth,
    {"rrthreshold", "float", "", "1", "paths whose throughput falls below it may end by roulette"},
    kLightSampling,
    kSeparateRay};
static constexpr ParamInfo kDirectParams[] = {kMaxDepth,
                                              {.name = "strategy",
                                               .type = "string",
                                               .unit = "",
                                               .defaultValue = "all",
                                               .meaning = "which lights are sampled at each hit",
                                               .choices = kStrategies},
                                              kLightSampling,
                                              kSeparateRay};
//<

//> List the parameters of light on hair
static constexpr ParamInfo kHairLightParams[] = {
    kMaxDepth,
    {.name = "shadow",
     .type = "string",
     .unit = "",
     .defaultValue = "opaque",
     .meaning = "how hair stands in the light: opaque; or let through at each crossing, counted along rays "
                "(traced) or by a deep shadow map of each light without area (deepmap; others are traced)",
     .choices = kHairShadows},
    {"opacity", "float", "", "0.5", "share of the light that a crossing of a hair takes away", 0, 1},
    {"mapresolution", "integer", "pixels", "256", "side of a deep shadow map", 1, 8192},
    {"mapsamples", "integer", "", "2", "rays of a map's pixel, to a side", 1, 16},
    {"maperror", "float", "", "0.01", "error of a map's functions by their compression", 0, 1},
    {"shellnormals", "bool", "", "false",
     "holds light on hair against the normal of the shell of all hair (Petrovic, Henne and Anderson 2005)"},
    {"shellcell", "float", "lengths of the scene", "0",
     "cells in which the shell is made; 0: 1/96 of the hair's longest side", 0},
    {"wrap", "float", "", "0", "how far light reaches around the shell: 1 is all around", 0, 1}};
//<

//> List the integrators
// To add an integrator: a row here, its class, and its Make function above. The meaning of one that is not
// rendered says how its picture would differ from the picture that is rendered instead.
static constexpr std::string_view kSameButCaustics =
    "both estimate the same light, but for caustics of point and distant lights, which paths from the camera "
    "cannot "
    "find";
static constexpr std::string_view kOpenness =
    "its picture shows how open each place is, whatever the lights; ours shows the lights";
static const PluginRow<IntegratorMaker> kIntegrators[] = {
    {{"path", kPathParams, "paths from the camera, with light sampling"}, MakePath},
    {{"directlighting", kDirectParams, "light that is scattered once, and mirrors and glass"}, MakeDirect},
    {{"whitted", kDirectParams, "the same"}, MakeDirect},
    {{.name = "hairlight",
      .params = kHairLightParams,
      .meaning = "ours: direct light that passes hair, and the normals of the hair's shell",
      .ours = true},
     MakeHairLight},
    {{"volpath", kPathParams,
      "the picture is the same where there are no participating media, which are not rendered", "path"},
     MakePath},
    {{"bdpt", kPathParams, kSameButCaustics, "path"}, MakePath},
    {{"mlt", kPathParams, kSameButCaustics, "path"}, MakePath},
    {{"sppm", kPathParams, kSameButCaustics, "path"}, MakePath},
    {{"ambientocclusion", kPathParams, kOpenness, "path"}, MakePath},
    {{"ao", kPathParams, kOpenness, "path"}, MakePath},
};
const PluginTable &IntegratorPlugins() {
    static const PluginTable table{PluginKind::Integrator,
                                   PluginInfos(kIntegrators),
                                   {"simplepath", "simplevolpath", "lightpath", "randomwalk", "function"},
                                   {"photonmap", "exphotonmap", "igi", "irradiancecache", "diffuseprt",
                                    "glossyprt", "useprobes", "dipolesubsurface"}};
    return table;
}
//<

std::unique_ptr<Integrator> MakeIntegrator(const Entity &entity, const std::string &type) {
    const bool override = type != entity.type;
    ParamSet params = entity.params;
    if (override) // the scene's parameters belong to another integrator: only the depth carries over
        std::erase_if(params.params, [](const Param &p) { return p.name != "maxdepth"; });
    //> Make the integrator, or say what stands in for it
    const PluginRow<IntegratorMaker> *row = FindPluginRow(kIntegrators, type);
    if (!row) {
        const std::vector<std::string_view> names = IntegratorPlugins().Names();
        throw Error(params.loc, "unknown integrator \"{}\"", type)
            .WithRemedy(Suggestion(type, names.data(), names.size()));
    }
    std::unique_ptr<Integrator> integrator = row->make(params);
    if (row->info.standIn.empty())
        params.ReportUnused(fmt::format("Integrator \"{}\"", type));
    else
        Warning(params.loc, fmt::format("integrator \"{}\" is not rendered", type),
                fmt::format("integrator \"{}\" is not rendered; \"{}\" is used instead: {}", type,
                            row->info.standIn, row->info.meaning));
    return integrator;
    //<
}

} // namespace cuticle
//<
