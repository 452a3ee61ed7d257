// Scenes as text, for the tests of the parser, and what it says of them.
#pragma once

#include "parser/plugins.h"
#include "parser/scene_description.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>

namespace cuticle {

// The parser knows names only from the tables that it is handed. These are as small as its tests allow.
inline const PluginTables &TestPlugins() {
    constexpr auto named = [](std::string_view name) { return ParamInfo{name, "float", "", "", ""}; };
    static constexpr ParamInfo kHair[] = {named("eumelanin"), named("beta_m"),    named("alpha"),
                                          named("model"),     named("azimuth_R"), named("roughness_u")};
    static constexpr ParamInfo kMesh[] = {named("filename"), named("alpha")};
    static const PluginTable camera{
        PluginKind::Camera, {{.name = "perspective"}, {.name = "orthographic"}}, {"spherical"}};
    static const PluginTable sampler{
        PluginKind::Sampler, {{.name = "halton"}, {.name = "random"}}, {"zsobol"}, {"bestcandidate"}};
    static const PluginTable film{PluginKind::Film, {{.name = "image"}}, {"rgb", "gbuffer"}};
    static const PluginTable integrator{
        PluginKind::Integrator, {{.name = "path"}, {.name = "bdpt", .standIn = "path"}}, {"randomwalk"}};
    static const PluginTable accelerator{
        PluginKind::Accelerator, {{.name = "bvh"}, {.name = "kdtree"}}, {}, {"grid"}};
    static const PluginTable shape{PluginKind::Shape,
                                   {{.name = "curve"},
                                    {.name = "sphere"},
                                    {.name = "disk"},
                                    {.name = "cylinder"},
                                    {.name = "plymesh", .params = kMesh}},
                                   {"bilinearmesh"}};
    static const PluginTable material{PluginKind::Material,
                                      {{.name = "hair", .params = kHair},
                                       {.name = "matte"},
                                       {.name = "plastic"},
                                       {.name = "mirror"},
                                       {.name = "glass"},
                                       {.name = "metal"},
                                       {.name = "mix"},
                                       {.name = ""},
                                       {.name = "none"}},
                                      {"coateddiffuse", "conductor", "dielectric", "diffuse"},
                                      {"shinymetal"}};
    static const PluginTable texture{PluginKind::Texture,
                                     {{.name = "constant"}, {.name = "scale"}, {.name = "imagemap"}}};
    static const PluginTable medium{PluginKind::Medium, {{.name = "homogeneous"}}, {"nanovdb"}};
    static const PluginTables tables{&camera, &sampler,  &film,    &integrator, &accelerator,
                                     &shape,  &material, &texture, &medium};
    return tables;
}

inline const std::string kData = std::string(CUTICLE_SOURCE_DIR) + "/tests/parser/data";

inline std::string World(const std::string &body) { return "WorldBegin\n" + body + "\nWorldEnd\n"; }

inline SceneDescription Parse(const std::string &text, const ParseOptions &options = {}) {
    return ParseSceneText(TestPlugins(), text, "test.pbrt", kData, options);
}

// The message that parsing ends with; "" when there is none.
inline std::string ErrorOf(const std::string &text) {
    try {
        Parse(text);
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

// The first warning, which strict mode turns into an Error; "" when there is none.
inline std::string WarningOf(const std::string &text) {
    const StrictWarnings strict;
    return ErrorOf(text);
}

inline bool Has(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

inline Point3f ImageOf(const Transform &t, const Point3f &p) { return t.Point(p); }

inline void ExpectNear(const Point3f &a, const Point3f &b, float bound) {
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(a[i], b[i], bound) << "coordinate " << i;
}

// A folder of this process's own, removed at the end.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "cuticle_parser_XXXXXX").string();
        if (!mkdtemp(name.data()))
            throw std::runtime_error("no temporary folder");
        path_ = name;
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    std::string Write(const std::string &name, const std::string &content) const {
        const std::string path = path_ + "/" + name;
        std::ofstream(path, std::ios::binary) << content;
        return path;
    }
    const std::string &Path() const { return path_; }

  private:
    std::string path_;
};

} // namespace cuticle
