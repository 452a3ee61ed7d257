#include "parser/manual.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace cuticle {

namespace {

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
        left.push_back(fmt::format("{}", fmt::join(rendered, ", ")));
    if (!ours.empty())
        left.push_back(fmt::format("ours: {}", fmt::join(ours, ", ")));
    if (!table.remark.empty())
        left.emplace_back(table.remark);
    for (size_t i = 0; i < standIns.size(); ++i)
        right.push_back(fmt::format("{}: {}", fmt::join(replaced[i], ", "), standIns[i]));
    return fmt::format("| `{}` | {} | {} |\n", DirectiveOf(table.kind), fmt::join(left, "; "),
                       fmt::join(right, "; "));
}

const PluginTable &FindKind(const PluginTables &tables, std::string_view kind) {
    std::vector<std::string_view> names;
    const auto lower = [](std::string_view s) {
        std::string l(s);
        std::transform(l.begin(), l.end(), l.begin(), [](unsigned char c) { return std::tolower(c); });
        return l;
    };
    for (size_t k = 0; k < kPluginKinds; ++k)
        if (const PluginTable *table = tables.Find(static_cast<PluginKind>(k))) {
            if (lower(DirectiveOf(table->kind)) == lower(kind))
                return *table;
            names.push_back(DirectiveOf(table->kind));
        }
    for (size_t k = 0; k < kPluginKinds; ++k)
        if (const PluginTable *table = tables.Find(static_cast<PluginKind>(k)); table && table->Find(kind))
            throw Error("\"{}\" is no directive", kind)
                .WithRemedy("it is the name of a {0}: cuticle features {0} {1}", DirectiveOf(table->kind),
                            kind);
    throw Error("no directive \"{}\" takes the name of a plug-in", kind)
        .WithRemedy(Suggestion(kind, names.data(), names.size()));
}

} // namespace

std::string RangeInWords(const ParamInfo &p) {
    if (!p.choices.empty())
        return fmt::format("{}", fmt::join(p.choices, ", "));
    const bool low = std::isfinite(p.low), high = std::isfinite(p.high);
    if (low && high)
        return fmt::format("{:.7g} to {:.7g}", p.low, p.high);
    return low ? fmt::format("{:.7g} or more", p.low) : high ? fmt::format("{:.7g} or less", p.high) : "";
}

std::string PluginManual(std::string_view directive, const PluginInfo &plugin) {
    std::string text = fmt::format("## {} \"{}\"\n\n", directive, plugin.name);
    if (!plugin.meaning.empty())
        text += fmt::format("{}.\n\n", plugin.meaning);
    if (plugin.ours)
        text += "Ours: pbrt-v3 has none of this name.\n\n";
    if (!plugin.standIn.empty())
        text += fmt::format("Known and not rendered: a warning, and instead {}.\n\n", plugin.standIn);
    if (plugin.params.empty())
        return text + "No parameters.\n";
    text +=
        "| parameter | type | unit | may be | default | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
    for (const ParamInfo &p : plugin.params)
        text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", p.name, p.type, p.unit, RangeInWords(p),
                            p.defaultValue, p.meaning);
    return text;
}

std::string FeatureTable(const PluginTables &tables) {
    std::string text =
        "| directive | rendered | known, with a warning and what is used instead |\n| --- | --- | --- |\n";
    for (size_t kind = 0; kind < kPluginKinds; ++kind)
        if (const PluginTable *table = tables.Find(static_cast<PluginKind>(kind)))
            text += FeatureRow(*table);
    return text + "| `ActiveTransform`, `TransformTimes` | | motion: the place at the start time |\n";
}

std::string PluginManual(const PluginTables &tables, std::string_view kind) {
    const PluginTable &table = FindKind(tables, kind);
    std::string text = fmt::format("# {}\n", DirectiveOf(table.kind));
    if (!table.remark.empty())
        text += fmt::format("\n{}.\n", table.remark);
    for (const PluginInfo &plugin : table.rows)
        text += "\n" + PluginManual(DirectiveOf(table.kind), plugin);
    return text;
}

std::string PluginManual(const PluginTables &tables, std::string_view kind, std::string_view name) {
    const PluginTable &table = FindKind(tables, kind);
    if (const PluginInfo *plugin = table.Find(name))
        return PluginManual(DirectiveOf(table.kind), *plugin);
    std::vector<std::string_view> names = table.Names();
    std::erase(names, ""); // pbrt's null material, which a list would show as a gap
    throw Error("{} \"{}\" is not known", DirectiveOf(table.kind), name)
        .WithRemedy(Suggestion(name, names.data(), names.size()));
}

} // namespace cuticle
