#include "materials/material.h"
#include "parser/lexer.h"
#include "parser/parser.h"
#include "parser/scene_description.h"
#include "parser/spd_file.h"
#include "render/plugins.h"
#include "shapes/curve.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>

namespace cuticle {
namespace {

const std::string kData = std::string(CUTICLE_SOURCE_DIR) + "/tests/parser/data";

std::string World(const std::string &body) { return "WorldBegin\n" + body + "\nWorldEnd\n"; }

SceneDescription Parse(const std::string &text) {
    return ParseSceneText(AllPlugins(), text, "test.pbrt", kData);
}

// The message that parsing ends with; "" when there is none.
std::string ErrorOf(const std::string &text) {
    try {
        Parse(text);
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

// The first warning, which strict mode turns into an Error; "" when there is none.
std::string WarningOf(const std::string &text) {
    const StrictWarnings strict;
    const std::string message = ErrorOf(text);

    return message;
}

bool Has(const std::string &text, const std::string &part) { return text.find(part) != std::string::npos; }

Point3f ImageOf(const Transform &t, const Point3f &p) { return t.Point(p); }

void ExpectNear(const Point3f &a, const Point3f &b, float bound) {
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

std::string Gzip(const std::string &text) {
    z_stream z{};
    deflateInit2(&z, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&z, static_cast<uLong>(text.size())) + 64, '\0');
    z.next_in = reinterpret_cast<Bytef *>(const_cast<char *>(text.data()));
    z.avail_in = static_cast<uInt>(text.size());
    z.next_out = reinterpret_cast<Bytef *>(out.data());
    z.avail_out = static_cast<uInt>(out.size());
    deflate(&z, Z_FINISH);
    out.resize(z.total_out);
    deflateEnd(&z);
    return out;
}

// --- numbers and tokens --------------------------------------------------------------------------------------------

TEST(ScanNumber, RoundsLikeStrtod) {
    std::mt19937_64 random(1);
    char text[64];
    for (int i = 0; i < 200000; ++i) {
        const double mantissa = static_cast<double>(static_cast<int64_t>(random())) / 9.3e18;
        const int exponent = static_cast<int>(random() % 80) - 40, digits = static_cast<int>(random() % 20);
        static constexpr const char *kFormats[] = {"%.*f", "%.*e", "%.*g", "%+.*f"};
        const bool fixed = i % 4 == 0 || i % 4 == 3;
        const int n = std::snprintf(text, sizeof text, kFormats[i % 4], digits,
                                    fixed ? mantissa * 1000 : mantissa * std::pow(10, exponent));
        double v = 0;
        const char *after = ScanNumber(text, text + n, &v);
        ASSERT_EQ(after, text + n) << text;
        const double expected = std::strtod(text, nullptr);
        ASSERT_EQ(std::memcmp(&v, &expected, sizeof v), 0) << text;
    }
}

TEST(ScanNumber, FormsOfRealFiles) {
    const std::pair<const char *, double> forms[] = {
        {".5", 0.5},           {"5.", 5},  {"-.25", -0.25}, {"1e+006", 1e6}, {"+3", 3},
        {"1E-3", 1e-3},        {"007", 7}, {"-1.e2", -100}, {"1e-999", 0},   {"0.1e1", 1},
        {"16777217", 16777217}};
    for (const auto &[text, value] : forms) {
        double v = -1;
        EXPECT_EQ(ScanNumber(text, text + std::strlen(text), &v), text + std::strlen(text)) << text;
        EXPECT_EQ(v, value) << text;
    }
    double zero = 1;
    ScanNumber("-0", nullptr, &zero);
    EXPECT_EQ(zero, 0);
    EXPECT_TRUE(std::signbit(zero));
    for (const char *text : {"", ".", "-", "+", "e5", "-.e5", "nan", "inf", "-inf", "[", "x"})
        EXPECT_EQ(ScanNumber(text, text + std::strlen(text), &zero), nullptr) << text;
}

TEST(Lexer, KnowsLineAndColumnInAnyOrder) {
    const std::string text = "a bb\r\n  \"c\"\n\n# x\n\t12]";
    Lexer lexer(TextSource::FromText(text, "t"));
    std::vector<Token> tokens;
    while (tokens.empty() || tokens.back().kind != Token::Kind::End)
        tokens.push_back(lexer.Next());
    ASSERT_EQ(tokens.size(), 6u);
    const uint32_t lines[] = {1, 1, 2, 5, 5, 5}, columns[] = {1, 3, 3, 2, 4, 5};
    for (int i : {0, 5, 2, 1, 4, 3, 0}) {
        const FileLoc loc = lexer.Loc(tokens[static_cast<size_t>(i)].begin);
        EXPECT_EQ(loc.line, lines[i]) << i;
        EXPECT_EQ(loc.column, columns[i]) << i;
    }
    EXPECT_EQ(tokens[2].text, "c");
    EXPECT_EQ(tokens[3].number, 12);
}

// --- options -----------------------------------------------------------------------------------------------------------

TEST(Parser, OptionsInAnyOrderTheLastWins) {
    const auto s =
        Parse("Film \"image\" \"integer xresolution\" [ 7 ]\n"
              "Sampler \"halton\"\nIntegrator \"bdpt\"\nSampler \"random\" \"integer pixelsamples\" 3\n"
              "PixelFilter \"gaussian\" \"float alpha\" 2\nAccelerator \"kdtree\"\nIntegrator \"path\"\n"
              "Camera \"orthographic\"\n"
              "Film \"image\" \"integer yresolution\" 9\n" +
              World(""));
    EXPECT_EQ(s.sampler.type, "random");
    EXPECT_EQ(s.sampler.params.FindInt("pixelsamples", 0), 3);
    EXPECT_EQ(s.integrator.type, "path");
    EXPECT_EQ(s.filter.type, "gaussian");
    EXPECT_EQ(s.accelerator.type, "kdtree");
    EXPECT_EQ(s.camera.type, "orthographic");
    EXPECT_EQ(s.film.params.FindInt("xresolution", -1), -1); // the later Film replaces the whole
    EXPECT_EQ(s.film.params.FindInt("yresolution", -1), 9);
}

TEST(Parser, DefaultsArePbrtV3s) {
    const auto s = Parse(World("Shape \"sphere\""));
    EXPECT_EQ(s.camera.type, "perspective");
    EXPECT_EQ(s.sampler.type, "halton");
    EXPECT_EQ(s.film.type, "image");
    EXPECT_EQ(s.filter.type, "box");
    EXPECT_EQ(s.integrator.type, "path");
    EXPECT_EQ(s.accelerator.type, "bvh");
    ASSERT_EQ(s.shapes.size(), 1u);
    EXPECT_EQ(s.materials[static_cast<size_t>(s.shapes[0].state.material)].type, "matte");
    EXPECT_EQ(s.shapes[0].state.areaLight, -1);
    EXPECT_FALSE(s.shapes[0].state.reverseOrientation);
}

TEST(Parser, CameraHasTheTransformationBeforeItAndTheWorldStartsAfresh) {
    const auto s = Parse("Scale -1 1 1\nLookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\"\n"
                         "Translate 9 9 9\n" +
                         World("CoordSysTransform \"camera\"\nShape \"sphere\"\nCoordSysTransform \"world\"\n"
                               "Shape \"sphere\""));
    ExpectNear(ImageOf(s.camera.ctm, {0, 0, 5}), {0, 0, 0}, 1e-6f);
    ExpectNear(ImageOf(s.camera.ctm, {0, 0, 0}), {0, 0, 5}, 1e-6f);
    ExpectNear(ImageOf(s.shapes[0].objectToWorld, {0, 0, 0}), {0, 0, 5}, 1e-6f); // where the camera stands
    EXPECT_TRUE(s.shapes[1].objectToWorld.IsIdentity());
}

TEST(Parser, OptionAfterWorldBeginIsIgnoredWithAWarning) {
    const std::string text = World("Integrator \"bdpt\"");
    EXPECT_EQ(Parse(text).integrator.type, "path");
    EXPECT_TRUE(Has(WarningOf(text), "test.pbrt:2:1: error: Integrator has no effect after WorldBegin"));
}

// --- transformations -------------------------------------------------------------------------------------------------

Point3f Moved(const std::string &directives, const Point3f &p) {
    return ImageOf(Parse(World(directives + " Shape \"sphere\"")).shapes.at(0).objectToWorld, p);
}

TEST(Parser, Transformations) {
    ExpectNear(Moved("Translate 1 2 3", {1, 1, 1}), {2, 3, 4}, 0);
    ExpectNear(Moved("Scale 2 3 4", {1, 1, 1}), {2, 3, 4}, 0);
    ExpectNear(Moved("Rotate 90 0 0 2", {1, 0, 0}), {0, 1, 0}, 1e-6f);
    ExpectNear(Moved("Translate 1 0 0 Scale 2 2 2", {1, 0, 0}), {3, 0, 0}, 0); // the later applies first
    ExpectNear(Moved("Scale 2 2 2 Identity", {1, 0, 0}), {1, 0, 0}, 0);
    // A matrix is written column after column: the translation comes last.
    const std::string matrix = "[ 1 0 0 0  0 2 0 0  0 0 3 0  5 6 7 1 ]";
    ExpectNear(Moved("Translate 100 0 0 Transform " + matrix, {1, 1, 1}), {6, 8, 10}, 0);
    ExpectNear(Moved("Translate 100 0 0 ConcatTransform " + matrix, {1, 1, 1}), {106, 8, 10}, 0);
    ExpectNear(
        Moved("Translate 1 0 0 CoordinateSystem \"here\" Identity CoordSysTransform \"here\"", {0, 0, 0}),
        {1, 0, 0}, 0);
    ExpectNear(Moved("TransformTimes 0 1", {1, 0, 0}), {1, 0, 0}, 0);
}

TEST(Parser, BlocksRestoreWhatTheyShould) {
    const auto s =
        Parse(World("TransformBegin Translate 1 0 0 Material \"mirror\" ReverseOrientation TransformEnd\n"
                    "Shape \"sphere\"\n"
                    "AttributeBegin Translate 1 0 0 Material \"glass\" ReverseOrientation\n"
                    "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] Shape \"sphere\" AttributeEnd\n"
                    "Shape \"sphere\""));
    ASSERT_EQ(s.shapes.size(), 3u);
    const auto material = [&](size_t i) {
        return s.materials[static_cast<size_t>(s.shapes[i].state.material)].type;
    };
    // A transform block keeps the rest of the state, an attribute block restores all of it.
    EXPECT_TRUE(s.shapes[0].objectToWorld.IsIdentity());
    EXPECT_EQ(material(0), "mirror");
    EXPECT_TRUE(s.shapes[0].state.reverseOrientation);
    EXPECT_EQ(material(1), "glass");
    EXPECT_FALSE(s.shapes[1].state.reverseOrientation);
    EXPECT_EQ(s.shapes[1].state.areaLight, 0);
    EXPECT_EQ(s.areaLights.at(0).params.FindSpectrum("L", Spectrum(0)), Spectrum(1, 2, 3));
    EXPECT_EQ(s.shapes[2].state, s.shapes[0].state);
    EXPECT_TRUE(s.shapes[2].objectToWorld.IsIdentity());
}

TEST(Parser, MotionKeepsTheStartAndWarnsOnce) {
    const std::string text =
        World("ActiveTransform EndTime Translate 5 0 0\nActiveTransform StartTime Translate 1 0 0\n"
              "ActiveTransform All Scale 2 2 2\nShape \"sphere\"\nShape \"sphere\"");
    FlushWarnings();
    const auto s = Parse(text);
    EXPECT_EQ(FlushWarnings(), 2u);
    ExpectNear(ImageOf(s.shapes[0].objectToWorld, {1, 0, 0}), {3, 0, 0}, 0);
    EXPECT_TRUE(Has(WarningOf(text), "motion is not rendered"));
    EXPECT_EQ(WarningOf(World(
                  "ActiveTransform EndTime Translate 5 0 0 Identity ActiveTransform All Shape \"sphere\"")),
              "");
}

// --- parameters --------------------------------------------------------------------------------------------------------

const Param &Only(const SceneDescription &s) { return s.shapes.at(0).params.params.at(0); }

TEST(Parser, EveryParameterType) {
    const auto s = Parse(
        World("Shape \"sphere\" \"integer a\" [1 -2] \"float b\" [.5 5. 1e+006] \"point2 c\" [1 2]\n"
              "\"vector2 d\" [1 2] \"point e\" [1 2 3] \"point3 f\" [1 2 3] \"vector g\" [1 2 3]\n"
              "\"vector3 h\" [1 2 3] \"normal i\" [1 2 3] \"string j\" [\"x\" \"y\"] \"bool k\" \"true\"\n"
              "\"rgb l\" [1 2 3 4 5 6] \"color m\" [1 2 3] \"xyz n\" [1 1 1] \"blackbody o\" [5000 2]\n"
              "\"spectrum p\" [400 1 700 1] \"float q\" [ ]"));
    const ParamType types[] = {ParamType::Integer,  ParamType::Float,    ParamType::Point2,
                               ParamType::Vector2,  ParamType::Point3,   ParamType::Point3,
                               ParamType::Vector3,  ParamType::Vector3,  ParamType::Normal,
                               ParamType::String,   ParamType::Bool,     ParamType::Spectrum,
                               ParamType::Spectrum, ParamType::Spectrum, ParamType::Spectrum,
                               ParamType::Spectrum, ParamType::Float};
    const size_t counts[] = {2, 3, 2, 2, 3, 3, 3, 3, 3, 0, 0, 6, 3, 3, 3, 3, 0};
    const auto &params = s.shapes.at(0).params.params;
    ASSERT_EQ(params.size(), std::size(types));
    for (size_t i = 0; i < params.size(); ++i) {
        EXPECT_EQ(params[i].type, types[i]) << params[i].name;
        EXPECT_EQ(params[i].numbers.size(), counts[i]) << params[i].name;
        EXPECT_EQ(params[i].name, std::string(1, static_cast<char>('a' + i)));
    }
    EXPECT_EQ(params[1].numbers, (std::vector<double>{0.5, 5, 1e6}));
    EXPECT_EQ(params[9].strings, (std::vector<std::string>{"x", "y"}));
    EXPECT_EQ(params[10].bools, std::vector<bool>{true});
    EXPECT_EQ(params[11].numbers, (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST(Parser, ParameterSpellingsOfRealFiles) {
    const char *spellings[] = {"\"float radius\" [ 2.5 ]",     "\"float radius\" 2.5",
                               "\"float radius\"[2.5]",        "\"float\tradius\" 2.5",
                               "\" float radius\" 2.5",        "\"float   radius \" 2.5",
                               "\"float radius\"\r\n2.5\r\n",  "# c\n\"float radius\" # d\n 2.5",
                               "\"float radius\" [ # e\n2.5]", "\"float radius\" +2.5",
                               "\"float radius\" 25e-1",       "\"float radius\" # ]\r2.5"};
    for (const char *spelling : spellings)
        EXPECT_EQ(Parse(World("Shape \"sphere\"\n# between\n" + std::string(spelling)))
                      .shapes.at(0)
                      .params.FindFloat("radius", 0),
                  2.5f)
            << spelling;
    for (const char *spelling : {"\"true\"", "[\"true\"]", "true", "[ true ]"})
        EXPECT_TRUE(Parse(World("Shape \"sphere\" \"bool b\" " + std::string(spelling)))
                        .shapes.at(0)
                        .params.FindBool("b", false))
            << spelling;
    EXPECT_TRUE(std::signbit(Only(Parse(World("Shape \"sphere\" \"float z\" -0"))).numbers.at(0)));
    EXPECT_EQ(
        Only(Parse("\xef\xbb\xbf" + World("Shape \"sphere\" \"string s\" \"a\\\"b\\\\c\\n\""))).strings.at(0),
        "a\"b\\c\n");
    EXPECT_EQ(Only(Parse(World("Shape \"sphere\" \"string s\" \"h\xc3\xa4r\""))).strings.at(0), "h\xc3\xa4r");
}

Spectrum ColorOf(const std::string &parameter) {
    return Parse(World("Shape \"sphere\" " + parameter)).shapes.at(0).params.FindSpectrum("c", Spectrum(-1));
}

TEST(Parser, SpectraBecomeLinearRGB) {
    EXPECT_EQ(ColorOf("\"rgb c\" [.1 .2 .3]"), Spectrum(.1f, .2f, .3f));
    EXPECT_EQ(ColorOf("\"color c\" [.1 .2 .3]"), Spectrum(.1f, .2f, .3f));
    EXPECT_EQ(ColorOf("\"xyz c\" [.3 .4 .5]"), XYZToRGB({.3, .4, .5}));
    EXPECT_EQ(ColorOf("\"blackbody c\" [3000 2.5]"), BlackbodyToRGB(3000, 2.5));
    EXPECT_EQ(ColorOf("\"spectrum c\" [400 1 500 .5 600 .25]"),
              SpectrumFromSamples({400, 500, 600}, {1, .5, .25}));
    EXPECT_EQ(ColorOf("\"spectrum c\" \"half.spd\""), ReadSPD(kData + "/half.spd"));
    // A flat spectrum of 0.5 has luminance 0.5 (Y is divided by the integral of Y-bar); float rounding only.
    EXPECT_NEAR(ColorOf("\"spectrum c\" [\"half.spd\"]").y(), 0.5, 1e-4);
    const auto s = Parse(
        World("Shape \"sphere\" \"blackbody c\" [3000 1 6000 2] \"spectrum d\" [\"half.spd\" \"half.spd\"]"));
    EXPECT_EQ(s.shapes[0].params.params[0].numbers.size(), 6u);
    EXPECT_EQ(s.shapes[0].params.params[1].numbers.size(), 6u);
}

TEST(Parser, ParameterGivenTwice) {
    const std::string text = World("Shape \"sphere\" \"float radius\" 1\n\"float radius\" 2");
    EXPECT_EQ(Parse(text).shapes[0].params.FindFloat("radius", 0), 2);
    EXPECT_EQ(Parse(text).shapes[0].params.params.size(), 1u);
    EXPECT_TRUE(Has(WarningOf(text), "test.pbrt:3:1: error: parameter \"radius\" is given twice"));
}

// --- textures, materials, lights ---------------------------------------------------------------------------------------

TEST(Parser, TexturesAreBoundWhereTheyAreRead) {
    const auto s = Parse(
        World("Texture \"t\" \"float\" \"constant\" \"float value\" 1\n"
              "Material \"matte\" \"texture sigma\" \"t\"\n"
              "Texture \"t\" \"float\" \"constant\" \"float value\" 2\n"
              "Texture \"t\" \"color\" \"constant\" \"rgb value\" [1 0 0]\n"
              "Material \"matte\" \"texture sigma\" \"t\"\n"
              "AttributeBegin Texture \"t\" \"spectrum\" \"scale\" \"texture tex1\" \"t\" AttributeEnd\n"
              "Material \"mirror\" \"texture Kr\" \"t\"\n"));
    ASSERT_EQ(s.floatTextures.size(), 2u);
    ASSERT_EQ(s.spectrumTextures.size(), 2u);
    ASSERT_EQ(s.materials.size(), 4u);
    const auto bound = [&](size_t m) { return s.materials[m].params.params.at(0); };
    EXPECT_EQ(bound(1).floatTexture, 0); // a later definition does not reach back
    EXPECT_EQ(bound(1).spectrumTexture, -1);
    EXPECT_EQ(bound(2).floatTexture, 1);
    EXPECT_EQ(bound(2).spectrumTexture, 0);
    // Inside its own definition the name still means the older one; outside of the block too.
    EXPECT_EQ(s.spectrumTextures[1].params.params.at(0).spectrumTexture, 0);
    EXPECT_EQ(bound(3).spectrumTexture, 0);
    EXPECT_EQ(s.spectrumTextures[1].type, "scale");
}

TEST(Parser, NamedMaterialsAreScoped) {
    const auto s =
        Parse(World("MakeNamedMaterial \"m\" \"string type\" \"mirror\"\n"
                    "AttributeBegin MakeNamedMaterial \"m\" \"string type\" [\"glass\"] NamedMaterial \"m\"\n"
                    "Shape \"sphere\" AttributeEnd\nNamedMaterial \"m\" Shape \"sphere\"\n"
                    "MakeNamedMaterial \"\" \"string type\" \"matte\" NamedMaterial \"\" Shape \"sphere\"\n"
                    "Material \"\" Shape \"sphere\" Material \"none\" Shape \"sphere\""));
    const auto material = [&](size_t i) {
        return s.materials[static_cast<size_t>(s.shapes.at(i).state.material)];
    };
    EXPECT_EQ(material(0).type, "glass");
    EXPECT_EQ(material(1).type, "mirror");
    EXPECT_EQ(material(1).name, "m");
    EXPECT_EQ(material(2).type, "matte");
    EXPECT_EQ(material(3).type, "");
    EXPECT_EQ(material(4).type, "none");
}

TEST(Parser, MixResolvesItsMaterialsWhereItIsMade) {
    const auto s =
        Parse(World("MakeNamedMaterial \"a\" \"string type\" \"mirror\"\n"
                    "MakeNamedMaterial \"b\" \"string type\" \"glass\"\n"
                    "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"\n"
                    "MakeNamedMaterial \"a\" \"string type\" \"matte\""));
    const MaterialEntity &mix = s.materials.at(3);
    ASSERT_EQ(mix.type, "mix");
    EXPECT_EQ(s.materials.at(static_cast<size_t>(mix.mixed[0])).type, "mirror");
    EXPECT_EQ(s.materials.at(static_cast<size_t>(mix.mixed[1])).type, "glass");
}

TEST(Parser, UnknownNamedMaterialKeepsTheCurrentOneAndWarns) {
    const std::string text = World(
        "MakeNamedMaterial \"chrome\" \"string type\" \"mirror\"\nNamedMaterial \"chrme\" Shape \"sphere\"");
    EXPECT_EQ(Parse(text).shapes[0].state.material, 0);
    const std::string warning = WarningOf(text);
    EXPECT_TRUE(Has(warning, "test.pbrt:3:15: error: no material \"chrme\"")) << warning;
    EXPECT_TRUE(Has(warning, "Did you mean \"chrome\"?")) << warning;
}

TEST(Parser, ShapeParametersOverrideTheMaterials) {
    std::string body = "Material \"hair\" \"float eumelanin\" 1.3 \"float beta_m\" .2\n";
    for (int i = 0; i < 100; ++i)
        body += "Shape \"sphere\" \"float radius\" " + std::to_string(i + 1) + " \"float eumelanin\" " +
                std::to_string(i % 2) + "\n";
    body += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float eumelanin\" 1 \"float alpha\" 5\n";
    body += "Shape \"plymesh\" \"string filename\" \"x.ply\" \"float alpha\" 0\n";
    const auto s = Parse(World(body));
    // matte, hair, and one copy for each of the three contents, not one for each shape.
    EXPECT_EQ(s.materials.size(), 5u);
    const auto material = [&](const ShapeState &state) {
        return s.materials.at(static_cast<size_t>(state.material));
    };
    EXPECT_EQ(material(s.shapes[0].state).params.FindFloat("eumelanin", -1), 0);
    EXPECT_EQ(material(s.shapes[1].state).params.FindFloat("eumelanin", -1), 1);
    EXPECT_EQ(material(s.shapes[1].state).params.FindFloat("beta_m", -1), .2f);
    EXPECT_EQ(s.shapes[2].state, s.shapes[0].state);
    const MaterialEntity curve = material(s.curveGroups.at(s.curves.segments.at(0).group).state);
    EXPECT_EQ(curve.params.FindFloat("alpha", -1), 5);
    EXPECT_EQ(curve.params.FindFloat("eumelanin", -1), 1);
    // A mesh's alpha is its mask.
    EXPECT_EQ(material(s.shapes.at(100).state).type, "hair");
    EXPECT_EQ(material(s.shapes.at(100).state).params.FindFloat("alpha", -1), -1);
    EXPECT_EQ(s.shapes.at(100).params.FindFloat("alpha", -1), 0);
}

TEST(Parser, EqualMaterialsAreKeptOnce) {
    std::string body;
    for (int i = 0; i < 50; ++i)
        body += "Material \"hair\" \"float eumelanin\" 1.3\nShape \"sphere\"\n";
    EXPECT_EQ(Parse(World(body)).materials.size(), 2u);
}

TEST(Parser, LightsAndMedia) {
    const auto s =
        Parse("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"fog\"\n" +
              World("Translate 1 2 3 LightSource \"point\" \"rgb I\" [1 1 1]\nMediumInterface \"fog\"\n"
                    "LightSource \"infinite\" \"string mapname\" \"sky.exr\""));
    ASSERT_EQ(s.lights.size(), 2u);
    ExpectNear(ImageOf(s.lights[0].ctm, {0, 0, 0}), {1, 2, 3}, 0);
    EXPECT_EQ(s.lights[1].params.FindFilename("mapname"), kData + "/sky.exr");
    EXPECT_TRUE(
        Has(WarningOf("MediumInterface \"\" \"fog\"\n" + World("")), "participating media are not rendered"));
    // Made and named: one line
    FlushWarnings();
    testing::internal::CaptureStderr();
    Parse("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n" +
          World("MediumInterface \"fog\" \"\""));
    FlushWarnings();
    const std::string fog = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(Has(fog, "test.pbrt:1:1: warning: participating media")) << fog;
    EXPECT_EQ(std::count(fog.begin(), fog.end(), '\n'), 1) << fog;
}

// --- objects -------------------------------------------------------------------------------------------------------------

TEST(Parser, ObjectsAndInstances) {
    const auto s =
        Parse(World("Translate 0 0 1\nObjectBegin \"o\"\nTranslate 1 0 0\nShape \"sphere\"\n"
                    "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\nObjectEnd\n"
                    "Scale 2 2 2 ObjectInstance \"o\"\nObjectBegin \"o\" Shape \"disk\" ObjectEnd\n"
                    "ObjectInstance \"o\" Shape \"cylinder\""));
    ASSERT_EQ(s.objects.size(), 2u);
    ASSERT_EQ(s.instances.size(), 2u);
    EXPECT_EQ(s.shapes.size(), 1u);
    EXPECT_TRUE(s.curves.segments.empty());
    EXPECT_EQ(s.instances[0].object, 0);
    EXPECT_EQ(s.instances[1].object, 1); // the newer definition of the name
    EXPECT_EQ(s.objects[0].name, "o");
    EXPECT_EQ(s.objects[0].loc.line, 3u);
    ExpectNear(ImageOf(s.objects[0].shapes.at(0).objectToWorld, {0, 0, 0}), {1, 0, 1}, 0);
    ExpectNear(s.objects[0].curves.segments.at(0).cp[3], {4, 0, 1}, 0);
    ExpectNear(ImageOf(s.instances[0].instanceToWorld, {1, 0, 0}), {2, 0, 1}, 0);
    EXPECT_EQ(s.shapes[0].objectToWorld, s.instances[1].instanceToWorld); // ObjectEnd restores
}

// pbrt-v3 does not have them either.
TEST(Parser, AreaLightsInObjectsAreOneWarning) {
    const std::string text = World("ObjectBegin \"o\" AreaLightSource \"area\" Shape \"sphere\"\n"
                                   "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\nObjectEnd\n"
                                   "AreaLightSource \"diffuse\" Shape \"sphere\" ObjectInstance \"o\"");
    const std::string warning = WarningOf(text);
    EXPECT_TRUE(Has(warning, "an area light on a shape of an object definition is not rendered")) << warning;
    const auto s = Parse(text);
    EXPECT_EQ(s.objects.at(0).shapes.at(0).state.areaLight, -1);
    EXPECT_EQ(s.shapes.at(0).state.areaLight, 1);
}

// --- files ------------------------------------------------------------------------------------------------------------------

TEST(Parser, IncludesAreRelativeToTheTopFile) {
    const auto s = ParseScene(AllPlugins(), kData + "/include_top.pbrt");
    ASSERT_EQ(s.shapes.size(), 3u);
    const float radii[] = {1, 2, 3};
    for (size_t i = 0; i < 3; ++i)
        EXPECT_EQ(s.shapes[i].params.FindFloat("radius", 0), radii[i]);
    ExpectNear(ImageOf(s.shapes[1].objectToWorld, {1, 0, 0}), {3, 0, 0}, 0); // the leaf's Scale goes on
    EXPECT_TRUE(s.shapes[2].objectToWorld.IsIdentity());
    EXPECT_EQ(*s.shapes[0].params.loc.file, kData + "/parts/leaf.pbrt");
    EXPECT_EQ(s.shapes[0].params.loc.line, 2u);
    EXPECT_EQ(s.shapes[2].params.loc.line, 5u);
    EXPECT_EQ(s.filename, kData + "/include_top.pbrt");
}

TEST(Parser, ErrorInAnIncludeNamesThatFile) {
    EXPECT_EQ(ErrorOf(World("Include \"parts/broken.pbrt\"")),
              kData +
                  "/parts/broken.pbrt:2:18: error: expected the value of \"float radius\", found \"oops\"\n"
                  "      \"float radius\" oops\n    " +
                  std::string(17, ' ') + "^");
}

TEST(Parser, MissingIncludeIsAnErrorWithItsPlace) {
    const std::string text =
        World("AttributeBegin\n  Include \"nowhere.pbrt\"\nNamedMaterial \"from there\"\n"
              "Material \"matte\" \"texture Kd\" \"also\" ObjectInstance \"too\" AttributeEnd");
    EXPECT_EQ(ErrorOf(text),
              "test.pbrt:3:11: error: cannot open \"" + kData +
                  "/nowhere.pbrt\": No such file or directory\n      Include \"nowhere.pbrt\"\n    " +
                  std::string(10, ' ') + "^");
    // What follows from it is not said again.
    std::vector<std::string> errors;
    ParseOptions options;
    options.collectErrors = &errors;
    ParseSceneText(AllPlugins(), text, "test.pbrt", kData, options);
    EXPECT_EQ(errors.size(), 1u);
}

TEST(Parser, IncludingItselfIsSeen) {
    EXPECT_THROW(ParseScene(AllPlugins(), kData + "/loop_a.pbrt"), Error);
    try {
        ParseScene(AllPlugins(), kData + "/loop_a.pbrt");
    } catch (const Error &e) {
        EXPECT_TRUE(Has(e.what(), kData + "/loop_b.pbrt:2:11: error: ")) << e.what();
        EXPECT_TRUE(Has(e.what(), "includes itself by way of other files")) << e.what();
    }
}

TEST(Parser, IncludesHaveALimitInDepthAndInNumber) {
    const TemporaryFolder folder;
    for (int i = 0; i < 80; ++i)
        folder.Write("f" + std::to_string(i), "Include \"f" + std::to_string(i + 1) + "\"");
    // Each file includes the next one ten times: 10^20 in all, if nobody counts.
    for (int i = 0; i < 20; ++i) {
        std::string text;
        for (int k = 0; k < 10; ++k)
            text += "Include \"g" + std::to_string(i + 1) + "\"\n";
        folder.Write("g" + std::to_string(i), text);
    }
    folder.Write("g20", "");
    const auto error = [&](const std::string &first) -> std::string {
        try {
            ParseSceneText(AllPlugins(), World("Include \"" + first + "\""), "top.pbrt", folder.Path());
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    EXPECT_TRUE(Has(error("f0"), "too deep")) << error("f0");
    EXPECT_TRUE(Has(error("g0"), "too many"));
}

TEST(Parser, GzipIsKnownByItsContent) {
    const TemporaryFolder folder;
    std::string body;
    for (int i = 0; i < 20000; ++i)
        body += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + std::to_string(i) + " 0 0]\n";
    const std::string text = World(body), half = text.substr(0, text.size() / 2),
                      rest = text.substr(text.size() / 2);
    const auto plain = Parse(text);
    ASSERT_EQ(plain.curves.segments.size(), 20000u);
    for (const std::string &path :
         {folder.Write("a.pbrt.gz", Gzip(text)), folder.Write("b.pbrt", Gzip(text)),
          folder.Write("c.pbrt.gz", text),
          folder.Write("d.gz", Gzip(half) + Gzip(rest))}) { // members may follow one another
        const auto s = ParseScene(AllPlugins(), path);
        EXPECT_EQ(s.curves.segments.size(), plain.curves.segments.size()) << path;
        EXPECT_EQ(s.bytesRead, text.size()) << path;
        EXPECT_EQ(s.curves.segments.back().cp[3].x, 19999) << path;
    }
    folder.Write("inner.gz", Gzip("Shape \"sphere\"\n"));
    EXPECT_EQ(ParseSceneText(AllPlugins(), World("Include \"inner.gz\""), "t", folder.Path()).shapes.size(),
              1u);

    const auto error = [&](const std::string &content) -> std::string {
        try {
            ParseScene(AllPlugins(), folder.Write("bad.gz", content));
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    const std::string packed = Gzip(text);
    EXPECT_TRUE(Has(error(packed.substr(0, packed.size() / 2)), "ends in the middle"));
    std::string damaged = packed;
    for (size_t i = packed.size() / 2; i < packed.size() / 2 + 50; ++i)
        damaged[i] = static_cast<char>(~damaged[i]);
    EXPECT_NE(error(damaged), "");
    EXPECT_TRUE(Has(error(Gzip(std::string(1 << 24, '\0'))), "binary data"));
    EXPECT_TRUE(Has(error(Gzip(std::string(size_t(300) << 20, ' '))), "times its size"));
}

// Text already read is given back to the system every few megabytes: places must stay right, and all curves arrive.
TEST(Parser, LargeFileIsReleasedBehindTheReader) {
    const TemporaryFolder folder;
    std::string text = "WorldBegin\nAttributeBegin\n";
    constexpr int kCurves = 250000;
    for (int i = 0; i < kCurves; ++i)
        text += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + std::to_string(i) +
                " 0 0] \"float width0\" [0.010000] \"float width1\" [0.005000]\n";
    ASSERT_GT(text.size(), size_t(20) << 20);
    const auto s = ParseScene(AllPlugins(), folder.Write("large.pbrt", text + "AttributeEnd WorldEnd\n"));
    ASSERT_EQ(s.curves.segments.size(), static_cast<size_t>(kCurves));
    for (int i = 0; i < kCurves; ++i)
        ASSERT_EQ(s.curves.segments[static_cast<size_t>(i)].cp[3].x, static_cast<float>(i));
    const std::string path = folder.Write("wrong.pbrt", text + "  TransformEnd\n");
    try {
        ParseScene(AllPlugins(), path);
        FAIL() << "TransformEnd closed an AttributeBegin";
    } catch (const Error &e) {
        EXPECT_EQ(std::string(e.what()),
                  path + ":" + std::to_string(kCurves + 3) +
                      ":3: error: TransformEnd inside the block of AttributeBegin at " + path +
                      ":2:1: that must end first\n      TransformEnd\n      ^");
    }
}

TEST(Parser, FilesThatAreNone) {
    EXPECT_THROW(ParseScene(AllPlugins(), kData + "/no such file.pbrt"), Error);
    EXPECT_THROW(ParseScene(AllPlugins(), kData), Error);
    const TemporaryFolder folder;
    EXPECT_THROW(ParseScene(AllPlugins(), folder.Write("empty", "")), Error);
    // A file of exactly whole pages has no byte behind it to stop at.
    std::string page = World("Shape \"sphere\"");
    page.insert(0, 8192 - page.size(), '\n');
    page.back() = ' ';
    EXPECT_EQ(ParseScene(AllPlugins(), folder.Write("page", page)).shapes.size(), 1u);
    const std::string number = "WorldBegin Translate 0 0 " + std::string(8192 - 25, '1');
    ASSERT_EQ(number.size() % 4096, 0u);
    EXPECT_THROW(ParseScene(AllPlugins(), folder.Write("number", number)), Error);
}

// --- curves ----------------------------------------------------------------------------------------------------------------

TEST(ParserCurves, OneSegment) {
    const auto s = Parse(World("ReverseOrientation Material \"hair\"\n"
                               "Shape \"curve\" \"point P\" [ -2 -1 -1  2 2 0  -2 -2 0  2 1 -1 ] \"float "
                               "width0\" [.35] \"float width1\" [.15]\n"
                               "Shape \"curve\" \"float width\" .5 \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] "
                               "\"string type\" \"cylinder\" \"integer splitdepth\" 4\n"
                               "Shape \"curve\" \"float width1\" .25 \"float width\" .5 \"point P\" [0 0 0 1 "
                               "0 0 2 0 0 3 0 0] \"string type\" [\"flat\"]\n"
                               "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]"));
    const auto &seg = s.curves.segments;
    ASSERT_EQ(seg.size(), 4u);
    EXPECT_EQ(seg[0].cp[0], Point3f(-2, -1, -1));
    EXPECT_EQ(seg[0].cp[3], Point3f(2, 1, -1));
    const float widths[4][2] = {
        {.35f, .15f}, {.5f, .5f}, {.5f, .25f}, {1, 1}}; // pbrt-v3: width gives both defaults
    for (size_t i = 0; i < 4; ++i)
        for (int k = 0; k < 2; ++k)
            EXPECT_EQ(seg[i].width[k], widths[i][k]) << i << " " << k;
    ASSERT_EQ(s.curveGroups.size(), 2u);
    EXPECT_EQ(seg[0].group, seg[2].group);
    EXPECT_EQ(s.curveGroups[seg[0].group].type, CurveType::Flat);
    EXPECT_EQ(s.curveGroups[seg[1].group].type, CurveType::Cylinder);
    EXPECT_EQ(s.curveGroups[0].state.material, 1);
    EXPECT_TRUE(s.curveGroups[0].state.reverseOrientation);
}

TEST(ParserCurves, TransformationScalesPointsAndWidths) {
    const std::string curve = "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" .5\n";
    const auto s = Parse(World("Translate 1 2 3 Rotate 90 0 0 1 Scale -2 2 2 " + curve));
    ExpectNear(s.curves.segments.at(0).cp[3], {1, -4, 3}, 2e-6f);
    EXPECT_NEAR(s.curves.segments[0].width[0], 1, 1e-6);
    EXPECT_EQ(WarningOf(World("Rotate 30 1 2 3 Scale 2.001 2 2 " + curve)), "");
    EXPECT_TRUE(Has(WarningOf(World("Scale 2.01 2 2 " + curve)), "scales differently along different axes"));
    EXPECT_NEAR(Parse(World("Scale 1 1 8 " + curve)).curves.segments[0].width[0], 1, 1e-6); // cbrt 8 = 2
    FlushWarnings();
}

TEST(ParserCurves, BasesDegreesAndRibbons) {
    const auto s = Parse(
        World("Shape \"curve\" \"integer degree\" 2 \"point P\" [0 0 0 1 1 0 2 0 0 3 -1 0 4 0 0]\n"
              "Shape \"curve\" \"string basis\" \"bspline\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0]\n"
              "Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 2 0 2 0] \"point P\" [0 0 0 1 0 "
              "0 2 0 0 3 0 0]\n"
              "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0] \"float width0\" 0"));
    const auto &seg = s.curves.segments;
    ASSERT_EQ(seg.size(), 2u + 2u + 1u + 2u);
    // Degree elevation: the cubic's inner points are 1/3 and 2/3 of the way to the quadratic's.
    ExpectNear(seg[0].cp[1], {2.0f / 3, 2.0f / 3, 0}, 1e-6f);
    // A uniform B-spline with evenly spaced points runs evenly from point 1 on.
    ExpectNear(seg[2].cp[0], {1, 0, 0}, 1e-6f);
    ExpectNear(seg[3].cp[3], {3, 0, 0}, 1e-6f);
    ASSERT_EQ(s.curves.ribbonNormals.size(), 1u);
    const RibbonNormals n = s.curves.ribbonNormals.at(4);
    ExpectNear(n.n[0], {0, 0, 1}, 1e-6f);
    ExpectNear(n.n[1], {0, 1, 0}, 1e-6f);
    EXPECT_NEAR(seg[5].width[1], 0.5, 1e-6);
    EXPECT_NEAR(seg[6].width[0], 0.5, 1e-6);
    EXPECT_NEAR(seg[6].width[1], 1, 1e-6);
}

TEST(ParserCurves, RibbonNormalsGoWithTheTransformation) {
    const auto s = Parse(World(
        "Scale 3 3 3 Rotate 90 1 0 0 Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1] "
        "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]"));
    ExpectNear(s.curves.ribbonNormals.at(0).n[0], {0, -1, 0}, 1e-6f);
}

// Random statements in all spellings, those of the short way and others, under changing states: both readers must give the same bytes.
TEST(ParserCurves, FastAndGeneralReaderAgreeBitForBit) {
    std::mt19937 random(11);
    const auto pick = [&](auto... options) {
        const std::string list[] = {std::string(options)...};
        return list[random() % sizeof...(options)];
    };
    const auto number = [&] {
        static constexpr const char *kFormats[] = {"%.3g", "%.9g", "%.17g", "%.6f", "%.2e", "%+.4f"};
        char text[64];
        const double v = (static_cast<double>(random()) / 4294967296.0 - 0.5) *
                         std::pow(10, static_cast<int>(random() % 9) - 3);
        std::snprintf(text, sizeof text, kFormats[random() % std::size(kFormats)], v);
        return std::string(text);
    };
    std::string body = "Texture \"t\" \"float\" \"constant\" \"float value\" 1\n";
    int statements = 0;
    for (; statements < 20000; ++statements) {
        switch (random() % 40) {
        case 0:
            body += "Rotate " + number() + " 1 2 3\n";
            break;
        case 1:
            body += pick("AttributeBegin\n", "TransformBegin\n", "Material \"hair\" \"float eumelanin\" 1\n",
                         "ReverseOrientation\n", "Identity\n", "Translate 1 2 3\n", "Scale 1 1.5 1\n",
                         "AreaLightSource \"diffuse\"\n");
            if (body.ends_with("AttributeBegin\n") || body.ends_with("TransformBegin\n")) {
                const std::string end =
                    body.ends_with("AttributeBegin\n") ? "AttributeEnd\n" : "TransformEnd\n";
                body += "Scale 2 2 2\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + number() +
                        " 0 0]\n" + end;
                ++statements;
            }
            break;
        default:
            break;
        }
        const int degree = random() % 4 ? 3 : 2,
                  segments = random() % 3 ? 1 : 1 + static_cast<int>(random() % 3);
        const bool spline = random() % 4 == 0, ribbon = random() % 6 == 0;
        const int points = spline ? segments + degree : segments * degree + 1;
        std::vector<std::string> parameters;
        std::string list = pick("\"point P\" [", "\"point P\"[ ", "\"point3 P\" [ ", "\"point\tP\" [ ");
        for (int i = 0; i < 3 * points; ++i)
            list += number() + pick(" ", "  ", "\n", "\t", " # c\n", " ");
        parameters.push_back(list + "]");
        if (degree == 2)
            parameters.push_back(pick("\"integer degree\" 2", "\"integer degree\" [ 2 ]"));
        else if (random() % 8 == 0)
            parameters.push_back("\"integer degree\" 3");
        if (spline)
            parameters.push_back(pick("\"string basis\" \"bspline\"", "\"string basis\" [\"bspline\"]"));
        if (ribbon) {
            list = "\"normal N\" [";
            for (int i = 0; i < 3 * (segments + 1); ++i)
                list += " " + number();
            parameters.push_back(list + "]");
            parameters.push_back("\"string type\" \"ribbon\"");
        } else if (random() % 2) {
            parameters.push_back(pick("\"string type\" \"flat\"", "\"string type\" [ \"cylinder\" ]",
                                      "\"string type\" \"cylinder\""));
        }
        if (random() % 2)
            parameters.push_back(pick("\"float width\" ", "\"float  width\" ") + number());
        if (random() % 2)
            parameters.push_back("\"float width0\" [" + number() + pick("]", " ]"));
        if (random() % 2)
            parameters.push_back("\"float width1\" " + number());
        if (random() % 6 == 0)
            parameters.push_back("\"integer splitdepth\" 2");
        if (random() % 10 == 0)
            parameters.push_back(
                pick("\"float eumelanin\" .5", "\"texture beta_m\" \"t\"", "\"float unheard\" 1"));
        std::shuffle(parameters.begin(), parameters.end(), random);
        body += pick("Shape \"curve\"", "Shape\t\"curve\"", "Shape \"curve\"\r\n");
        for (const std::string &p : parameters)
            body += pick(" ", "\n  ", "\r\n") + p;
        body += pick("\n", " ", "\n# end\n");
    }
    ParseOptions slow;
    slow.fastCurves = false;
    const std::string text = World(body);
    const auto a = ParseSceneText(AllPlugins(), text, "a", "."),
               b = ParseSceneText(AllPlugins(), text, "b", ".", slow);
    FlushWarnings();
    ASSERT_GT(a.curves.segments.size(), static_cast<size_t>(statements));
    ASSERT_EQ(a.curves.segments.size(), b.curves.segments.size());
    static_assert(sizeof(CurveSegment) == 60, "no padding, so that bytes can be compared");
    for (size_t i = 0; i < a.curves.segments.size(); ++i)
        ASSERT_EQ(std::memcmp(&a.curves.segments[i], &b.curves.segments[i], sizeof(CurveSegment)), 0)
            << "segment " << i;
    ASSERT_EQ(a.curves.ribbonNormals.size(), b.curves.ribbonNormals.size());
    ASSERT_GT(a.curves.ribbonNormals.size(), 1000u);
    for (const auto &[i, n] : a.curves.ribbonNormals)
        ASSERT_EQ(std::memcmp(&n, &b.curves.ribbonNormals.at(i), sizeof n), 0) << "ribbon " << i;
    ASSERT_EQ(a.curveGroups.size(), b.curveGroups.size());
    for (size_t i = 0; i < a.curveGroups.size(); ++i) {
        EXPECT_EQ(a.curveGroups[i].type, b.curveGroups[i].type);
        EXPECT_EQ(a.curveGroups[i].state, b.curveGroups[i].state);
    }
    EXPECT_EQ(a.materials.size(), b.materials.size());
}

TEST(ParserCurves, MemoryOfManyCurvesIsTheSegmentsAndLittleMore) {
    std::string body;
    for (int i = 0; i < 100000; ++i)
        body += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" .01\n";
    const auto s = Parse(World(body));
    ASSERT_EQ(s.curves.segments.size(), 100000u);
    EXPECT_EQ(s.curveGroups.size(), 1u);
    const double held = static_cast<double>(s.curves.segments.capacity() * sizeof(CurveSegment)) / 100000;
    EXPECT_LE(held, 64) << "bytes a curve";
}

// --- what is wrong, and where -----------------------------------------------------------------------------------------

struct Wrong {
    const char *text;
    const char *place;   // "line:column"
    const char *message; // a part of it
};

TEST(ParserErrors, NameThePlaceAndWhatWouldBeRight) {
    const Wrong cases[] = {
        // directives
        {"WorldBegin\n  Shpe \"sphere\"", "2:3", "directive \"Shpe\" is not known. Did you mean \"Shape\"?"},
        {"WorldBegin\nShape \"spere\"", "2:7", "Shape \"spere\" is not known. Did you mean \"sphere\"?"},
        {"WorldBegin Shape sphere", "1:18", "Shape needs a type in quotes, found \"sphere\""},
        {"WorldBegin\nMaterial \"hairy\"", "2:10", "Did you mean \"hair\"?"},
        {"Camera \"perspectiv\"", "1:8", "Did you mean \"perspective\"?"},
        {"WorldBegin MakeNamedMaterial \"a\"\n \"string type\" \"plastik\"", "2:2",
         "Did you mean \"plastic\"?"},
        {"WorldBegin MakeNamedMaterial \"a\"", "1:12", "needs a parameter \"string type\""},
        {"WorldBegin Texture \"a\" \"colour\" \"scale\"", "1:24",
         "must be \"float\", \"color\" or \"spectrum\", not \"colour\". Did you mean \"color\"?"},
        {"WorldBegin Texture \"a\" \"color\" \"imagmap\"", "1:32", "Did you mean \"imagemap\"?"},
        {"Shape \"sphere\"", "1:1", "WorldBegin has not come yet"},
        {"WorldBegin WorldBegin", "1:12", "a second WorldBegin"},
        {"WorldEnd", "1:1", "WorldEnd without WorldBegin"},
        {"Camera \"perspective\"", "1:21", "without a WorldBegin"},
        {"Translate 1 2", "1:14", "Translate needs 3 numbers (x y z), found the end of the file after 2"},
        {"LookAt 0 0 0 1 1 1 0 1\nWorldBegin", "2:1", "LookAt needs 9 numbers"},
        {"LookAt 0 0 0  0 0 0  0 1 0", "1:1", "cannot be inverted (the eye is the point looked at"},
        {"Rotate 10 0 0 0", "1:1", "axis"},
        {"Scale 1 0 1", "1:1", "cannot be inverted (a factor is 0?)"},
        {"Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0]", "1:41", "found \"]\" after 15"},
        {"Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1]", "1:44", "16 numbers and then \"]\""},
        {"ActiveTransform Never", "1:17", "StartTime, EndTime or All, not \"Never\""},
        {"CoordSysTransform \"camra\"", "1:19", "no coordinate system \"camra\""},
        {"WorldBegin ObjectInstance \"x\"", "1:27", "no object \"x\" has been defined"},
        {"WorldBegin ObjectBegin \"a\" ObjectBegin \"b\"", "1:28", "which has no ObjectEnd yet"},
        {"WorldBegin ObjectBegin \"a\" ObjectInstance \"a\"", "1:28", "inside the definition of an object"},
        {"WorldBegin Material \"matte\" \"texture Kd\" \"wod\"", "1:42",
         "no texture \"wod\" has been defined here"},
        {"WorldBegin Texture \"wood\" \"color\" \"constant\"\nMaterial \"matte\" \"texture Kd\" \"wod\"",
         "2:31", "Did you mean \"wood\"?"},
        // blocks
        {"WorldBegin AttributeEnd", "1:12", "AttributeEnd without AttributeBegin"},
        {"WorldBegin\nAttributeBegin\nTransformEnd", "3:1",
         "inside the block of AttributeBegin at test.pbrt:2:1"},
        {"WorldBegin\nAttributeBegin\nWorldEnd", "3:1",
         "AttributeBegin at test.pbrt:2:1 has no AttributeEnd before WorldEnd"},
        {"WorldBegin\nTransformBegin\n", "3:1",
         "TransformBegin at test.pbrt:2:1 has no TransformEnd before the end of the file"},
        {"WorldBegin ObjectBegin \"a\" WorldEnd", "1:28", "ObjectBegin at test.pbrt:1:12 has no ObjectEnd"},
        {"WorldBegin ObjectEnd", "1:12", "ObjectEnd without ObjectBegin"},
        // parameters
        {"Camera \"perspective\" \"fov\" 30", "1:22", "\"type name\""},
        {"Camera \"perspective\" \"float fov x\" 30", "1:22", "\"type name\""},
        {"Camera \"perspective\" \"flaot fov\" 30", "1:22",
         "parameter type \"flaot\" is not known. Did you mean \"float\"?"},
        {"Camera \"perspective\" \"int fov\" 30", "1:22",
         "parameter type \"int\" is not known. Did you mean \"integer\"?"},
        {"Camera \"perspective\" \"float fov\"", "1:33",
         "expected the value of \"float fov\", found the end of the file"},
        {"Camera \"perspective\" \"float fov\" 30 40", "1:37",
         "several values of one parameter need brackets"},
        {"Camera \"perspective\" \"float fov\" \"30\"", "1:34", "\"float fov\" takes numbers, not \"30\""},
        {"Camera \"perspective\" \"float fov\" true", "1:34", "\"float fov\" takes numbers, not \"true\""},
        {"Camera \"perspective\" \"float fov\" [30 \"x\"]", "1:22", "strings as well as numbers"},
        {"Camera \"perspective\" \"string s\" 1", "1:22", "takes a string in quotes, not a number"},
        {"Camera \"perspective\" \"string s\" true", "1:33", "takes strings in quotes"},
        {"Camera \"perspective\" \"bool b\" 1", "1:22", "takes \"true\" or \"false\", not a number"},
        {"Camera \"perspective\" \"bool b\" \"yes\"", "1:31", "takes \"true\" or \"false\", not \"yes\""},
        {"Camera \"perspective\" \"rgb c\" [1 2]", "1:22", "a colour of 3 numbers (or several), not of 2"},
        {"Camera \"perspective\" \"rgb c\" []", "1:22", "not of 0"},
        {"Camera \"perspective\" \"spectrum c\" [400 1 500]", "1:22",
         "pairs of wavelength in nm and value, not 3"},
        {"Camera \"perspective\" \"spectrum c\" [0 1]", "1:22", "above 0 nm"},
        {"Camera \"perspective\" \"spectrum c\" \"no.spd\"", "1:35", "cannot open the spectrum file"},
        {"Camera \"perspective\" \"blackbody c\" [-5 1]", "1:22", "above 0 kelvin"},
        {"Camera \"perspective\" \"texture t\" [\"a\" \"b\"]", "1:22", "the name of one texture, not 2"},
        {"Film \"image\" \"float c\" [ 0 1\nWorldBegin", "1:24",
         "have no closing \"]\" before \"WorldBegin\" at test.pbrt:2:1"},
        {"Film \"image\" \"float c\" [ 0 1", "1:24", "have no closing \"]\" before the end of the file"},
        {"Film \"image\" ] ", "1:14", "\"]\" stands outside of a parameter"},
        {"Identity \"x\"", "1:10", "expected a directive, found the string \"x\""},
        // numbers
        {"Translate 1 2 1e999", "1:15", "the number 1e999 is out of range"},
        {"Camera \"perspective\" \"float fov\" -4e38", "1:34", "out of range"},
        {"Camera \"perspective\" \"float f\" [1 1e39 2]", "1:35", "out of range"},
        {"Translate 1 2 nan", "1:15", "not-a-number and infinity have no place"},
        {"Translate 1 2 -inf", "1:15", "\"-inf\" is not a number"},
        {"Camera \"perspective\" \"float f\" [1 Infinity]", "1:35",
         "not-a-number and infinity have no place"},
        {"Translate 1,2,3", "1:11", "\"1,2,3\" is not a number"},
        {"Translate 1.2.3 0 0", "1:11", "\"1.2.3\" is not a number"},
        {"Translate 0x10 0 0", "1:11", "\"0x10\" is not a number"},
        {"Translate 1e 0 0", "1:11", "\"1e\" is not a number"},
        {"Translate - 0 0", "1:11", "\"-\" is not a number"},
        // text
        {"Film \"image\n\"", "1:6", "no closing quote on its line"},
        {"Film \"image", "1:6", "no closing quote on its line"},
        {"Film \"im\\age\"", "1:9", "unknown escape"},
        {"\x01\x02", "1:1", "byte 0x01 outside quotes"},
        {"\x7f"
         "ELF",
         "1:1", "byte 0x7f outside quotes"},
        {"\xff\xfe"
         "F",
         "1:1", "UTF-16"},
        {"Identity \xc3\xa4", "1:10", "byte 0xc3 outside quotes"},
        // curves
        {"WorldBegin\nShape \"curve\" \"float width\" 1", "2:1", "needs control points"},
        {"WorldBegin\nShape \"curve\"\n  \"point P\" [0 0 0 1]", "3:3", "no multiple of 3"},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 1 1 2 2 2]", "2:1", "Shape \"curve\": "},
        {"WorldBegin\nShape \"curve\" \"float P\" [0 0 0 1 1 1 2 2 2 3 3 3]", "2:15",
         "\"P\" is written \"point P\""},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n\"string type\" \"cylindr\"",
         "3:1", "Did you mean \"cylinder\"?"},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n \"integer degree\" 4", "3:2",
         "must be 2 or 3"},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string basis\" \"hermite\"",
         "2:51", "\"basis\" cannot be \"hermite\""},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribbon\"",
         "2:1", "needs \"normal N\""},
        {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" [1 2]", "2:51",
         "takes one number, not 2"},
        {"WorldBegin\nScale 1e30 1e30 1e30 Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 1e30 0 0]", "2:22",
         "out of range after the transformation"},
    };
    for (const Wrong &c : cases) {
        const std::string error = ErrorOf(c.text);
        EXPECT_TRUE(error.starts_with("test.pbrt:" + std::string(c.place) + ": error: "))
            << c.text << "\ngave " << error;
        EXPECT_TRUE(Has(error, c.message)) << c.text << "\ngave " << error;
    }
    FlushWarnings();
}

TEST(ParserErrors, ShowTheLineWithACaret) {
    EXPECT_EQ(ErrorOf("# first\n\tCamera \"perspective\" \"float fov\" x\nWorldBegin\n"),
              "test.pbrt:2:35: error: expected the value of \"float fov\", found \"x\"\n"
              "     Camera \"perspective\" \"float fov\" x\n    " +
                  std::string(34, ' ') + "^");
}

TEST(ParserErrors, OtherVersionsOfPbrtAreNamed) {
    for (const char *text :
         {"Film \"rgb\"", "Film \"gbuffer\"", "Option \"seed\" 1", "ColorSpace \"rec2020\"",
          "Sampler \"zsobol\"", "Integrator \"randomwalk\"", "Camera \"spherical\"",
          "WorldBegin Attribute \"shape\" \"float alpha\" 1", "WorldBegin Material \"coateddiffuse\"",
          "WorldBegin Material \"diffuse\"", "WorldBegin Material \"dielectric\"",
          "WorldBegin MakeNamedMaterial \"m\" \"string type\" \"conductor\"",
          "WorldBegin Shape \"bilinearmesh\"", "MakeNamedMedium \"m\" \"string type\" \"nanovdb\"",
          "WorldBegin LightSource \"infinite\" \"spectrum L\" \"stdillum-D65\"",
          "WorldBegin LightSource \"infinite\" \"blackbody L\" 6500",
          "WorldBegin Material \"metal\" \"spectrum eta\" \"metal-Cu-eta\"",
          "WorldBegin LightSource \"infinite\" \"spectrum L\" 1"})
        EXPECT_TRUE(Has(ErrorOf(text), "pbrt-v4")) << text << "\ngave " << ErrorOf(text);
    for (const char *text :
         {"SurfaceIntegrator \"path\"", "Renderer \"sampler\"", "VolumeIntegrator \"single\"",
          "WorldBegin Volume \"homogeneous\"", "Sampler \"bestcandidate\"", "Accelerator \"grid\"",
          "WorldBegin Material \"shinymetal\""})
        EXPECT_TRUE(Has(ErrorOf(text), "pbrt-v2")) << text << "\ngave " << ErrorOf(text);
}

TEST(ParserErrors, MissingWorldEndIsAWarningThatThinksOfV4) {
    const std::string text = "WorldBegin\nShape \"sphere\"\n";
    EXPECT_EQ(Parse(text).shapes.size(), 1u);
    EXPECT_TRUE(Has(WarningOf(text), "test.pbrt:3:1: error: the file ends without WorldEnd"));
    EXPECT_TRUE(Has(WarningOf(text), "pbrt-v4"));
}

TEST(ParserErrors, TextAfterWorldEndIsNotRead) {
    const std::string text = World("Shape \"sphere\"") + "Film \"image\"\nWorldBegin Shape \"disk\" WorldEnd";
    EXPECT_EQ(Parse(text).shapes.size(), 1u);
    EXPECT_TRUE(Has(WarningOf(text), "test.pbrt:4:1: error: what stands after WorldEnd is not read"));
    EXPECT_EQ(WarningOf(World("") + "\n# a comment\n"), "");
}

TEST(ParserErrors, CollectedOneByOne) {
    std::vector<std::string> errors;
    ParseOptions options;
    options.collectErrors = &errors;
    const auto s = ParseSceneText(AllPlugins(),
                                  "Film \"rgb\"\nCamera \"perspective\" \"float fov\" x\nWorldBegin\nShape "
                                  "\"sphere\" \"float radius\" [1\n"
                                  "Shape \"disk\"\nAttributeEnd\nShape \"curve\" \"point P\" [0 0 "
                                  "0]\n\"unclosed\nShape \"sphere\"\nWorldEnd",
                                  "test.pbrt", ".", options);
    EXPECT_EQ(s.shapes.size(), 2u);
    const char *places[] = {"1:6", "2:34", "4:31", "6:1", "8:1"};
    ASSERT_EQ(errors.size(), std::size(places));
    for (size_t i = 0; i < errors.size(); ++i)
        EXPECT_TRUE(errors[i].starts_with("test.pbrt:" + std::string(places[i]) + ":")) << errors[i];
}

TEST(ParserErrors, UnreadableIncludeLeavesTheIncluderReadable) {
    const TemporaryFolder folder;
    folder.Write("utf16.pbrt", std::string("\xff\xfeS\0h\0", 6));
    std::vector<std::string> errors;
    ParseOptions options;
    options.collectErrors = &errors;
    const auto s = ParseSceneText(AllPlugins(), World("Include \"utf16.pbrt\"\nShape \"sphere\""), "t",
                                  folder.Path(), options);
    EXPECT_EQ(s.shapes.size(), 1u);
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_TRUE(Has(errors[0], "utf16.pbrt:1:1: error: this is UTF-16 text")) << errors[0];
}

// Hostile input of some 20 MB each ends in an Error within a second of processor time.
TEST(ParserErrors, HostileInputEndsSoon) {
    constexpr size_t kSize = 20 << 20;
    const auto repeat = [](const std::string &unit) {
        std::string s;
        s.reserve(kSize + unit.size());
        while (s.size() < kSize)
            s += unit;
        return s;
    };
    const std::pair<const char *, std::string> inputs[] = {
        {"quote without end", "Film \"" + repeat("a")},
        {"word without end", "Film" + repeat("a")},
        {"number without end", "Translate " + repeat("1")},
        {"fraction without end", "Translate 0." + repeat("0")},
        {"array without end", "Film \"image\" \"float x\" [" + repeat("1 ")},
        {"open brackets", "Film \"image\" \"float x\" " + repeat("[")},
        {"blocks without end", "WorldBegin " + repeat("AttributeBegin ")},
        {"NUL bytes", std::string(kSize, '\0')},
        {"NUL bytes in a string", "Film \"" + std::string(kSize, '\0') + "\""},
        {"escapes", "Film \"" + repeat("\\\\")},
        {"quotes", repeat("\"")},
        {"blanks", repeat(" \n")},
        {"comment", "#" + repeat("x")},
        {"curve without end", "WorldBegin Shape \"curve\" \"point P\" [" + repeat("0.5 ")},
        {"curve of quotes", "WorldBegin Shape \"curve\" " + repeat("\"")},
    };
    for (const auto &[name, text] : inputs) {
        const std::clock_t begin = std::clock();
        const std::string error = ErrorOf(text);
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        EXPECT_NE(error, "") << name;
        EXPECT_LT(error.size(), 1000u) << name;
        EXPECT_LT(seconds, 1) << name;
    }
}

// A text with a bit of everything, cut at every byte and damaged at random: it parses, or ends in an Error.
TEST(ParserErrors, CutAndDamagedTextNeverDoesWorse) {
    const std::string text =
        "LookAt 0 0 5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [ 30 ]\nFilm \"image\" \"string "
        "filename\" \"a.exr\"\n" +
        World("Texture \"t\" \"float\" \"constant\" \"float value\" 1 # c\nMakeNamedMaterial \"m\" \"string "
              "type\" \"hair\" \"texture beta_m\" \"t\"\n"
              "AttributeBegin NamedMaterial \"m\" Rotate 45 0 0 1\nShape \"curve\" \"point P\" [0 0 0 1 .5 "
              "-2e-1 2 0 0 3 0 0] \"float width0\" .1 \"string type\" \"cylinder\"\n"
              "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0] \"string type\" \"ribbon\" \"normal N\" [0 0 "
              "1 0 1 0] \"integer degree\" [2]\nAttributeEnd\n"
              "ObjectBegin \"o\" Shape \"sphere\" \"float radius\" 2 ObjectEnd ObjectInstance "
              "\"o\"\nTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\n"
              "LightSource \"distant\" \"blackbody L\" [5000 1] \"spectrum scale\" [400 1 700 .5] \"bool b\" "
              "true");
    ASSERT_EQ(ErrorOf(text), "");
    size_t parsed = 0, refused = 0;
    const auto feed = [&](const std::string &s) {
        // Anything but an Error ends the test.
        (ErrorOf(s).empty() ? parsed : refused)++;
    };
    for (size_t n = 0; n < text.size(); ++n)
        feed(text.substr(0, n));
    std::mt19937 random(3);
    constexpr std::string_view kBytes = "\"[]#-+.eE019 \n\tPx\\\0\xff";
    for (int i = 0; i < 20000; ++i) {
        std::string s = text;
        for (unsigned k = 0; k < 1 + random() % 3; ++k) {
            const size_t at = random() % s.size();
            switch (random() % 3) {
            case 0:
                s[at] = kBytes[random() % kBytes.size()];
                break;
            case 1:
                s.erase(at, 1 + random() % 8);
                break;
            default:
                s.insert(at, s.substr(random() % s.size(), random() % 30));
            }
        }
        feed(s);
    }
    FlushWarnings();
    std::cout << parsed << " parsed, " << refused << " refused\n";
    EXPECT_GT(parsed, 100u);
    EXPECT_GT(refused, 10000u);
}

// --- real files ----------------------------------------------------------------------------------------------------------

// Every scene of the shared folder parses; what it lacks (includes, spectra) is reported as missing. Runs where the folder is
// there: named by CUTICLE_SHARED_DATA, or beside the source tree.
TEST(ParserRealFiles, ParseOrLackFiles) {
    const char *named = std::getenv("CUTICLE_SHARED_DATA");
    const std::filesystem::path folder =
        named ? std::filesystem::path(named) : std::filesystem::path(CUTICLE_SOURCE_DIR) / "../shared/data";
    if (!std::filesystem::is_directory(folder / "parser")) {
        std::cout << "passed over: no folder of real scenes (CUTICLE_SHARED_DATA names it)\n";
        return;
    }
    size_t files = 0, missing = 0;
    for (const char *part : {"parser", "scenes"})
        for (const auto &entry : std::filesystem::recursive_directory_iterator(folder / part)) {
            if (entry.path().extension() != ".pbrt")
                continue;
            ++files;
            std::vector<std::string> errors;
            ParseOptions options;
            options.collectErrors = &errors;
            // A part that others include is parsed as they do it.
            const bool isPart = entry.path().parent_path().filename() == "geometry";
            const auto s = isPart
                               ? ParseSceneText(AllPlugins(),
                                                World("Include \"" + entry.path().filename().string() + "\""),
                                                "whole", entry.path().parent_path().string(), options)
                               : ParseScene(AllPlugins(), entry.path().string(), options);
            for (const std::string &e : errors) {
                EXPECT_TRUE(Has(e, ": No such file or directory")) << e;
                ++missing;
            }
            EXPECT_GT(s.bytesRead, 0u);
        }
    FlushWarnings();
    std::cout << files << " files, " << missing << " files that they name are missing\n";
    EXPECT_GE(files, 72u);
}

TEST(ParserTables, EveryMaterialHasItsParametersOrNone) {
    for (const std::string_view type : MaterialPlugins().Names())
        EXPECT_EQ(MaterialParameters(type).empty(), type.empty() || type == "none") << type;
    EXPECT_TRUE(MaterialParameters("unheard of").empty());
}

} // namespace
} // namespace cuticle
