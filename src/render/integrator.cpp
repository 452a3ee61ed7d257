//> Turn names into integrators
#include "render/integrator.h"

#include "render/path.h"
#include "render/plugins.h"

#include <algorithm>

namespace cuticle {

//> Read the path integrator's settings from the scene
static PathIntegrator::Settings PathSettings(const ParamSet &params, bool directOnly) {
    PathIntegrator::Settings s;
    s.maxDepth = params.FindInt("maxdepth", 5);
    if (s.maxDepth < 0)
        throw Error(params.loc, "\"maxdepth\" must be 0 or more, not " + std::to_string(s.maxDepth));
    s.directOnly = directOnly;
    s.separateLightRay = params.FindBool("separatelightray", false); // ours
    if (directOnly)
        // "all" and "one" have one expected picture; ours chooses one light for each sample.
        (void)params.FindString("strategy", "all");
    else
        s.rrThreshold = params.FindFloat("rrthreshold", 1);
    (void)params.FindString("lightsamplestrategy", "power"); // a matter of noise, not of the picture
    return s;
}
//<

//> List the integrators that "path" stands in for
// And how their pictures would differ from ours.
struct Difference {
    std::string_view name;
    const char *text;
};
static constexpr char kSameButCaustics[] = "both estimate the same light, but for caustics of point and "
                                           "distant lights, which paths from the camera cannot find";
static constexpr char kOpenness[] =
    "its picture shows how open each place is, whatever the lights; ours shows the lights";
static constexpr Difference kDifferences[] = {
    {"volpath", "the picture is the same where there are no participating media, which are not rendered"},
    {"bdpt", kSameButCaustics},
    {"mlt", kSameButCaustics},
    {"sppm", kSameButCaustics},
    {"ambientocclusion", kOpenness},
    {"ao", kOpenness},
};
//<

std::unique_ptr<Integrator> MakeIntegrator(const Entity &entity, const std::string &type) {
    const bool override = type != entity.type;
    ParamSet params = entity.params;
    if (override) // the scene's parameters belong to another integrator: only the depth carries over
        std::erase_if(params.params, [](const Param &p) { return p.name != "maxdepth"; });
    //> Make the integrator, or say what stands in for it
    const PluginInfo *plugin = IntegratorPlugins().Find(type);
    if (!plugin) {
        const std::vector<std::string_view> names = IntegratorPlugins().Names();
        throw Error(params.loc, "unknown integrator \"{}\"", type)
            .WithRemedy(Suggestion(type, names.data(), names.size()));
    }
    // pbrt-v3's "whitted" adds up direct light and follows mirrors and glass: the picture of "directlighting".
    const bool direct = type == "directlighting" || type == "whitted";
    auto integrator = std::make_unique<PathIntegrator>(PathSettings(params, direct));
    const std::string standIn(plugin->standIn);
    if (standIn.empty()) {
        params.ReportUnused("Integrator \"" + type + "\"");
        return integrator;
    }
    std::string message = "integrator \"" + type + "\" is not rendered; \"" + standIn + "\" is used instead";
    for (const Difference &difference : kDifferences)
        if (difference.name == type)
            message += std::string(": ") + difference.text;
    Warning(params.loc, "integrator \"" + type + "\" is not rendered", message);
    return integrator;
    //<
}

} // namespace cuticle
//<
