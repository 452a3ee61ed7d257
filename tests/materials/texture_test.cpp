// Textures, from the scene's words to values.
#include "materials/material.h"
#include "materials/texture.h"
#include "warnings.h"

#include "core/error.h"
#include "core/sampling.h"
#include "images/image.h"
#include "materials/noise.h"
#include "message_of.h"
#include "parser/scene_description.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <unistd.h>

using namespace cuticle;
namespace fs = std::filesystem;

namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins()};

// A folder for the images of one test.
class Textures : public testing::Test {
  protected:
    Textures() {
        const auto *info = testing::UnitTest::GetInstance()->current_test_info();
        folder =
            fs::path(testing::TempDir()) / ("cuticle_texture_" + std::to_string(::getpid()) + info->name());
        fs::create_directories(folder);
        FlushWarnings();
    }
    ~Textures() override {
        FlushWarnings();
        fs::remove_all(folder);
    }
    SceneDescription Parse(const std::string &text) const {
        return ParseSceneText(kPlugins, "WorldBegin\n" + text + "\nWorldEnd\n", "test.pbrt", folder.string());
    }
    TextureTable Table(const std::string &text) const {
        const SceneDescription scene = Parse(text);
        return TextureTable(scene.floatTextures, scene.spectrumTextures);
    }
    float Float(const std::string &text, const TexturePoint &point = {}) const {
        const SceneDescription scene = Parse(text);
        return TextureTable(scene.floatTextures, scene.spectrumTextures)
            .FloatTexture(scene.floatTextures.size() - 1)
            ->Evaluate(point);
    }
    Spectrum Color(const std::string &text, const TexturePoint &point = {}) const {
        const SceneDescription scene = Parse(text);
        return TextureTable(scene.floatTextures, scene.spectrumTextures)
            .SpectrumTexture(scene.spectrumTextures.size() - 1)
            ->Evaluate(point);
    }
    // 2 x 2: top row red, green; bottom row blue, white.
    void WriteFour(const std::string &name) const {
        Image image(2, 2, {"R", "G", "B"});
        image.data = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
        WriteImage((folder / name).string(), image);
    }
    fs::path folder;
};

TexturePoint UV(float u, float v) { return {{}, {u, v}}; }

} // namespace

TEST_F(Textures, ConstantScaleMix) {
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"constant\" \"float value\" .25"), 0.25f);
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"constant\""), 1);
    EXPECT_EQ(Color("Texture \"a\" \"color\" \"constant\" \"rgb value\" [.1 .2 .3]"),
              Spectrum(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"scale\" \"float tex1\" 3 \"float tex2\" .5"), 1.5f);
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"scale\" \"float tex1\" 3"), 3);
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"mix\""), 0.5f);
    EXPECT_EQ(Color("Texture \"h\" \"float\" \"constant\" \"float value\" .25\n"
                    "Texture \"a\" \"color\" \"mix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"texture "
                    "amount\" \"h\""),
              Spectrum(0.75f, 0, 0.25f));
    EXPECT_EQ(FlushWarnings(), 0u);
}

// A later texture of the same name does not change what an earlier use has bound.
TEST_F(Textures, NamesBindWhereTheyAreUsed) {
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"constant\" \"float value\" 2\n"
                    "Texture \"a\" \"float\" \"scale\" \"texture tex1\" \"a\" \"float tex2\" 5"),
              10);
}

