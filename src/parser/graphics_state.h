// The state that directives change for those after them: attributes, names, the transformation, blocks.
#pragma once

#include "core/vecmath.h"
#include "parser/scene_description.h"
#include "parser/scene_text.h"

#include <array>
#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

// Maps a name that the scene gives to an index into a list of SceneDescription.
using NameMap = std::unordered_map<std::string, int>;

// The names that materials and textures have at a place of the file. A block hides names of the blocks around
// it; at its end they come back. Only what a block changed is kept, so that it costs nothing however many
// names there are.
class ScopedNames {
  public:
    NameMap materials, floatTextures, spectrumTextures;

    // map: one of the three.
    void Set(NameMap *map, const std::string &name, int index);
    // Marks where a block begins; Restore() brings back the names of then.
    size_t Mark() const { return hidden_.size(); }
    void Restore(size_t mark);

  private:
    static constexpr int kNone = -1;
    struct HiddenName {
        NameMap *map;
        std::string name;
        int index;
    };
    std::vector<HiddenName> hidden_;
};

// The current transformation at the start and at the end of the shutter's time.
using TransformPair = std::array<Transform, 2>;

enum class BlockKind { Attribute, Transform, Object };

// Throws Errors at the word of the directive; what pbrt-v3 ignores is a Warning, and nothing changes.
class GraphicsState {
  public:
    explicit GraphicsState(SceneText *text) : text_(*text) {}

    // AttributeBegin saves these, and the names.
    struct Attributes {
        int material = 0;   // index into SceneDescription::materials
        int areaLight = -1; // index into SceneDescription::areaLights
        bool reverseOrientation = false;
    };
    Attributes attributes;
    ScopedNames names;
    int object = -1; // index into SceneDescription::objects of the one being defined

    bool InObject() const { return object >= 0; }
    // The state of a shape of that material. Shapes of an object emit no light.
    ShapeState StateOfShape(int material) const {
        return {material, InObject() ? -1 : attributes.areaLight, attributes.reverseOrientation};
    }

    // WorldBegin. RequireWorld: false, and a Warning, unless it has come: the directive is ignored.
    void BeginWorld(const Token &word);
    bool InWorld() const { return inWorld_; }
    bool RequireWorld(const Token &word);

    bool BeginBlock(const Token &word, BlockKind kind); // false: ignored
    void EndBlock(const Token &word, BlockKind kind);
    bool InBlock() const { return !blocks_.empty(); }
    // At the end of the scene, `before` in words: "" or what is wrong with the blocks that have no end;
    // forgets them.
    std::string CloseBlocks(std::string_view before);

    // Multiplies the active transformations by t from the right (concat), or replaces them. Error: not
    // invertible.
    void Apply(const Token &word, const Transform &t, bool concat);
    enum ActiveBits : unsigned { kStart = 1, kEnd = 2, kBoth = 3 };
    void SetActive(ActiveBits bits) { active_ = bits; }
    // Remembers where a matrix stands that is projective: Current() names it.
    void NoteProjective(const Token &word, const Transform::Matrix &m);
    // The transformation at the start; a Warning where that at the end is another. Error at the place of the
    // matrix: it is projective.
    const Transform &Current(const FileLoc &loc);
    // The same for what has no points, only directions: pbrt-v3 never asks for the last row there.
    const Transform &CurrentOfDirections(const FileLoc &loc);
    // The same without warning, for whoever has asked Current() since TransformVersion() changed.
    const Transform &AtStart() const { return ctm_[0]; }
    // Changes with the transformation.
    uint64_t TransformVersion() const { return transformVersion_; }
    // The camera's space gets its name from the current transformation, world to camera.
    void NameCameraSpace() { coordinateSystems_["camera"] = {ctm_[0].Inverse(), ctm_[1].Inverse()}; }
    void NameSpace(const std::string &name) { coordinateSystems_[name] = ctm_; }
    // CoordSysTransform; a Warning at `at` where there is none of this name.
    void UseSpace(const std::string &name, const Token &at);

  private:
    struct Block {
        BlockKind kind;
        FileLoc loc;
        Attributes attributes; // not of a Transform block
        size_t names;          // ScopedNames::Mark(), likewise
        TransformPair ctm;
        ActiveBits active;
    };

    SceneText &text_;
    bool inWorld_ = false;
    TransformPair ctm_;
    uint64_t transformVersion_ = 1;
    struct {
        FileLoc loc;
        std::string what; // the directive and its numbers, for a message
    } projective_;        // the last one of the scene
    ActiveBits active_ = kBoth;
    std::unordered_map<std::string, TransformPair> coordinateSystems_;
    std::vector<Block> blocks_;
};

} // namespace cuticle
