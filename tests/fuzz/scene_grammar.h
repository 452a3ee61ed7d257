// Scenes as a grammar, for fuzzing that keeps their structure: statements, parameters, blocks, includes and
// the files that a scene names. What may be written is read from the tables of plug-ins, so that a new row is
// fuzzed from the day it stands there.
#pragma once

#include "fuzz/scene_bundle.h"
#include "parser/plugins.h"

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cuticle {

// Makes scenes and changes them. The same seed makes the same changes.
class SceneMutator {
  public:
    // plugins: what may be named; seedFiles: the files that a scene finds beside it.
    SceneMutator(const PluginTables &plugins, std::vector<std::string> seedFiles, uint64_t seed);

    // A small whole scene; most of them are valid.
    SceneBundle NewScene();
    // One to five changes of a bundle.
    void Mutate(SceneBundle *bundle);
    // Puts some statements of another bundle into this one.
    void Splice(SceneBundle *bundle, const SceneBundle &other);

  private:
    using Tokens = std::vector<std::string>;
    using Change = void (SceneMutator::*)(SceneBundle *);
    struct ChangeRow;

    size_t Below(size_t n); // uniform in [0, n); 0 for n = 0
    bool Chance(double probability);
    template <class List>
    auto &Pick(List &list) {
        return list[Below(list.size())];
    }

    std::string Name();     // of a texture, material, object: few, so that they meet
    std::string FileName(); // of a seed or of a file beside the scene
    double SaneNumber(const ParamInfo &info);
    std::string EdgeNumber(const ParamInfo &info);
    std::string Number(const ParamInfo &info, bool integer);
    void Numbers(const ParamInfo &info, bool integer, size_t count, Tokens *to);
    void SpectrumParam(const ParamInfo &info, Tokens *to);
    void Param(const ParamInfo &info, std::string_view plugin, Tokens *to);
    void Params(const PluginInfo &plugin, Tokens *to);
    void Values(std::initializer_list<double> sane, double spread, Tokens *to);

    SceneStatement PluginStatement(PluginKind kind);
    SceneStatement TransformStatement();
    SceneStatement NameStatement();
    SceneStatement Statement();
    std::vector<SceneStatement> Block();

    void Insert(SceneBundle *bundle);
    void Remove(SceneBundle *bundle);
    void Repeat(SceneBundle *bundle);
    void Swap(SceneBundle *bundle);
    void Nest(SceneBundle *bundle);
    void ChangeNumber(SceneBundle *bundle);
    void ChangeCount(SceneBundle *bundle);
    void ChangeString(SceneBundle *bundle);
    void ChangeDeclaration(SceneBundle *bundle);
    void AddParam(SceneBundle *bundle);
    void RemoveToken(SceneBundle *bundle);
    void MoveToInclude(SceneBundle *bundle);
    void DamageFile(SceneBundle *bundle);
    SceneStatement *AnyStatement(SceneBundle *bundle);
    std::pair<SceneStatement *, size_t> AnyToken(SceneBundle *bundle, bool (*fits)(const std::string &));

    const PluginTables &plugins_;
    std::vector<std::string> seedFiles_;
    std::mt19937_64 random_;
    size_t vertices_ = 4; // of the shape that is being written
};

} // namespace cuticle