TEST_F(Textures, ParametersAreValuesOrTextures) {
    const SceneDescription scene = Parse("Texture \"f\" \"float\" \"constant\" \"float value\" .5\n"
                                         "Texture \"c\" \"spectrum\" \"constant\" \"rgb value\" [1 2 3]\n"
                                         "Material \"matte\" \"texture Kd\" \"c\" \"texture sigma\" \"f\"\n"
                                         "Shape \"sphere\"\n"
                                         "Material \"matte\" \"rgb Kd\" [4 5 6] \"float sigma\" 7\n"
                                         "Shape \"sphere\"\n"
                                         "Material \"matte\" \"texture Kd\" \"f\" \"texture sigma\" \"c\"\n"
                                         "Shape \"sphere\"\n");
    const TextureTable table(scene.floatTextures, scene.spectrumTextures);
    const size_t last = scene.materials.size() - 1;
    const ParamSet &bound = scene.materials[last - 2].params, &plain = scene.materials[last - 1].params;
    EXPECT_EQ(table.GetSpectrumTexture(bound, "Kd", Spectrum(0))->Evaluate({}), Spectrum(1, 2, 3));
    EXPECT_EQ(table.GetFloatTexture(bound, "sigma", 0)->Evaluate({}), 0.5f);
    EXPECT_EQ(table.GetSpectrumTexture(plain, "Kd", Spectrum(0))->Evaluate({}), Spectrum(4, 5, 6));
    EXPECT_EQ(table.GetFloatTexture(plain, "sigma", 0)->Evaluate({}), 7);
    EXPECT_EQ(table.GetFloatTexture(plain, "absent", 8)->Evaluate({}), 8);
    plain.ReportUnused("Material \"matte\"");
    bound.ReportUnused("Material \"matte\"");
    EXPECT_EQ(FlushWarnings(), 0u);
    // The other kind of texture is a Warning, and the default
    const ParamSet &wrong = scene.materials[last].params;
    EXPECT_EQ(table.GetSpectrumTexture(wrong, "Kd", Spectrum(3))->Evaluate({}), Spectrum(3));
    EXPECT_EQ(table.GetFloatTexture(wrong, "sigma", 5)->Evaluate({}), 5);
    EXPECT_EQ(FlushWarnings(), 2u);
}

TEST_F(Textures, Checkerboard2D) {
    const std::string text = "Texture \"a\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 2 "
                             "\"float tex1\" 1 \"float tex2\" 0 \"string aamode\" \"none\"";
    for (int i = -8; i < 8; ++i)
        for (int j = -4; j < 4; ++j)
            EXPECT_EQ(Float(text, UV((static_cast<float>(i) + 0.5f) / 4, (static_cast<float>(j) + 0.5f) / 2)),
                      (i + j) % 2 == 0 ? 1 : 0)
                << i << ", " << j;
    EXPECT_EQ(FlushWarnings(), 0u);
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"checkerboard\" \"float udelta\" 1", UV(0.5f, 0.5f)), 0);
    // Coordinates beyond every int, and none at all
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"checkerboard\"", UV(1e30f, 0)), 1);
    EXPECT_TRUE(std::isnan(Float("Texture \"a\" \"float\" \"checkerboard\"", UV(std::nanf(""), 0))));
    EXPECT_TRUE(std::isnan(Float("Texture \"a\" \"float\" \"checkerboard\"", UV(Infinity, 0))));
}

// pbrt-v3's own way: the world's point goes through the transformation, not through its inverse.
TEST_F(Textures, Checkerboard3DGoesThroughTheTransformation) {
    const std::string text = "Scale 2 2 2\nTexture \"a\" \"float\" \"checkerboard\" \"integer dimension\" 3";
    EXPECT_EQ(Float(text, {{0.25f, 0.25f, 0.25f}, {}}), 1);
    EXPECT_EQ(Float(text, {{0.75f, 0.25f, 0.25f}, {}}), 0);
    EXPECT_EQ(Float(text, {{0.75f, 0.75f, 0.25f}, {}}), 1);
    EXPECT_EQ(Float(text, {{0.75f, 0.75f, -0.25f}, {}}), 0);
    EXPECT_EQ(Float("Translate 1 0 0\nTexture \"a\" \"float\" \"checkerboard\" \"integer dimension\" 3",
                    {{0.5f, 0.5f, 0.5f}, {}}),
              0);
}

// v points up: the file's bottom row is at v = 0.
TEST_F(Textures, ImageRowZeroIsAtTheTop) {
    WriteFour("four.exr");
    const std::string text = "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"four.exr\"";
    EXPECT_EQ(Color(text, UV(0.25f, 0.75f)), Spectrum(1, 0, 0));
    EXPECT_EQ(Color(text, UV(0.75f, 0.75f)), Spectrum(0, 1, 0));
    EXPECT_EQ(Color(text, UV(0.25f, 0.25f)), Spectrum(0, 0, 1));
    EXPECT_EQ(Color(text, UV(0.75f, 0.25f)), Spectrum(1, 1, 1));
    // The point between all four is their mean
    EXPECT_EQ(Color(text, UV(0.5f, 0.5f)), Spectrum(0.5f));
}

