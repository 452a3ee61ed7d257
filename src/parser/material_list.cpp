#include "parser/material_list.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cuticle {

namespace {

constexpr int kMatte = 0; // the first material of a scene

// The content of a material as bytes, equal for equal content.
std::string ContentKey(const MaterialEntity &m) {
    std::string key = m.type;
    const auto raw = [&](const void *data, size_t size) {
        key.append(static_cast<const char *>(data), size);
    };
    for (const Param &p : m.params.params) {
        key += '\0';
        key += p.name;
        key += '\0';
        key += static_cast<char>(p.type);
        const std::array<size_t, 3> counts{p.numbers.size(), p.strings.size(), p.bools.size()};
        raw(counts.data(), sizeof(counts));
        raw(p.numbers.data(), p.numbers.size() * sizeof(double));
        for (const std::string &s : p.strings) {
            key += s;
            key += '\0';
        }
        for (const bool b : p.bools)
            key += b ? '1' : '0';
        raw(&p.floatTexture, sizeof(int));
        raw(&p.spectrumTexture, sizeof(int));
    }
    raw(m.mixed, sizeof(m.mixed));
    return key;
}

} // namespace

MaterialList::MaterialList(SceneText *text, GraphicsState *state, const PluginTable *rows,
                           std::vector<MaterialEntity> *materials)
    : text_(*text), state_(*state), rows_(rows), materials_(*materials) {}

int MaterialList::Add(MaterialEntity material) {
    const auto [it, isNew] =
        indexByContent_.emplace(ContentKey(material), static_cast<int>(materials_.size()));
    if (isNew)
        materials_.push_back(std::move(material));
    return it->second;
}

void MaterialList::AddNamed(MaterialEntity material) {
    NameMap &names = state_.names.materials;
    const std::string name = material.name;
    if (names.count(name))
        Warning(material.params.loc, "named material redefined",
                fmt::format("named material {} is defined again", Quoted(name)));
    state_.names.Set(&names, name, static_cast<int>(materials_.size()));
    materials_.push_back(std::move(material));
}

void MaterialList::Choose(const std::string &name, const Token &at) {
    const NameMap &names = state_.names.materials;
    const auto it = names.find(name);
    if (it != names.end()) {
        state_.attributes.material = it->second;
    } else if (!text_.missingFile) {
        // Scenes that people share do this, and pbrt-v3 renders them
        text_.Complain(at, "unknown named material",
                       "no material {} has been defined here; the current one stays, as in pbrt-v3{}",
                       Quoted(name), text_.SuggestOnce("unknown named material", name, {&names}));
    }
}

void MaterialList::ResolveMix(const Token &word, MaterialEntity *material) {
    if (material->type != "mix")
        return;
    const NameMap &names = state_.names.materials;
    static constexpr std::array<const char *, 2> kNames{"namedmaterial1", "namedmaterial2"};
    for (size_t i = 0; i < 2; ++i) {
        const Param *p = material->params.Find(kNames[i], ParamType::String);
        const std::string name = p && p->strings.size() == 1 ? p->strings[0] : "";
        if (const auto it = names.find(name); it != names.end()) {
            material->mixed[i] = it->second;
            continue;
        }
        material->mixed[i] = kMatte;
        if (text_.missingFile)
            continue;
        if (name.empty())
            text_.Complain(word, "mix without its materials",
                           "a material \"mix\" needs \"string {}\"; matte takes its place, as in pbrt-v3",
                           kNames[i]);
        else
            text_.Complain(text_.PlaceOf(word, *p), "unknown material of a mix",
                           "no material {} has been defined here; matte takes its place, as in pbrt-v3{}",
                           Quoted(name), text_.SuggestOnce("unknown material of a mix", name, {&names}));
    }
}

int MaterialList::OfShape(const PluginInfo *shape, const ParamSet &params) {
    const int index = state_.attributes.material;
    const MaterialEntity &current = materials_[static_cast<size_t>(index)];
    const PluginInfo *row = rows_ ? rows_->Find(current.type) : nullptr;
    if (!row)
        return index;
    MaterialEntity copy;
    bool changed = false;
    for (const Param &p : params.params) {
        // What a shape has itself is the shape's: the alpha of a mesh is its cut-out mask.
        if (!row->FindParam(p.name) || (shape && shape->FindParam(p.name)))
            continue;
        if (!changed) {
            copy = current;
            changed = true;
        }
        p.used = true;
        Param mine = p;
        mine.used = false;
        const auto same = std::find_if(copy.params.params.begin(), copy.params.params.end(),
                                       [&](const Param &q) { return q.name == p.name; });
        if (same != copy.params.params.end())
            *same = std::move(mine);
        else
            copy.params.params.push_back(std::move(mine));
    }
    return changed ? Add(std::move(copy)) : index;
}

} // namespace cuticle
