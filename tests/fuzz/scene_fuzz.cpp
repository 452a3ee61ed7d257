// Scene text through the parser.
#include "fuzz/scene_laws.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const std::string text = Text(data, size);
    ReadInAllWays([&](const ParseOptions &options) {
        return ParseSceneText(AllPlugins(), text, "fuzz.pbrt", ".", options);
    });
    return 0;
}
