// Scenes by their grammar, with the files that they include and name, through the parser and to a few pixels.
// An input is a bundle (scene_bundle.h); it is changed by statements and parameters and never by bytes.
#include "fuzz/scene_grammar.h"
#include "fuzz/scene_laws.h"

#include "core/isa.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

using namespace cuticle;

namespace {

const std::string kSeeds = CUTICLE_SOURCE_DIR "/tests/fuzz/seeds";

// The files that scenes find beside them: all seeds but scenes.
std::vector<std::string> SeedFiles() {
    std::vector<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(kSeeds))
        if (entry.path().extension() != ".pbrt")
            names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end()); // the same choice on every machine
    return names;
}

void WriteBytes(const std::filesystem::path &path, const std::string &bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

// The process' own folder of scenes; it goes with the process.
class Folder {
  public:
    Folder() : path_(std::filesystem::temp_directory_path() / ("cuticle-fuzz-" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
        for (const std::string &name : SeedFiles())
            std::filesystem::copy_file(kSeeds + "/" + name, path_ / name,
                                       std::filesystem::copy_options::overwrite_existing);
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    std::string Scene() const { return path_ / "scene.pbrt"; }
    void Put(const SceneBundle &bundle) const {
        // from the last to the first: of two with one name the first counts, as FlattenIncludes takes it
        for (size_t i = bundle.files.size(); i-- > 0;)
            WriteBytes(path_ / bundle.files[i].name, FileBytes(bundle.files[i], kSeeds));
    }
    // Leaves what the next input finds, the seeds, as they were.
    void Clear(const SceneBundle &bundle) const {
        for (const SceneFile &file : bundle.files)
            std::filesystem::remove(path_ / file.name);
        for (const SceneFile &file : bundle.files)
            if (std::filesystem::exists(kSeeds + "/" + file.name))
                std::filesystem::copy_file(kSeeds + "/" + file.name, path_ / file.name);
    }

  private:
    std::filesystem::path path_;
};

// Each input has its instruction set, so that all kernels are fuzzed.
void ChooseKernels(const uint8_t *data, size_t size) {
    const std::vector<InstructionSet> isas = SupportedIsas();
    const size_t hash = std::hash<std::string>()(Text(data, size));
    const char *const name = IsaName(isas[hash % isas.size()]);
    setenv("CUTICLE_ISA", name, 1);
    SetHairKernels(hash / isas.size() % 4 == 0 ? "scalar" : name);
}

// An Include is nothing but the text that it stands for.
void RequireSameWithoutIncludes(const SceneDescription &whole, const std::string &flat,
                                const std::string &folder) {
    SceneDescription scene;
    Require(Accepts([&] { scene = ParseSceneText(AllPlugins(), flat, "flat.pbrt", folder, {}); }));
    Require(scene.shapes.size() == whole.shapes.size() && scene.lights.size() == whole.lights.size() &&
            scene.materials.size() == whole.materials.size() &&
            scene.instances.size() == whole.instances.size() &&
            scene.curves.segments.size() == whole.curves.segments.size());
    for (size_t i = 0; i < scene.curves.segments.size(); ++i)
        for (size_t k = 0; k < 4; ++k)
            Require(scene.curves.segments[i].cp[k] == whole.curves.segments[i].cp[k]);
}

size_t WriteTo(uint8_t *data, size_t maxSize, const SceneBundle &bundle) {
    const std::string text = WriteBundle(bundle);
    const size_t size = std::min(maxSize, text.size());
    std::memcpy(data, text.data(), size);
    return size;
}

} // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t maxSize, unsigned seed) {
    SceneMutator mutator(AllPlugins(), SeedFiles(), seed);
    SceneBundle bundle = size < 20 || seed % 50 == 0 ? mutator.NewScene() : ReadBundle(Text(data, size));
    mutator.Mutate(&bundle);
    return WriteTo(data, maxSize, bundle);
}

extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t *a, size_t sizeA, const uint8_t *b, size_t sizeB,
                                            uint8_t *out, size_t maxSize, unsigned seed) {
    SceneMutator mutator(AllPlugins(), SeedFiles(), seed);
    SceneBundle bundle = ReadBundle(Text(a, sizeA));
    mutator.Splice(&bundle, ReadBundle(Text(b, sizeB)));
    return WriteTo(out, maxSize, bundle);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const Folder folder;
    const SceneBundle bundle = ReadBundle(Text(data, size));
    ChooseKernels(data, size);
    folder.Put(bundle);
    size_t errors = 0;
    SceneDescription scene = ReadInAllWays(
        [&](const ParseOptions &options) { return ParseScene(AllPlugins(), folder.Scene(), options); },
        &errors);
    std::string flat;
    if (errors == 0 && FlattenIncludes(bundle, &flat))
        RequireSameWithoutIncludes(scene, flat, std::filesystem::path(folder.Scene()).parent_path());
    RenderMiddle(&scene);
    folder.Clear(bundle);
    return 0;
}
