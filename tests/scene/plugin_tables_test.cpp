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

#include <cmath>
#include <optional>
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

// A number between 1 and 2 by the name, so that "from" and "to", "zmin" and "zmax" differ.
double Apart(const ParamInfo &info) {
    double sum = 0;
    for (const char c : info.name)
        sum += c;
    return 1 + sum / 10000;
}

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
        p.numbers = {0.5, 2, Apart(info)};
    } else if (info.type == "floats" && info.name == "screenwindow") {
        p.type = ParamType::Float;
        p.numbers = {-1, 1, -1, 1};
    } else if (is("float") || is("integer") || is("spectrum")) {
        const bool color = is("spectrum") && !is("float");
        p.type = is("integer") ? ParamType::Integer : color ? ParamType::Spectrum : ParamType::Float;
        const double low = std::isfinite(info.low) ? info.low : 0;
        const double value =
            std::isfinite(info.high) && info.high < 1000 ? (low + info.high) / 2 : low + Apart(info);
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

// Makes every row of a table with all of its parameters, and again without those that hide others ("eta"
// hides "index", "uroughness" hides "roughness"): each must be read in one of the two.
template <class Make>
void ExpectAllRead(const PluginTable &table, const Make &make) {
    for (const PluginInfo &info : table.rows) {
        UnusedParameters all, fewer;
        ParamSet params = AllOf(info);
        {
            const WarningScope scope(&all);
            make(info, params);
        }
        std::erase_if(params.params, [](const Param &p) {
            return p.name == "eta" || p.name == "uroughness" || p.name == "vroughness";
        });
        const WarningScope scope(&fewer);
        make(info, params);
        for (const std::string &kind : all.kinds)
            EXPECT_FALSE(fewer.kinds.contains(kind))
                << DirectiveOf(table.kind) << " \"" << info.name << "\": " << kind;
    }
}

TEST(PluginTables, MaterialsReadTheirParameters) {
    const TextureTable textures;
    ExpectAllRead(MaterialPlugins(), [&](const PluginInfo &info, const ParamSet &params) {
        if (info.name == "mix" ||
            info.name == "hair") // two materials; the models of hair have a test of their own
            return;
        MaterialEntity entity;
        entity.type = info.name;
        entity.params = params;
        MakeMaterial(entity, textures, {});
    });
}

TEST(PluginTables, TexturesReadTheirParameters) {
    ExpectAllRead(TexturePlugins(), [&](const PluginInfo &info, const ParamSet &params) {
        if (info.name == "imagemap") // needs a file
            return;
        // Each mapping reads parameters of its own: those count that none reads
        std::optional<std::set<std::string>> everywhere;
        for (const char *mapping : {"uv", "planar"}) {
            UnusedParameters unused;
            const WarningScope scope(&unused);
            TextureEntity entity;
            entity.type = info.name;
            entity.params = params;
            for (Param &p : entity.params.params) {
                if (p.name == "mapping")
                    p.strings = {mapping};
                if (p.name == "dimension")
                    p.numbers = {2};
                if (info.FindParam(p.name)->type.find("spectrum") != std::string_view::npos) {
                    p.type = ParamType::Spectrum;
                    p.numbers.resize(3, p.numbers[0]);
                }
            }
            TextureTable({}, {entity});
            if (!everywhere)
                everywhere = unused.kinds;
            else
                std::erase_if(*everywhere, [&](const std::string &k) { return !unused.kinds.contains(k); });
        }
        EXPECT_TRUE(everywhere->empty()) << info.name << ": " << *everywhere->begin();
    });
}

TEST(PluginTables, LightsReadTheirParameters) {
    ExpectAllRead(LightPlugins(), [](const PluginInfo &info, const ParamSet &params) {
        LightEntity entity;
        entity.type = info.name;
        entity.params = params;
        MakeLight(entity, {{-1, -1, -1}, {1, 1, 1}});
        entity.params.ReportUnused("LightSource");
    });
    ExpectAllRead(AreaLightPlugins(), [](const PluginInfo &info, const ParamSet &params) {
        Entity entity;
        entity.type = info.name;
        entity.params = params;
        MakeAreaLight(entity, nullptr, 0);
        entity.params.ReportUnused("AreaLightSource");
    });
}

TEST(PluginTables, CamerasReadTheirParameters) {
    ExpectAllRead(CameraPlugins(), [](const PluginInfo &info, const ParamSet &params) {
        Entity entity;
        entity.type = info.name;
        entity.params = params;
        MakeCamera(entity, {20, 10});
    });
}

// Shapes whose parameters need no lists of points or files.
TEST(PluginTables, ShapesReadTheirParameters) {
    ExpectAllRead(ShapePlugins(), [](const PluginInfo &info, const ParamSet &params) {
        if (info.FindParam("P") || info.FindParam("Pz") || info.FindParam("filename"))
            return;
        SceneDescription description;
        description.materials.emplace_back().type = "matte";
        ShapeEntity &shape = description.shapes.emplace_back();
        shape.type = info.name;
        shape.params = params;
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
