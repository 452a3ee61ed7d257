// Scene text all the way to a few pixels: whatever the parser lets pass, no sample may be NaN or infinite.
#include "fuzz/fuzz.h"

#include "core/parallel.h"
#include "render/plugins.h"
#include "render/renderer.h"

using namespace cuticle;

namespace {

// Whether a scene is legitimate and takes long: recipes of many strands, surfaces divided often, many
// objects.
bool TakesLong(const SceneDescription &scene) {
    const auto isLong = [](const ShapeEntity &s) {
        return s.type.starts_with("groom") ||
               (s.type == "loopsubdiv" && s.params.FindInt("nlevels", s.params.FindInt("levels", 3)) > 5);
    };
    bool found = std::any_of(scene.shapes.begin(), scene.shapes.end(), isLong);
    for (const ObjectDefinition &o : scene.objects)
        found |= std::any_of(o.shapes.begin(), o.shapes.end(), isLong);
    return found || scene.instances.size() > 1000;
}

// The window of 4 x 4 pixels in the middle of the film.
std::array<float, 4> Middle(const SceneDescription &scene) {
    const ParamSet &film = scene.film.params;
    const auto window = [](int resolution, float *crop) {
        const auto n = static_cast<float>(std::max(1, resolution));
        crop[0] = std::max(0.f, 0.5f - 2 / n), crop[1] = std::min(1.f, 0.5f + 2 / n);
    };
    std::array<float, 4> crop{};
    window(film.FindInt("xresolution", 1280), &crop[0]);
    window(film.FindInt("yresolution", 720), &crop[2]);
    return crop;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const ThreadLimit oneThread(1);
    RenderStats stats;
    Accepts([&] {
        // A mistake costs its directive alone, so that more of the text gets to be rendered
        std::vector<std::string> errors;
        ParseOptions parseOptions;
        parseOptions.collectErrors = &errors;
        SceneDescription description =
            ParseSceneText(AllPlugins(), Text(data, size), "fuzz.pbrt", ".", parseOptions);
        if (TakesLong(description))
            return;
        const Scene scene(&description, {});
        RenderOptions options;
        options.spp = 2;
        options.threads = 1;
        options.film.crop = Middle(description);
        Render(description, scene, options, &stats);
    });
    Require(stats.nanSamples == 0);
    return 0;
}
