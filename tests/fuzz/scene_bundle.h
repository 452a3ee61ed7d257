// A scene and the files beside it as one text: what structure-aware fuzzing (scene_grammar.h) changes and a
// fuzz target writes into a folder of its own.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// A directive and what follows it, each token as it is written: "\"float beta_m\"", "[", "0.3", "]".
struct SceneStatement {
    std::string word;
    std::vector<std::string> tokens;
    bool operator==(const SceneStatement &) const = default;
};

// Damage to the bytes of a file, after it is made and packed.
struct FileDamage {
    uint32_t offset = 0; // taken modulo the size of the file
    uint32_t size = 1;   // bytes that are overwritten, 0: the file ends at `offset`
    int64_t value = 0;   // written there, low byte first
    bool operator==(const FileDamage &) const = default;
};

// A file beside a scene: text of its own, or a copy of a seed file (tests/fuzz/seeds).
struct SceneFile {
    std::string name; // in the scene's folder
    std::string seed; // the seed file that is copied; "": statements
    bool packed = false;
    std::vector<FileDamage> damage;
    std::vector<SceneStatement> statements;
    bool operator==(const SceneFile &) const = default;
};

// A scene, files[0], with the files beside it. As text: the scene, then for each file a line
// "#file NAME [seed SEED] [packed] [damage OFFSET SIZE VALUE]..." and its statements.
struct SceneBundle {
    std::vector<SceneFile> files;
    bool operator==(const SceneBundle &) const = default;
};

// Any text is a bundle: what is no token is left out, and there is always a first file.
SceneBundle ReadBundle(std::string_view text);
std::string WriteBundle(const SceneBundle &bundle);

// A file's bytes. seeds: the folder of the seed files; a seed that is not there is empty.
std::string FileBytes(const SceneFile &file, const std::string &seeds);

// The scene with the text of every Include in its place; false where one cannot be put there (it is damaged,
// a copy of a seed, missing, or includes itself).
bool FlattenIncludes(const SceneBundle &bundle, std::string *text);

} // namespace cuticle
