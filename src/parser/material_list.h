// The materials that a scene declares: equal ones are stored once, and a shape's own parameters make a
// variant.
#pragma once

#include "parser/graphics_state.h"
#include "parser/plugins.h"

#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

// Fills SceneDescription::materials. Every index is into that list.
class MaterialList {
  public:
    // rows: which parameters each material reads; null: none is known. The current attributes and names are
    // state's.
    MaterialList(SceneText *text, GraphicsState *state, const PluginTable *rows,
                 std::vector<MaterialEntity> *materials);

    // The index of a material with this content, added where there was none.
    int Add(MaterialEntity material);
    // Adds a named one, which a NamedMaterial may then choose; a Warning where the name was taken.
    void AddNamed(MaterialEntity material);
    // Makes the material of this name the current one. A name that is not known is a Warning, and the current
    // one stays.
    void Choose(const std::string &name, const Token &at);
    // Finds the two materials that a "mix" names; matte takes the place of one that is missing, with a
    // Warning.
    void ResolveMix(const Token &word, MaterialEntity *material);
    // pbrt-v3 looks for a material's parameters among the shape's first. Gives the current material, or a
    // copy that has the shape's values. shape: its row, whose own parameters stay its own; null: not known.
    int OfShape(const PluginInfo *shape, const ParamSet &params);

  private:
    SceneText &text_;
    GraphicsState &state_;
    const PluginTable *rows_;
    std::vector<MaterialEntity> &materials_;
    std::unordered_map<std::string, int> indexByContent_;
};

} // namespace cuticle
