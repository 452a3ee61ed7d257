// A plug-in of pbrt (the "hair" of Material "hair") is one row in the table of its kind: name, parameters,
// what stands in for it, what it means, and in the room that makes the kind also its maker. The parser checks
// names against the tables that it is handed, the makers look themselves up in them, and `cuticle features`
// prints them: that is the manual.
//
// How rows are written, in the file that makes the kind:
//
//     constexpr ParamInfo kBumpMap{"bumpmap", "float texture", "lengths of the scene", "", "height over it"};
//     constexpr ParamInfo kMatteParams[] = {
//         {"Kd", "spectrum texture", "", "0.5", "the share of light that is reflected", 0, 1},
//         {"sigma", "float texture", "degrees", "0", "roughness (Oren and Nayar 1994)", 0, 90},
//         kBumpMap,
//     };
//     const PluginRow<Maker> kMaterials[] = {
//         {{"matte", kMatteParams, "a diffuse surface"}, Make<MatteMaterial>},
//         {{.name = "fourier", .standIn = "a matte surface of reflectance 0.5"}, MakeFourier},
//     };
//     const PluginTable &MaterialPlugins() {
//         static const PluginTable table{PluginKind::Material, PluginInfos(kMaterials), {"conductor"}};
//         return table;
//     }
//
// Parameters stand in the row in the order in which the manual shall print them. A parameter that several
// plug-ins read is a constant of its own. A row whose parameters are only known when the program runs
// (Material "hair": those of all fiber models) stands in a function's static array.
#pragma once

#include "core/param_info.h"

#include <array>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// To add one: here, its table in the room that makes the kind, and that table in AllPlugins()
// (render/plugins.cpp).
enum class PluginKind {
    Camera,
    Sampler,
    Film,
    Filter,
    Integrator,
    Accelerator,
    Shape,
    Material,
    Texture,
    Light,
    AreaLight,
    Medium
};
inline constexpr size_t kPluginKinds = 12;

// A plug-in as it is known apart from its maker. Texts and parameters live as long as the program.
struct PluginInfo {
    std::string_view name;
    std::span<const ParamInfo> params = {};
    std::string_view meaning = {}; // one line for the manual
    // Stands in for one that is known and not rendered, as in "a matte surface"; empty: it is rendered.
    std::string_view standIn = {};
    bool ours = false;        // no plug-in of pbrt-v3
    bool directional = false; // a light without a place: its transformation turns directions only

    // The row of a parameter, or null.
    const ParamInfo *FindParam(std::string_view param) const;
};

// A row of the room that makes the kind. Maker: whatever the room calls to make one.
template <class Maker>
struct PluginRow {
    PluginInfo info;
    Maker make;
};

// The rows without their makers, for a PluginTable.
template <class Rows>
std::vector<PluginInfo> PluginInfos(const Rows &rows) {
    std::vector<PluginInfo> infos;
    for (const auto &row : rows)
        infos.push_back(row.info);
    return infos;
}

// The row of this name in an array or vector of PluginRows, or null.
template <class Rows>
auto FindPluginRow(const Rows &rows, std::string_view name) -> decltype(&*std::begin(rows)) {
    for (const auto &row : rows)
        if (row.info.name == name)
            return &row;
    return nullptr;
}

// All plug-ins of one kind.
struct PluginTable {
    PluginKind kind;
    std::vector<PluginInfo> rows;
    // Names that only pbrt-v4, or only pbrt-v2, has: a scene that uses one is told so.
    std::vector<std::string_view> v4 = {}, v2 = {};
    std::string_view remark = {}; // one line on the whole kind, for the manual

    const PluginInfo *Find(std::string_view name) const; // null for an unknown name
    std::vector<std::string_view> Names() const;         // that are read, ours among them
};

// The directive that takes names of this kind, "Camera", "PixelFilter", ...
std::string_view DirectiveOf(PluginKind kind);

// The tables that a parser is handed; each must outlive it. Names of a kind without a table are not checked.
// AllPlugins() (render/plugins.h) has all of them.
class PluginTables {
  public:
    PluginTables() = default;
    PluginTables(std::initializer_list<const PluginTable *> tables);
    const PluginTable *Find(PluginKind kind) const { return tables_[static_cast<size_t>(kind)]; }

  private:
    std::array<const PluginTable *, kPluginKinds> tables_{};
};

} // namespace cuticle
