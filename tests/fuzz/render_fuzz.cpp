// Scene text all the way to a few pixels.
#include "fuzz/scene_laws.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    // A mistake costs its directive alone, so that more of the text gets to be rendered
    std::vector<std::string> errors;
    ParseOptions options;
    options.collectErrors = &errors;
    SceneDescription scene;
    if (Accepts([&] { scene = ParseSceneText(AllPlugins(), Text(data, size), "fuzz.pbrt", ".", options); }))
        RenderMiddle(&scene);
    return 0;
}
