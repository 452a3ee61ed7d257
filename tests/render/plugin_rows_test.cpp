// The manual cannot drift from the program: the parameters in a plug-in's row are those that its maker reads.
#include "materials/hair_models.h"
#include "parser/manual.h"
#include "render/film.h"
#include "render/filter.h"
#include "render/integrator.h"
#include "render/plugins.h"
#include "render/sampler.h"
#include "scene/camera.h"
#include "scene/scene.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>

namespace cuticle {
namespace {

using Names = std::set<std::string, std::less<>>;

constexpr char kNoFile[] = "plugin_rows_test.none";

// The smallest files that a plug-in reads, for those that read nothing more before they have one.
class SmallFiles {
  public:
    SmallFiles() {
        Write("image.pfm", std::string("Pf\n1 1\n-1\n") + std::string(4, '\0'));
        Write("mesh.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
              "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
              "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
        Write("strands.usda",
              "#usda 1.0\ndef BasisCurves \"hair\"\n{\n    uniform token type = \"linear\"\n"
              "    int[] curveVertexCounts = [2]\n    point3f[] points = [(0, 0, 0), (0, 0, 1)]\n"
              "    float[] widths = [0.1, 0.1]\n}\n");
    }
    ~SmallFiles() { std::filesystem::remove_all(folder_); }
    std::string Named(const char *name) const {
        return fmt::format("\"string filename\" \"{}\" ", (folder_ / name).string());
    }

  private:
    void Write(const char *name, const std::string &content) const {
        std::filesystem::create_directories(folder_);
        std::ofstream(folder_ / name, std::ios::binary) << content;
    }
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / fmt::format("plugin_rows_{}", getpid());
};
constexpr uint32_t kLine = 2; // of the plug-in under test

// A scene in which the plug-in stands alone on line 2, with what it cannot do without.
std::string SceneOf(PluginKind kind, std::string_view name, const std::string &parameters) {
    const std::string directive =
        fmt::format("\n{} {}\"{}\" {}\n", DirectiveOf(kind),
                    kind == PluginKind::Texture ? "\"t\" \"CLASS\" " : "", name, parameters);
    const std::string sphere = "Shape \"sphere\" WorldEnd";
    switch (kind) {
    case PluginKind::Film:
    case PluginKind::Camera:
    case PluginKind::Sampler:
    case PluginKind::Filter:
    case PluginKind::Integrator:
    case PluginKind::Accelerator:
        return directive + "WorldBegin " + sphere;
    case PluginKind::Material:
        return "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"matte\"" + directive + sphere;
    case PluginKind::Shape:
        return "WorldBegin" + directive + "WorldEnd";
    default:
        return "WorldBegin" + directive + sphere;
    }
}

// Parameters without which the maker would stop before it has read the others.
std::string Needed(PluginKind kind, std::string_view name) {
    static const SmallFiles files;
    if (kind == PluginKind::Material && name == "mix")
        return "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"a\" ";
    if (kind == PluginKind::Texture && name == "imagemap")
        return files.Named("image.pfm");
    if (kind != PluginKind::Shape)
        return "";
    if (name == "trianglemesh" || name == "loopsubdiv")
        return "\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] ";
    if (name == "plymesh" || name == "hairfile")
        return files.Named(name == "plymesh" ? "mesh.ply" : "strands.usda");
    if (name == "heightfield")
        return "\"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0] ";
    if (name == "curve")
        return "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 1 ";
    if (name == "groom")
        return "\"integer strands\" 1 ";
    return "";
}

// The names that are asked of the plug-in's parameters while a scene that holds it is made.
void Record(PluginKind kind, std::string text, Names *asked) {
    struct Silence : WarningSink {
        void Warn(const FileLoc &, const std::string &, const std::string &) override {}
    } silence;
    const WarningScope quiet(&silence);
    const ParamRecorder recorder;
    try {
        ParseOptions options;
        options.fastCurves = false;
        SceneDescription d = ParseSceneText(AllPlugins(), text, "scene.pbrt", ".", options);
        switch (kind) {
        case PluginKind::Film:
            Film(d.film, {});
            break;
        case PluginKind::Camera:
            MakeCamera(d.camera, {2, 2});
            break;
        case PluginKind::Sampler:
            MakeSampler(d.sampler);
            break;
        case PluginKind::Filter:
            MakeFilter(d.filter);
            break;
        case PluginKind::Integrator:
            MakeIntegrator(d.integrator, d.integrator.type);
            break;
        case PluginKind::Accelerator:
        case PluginKind::Medium:
            break;
        default:
            Scene(&d, SceneOptions());
        }
    } catch (const Error &) { // of a value that is not right: what was read until then counts
    }
    asked->insert(recorder.AskedOn(kLine).begin(), recorder.AskedOn(kLine).end());
}

// A parameter as a scene writes it, with each value that may decide what else is read.
std::vector<std::string> Written(const ParamInfo &p) {
    std::vector<std::string> written;
    const auto add = [&](std::string_view type, std::string_view value) {
        written.push_back(fmt::format("\"{} {}\" {} ", type, p.name, value));
    };
    const std::string_view type = p.type;
    double number = 1;
    const char *const end = p.defaultValue.data() + p.defaultValue.size();
    if (p.defaultValue.empty() || std::from_chars(p.defaultValue.data(), end, number).ec != std::errc())
        number = std::clamp(1., p.low, p.high);
    if (type.starts_with("spectrum"))
        add("rgb", "[.5 .5 .5]");
    else if (type == "floats")
        add("float", "[0 1 0 1]");
    else if (type.starts_with("float"))
        add("float", fmt::format("{}", number));
    else if (type == "integers")
        add("integer", "[0 1 2]");
    else if (type == "integer")
        add("integer", fmt::format("{}", static_cast<int>(number)));
    else if (type == "bool")
        for (const char *value : {"\"true\"", "\"false\""})
            add("bool", value);
    else if (type == "string" && p.choices.empty())
        add("string", fmt::format("\"{}\"", kNoFile));
    else if (type == "string")
        for (const std::string_view choice : p.choices)
            add("string", fmt::format("\"{}\"", choice));
    else if (type.starts_with("point2"))
        add("point2", "[0 0 1 0 0 1]");
    else if (type.starts_with("point3"))
        add("point", type == "point3" ? "[1 1 1]" : "[0 0 0 1 0 0 0 1 0]");
    else if (type.starts_with("normal"))
        add("normal", "[0 0 1 0 0 1 0 0 1]");
    else if (type.starts_with("vector3"))
        add("vector", type == "vector3" ? "[1 1 1]" : "[1 0 0 1 0 0 1 0 0]");
    else
        ADD_FAILURE() << p.name << " is of type " << type << ", which this test cannot write";
    return written;
}

// All names that the maker asks for, with no parameter given, and with each alone.
Names AskedBy(PluginKind kind, const PluginInfo &row) {
    std::vector<std::string> beginnings{Needed(kind, row.name)};
    if (kind == PluginKind::Material && row.name == "hair")
        for (const std::string_view model : HairModelNames()) // the least that a table of rays is made of
            beginnings.push_back(fmt::format("\"string model\" \"{}\" {}", model,
                                             model == "tabulated" ? "\"integer samples\" 1 " : ""));
    Names asked;
    const auto record = [&](const std::string &parameters) {
        const std::string text = SceneOf(kind, row.name, parameters);
        if (kind != PluginKind::Texture)
            return Record(kind, text, &asked);
        for (const char *type : {"float", "spectrum"})
            Record(kind, std::string(text).replace(text.find("CLASS"), 5, type), &asked);
    };
    for (const std::string &beginning : beginnings) {
        record(beginning);
        for (const ParamInfo &p : row.params)
            for (const std::string &parameter : Written(p))
                record(beginning + parameter);
    }
    return asked;
}

TEST(PluginRows, NameWhatTheMakersReadAndNothingElse) {
    for (size_t k = 0; k < kPluginKinds; ++k) {
        const auto kind = static_cast<PluginKind>(k);
        for (const PluginInfo &row : AllPlugins().Find(kind)->rows) {
            if (!row.standIn.empty() && row.params.empty())
                continue;
            if (kind == PluginKind::Accelerator) // none is made: pbrt's parameters have no effect
                continue;
            const Names asked = AskedBy(kind, row);
            for (const ParamInfo &p : row.params)
                EXPECT_TRUE(asked.count(p.name))
                    << DirectiveOf(kind) << " \"" << row.name << "\" does not read \"" << p.name << "\"";
            if (!row.standIn.empty()) // of which the row names pbrt's parameters alone
                continue;
            for (const std::string &name : asked)
                EXPECT_TRUE(row.FindParam(name)) << DirectiveOf(kind) << " \"" << row.name << "\" reads \""
                                                 << name << "\", which its row does not name";
        }
    }
}

TEST(PluginRows, AreWholeAndFitTheManual) {
    for (size_t k = 0; k < kPluginKinds; ++k) {
        const auto kind = static_cast<PluginKind>(k);
        for (const PluginInfo &row : AllPlugins().Find(kind)->rows) {
            EXPECT_FALSE(row.meaning.empty()) << DirectiveOf(kind) << " \"" << row.name << "\"";
            Names names;
            for (const ParamInfo &p : row.params) {
                EXPECT_TRUE(names.emplace(p.name).second) << p.name << " stands twice in " << row.name;
                EXPECT_FALSE(p.type.empty() || p.meaning.empty()) << row.name << " " << p.name;
                EXPECT_LE(p.low, p.high) << row.name << " " << p.name;
                for (const std::string_view text : {p.name, p.type, p.unit, p.defaultValue, p.meaning})
                    EXPECT_EQ(text.find_first_of("|\n"), text.npos) << row.name << " " << p.name;
            }
            const std::string manual = PluginManual(AllPlugins(), DirectiveOf(kind), row.name);
            for (const ParamInfo &p : row.params)
                EXPECT_NE(manual.find(fmt::format("| `{}` | {} |", p.name, p.type)), manual.npos) << manual;
        }
    }
}

// A hair parameter on a shape is the material's, whichever model reads it: pbrt-v3's rule for materials.
TEST(PluginRows, EveryHairParameterWorksOnAShape) {
    const PluginInfo *hair = MaterialPlugins().Find("hair");
    ASSERT_NE(hair, nullptr);
    for (const char *name : {"eccentricity", "azimuth_R", "roughness_u", "exponent", "lobes", "roots", "Kd"})
        EXPECT_NE(hair->FindParam(name), nullptr) << name;
    for (const ParamInfo &p : hair->params) {
        const std::string written = Written(p).front();
        const SceneDescription s = ParseSceneText(
            AllPlugins(),
            "WorldBegin Material \"hair\" Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] " + written +
                " WorldEnd",
            "scene.pbrt");
        const auto group = static_cast<size_t>(s.curves.segments.at(0).group);
        const auto material = static_cast<size_t>(s.curveGroups.at(group).state.material);
        EXPECT_NE(s.materials.at(material).params.Find(p.name), nullptr) << written;
        EXPECT_EQ(s.materials.at(material).type, "hair");
        EXPECT_EQ(FlushWarnings(), 0u) << written;
    }
}

// A shape's parameters are looked for in its material too: one name must not mean two things. The alpha of a
// mesh is the one exception, which the parser knows.
TEST(PluginRows, ShapesAndMaterialsShareNoName) {
    for (const PluginInfo &material : MaterialPlugins().rows)
        for (const ParamInfo &p : material.params)
            for (const PluginInfo &shape : AllPlugins().Find(PluginKind::Shape)->rows)
                EXPECT_TRUE(p.name == "alpha" || !shape.FindParam(p.name))
                    << "Material \"" << material.name << "\" and Shape \"" << shape.name << "\" both have \""
                    << p.name << "\"";
}

} // namespace
} // namespace cuticle
