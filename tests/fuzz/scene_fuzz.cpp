// Scene text through the parser. The short cut for curves and the general reader must agree on every text.
#include "fuzz/fuzz.h"
#include "parser/scene_description.h"
#include "render/plugins.h"

#include <vector>

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const std::string text = Text(data, size);
    const auto parse = [&](bool fastCurves, std::vector<std::string> *errors) {
        SceneDescription scene;
        ParseOptions options;
        options.collectErrors = errors;
        options.fastCurves = fastCurves;
        Accepts([&] { scene = ParseSceneText(AllPlugins(), text, "fuzz.pbrt", ".", options); });
        return scene;
    };
    std::vector<std::string> fastErrors, slowErrors;
    const SceneDescription fast = parse(true, &fastErrors), slow = parse(false, &slowErrors);
    Require(fastErrors == slowErrors);
    const std::vector<CurveSegment> &a = fast.curves.segments, &b = slow.curves.segments;
    Require(a.size() == b.size());
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t k = 0; k < 4; ++k)
            Require(a[i].cp[k] == b[i].cp[k] && IsFinite(a[i].cp[k]));
    // Without a list the first error is thrown
    bool threw = false;
    threw = !Accepts([&] { ParseSceneText(AllPlugins(), text, "fuzz.pbrt"); });
    Require(threw == !fastErrors.empty());
    return 0;
}
