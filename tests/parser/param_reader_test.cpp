#include "parser/spd_file.h"
#include "parser/test_scenes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

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

} // namespace
} // namespace cuticle
