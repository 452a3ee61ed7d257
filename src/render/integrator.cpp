//> Turn names into integrators
#include "render/integrator.h"

#include "render/path.h"

namespace cuticle {

//> Read the path integrator's settings from the scene
static PathIntegrator::Settings PathSettings(const ParamSet &params, bool directOnly) {
    PathIntegrator::Settings s;
    s.maxDepth = params.FindInt("maxdepth", 5);
    if (s.maxDepth < 0)
        throw Error(params.loc, "\"maxdepth\" must be 0 or more, not " + std::to_string(s.maxDepth));
    s.directOnly = directOnly;
    if (directOnly)
        // "all" and "one" have one expected picture; ours chooses one light for each sample.
        (void)params.FindString("strategy", "all");
    else
        s.rrThreshold = params.FindFloat("rrthreshold", 1);
    (void)params.FindString("lightsamplestrategy", "power"); // a matter of noise, not of the picture
    return s;
}
//<

//> List the integrators that pbrt-v3 knows
static constexpr std::string_view kIntegrators[] = {"path", "directlighting", "volpath", "bdpt",
                                                    "mlt",  "sppm",           "whitted"};
//<

std::unique_ptr<Integrator> MakeIntegrator(const Entity &entity, const std::string &type) {
    const bool override = type != entity.type;
    ParamSet params = entity.params;
    if (override) // the scene's parameters belong to another integrator: only the depth carries over
        std::erase_if(params.params, [](const Param &p) { return p.name != "maxdepth"; });
    //> Make the integrator, or say what stands in for it
    if (std::find(std::begin(kIntegrators), std::end(kIntegrators), type) == std::end(kIntegrators))
        throw Error(params.loc, "unknown integrator \"" + type + "\"." +
                                    Suggestion(type, kIntegrators, std::size(kIntegrators)));
    const bool direct = type == "directlighting";
    auto integrator = std::make_unique<PathIntegrator>(PathSettings(params, direct));
    if (direct || type == "path")
        params.ReportUnused("Integrator \"" + type + "\"");
    else
        Warning(params.loc, "integrator \"" + type + "\" is not rendered",
                "integrator \"" + type + "\" is not rendered; \"path\" is used instead");
    return integrator;
    //<
}

} // namespace cuticle
//<
