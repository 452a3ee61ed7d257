// The table of what pbrt-v3 knows by name, and what becomes of it: what is rendered, and what stands in for the rest. The
// parser, the makers of things and `cuticle features` all ask it, so what the documentation says is what happens.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

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

struct Plugin {
    std::string_view name;
    std::string_view standIn =
        {};            // of what is known and not rendered: what is used instead; empty: it is rendered
    bool ours = false; // no plug-in of pbrt-v3
};

// One kind: the directive that takes these names, all that are read, and what only pbrt's successor and predecessor know.
struct PluginTable {
    std::string_view directive;
    std::vector<Plugin> known;
    std::vector<std::string_view> v4, v2;
    std::string_view remark; // for the documentation
};
const PluginTable &Plugins(PluginKind kind);

// The names that are read, ours among them.
std::vector<std::string_view> PluginNames(PluginKind kind);
// What is used instead of a plug-in that is not rendered; empty for one that is, and for unknown names.
std::string_view StandInOf(PluginKind kind, std::string_view name);

// All of it as a Markdown table.
std::string FeatureTable();

} // namespace cuticle