TEST_F(Textures, ImageWrapModes) {
    WriteFour("four.exr");
    const auto at = [&](const std::string &wrap, float u, float v) {
        return Color(
            "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"four.exr\" \"string wrap\" \"" +
                wrap + "\"",
            UV(u, v));
    };
    for (const float u : {-2.f, 3.f, 0.f})
        EXPECT_EQ(at("repeat", 0.25f + u, 0.75f - u), Spectrum(1, 0, 0)) << u;
    EXPECT_EQ(at("repeat", 0, 0.75f), Spectrum(0.5f, 0.5f, 0)); // red and green across the seam
    EXPECT_EQ(at("clamp", 0, 0.75f), Spectrum(1, 0, 0));
    EXPECT_EQ(at("clamp", -7, 0.75f), Spectrum(1, 0, 0));
    EXPECT_EQ(at("clamp", 1e20f, -1e20f), Spectrum(1, 1, 1));
    EXPECT_EQ(at("black", 0, 0.75f), Spectrum(0.5f, 0, 0));
    EXPECT_EQ(at("black", -0.3f, 0.75f), Spectrum(0));
    EXPECT_EQ(at("black", 1e20f, 0.75f), Spectrum(0));
    for (const char *wrap : {"repeat", "clamp", "black"})
        EXPECT_TRUE(at(wrap, std::nanf(""), 0).HasNaNs()) << wrap;
    EXPECT_TRUE(at("repeat", 3e38f, -3e38f).IsFinite());
}

// pbrt-v3: sRGB decoding by default for 8-bit files alone, then the scale; the luminance for float textures.
TEST_F(Textures, ImageGammaScaleAndLuminance) {
    Image image(1, 1, {"R", "G", "B"});
    image.data = {0.5f, 0.25f, 0.125f};
    WriteImage((folder / "p.exr").string(), image);
    WriteImage((folder / "p.png").string(), image);
    const Spectrum stored = ReadImage((folder / "p.png").string(), false).RGB(0, 0);
    const auto texture = [](const std::string &kind, const std::string &rest) {
        return "Texture \"a\" \"" + kind + "\" \"imagemap\" " + rest;
    };
    EXPECT_EQ(Color(texture("color", "\"string filename\" \"p.exr\" \"float scale\" 2")),
              Spectrum(1, 0.5f, 0.25f));
    const Spectrum decoded = Color(texture("color", "\"string filename\" \"p.png\""));
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(decoded[c], image.data[static_cast<size_t>(c)], 0.004f);
    EXPECT_EQ(Color(texture("color", "\"string filename\" \"p.png\" \"bool gamma\" \"false\"")), stored);
    EXPECT_EQ(Color(texture("color", "\"string filename\" \"p.exr\" \"bool gamma\" \"true\""))[0],
              SRGBToLinear(0.5f));
    EXPECT_FLOAT_EQ(Float(texture("float", "\"string filename\" \"p.exr\"")),
                    Spectrum(0.5f, 0.25f, 0.125f).y());
    EXPECT_FLOAT_EQ(Float(texture("float", "\"string filename\" \"p.png\" \"float scale\" 3")),
                    3 * SRGBToLinear(stored.y()));
}

TEST_F(Textures, FilterParametersAreReadAndUnknownOnesReported) {
    WriteFour("four.png");
    Table("Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"four.png\" \"bool trilinear\" \"true\" "
          "\"float maxanisotropy\" 16 \"string mapping\" \"uv\"");
    EXPECT_EQ(FlushWarnings(), 0u);
    Table("Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"four.png\" \"bool invert\" \"true\"");
    EXPECT_EQ(FlushWarnings(), 1u);
}

TEST_F(Textures, AFileIsReadOnce) {
    WriteFour("four.exr");
    WriteFour("other.exr");
    const std::string image = "\"imagemap\" \"string filename\" \"four.exr\" ";
    const TextureTable table =
        Table("Texture \"a\" \"color\" " + image + "Texture \"b\" \"color\" " + image +
              "\"float uscale\" 3 Texture \"c\" \"float\" " + image + "\"float scale\" 2 " +
              "Texture \"d\" \"color\" \"imagemap\" \"string filename\" \"other.exr\"");
    EXPECT_EQ(table.ImageFilesRead(), 2u);
}

