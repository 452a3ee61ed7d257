#include "scene/plugins.h"

namespace cuticle {

// Media are read and not rendered: the parser warns of them.
const PluginTable &MediumPlugins() {
    static const PluginTable table{PluginKind::Medium,
                                   {{.name = "homogeneous", .standIn = "empty space"},
                                    {.name = "heterogeneous", .standIn = "empty space"}},
                                   {"uniformgrid", "rgbgrid", "cloud", "nanovdb"}};
    return table;
}

} // namespace cuticle
