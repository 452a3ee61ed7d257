#include "parser/plugins.h"

namespace cuticle {

const ParamInfo *PluginInfo::FindParam(std::string_view param) const {
    for (const ParamInfo &p : params)
        if (p.name == param)
            return &p;
    return nullptr;
}

const PluginInfo *PluginTable::Find(std::string_view name) const {
    for (const PluginInfo &row : rows)
        if (row.name == name)
            return &row;
    return nullptr;
}

std::vector<std::string_view> PluginTable::Names() const {
    std::vector<std::string_view> names;
    for (const PluginInfo &row : rows)
        names.push_back(row.name);
    return names;
}

std::string_view DirectiveOf(PluginKind kind) {
    static constexpr std::array<std::string_view, kPluginKinds> kNames{
        "Camera", "Sampler",  "Film",    "PixelFilter", "Integrator",      "Accelerator",
        "Shape",  "Material", "Texture", "LightSource", "AreaLightSource", "MakeNamedMedium"};
    return kNames[static_cast<size_t>(kind)];
}

PluginTables::PluginTables(std::initializer_list<const PluginTable *> tables) {
    for (const PluginTable *table : tables)
        tables_[static_cast<size_t>(table->kind)] = table;
}

} // namespace cuticle
