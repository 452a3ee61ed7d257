// The grammar by which scenes are fuzzed: a fuzzer that writes nothing valid, or passes plug-ins over, finds
// nothing.
#include "fuzz/scene_grammar.h"
#include "fuzz/scene_laws.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

namespace cuticle {
namespace {

const std::string kSeedFolder = CUTICLE_SOURCE_DIR "/tests/fuzz/seeds";

std::vector<std::string> SeedNames() {
    std::vector<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(kSeedFolder))
        names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
}

TEST(SceneGrammar, WhatIsWrittenIsRead) {
    for (uint64_t seed = 0; seed < 300; ++seed) {
        SceneMutator mutator(AllPlugins(), SeedNames(), seed);
        SceneBundle bundle = mutator.NewScene();
        for (size_t i = 0; i < seed % 7; ++i)
            mutator.Mutate(&bundle);
        const std::string text = WriteBundle(bundle);
        const std::string again = WriteBundle(ReadBundle(text));
        EXPECT_EQ(text, WriteBundle(ReadBundle(again))) << seed; // one reading settles it
    }
}

TEST(SceneGrammar, ReadsWordsStringsBracketsAndFiles) {
    const SceneBundle bundle =
        ReadBundle("# a comment\nTranslate 1 -2.5e3 3 Shape \"curve\"\"point P\"[ 0 1]\n"
                   "#file b.pbrt packed damage 12 4 255\nIdentity\n"
                   "#file c.ply seed mesh.ply damage 3 0 0\n");
    ASSERT_EQ(bundle.files.size(), 3u);
    const std::vector<SceneStatement> expected{{"Translate", {"1", "-2.5e3", "3"}},
                                               {"Shape", {"\"curve\"", "\"point P\"", "[", "0", "1", "]"}}};
    EXPECT_EQ(bundle.files[0].statements, expected);
    EXPECT_EQ(bundle.files[1].name, "b.pbrt");
    EXPECT_TRUE(bundle.files[1].packed);
    EXPECT_EQ(bundle.files[1].statements, (std::vector<SceneStatement>{{"Identity", {}}}));
    EXPECT_EQ(bundle.files[1].damage, (std::vector<FileDamage>{{12, 4, 255}}));
    EXPECT_EQ(bundle.files[2].seed, "mesh.ply");
    EXPECT_EQ(FileBytes(bundle.files[2], kSeedFolder), "ply"); // cut behind its third byte
}

TEST(SceneGrammar, FilesStayInTheirFolder) {
    const SceneBundle bundle =
        ReadBundle("Identity\n#file ../x\nIdentity\n#file /tmp/x seed ../run.py\nIdentity\n");
    for (const SceneFile &file : bundle.files) {
        EXPECT_EQ(file.name.find('/'), std::string::npos) << file.name;
        EXPECT_EQ(file.seed, "");
    }
}

TEST(SceneGrammar, IncludesAreFlattenedWhereTheyAreWhole) {
    std::string text;
    EXPECT_TRUE(FlattenIncludes(ReadBundle("A Include \"b.pbrt\" C\n#file b.pbrt packed\nB 1\n"), &text));
    EXPECT_EQ(text, "A\nB 1\nC\n");
    EXPECT_FALSE(FlattenIncludes(ReadBundle("Include \"b.pbrt\""), &text));
    EXPECT_FALSE(FlattenIncludes(ReadBundle("Include \"scene.pbrt\""), &text));
    EXPECT_FALSE(FlattenIncludes(ReadBundle("Include \"b.pbrt\"\n#file b.pbrt damage 1 1 0\nB\n"), &text));
}

TEST(SceneGrammar, EveryPlugInIsWritten) {
    std::set<std::string> missing;
    for (size_t kind = 0; kind < kPluginKinds; ++kind)
        if (const PluginTable *table = AllPlugins().Find(static_cast<PluginKind>(kind)))
            for (const PluginInfo &row : table->rows)
                missing.insert(std::string(row.name));
    for (uint64_t seed = 0; seed < 3000 && !missing.empty(); ++seed) {
        SceneMutator mutator(AllPlugins(), SeedNames(), seed);
        SceneBundle bundle = mutator.NewScene();
        for (int i = 0; i < 5; ++i)
            mutator.Mutate(&bundle);
        const std::string text = WriteBundle(bundle);
        std::erase_if(missing, [&](const std::string &name) {
            return text.find("\"" + name + "\"") != std::string::npos;
        });
    }
    for (const std::string &name : missing)
        ADD_FAILURE() << name << " is in no scene";
}

// New scenes are parsed by all readers and rendered. At least a third of them are valid as a whole; each of
// them holds the laws that ReadInAllWays and RenderMiddle end the program by.
TEST(SceneGrammar, ManyNewScenesAreValidAndRendered) {
    size_t valid = 0, scenes = 0;
    for (uint64_t seed = 0; seed < 300; ++seed) {
        SceneMutator mutator(AllPlugins(), SeedNames(), seed);
        std::string text;
        if (!FlattenIncludes(mutator.NewScene(), &text))
            continue; // it includes a file that is not there
        ++scenes;
        size_t errors = 0;
        SceneDescription scene = ReadInAllWays(
            [&](const ParseOptions &options) {
                return ParseSceneText(AllPlugins(), text, "new.pbrt", kSeedFolder, options);
            },
            &errors);
        valid += errors == 0;
        RenderMiddle(&scene);
    }
    EXPECT_GT(scenes, 200u);
    EXPECT_GT(3 * valid, scenes) << valid << " of " << scenes;
}

} // namespace
} // namespace cuticle
