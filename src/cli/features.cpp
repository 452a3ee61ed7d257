// cuticle features: what of pbrt-v3 is rendered.
#include "cli/commands.h"
#include "render/plugins.h"

#include <iostream>

namespace cuticle {

void AddFeaturesCommand(CLI::App &app) {
    CLI::App *c =
        app.add_subcommand("features", "Tell what of pbrt-v3 is rendered, and what stands in for the rest.");
    c->footer("A Markdown table, made from the names that the reader of scenes knows.");
    c->callback([] { std::cout << FeatureTable(AllPlugins()); });
}

} // namespace cuticle
