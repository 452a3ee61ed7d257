//> Turn names into integrators
#include "render/integrator.h"

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
