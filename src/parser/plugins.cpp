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

namespace {

std::string Join(const std::vector<std::string> &parts, const char *between) {
    std::string text;
    for (const std::string &part : parts)
        text += (text.empty() ? "" : between) + part;
    return text;
}

std::string FeatureRow(const PluginTable &table) {
    std::vector<std::string> rendered, ours, standIns;
    std::vector<std::vector<std::string>> replaced; // by each of standIns
    for (const PluginInfo &plugin : table.rows) {
        const std::string name = plugin.name.empty() ? "`\"\"`" : std::string(plugin.name);
        if (plugin.standIn.empty()) {
            (plugin.ours ? ours : rendered).push_back(name);
            continue;
        }
        if (standIns.empty() || standIns.back() != plugin.standIn) {
            standIns.emplace_back(plugin.standIn);
            replaced.emplace_back();
        }
        replaced.back().push_back(name);
    }
    std::vector<std::string> left, right;
    if (!rendered.empty())
        left.push_back(Join(rendered, ", "));
    if (!ours.empty())
        left.push_back("ours: " + Join(ours, ", "));
    if (!table.remark.empty())
        left.emplace_back(table.remark);
    for (size_t i = 0; i < standIns.size(); ++i)
        right.push_back(Join(replaced[i], ", ") + ": " + standIns[i]);
    return "| `" + std::string(DirectiveOf(table.kind)) + "` | " + Join(left, "; ") + " | " +
           Join(right, "; ") + " |\n";
}

} // namespace

std::string FeatureTable(const PluginTables &tables) {
    std::string text =
        "| directive | rendered | known, with a warning and what is used instead |\n| --- | --- | --- |\n";
    for (size_t kind = 0; kind < kPluginKinds; ++kind)
        if (const PluginTable *table = tables.Find(static_cast<PluginKind>(kind)))
            text += FeatureRow(*table);
    return text + "| `ActiveTransform`, `TransformTimes` | | motion: the place at the start time |\n";
}

} // namespace cuticle
