// The table of plug-ins says what happens: each is put into a scene, which is made.
#include "warnings.h"

#include "core/error.h"
#include "materials/texture.h"
#include "render/integrator.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

const char kMissing[] = "plugins_test.none";

// A scene in which the plug-in stands, with the least parameters that it needs.
std::string SceneWith(PluginKind kind, const std::string &name) {
    const std::string what = std::string(DirectiveOf(kind)) + " \"" + name + "\" ";
    const std::string film =
        kind == PluginKind::Film ? "" : "Film \"image\" \"integer xresolution\" 2 \"integer yresolution\" 2 ";
    const std::string sphere = "Shape \"sphere\" ";
    switch (kind) {
    case PluginKind::Film:
        return what + "\"integer xresolution\" 2 \"integer yresolution\" 2 WorldBegin " + sphere + "WorldEnd";
    case PluginKind::Camera:
    case PluginKind::Sampler:
    case PluginKind::Filter:
    case PluginKind::Integrator:
    case PluginKind::Accelerator:
        return film + what + "WorldBegin " + sphere + "WorldEnd";
    case PluginKind::Material:
        if (name == "mix")
            return film + "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"matte\" " + what +
                   "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"a\" " + sphere + "WorldEnd";
        return film + "WorldBegin " + what + sphere + "WorldEnd";
    case PluginKind::Texture:
        return film + "WorldBegin Texture \"t\" \"spectrum\" \"" + name + "\" " +
               (name == "imagemap" ? std::string("\"string filename\" \"") + kMissing + "\" " : "") +
               "Material \"matte\" \"texture Kd\" \"t\" " + sphere + "WorldEnd";
    case PluginKind::Shape: {
        std::string parameters;
        if (name == "trianglemesh" || name == "loopsubdiv")
            parameters = "\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] ";
        else if (name == "plymesh" || name == "hairfile")
            parameters = std::string("\"string filename\" \"") + kMissing + "\" ";
        else if (name == "heightfield")
            parameters = "\"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0] ";
        else if (name == "curve")
            parameters = "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] ";
        else if (name == "groom")
            parameters = "\"integer strands\" 2 ";
        return film + "WorldBegin " + what + parameters + "WorldEnd";
    }
    case PluginKind::AreaLight:
        return film + "WorldBegin " + what + sphere + "WorldEnd";
    case PluginKind::Medium:
        return film + "WorldBegin MakeNamedMedium \"m\" \"string type\" \"" + name + "\" " + sphere +
               "WorldEnd";
    case PluginKind::Light:
        return film + "WorldBegin " + what + sphere + "WorldEnd";
    }
    return {};
}

// Returns what is said on the way to the scene and its integrator; "" where all is rendered.
std::string WarningsOf(PluginKind kind, const std::string &name) {
    testing::internal::CaptureStderr();
    try {
        SceneDescription description = ParseSceneText(AllPlugins(), SceneWith(kind, name), "scene.pbrt");
        const Scene scene(&description, SceneOptions());
        RenderOptions options;
        options.spp = 1;
        RenderStats stats;
        Render(description, scene, options, &stats);
    } catch (const Error &e) {
        // The files of strands and triangles are not there: their readers have been found
        EXPECT_NE(std::string(e.what()).find(kMissing), std::string::npos) << name << ": " << e.what();
    }
    FlushWarnings();
    return testing::internal::GetCapturedStderr();
}

TEST(Plugins, AreRenderedOrReplacedAsTheTableSays) {
    for (size_t k = 0; k < kPluginKinds; ++k) {
        const auto kind = static_cast<PluginKind>(k);
        for (const PluginInfo &plugin : AllPlugins().Find(kind)->rows) {
            const std::string said = WarningsOf(kind, std::string(plugin.name));
            const bool replaced = said.find("not rendered") != std::string::npos;
            EXPECT_EQ(replaced, !plugin.standIn.empty()) << plugin.name << " says: " << said;
        }
    }
}

// A parameter that a row lists is read, and so is none of the unused ones that are warned of.
TEST(Plugins, IntegratorsReadTheParametersOfTheirRows) {
    const auto value = [](const ParamInfo &p) -> std::string {
        return p.type == "integer" ? "2"
               : p.type == "float" ? "0.5"
               : p.type == "bool"  ? "\"true\""
               : p.choices.empty() ? "\"all\""
                                   : fmt::format("\"{}\"", p.choices.back());
    };
    for (const PluginInfo &row : IntegratorPlugins().rows) {
        if (!row.standIn.empty())
            continue;
        std::string text = fmt::format("Integrator \"{}\"", row.name);
        for (const ParamInfo &p : row.params)
            text += fmt::format(" \"{} {}\" {}", p.type, p.name, value(p));
        FlushWarnings();
        const SceneDescription scene =
            ParseSceneText(AllPlugins(), text + " WorldBegin WorldEnd", "scene.pbrt");
        EXPECT_NE(MakeIntegrator(scene.integrator, scene.integrator.type), nullptr);
        EXPECT_EQ(FlushWarnings(), 0u) << text;
    }
}

TEST(Plugins, OnePlaceForEachName) {
    for (size_t k = 0; k < kPluginKinds; ++k) {
        std::vector<std::string_view> names = AllPlugins().Find(static_cast<PluginKind>(k))->Names();
        EXPECT_FALSE(names.empty());
        std::sort(names.begin(), names.end());
        EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    }
    EXPECT_EQ(TexturePlugins().Find("ptex")->standIn, "the constant 0.5");
    EXPECT_EQ(TexturePlugins().Find("unheard of"), nullptr);
}

} // namespace
} // namespace cuticle
