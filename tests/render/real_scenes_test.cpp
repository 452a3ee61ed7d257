#include "parser/scene_description.h"
#include "render/plugins.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace cuticle {
namespace {

// Every scene of the shared folder parses; what it lacks (includes, spectra) is reported as missing. Runs
// where the folder is there: named by CUTICLE_SHARED_DATA, or beside the source tree.
TEST(RealScenes, ParseOrLackFiles) {
    const char *named = std::getenv("CUTICLE_SHARED_DATA");
    const std::filesystem::path folder =
        named ? std::filesystem::path(named) : std::filesystem::path(CUTICLE_SOURCE_DIR) / "../shared/data";
    if (!std::filesystem::is_directory(folder / "parser")) {
        std::cout << "passed over: no folder of real scenes (CUTICLE_SHARED_DATA names it)\n";
        return;
    }
    size_t files = 0, missing = 0;
    for (const char *part : {"parser", "scenes"})
        for (const auto &entry : std::filesystem::recursive_directory_iterator(folder / part)) {
            if (entry.path().extension() != ".pbrt")
                continue;
            ++files;
            std::vector<std::string> errors;
            ParseOptions options;
            options.collectErrors = &errors;
            // A part that others include is parsed as they do it.
            const bool isPart = entry.path().parent_path().filename() == "geometry";
            const auto s = isPart ? ParseSceneText(AllPlugins(),
                                                   "WorldBegin Include \"" +
                                                       entry.path().filename().string() + "\" WorldEnd",
                                                   "whole", entry.path().parent_path().string(), options)
                                  : ParseScene(AllPlugins(), entry.path().string(), options);
            for (const std::string &e : errors) {
                EXPECT_TRUE(e.find(": No such file or directory") != e.npos) << e;
                ++missing;
            }
            EXPECT_GT(s.bytesRead, 0u);
        }
    FlushWarnings();
    std::cout << files << " files, " << missing << " files that they name are missing\n";
    EXPECT_GE(files, 72u);
}

// As the scene of the dragon in pbrt-v3's collection: a shift that stands in the wrong row of the matrix.
TEST(RealScenes, ALightOfDirectionsTakesAProjectiveMatrix) {
    const auto s = ParseSceneText(AllPlugins(),
                                  "WorldBegin ConcatTransform [0 0 1 0  1 0 0 0  0 1 0 8.87  0 0 0 1] "
                                  "LightSource \"infinite\" LightSource \"distant\" TransformBegin Identity "
                                  "LightSource \"point\" TransformEnd LightSource \"exinfinite\"",
                                  "test.pbrt");
    ASSERT_EQ(s.lights.size(), 4u);
    for (const size_t i : {0u, 1u, 3u})
        EXPECT_EQ(s.lights[i].ctm.Vector({1, 2, 3}), Vector3f(2, 3, 1)) << i;
}

} // namespace
} // namespace cuticle
