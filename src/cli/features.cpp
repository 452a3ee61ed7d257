// cuticle features: what of pbrt-v3 is rendered, and the manual of every plug-in.
#include "cli/commands.h"
#include "parser/manual.h"
#include "render/plugins.h"

#include <iostream>
#include <memory>
#include <string>

namespace cuticle {

namespace {

struct FeaturesArguments {
    std::string kind, name;
};

} // namespace

void AddFeaturesCommand(CLI::App &app) {
    CLI::App *c =
        app.add_subcommand("features", "Tell what of pbrt-v3 is rendered, and every parameter of it.");
    c->footer(
        "Without arguments a table of what is rendered and of what stands in for the rest; with a directive, "
        "and the name of one that it makes, all parameters. In Markdown, from the code's own tables.\n"
        "Example: cuticle features Material hair");
    auto arguments = std::make_shared<FeaturesArguments>();
    CLI::Option *kind = c->add_option("KIND", arguments->kind, "a directive: Camera, Material, Shape, ...");
    CLI::Option *name =
        c->add_option("NAME", arguments->name, "the name of one that it makes: hair, sphere, ...");
    c->callback([=] {
        const FeaturesArguments &a = *arguments;
        std::cout << (name->count()   ? PluginManual(AllPlugins(), a.kind, a.name)
                      : kind->count() ? PluginManual(AllPlugins(), a.kind)
                                      : FeatureTable(AllPlugins()));
    });
}

} // namespace cuticle