TEST_F(Textures, ErrorsNameTheirPlace) {
    const StrictWarnings strict; // pbrt-v3 goes on after most of these, and so does Table() without it
    const auto message = [&](const std::string &text) { return MessageOf([&] { Table(text); }); };
    std::string m = message("Texture \"a\" \"color\" \"imagemap\"\n  \"string filename\" \"absent.png\"");
    EXPECT_NE(m.find("test.pbrt:3:"), std::string::npos) << m;
    EXPECT_NE(m.find("absent.png"), std::string::npos) << m;
    EXPECT_NE(m.find("No such file"), std::string::npos) << m;
    m = message("Texture \"a\" \"color\" \"imagemap\"");
    EXPECT_NE(m.find("test.pbrt:2:"), std::string::npos) << m;
    EXPECT_NE(m.find("filename"), std::string::npos) << m;
    m = message("Texture \"a\" \"color\" \"imagmap\"");
    EXPECT_NE(m.find("Did you mean \"imagemap\"?"), std::string::npos) << m;
    std::ofstream(folder / "bad.png") << "this is no png";
    EXPECT_NE(
        message("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"bad.png\"").find("test.pbrt:2:"),
        std::string::npos);
    WriteFour("four.exr");
    const std::string image = "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"four.exr\" ";
    EXPECT_NE(message(image + "\"string wrap\" \"clam\"").find("Did you mean \"clamp\"?"), std::string::npos);
    EXPECT_NE(message(image + "\"string mapping\" \"cubic\"").find("spherical"), std::string::npos);
    EXPECT_NE(message("Texture \"a\" \"float\" \"checkerboard\" \"integer dimension\" 4").find("2 or 3"),
              std::string::npos);
}

TEST_F(Textures, BilerpBlendsItsCorners) {
    const std::string values =
        "\"bilerp\" \"float v00\" 1 \"float v01\" 2 \"float v10\" 3 \"float v11\" 6 \"float uscale\" 2";
    const std::string text = "Texture \"a\" \"float\" " + values;
    EXPECT_EQ(Float(text, UV(0, 0)), 1);
    EXPECT_EQ(Float(text, UV(0, 1)), 2);
    EXPECT_EQ(Float(text, UV(0.5f, 0)), 3);
    EXPECT_EQ(Float(text, UV(0.5f, 1)), 6);
    EXPECT_EQ(Float(text, UV(0.25f, 0.5f)), 3);
    EXPECT_EQ(Float(text, UV(1, 0)), 5); // goes on beyond the square
    EXPECT_EQ(Color("Texture \"a\" \"color\" \"bilerp\" \"rgb v11\" [1 0 .5]", UV(1, 1)),
              Spectrum(1, 0, 0.5f));
    EXPECT_EQ(Float("Texture \"a\" \"float\" \"bilerp\"", UV(0.3f, 0.625f)), 0.625f); // v, by default
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST_F(Textures, UVShowsTheFractions) {
    EXPECT_EQ(Color("Texture \"a\" \"color\" \"uv\" \"float uscale\" 3 \"float vdelta\" -1", UV(0.75f, 0.5f)),
              Spectrum(0.25f, 0.5f, 0));
    EXPECT_EQ(Color("Texture \"a\" \"spectrum\" \"uv\" \"string mapping\" \"planar\" \"vector v1\" [0 0 1]",
                    {{0, 2.25f, 3.5f}, {}}),
              Spectrum(0.5f, 0.25f, 0));
    EXPECT_EQ(FlushWarnings(), 0u);
}

// pbrt-v3's rule, written out again in double.
TEST_F(Textures, DotsLieWhereNoiseSaysSo) {
    const TextureTable table = Table("Texture \"a\" \"float\" \"dots\" \"float inside\" 2 \"float outside\" "
                                     "1 \"float uscale\" 3 \"float vscale\" 2");
    RNG rng(3);
    const auto noise = [](double x, double y) {
        return static_cast<double>(Noise({static_cast<float>(x), static_cast<float>(y), 0.5f}));
    };
    int inside = 0, undecided = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
        const Point2f uv{20 * rng.UniformFloat() - 10, 20 * rng.UniformFloat() - 10};
        const double s = 3 * static_cast<double>(uv.x), t = 2 * static_cast<double>(uv.y);
        const double cs = std::round(s), ct = std::round(t);
        const double r =
            std::hypot(s - cs - 0.15 * noise(cs + 1.5, ct + 2.8), t - ct - 0.15 * noise(cs + 4.5, ct + 9.8));
        const bool in = noise(cs + 0.5, ct + 0.5) > 0 && r < 0.35;
        inside += in;
        if (std::abs(r - 0.35) < 1e-4)
            ++undecided; // rounding may put it on either side
        else
            EXPECT_EQ(table.FloatTexture(0)->Evaluate({{}, uv}), in ? 2 : 1) << uv.x << ", " << uv.y;
    }
    EXPECT_LT(undecided, n / 100);
    // Some half of the cells hold a disk of area 0.385
    EXPECT_GT(inside, n * 0.385 * 0.3);
    EXPECT_LT(inside, n * 0.385 * 0.7);
    EXPECT_TRUE(std::isnan(table.FloatTexture(0)->Evaluate(UV(std::nanf(""), 0))));
}

