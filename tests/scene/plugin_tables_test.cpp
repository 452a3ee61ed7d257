// The tables of plug-ins say what their makers do: every parameter of a row is read.
#include "core/error.h"
#include "materials/material.h"
#include "materials/texture.h"
#include "parser/scene_description.h"
#include "scene/camera.h"
#include "scene/light.h"
#include "scene/plugins.h"
#include "scene/scene.h"

#include <gtest/gtest.h>

#include <mutex>
#include <set>

namespace cuticle {
namespace {

// The parameters that makers left unread.
class UnusedParameters : public WarningSink {
  public:
    void Warn(const FileLoc &, const std::string &kind, const std::string &) override {
        if (kind.starts_with("unused parameter"))
            kinds.insert(kind);
    }
    std::set<std::string> kinds;
};

// A parameter with a value of its type, as the parser would give it. Nothing for files and names, which need
// more.
std::optional<Param> Given(const ParamInfo &info) {
    const auto is = [&](std::string_view text) { return info.type.find(text) != std::string_view::npos; };
    Param p;
    p.name = info.name;
    if (info.type == "string") {
        if (info.choices.empty())
            return {};
        p.type = ParamType::String;
        p.strings = {std::string(info.choices[0])};
    } else if (info.type == "bool") {
        p.type = ParamType::Bool;
        p.bools = {false};
    } else if (info.type == "point3" || info.type == "vector3") {
        p.type = info.type == "point3" ? ParamType::Point3 : ParamType::Vector3;
        p.numbers = {0.5, 2, 4};
    } else if (info.type == "floats" && info.name == "screenwindow") {
        p.type = ParamType::Float;
        p.numbers = {-1, 1, -1, 1};
    } else if (is("float") || is("integer") || is("spectrum")) {
        const bool color = is("spectrum") && !is("float");
        p.type = is("integer") ? ParamType::Integer : color ? ParamType::Spectrum : ParamType::Float;
        const double low = std::isfinite(info.low) ? info.low : 0;
        const double value = std::isfinite(info.high) && info.high < 1000 ? (low + info.high) / 2 : low + 1;
        p.numbers.assign(color ? 3 : 1, is("integer") ? std::ceil(value) : value);
    } else {
        return {};
    }
    return p;
}

// All parameters of a row that have values, in one set.
ParamSet AllOf(const PluginInfo &info) {
    ParamSet set;
    for (const ParamInfo &param : info.params)
        if (const std::optional<Param> p = Given(param))
            set.params.push_back(*p);
    return set;
}

template <class Make>
void ExpectAllRead(const PluginTable &table, const Make &make) {
    for (const PluginInfo &info : table.rows) {
        UnusedParameters unused;
        const WarningScope scope(&unused);
        make(info);
        EXPECT_TRUE(unused.kinds.empty())
            << DirectiveOf(table.kind) << " \"" << info.name << "\": " << *unused.kinds.begin();
    }
}

TEST(PluginTables, MaterialsReadTheirParameters) {
    const TextureTable textures;
    ExpectAllRead(MaterialPlugins(), [&](const PluginInfo &info) {
        if (info.name == "mix" ||
            info.name == "hair") // two materials; the models of hair have a test of their own
            return;
        MaterialEntity entity;
        entity.type = info.name;
        entity.params = AllOf(info);
        MakeMaterial(entity, textures, {});
    });
}

TEST(PluginTables, TexturesReadTheirParameters) {
    ExpectAllRead(TexturePlugins(), [&](const PluginInfo &info) {
        if (info.name == "imagemap") // needs a file
            return;
        // Every mapping, since each reads parameters of its own
        std::set<std::string> everywhere;
        const bool mapped = info.FindParam("mapping") != nullptr;
        for (const char *mapping : {"uv", "planar"}) {
            UnusedParameters unused;
            const WarningScope scope(&unused);
            TextureEntity entity;
            entity.type = info.name;
            entity.params = AllOf(info);
            for (Param &p : entity.params.params) {
                if (p.name == "mapping")
                    p.strings = {mapping};
                if (p.type == ParamType::Float && info.FindParam(p.name)->type != "float")
                    p.type = ParamType::Spectrum, p.numbers.resize(3, p.numbers[0]);
            }
            TextureTable({}, {entity});
            if (&mapping[0] && everywhere.empty())
                everywhere = unused.kinds;
            else
                std::erase_if(everywhere, [&](const std::string &k) { return !unused.kinds.contains(k); });
            if (!mapped)
                break;
        }
        EXPECT_TRUE(everywhere.empty()) << info.name << ": " << *everywhere.begin();
    });
}

TEST(PluginTables, LightsReadTheirParameters) {
    ExpectAllRead(LightPlugins(), [](const PluginInfo &info) {
        LightEntity entity;
        entity.type = info.name;
        entity.params = AllOf(info);
        MakeLight(entity, {{-1, -1, -1}, {1, 1, 1}});
        entity.params.ReportUnused("LightSource");
    });
    ExpectAllRead(AreaLightPlugins(), [](const PluginInfo &info) {
        Entity entity;
        entity.type = info.name;
        entity.params = AllOf(info);
        MakeAreaLight(entity, nullptr, 0);
        entity.params.ReportUnused("AreaLightSource");
    });
}

TEST(PluginTables, CamerasReadTheirParameters) {
    ExpectAllRead(CameraPlugins(), [](const PluginInfo &info) {
        Entity entity;
        entity.type = info.name;
        entity.params = AllOf(info);
        MakeCamera(entity, {20, 10});
    });
}

// Shapes whose parameters need no lists of points or files.
TEST(PluginTables, ShapesReadTheirParameters) {
    ExpectAllRead(ShapePlugins(), [](const PluginInfo &info) {
        if (info.FindParam("P") || info.FindParam("Pz") || info.FindParam("filename"))
            return;
        SceneDescription description;
        description.materials.emplace_back().type = "matte";
        ShapeEntity &shape = description.shapes.emplace_back();
        shape.type = info.name;
        shape.params = AllOf(info);
        if (info.name == "groom")
            std::erase_if(shape.params.params, [&](const Param &p) {
                return p.name == "radius" || p.name == "side"; // of other kinds than a head
            });
        for (Param &p : shape.params.params)
            if (p.name == "strands" || p.name == "locks")
                p.numbers = {5};
        const Scene scene(&description, {});
    });
}

} // namespace
} // namespace cuticle
