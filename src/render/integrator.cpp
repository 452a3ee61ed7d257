//> Turn names into integrators
#include "render/integrator.h"

#include "render/dual_scattering.h"
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

//> Read parameters that have bounds
// Errors at the parameter, and say what would be right.
struct IntegratorParams {
    const ParamSet &params;

    // The place of the string in the choices; the first where it is not given.
    size_t Choice(const char *name, std::span<const std::string_view> choices) const {
        const std::string given = params.FindString(name, std::string(choices[0]));
        const auto found = std::find(choices.begin(), choices.end(), given);
        if (found == choices.end())
            throw Error(params.Find(name)->loc, "unknown {} \"{}\"", name, given)
                .WithRemedy(Suggestion(given, choices.data(), choices.size()));
        return static_cast<size_t>(found - choices.begin());
    }
    float Number(const char *name, float byDefault, float low, float high) const {
        return Within(name, params.FindFloat(name, byDefault), low, high);
    }
    int Whole(const char *name, int byDefault, int low, int high) const {
        return Within(name, params.FindInt(name, byDefault), low, high);
    }

  private:
    template <class T>
    T Within(const char *name, T v, T low, T high) const {
        if (!(v >= low && v <= high))
            throw Error(params.Find(name)->loc, "\"{}\" is {}", name, v)
                .WithRemedy("it must be {} to {}", low, high);
        return v;
    }
};
//<

//> Read the path integrator's settings from the scene
static constexpr std::string_view kHairFields[] = {"auto", "near"};

static PathIntegrator::Settings PathSettings(const ParamSet &params, bool directOnly) {
    PathIntegrator::Settings s;
    s.maxDepth = params.FindInt("maxdepth", 5);
    if (s.maxDepth < 0)
        throw Error(params.loc, "\"maxdepth\" must be 0 or more, not {}", s.maxDepth);
    s.directOnly = directOnly;
    s.separateLightRay = params.FindBool("separatelightray", false); // ours
    s.field = static_cast<HairField>(IntegratorParams{params}.Choice("hairfield", kHairFields));
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
    const IntegratorParams read{params};
    HairLightIntegrator::Settings s;
    s.shadow = static_cast<HairLightIntegrator::Shadow>(read.Choice("shadow", kHairShadows));
    s.map.opacity = read.Number("opacity", 0.5f, 0, 1);
    s.map.error = read.Number("maperror", 0.01f, 0, 1);
    s.map.side = static_cast<size_t>(read.Whole("mapresolution", 256, 1, 8192));
    s.map.samples = static_cast<size_t>(read.Whole("mapsamples", 2, 1, 16));
    s.shellNormals = params.FindBool("shellnormals", false);
    s.shellCell = read.Number("shellcell", 0, 0, kMaxCoordinate);
    s.wrap = read.Number("wrap", 0, 0, 1);
    s.maxDepth = read.Whole("maxdepth", 5, 0, std::numeric_limits<int>::max());
    return std::make_unique<HairLightIntegrator>(s);
}
//<

//> Read how light is scattered twice
static constexpr std::string_view kHairCounts[] = {"traced", "grid"};
static constexpr std::string_view kReturns[] = {"half", "printed"};

static std::unique_ptr<Integrator> MakeDualScattering(const ParamSet &params) {
    const IntegratorParams read{params};
    DualScatteringIntegrator::Settings s;
    s.count = static_cast<DualScatteringIntegrator::Count>(read.Choice("count", kHairCounts));
    s.returned = static_cast<DualScatteringIntegrator::Return>(read.Choice("return", kReturns));
    s.forwardDensity = read.Number("forwarddensity", s.forwardDensity, 0, 1);
    s.backwardDensity = read.Number("backwarddensity", s.backwardDensity, 0, 1);
    s.cell = read.Number("gridcell", 0, 0, kMaxCoordinate);
    s.maxDepth = read.Whole("maxdepth", 5, 0, std::numeric_limits<int>::max());
    return std::make_unique<DualScatteringIntegrator>(s);
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
static constexpr ParamInfo kHairField{
    .name = "hairfield",
    .type = "string",
    .unit = "",
    .defaultValue = "auto",
    .meaning = "ours: a fiber that is narrower than a pixel, or met after the camera's hit, scatters light "
               "as the mean over its width (auto); or as at the place where it is met (near, as in pbrt-v3)",
    .choices = kHairFields};
static constexpr ParamInfo kPathParams[] = {
    kMaxDepth,
    {"rrthreshold", "float", "", "1", "paths whose throughput falls below it may end by roulette"},
    kLightSampling,
    kSeparateRay,
    kHairField};
static constexpr ParamInfo kDirectParams[] = {kMaxDepth,
                                              {.name = "strategy",
                                               .type = "string",
                                               .unit = "",
                                               .defaultValue = "all",
                                               .meaning = "which lights are sampled at each hit",
                                               .choices = kStrategies},
                                              kLightSampling,
                                              kSeparateRay,
                                              kHairField};
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

//> List the parameters of dual scattering
static constexpr ParamInfo kDualScatteringParams[] = {
    kMaxDepth,
    {.name = "count",
     .type = "string",
     .unit = "",
     .defaultValue = "traced",
     .meaning = "how the hairs before a place are counted: along a ray (traced), or by a grid of hair",
     .choices = kHairCounts},
    {"forwarddensity", "float", "", "1",
     "share of forward light that neighbours send to a fiber (printed: 0.7)", 0, 1},
    {"backwarddensity", "float", "", "1", "the same of light that comes back from behind it", 0, 1},
    {.name = "return",
     .type = "string",
     .unit = "",
     .defaultValue = "half",
     .meaning =
         "where light from behind a fiber goes: to the side that it came from (half), or as printed in "
         "Zinke et al. 2008",
     .choices = kReturns},
    {"gridcell", "float", "lengths of the scene", "0",
     "cells of the grid; 0: 1/96 of the hair's longest side", 0}};
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
    {{.name = "dualscattering",
      .params = kDualScatteringParams,
      .meaning = "ours: light in hair without paths, forward through the hair before a place and back from "
                 "behind it (Zinke et al. 2008)",
      .ours = true},
     MakeDualScattering},
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
