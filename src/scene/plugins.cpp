#include "scene/plugins.h"

namespace cuticle {

// Media are read and not rendered: the parser warns of them.
const PluginTable &MediumPlugins() {
    static const PluginTable table{
        PluginKind::Medium,
        {{.name = "homogeneous", .meaning = "a medium that is the same everywhere", .standIn = "empty space"},
         {.name = "heterogeneous", .meaning = "a medium on a grid", .standIn = "empty space"}},
        {"uniformgrid", "rgbgrid", "cloud", "nanovdb"}};
    return table;
}

} // namespace cuticle