// The noise goes through the texture's transformation as the 3D checkerboard does.
TEST_F(Textures, NoiseTexturesAreSumsOfOctaves) {
    RNG rng(4);
    const auto octaves = [](const Point3f &p, double omega, int n, bool absolute) {
        double sum = 0, weight = 1, lambda = 1;
        for (int i = 0; i < n; ++i, weight *= omega, lambda *= 1.99) {
            const double v = static_cast<double>(Noise(p * static_cast<float>(lambda)));
            sum += weight * (absolute ? std::abs(v) : v);
        }
        return sum;
    };
    const std::string end = " \"integer octaves\" 5 \"float roughness\" .7";
    const std::string move = "Scale 2 2 2 Translate 1 2 3 ";
    const TextureTable table = Table(
        move + "Texture \"a\" \"float\" \"fbm\"" + end + " Texture \"b\" \"float\" \"wrinkled\"" + end +
        " Texture \"c\" \"float\" \"windy\" Texture \"d\" \"float\" \"fbm\" Texture \"e\" \"color\" \"fbm\"" +
        end + " Texture \"f\" \"color\" \"wrinkled\"" + end + " Texture \"g\" \"color\" \"windy\"");
    EXPECT_EQ(FlushWarnings(), 0u);
    for (int i = 0; i < 1000; ++i) {
        const auto r = [&] { return 10 * rng.UniformFloat() - 5; };
        const TexturePoint point{{r(), r(), r()}, {}};
        const Point3f p = (point.p + Point3f(1, 2, 3)) * 2;
        const auto at = [&](size_t k) { return static_cast<double>(table.FloatTexture(k)->Evaluate(point)); };
        // Rounding of the point times the gradient of the finest octave
        const double fbm = octaves(p, 0.7, 5, false),
                     wrinkled = octaves(p, 0.7, 5, true) + 0.2 * std::pow(0.7, 5);
        EXPECT_NEAR(at(0), fbm, 2e-4);
        EXPECT_NEAR(at(1), wrinkled, 2e-4);
        EXPECT_NEAR(at(2), std::abs(octaves(p * 0.1f, 0.5, 3, false)) * octaves(p, 0.5, 6, false), 2e-4);
        EXPECT_NEAR(at(3), octaves(p, 0.5, 8, false), 2e-4); // the defaults
        for (size_t k = 0; k < 3; ++k)
            EXPECT_EQ(table.SpectrumTexture(k)->Evaluate(point),
                      Spectrum(table.FloatTexture(k)->Evaluate(point)));
    }
}

// The colours by de Casteljau's algorithm, in double; a reflectance stays one.
TEST_F(Textures, MarbleIsASplineOfColours) {
    const double reds[] = {.58, .58, .58, .5, .6, .58, .58, .2, .58},
                 blues[] = {.6, .6, .6, .5, .58, .6, .6, .33, .6};
    const TextureTable table =
        Table("Texture \"a\" \"color\" \"marble\" \"float scale\" 3 \"float variation\" 2 "
              "\"integer octaves\" 4 \"float roughness\" .4");
    RNG rng(5);
    float least = 1, most = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto r = [&] { return 4 * rng.UniformFloat() - 2; };
        const Point3f p{r(), r(), r()};
        const double t = 3 * (1 + std::sin(static_cast<double>(3 * p.y + 2 * FBm(p * 3, 0.4f, 4))));
        const int first = std::min(static_cast<int>(t), 5);
        const auto spline = [&](const double *c) {
            double v[4];
            std::copy(c + first, c + first + 4, v);
            for (int level = 3; level > 0; --level)
                for (int k = 0; k < level; ++k)
                    v[k] += (v[k + 1] - v[k]) * (t - first);
            return 1.5 * v[0];
        };
        const Spectrum color = table.SpectrumTexture(0)->Evaluate({p, {}});
        if (std::abs(t - std::round(t)) > 1e-4) { // rounding may take either segment there
            EXPECT_NEAR(color[0], spline(reds), 1e-4);
            EXPECT_NEAR(color[2], spline(blues), 1e-4);
        }
        least = std::min(least, color[0]), most = std::max(most, color[0]);
    }
    EXPECT_GT(least, 0.2f);
    EXPECT_LT(least, 0.8f); // dark veins
    EXPECT_LT(most, 1);
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST_F(Textures, WhatIsNotRenderedIsOneWarningOrAnError) {
    EXPECT_EQ(Color("Texture \"a\" \"color\" \"ptex\" \"string filename\" \"a.ptx\""), Spectrum(0.5f));
    EXPECT_EQ(FlushWarnings(), 1u);
    // pbrt-v3 has these in colour alone
    for (const std::string name : {"uv", "marble"}) {
        const std::string m = MessageOf([&] { Table("Texture \"a\" \"float\" \"" + name + "\""); });
        EXPECT_NE(m.find("test.pbrt:2:"), std::string::npos) << m;
        EXPECT_NE(m.find("\"color\""), std::string::npos) << m;
    }
    for (const char *octaves : {"-1", "101"}) {
        const std::string m = MessageOf(
            [&] { Table(std::string("Texture \"a\" \"float\" \"fbm\" \"integer octaves\" ") + octaves); });
        EXPECT_NE(m.find("0 to 100"), std::string::npos) << m;
    }
}

