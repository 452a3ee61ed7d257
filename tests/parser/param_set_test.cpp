#include "parser/param_set.h"
#include "parser/test_scenes.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

ParamSet Params(const std::string &text) {
    return ParseSceneText(TestPlugins(), "WorldBegin Shape \"sphere\"\n" + text + "\nWorldEnd", "t.pbrt",
                          "scenes")
        .shapes.at(0)
        .params;
}

template <typename Call>
std::string ErrorOfCall(const Call &call) {
    try {
        call();
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

TEST(ParamSet, ValuesAndDefaults) {
    const ParamSet p =
        Params("\"bool b\" \"true\" \"integer i\" -7 \"float f\" .5 \"string s\" \"x\" \"rgb c\" [1 2 3]\n"
               "\"point p\" [1 2 3] \"vector v\" [4 5 6]");
    EXPECT_TRUE(p.FindBool("b", false));
    EXPECT_EQ(p.FindInt("i", 0), -7);
    EXPECT_EQ(p.FindFloat("f", 0), .5f);
    EXPECT_EQ(p.FindFloat("i", 0), -7); // an integer serves as a float
    EXPECT_EQ(p.FindString("s", ""), "x");
    EXPECT_EQ(p.FindSpectrum("c", Spectrum(0)), Spectrum(1, 2, 3));
    EXPECT_EQ(p.FindPoint3f("p", {}), Point3f(1, 2, 3));
    EXPECT_EQ(p.FindVector3f("v", {}), Vector3f(4, 5, 6));
    EXPECT_TRUE(p.FindBool("none", true));
    EXPECT_EQ(p.FindInt("none", 3), 3);
    EXPECT_EQ(p.FindFloat("none", 3), 3);
    EXPECT_EQ(p.FindString("none", "d"), "d");
    EXPECT_EQ(p.FindSpectrum("none", Spectrum(2)), Spectrum(2));
    EXPECT_EQ(p.FindPoint3f("none", {1, 1, 1}), Point3f(1, 1, 1));
    EXPECT_EQ(p.FindVector3f("none", {1, 1, 1}), Vector3f(1, 1, 1));
    EXPECT_TRUE(ParamSet().empty());
    EXPECT_FALSE(p.empty());
}

TEST(ParamSet, Arrays) {
    const ParamSet p =
        Params("\"float f\" [1 2 3 4] \"integer i\" [1 2] \"point2 q\" [1 2 3 4] \"point P\" [1 2 3 4 5 6]\n"
               "\"normal N\" [0 0 1] \"vector S\" [1 0 0]");
    EXPECT_EQ(p.FindFloats("f"), (std::vector<float>{1, 2, 3, 4}));
    EXPECT_EQ(p.FindFloats("i"), (std::vector<float>{1, 2}));
    EXPECT_EQ(p.FindInts("i"), (std::vector<int>{1, 2}));
    EXPECT_EQ(p.FindPoint2fs("q"), (std::vector<Point2f>{{1, 2}, {3, 4}}));
    EXPECT_EQ(p.FindPoint2fs("f"), (std::vector<Point2f>{{1, 2}, {3, 4}})); // pbrt's "float uv"
    EXPECT_EQ(p.FindPoint3fs("P"), (std::vector<Point3f>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(p.FindPoint3fs("S"), (std::vector<Point3f>{{1, 0, 0}}));
    EXPECT_EQ(p.FindNormals("N"), (std::vector<Normal3f>{{0, 0, 1}}));
    EXPECT_TRUE(p.FindFloats("none").empty());
    EXPECT_TRUE(p.FindInts("none").empty());
    EXPECT_TRUE(p.FindPoint2fs("none").empty());
    EXPECT_TRUE(p.FindPoint3fs("none").empty());
    EXPECT_TRUE(p.FindNormals("none").empty());
}

// Out of range is an Error, the rest a Warning, after which the default counts.
TEST(ParamSet, WrongTypeCountOrRangeIsToldAtThePlace) {
    const ParamSet p =
        Params("  \"string s\" \"x\" \"float f\" [1 2] \"float h\" .5 \"integer i\" .5 \"integer j\" 3e9 "
               "\"integer k\" -3e9\n"
               "\"point P\" [1 2 3 4] \"rgb c\" [1 2 3 4 5 6] \"bool b\" [true false] \"float e\" []");
    EXPECT_EQ(p.FindFloat("s", 7), 7);
    EXPECT_EQ(p.FindFloat("f", 7), 7);
    EXPECT_EQ(p.FindInt("i", 7), 0);
    EXPECT_EQ(p.FindPoint3fs("P").size(), 1u);
    EXPECT_EQ(p.FindSpectrum("c", Spectrum(7)), Spectrum(7));
    EXPECT_EQ(FlushWarnings(), 5u);
    const StrictWarnings strict;
    const auto expect = [](const std::string &error, const std::string &place, const std::string &message) {
        EXPECT_TRUE(error.starts_with("t.pbrt:" + place + ": error: ")) << error;
        EXPECT_TRUE(Has(error, message)) << error;
    };
    expect(ErrorOfCall([&] { p.FindFloat("s", 0); }), "2:3", "it must be \"float s\"");
    expect(ErrorOfCall([&] { p.FindFloats("s"); }), "2:3", "it must be \"float s\"");
    expect(ErrorOfCall([&] { p.FindInt("h", 0); }), "2:34", "it must be \"integer h\"");
    expect(ErrorOfCall([&] { p.FindFloat("f", 0); }), "2:18", "must have one value, not 2 values");
    expect(ErrorOfCall([&] { p.FindFloat("e", 0); }), "3:65", "must have one value, not 0 values");
    expect(ErrorOfCall([&] { p.FindInt("i", 0); }), "2:47", "must be a whole number");
    expect(ErrorOfCall([&] { p.FindInt("j", 0); }), "2:62", "out of range");
    expect(ErrorOfCall([&] { p.FindInts("k"); }), "2:78", "out of range");
    expect(ErrorOfCall([&] { p.FindPoint3fs("P"); }), "3:1", "has 4 numbers, which is no multiple of 3");
    expect(ErrorOfCall([&] { p.FindPoint3f("P", {}); }), "3:1", "three numbers");
    expect(ErrorOfCall([&] { p.FindNormals("P"); }), "3:1", "it must be \"normal P\"");
    expect(ErrorOfCall([&] { p.FindSpectrum("c", Spectrum(0)); }), "3:21", "must have one colour, not 2");
    expect(ErrorOfCall([&] { p.FindBool("b", true); }), "3:43", "one value");
    expect(ErrorOfCall([&] { p.FindString("f", ""); }), "2:18", "it must be \"string f\"");
    expect(ErrorOfCall([&] { p.FindPoint2fs("c"); }), "3:21", "it must be \"point2 c\"");
}

TEST(ParamSet, ErrorShowsTheLineOfAFileLongAfterParsing) {
    const TemporaryFolder folder;
    const std::string path =
        folder.Write("s.pbrt", "\nCamera \"perspective\" \"integer i\" 3e9\nWorldBegin WorldEnd");
    const SceneDescription s = ParseScene(TestPlugins(), path);
    EXPECT_EQ(ErrorOfCall([&] { s.camera.params.FindInt("i", 0); }),
              path +
                  ":2:22: error: \"i\" is 3e+09, which is out of range (an integer has 32 bits)\n"
                  "    Camera \"perspective\" \"integer i\" 3e9\n    " +
                  std::string(21, ' ') + "^");
}

TEST(ParamSet, UnusedParametersAreReported) {
    FlushWarnings();
    const ParamSet p = Params("\"float a\" 1 \"float b\" 2 \"float c\" 3");
    p.FindFloat("b", 0);
    EXPECT_NE(p.Find("c"), nullptr); // looking does not count as reading
    p.ReportUnused("Shape \"sphere\"");
    EXPECT_EQ(FlushWarnings(), 2u);
    EXPECT_NE(p.Find("c", ParamType::Float), nullptr);
    EXPECT_EQ(p.Find("a", ParamType::String), nullptr); // another type: neither given nor marked
    const StrictWarnings strict;
    const std::string warning = ErrorOfCall([&] { p.ReportUnused("Shape \"sphere\""); });

    EXPECT_TRUE(warning.starts_with("t.pbrt:2:1: error: Shape \"sphere\" has no use for parameter \"a\""))
        << warning;
}

TEST(ParamSet, FileNames) {
    const ParamSet p = Params("\"string a\" \"textures/x.exr\" \"string b\" \"/root.exr\"");
    EXPECT_EQ(p.FindFilename("a"), "scenes/textures/x.exr");
    EXPECT_EQ(p.FindFilename("b"), "/root.exr");
    EXPECT_EQ(p.FindFilename("none"), "");
    EXPECT_EQ(ResolveFilename("", "x"), "x");
    EXPECT_EQ(ResolveFilename("a/", "x"), "a/x");
}

} // namespace
} // namespace cuticle