// The map of the whole sphere: poles, the four sides, and the centre that has no direction.
TEST_F(Textures, SphericalMapping) {
    Image image(4, 4, {"R", "G", "B"});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            image.At(x, y, 0) = static_cast<float>(x), image.At(x, y, 1) = static_cast<float>(3 - y);
    WriteImage((folder / "grid.exr").string(), image);
    const std::string text = "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"grid.exr\" "
                             "\"string mapping\" \"spherical\" \"string wrap\" \"clamp\"";
    // s = theta / pi, t = phi / 2 pi; texel k holds k at (k + 1/2) / 4
    for (const float phi : {0.25f * Pi, 0.75f * Pi, 1.25f * Pi, 1.75f * Pi})
        for (const float theta : {0.125f * Pi, 0.375f * Pi, 0.625f * Pi, 0.875f * Pi}) {
            const Point3f p =
                Point3f(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)) *
                7;
            const Spectrum c = Color(text, {p, {}});
            EXPECT_NEAR(c[0], 4 * theta / Pi - 0.5f, 1e-4f);
            EXPECT_NEAR(c[1], 4 * phi / (2 * Pi) - 0.5f, 1e-4f);
            // A translated texture has its pole elsewhere
            const Spectrum moved = Color("Translate 1 2 3\n" + text, {p + Point3f(1, 2, 3), {}});
            EXPECT_NEAR(moved[0], c[0], 1e-4f);
            EXPECT_NEAR(moved[1], c[1], 1e-4f);
        }
    EXPECT_TRUE(Color(text, {{0, 0, 0}, {}}).IsFinite());
    EXPECT_TRUE(Color(text, {{0, 0, -1}, {}}).IsFinite());
}

TEST_F(Textures, CylindricalAndPlanarMappings) {
    Image image(8, 1, {"Y"});
    for (int x = 0; x < 8; ++x)
        image.At(x, 0, 0) = static_cast<float>(x);
    WriteImage((folder / "ramp.exr").string(), image);
    const std::string map =
        "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"ramp.exr\" \"string wrap\" "
        "\"clamp\" \"string mapping\" ";
    // s = (pi + phi) / 2 pi
    for (const float phi : {-0.625f * Pi, -0.125f * Pi, 0.125f * Pi, 0.625f * Pi})
        EXPECT_NEAR(Float(map + "\"cylindrical\"", {{2 * std::cos(phi), 2 * std::sin(phi), 5}, {}}),
                    8 * (Pi + phi) / (2 * Pi) - 0.5f, 1e-4f);
    EXPECT_TRUE(std::isfinite(Float(map + "\"cylindrical\"", {{0, 0, 0}, {}})));
    EXPECT_NEAR(Float(map + "\"planar\" \"vector v1\" [0 .5 0] \"float udelta\" .25", {{9, 0.5f, 9}, {}}),
                8 * (0.25f + 0.25f) - 0.5f, 1e-5f);
    EXPECT_NEAR(Float(map + "\"planar\"", {{0.3f, 9, 9}, {}}), 8 * 0.3f - 0.5f, 1e-5f);
}
