#include "parser/test_scenes.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

struct Wrong {
    const char *text;
    const char *place;   // "line:column"
    const char *message; // a part of it
};

// To add one: a row here.
constexpr Wrong kWrong[] = {
    // directives
    {"WorldBegin\n  Shpe \"sphere\"", "2:3", "directive \"Shpe\" is not known. Did you mean \"Shape\"?"},
    {"WorldBegin Shape sphere", "1:18", "Shape needs a type in quotes, found \"sphere\""},
    {"Camera \"perspectiv\"", "1:8", "Did you mean \"perspective\"?"},
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
    // blocks
    {"WorldBegin\nAttributeBegin\nTransformEnd", "3:1",
     "inside the block of AttributeBegin at test.pbrt:2:1"},
    // parameters
    {"Camera \"perspective\" \"float fov\"", "1:33",
     "expected the value of \"float fov\", found the end of the file"},
    {"Camera \"perspective\" \"float fov\" 30 40", "1:37", "several values of one parameter need brackets"},
    {"Camera \"perspective\" \"float fov\" true", "1:34", "\"float fov\" takes numbers, not \"true\""},
    {"Camera \"perspective\" \"float fov\" [30 \"x\"]", "1:22", "strings as well as numbers"},
    {"Camera \"perspective\" \"string s\" true", "1:33", "takes strings in quotes"},
    {"Camera \"perspective\" \"spectrum c\" [0 1]", "1:22",
     "a wavelength of \"spectrum c\" is 0; it must be above 0"},
    {"Camera \"perspective\" \"blackbody c\" [3.4e38 90]", "1:22",
     "the temperature of \"blackbody c\" is 3.4e+38; "},
    {"Camera \"perspective\" \"blackbody c\" [5000 3.4e38 5000 1e38]", "1:22",
     "the colour of \"blackbody c\" has the red inf"},
    {"Camera \"perspective\" \"xyz c\" [3e38 0 0]", "1:22", "the colour of \"xyz c\" has the red inf"},
    {"Camera \"perspective\" \"spectrum c\" [400 3e38 700 3e38]", "1:22", "\"spectrum c\""},
    {"Transform [1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 1]\nCamera \"perspective\"", "1:1",
     "the matrix is projective (its last row, each fourth number, is 0 0 1 1), which only a light of "
     "directions (infinite, distant) can be, not what stands at test.pbrt:2:1"},
    {"Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 0]", "1:1", "cannot be inverted"},
    {"Scale 2 2 2\nConcatTransform [1 0 0 .5 0 1 0 0 0 0 1 0 0 0 0 1]\nTranslate 1 0 0 Camera "
     "\"perspective\"",
     "2:1", "ConcatTransform: the matrix is projective"},
    {"WorldBegin AttributeBegin\nTransform [1 0 0 .5 0 1 0 0 0 0 1 0 0 0 0 1] Scale 2 2 2 "
     "LightSource \"point\"",
     "2:1", "Transform: the matrix is projective"},
    {"Camera \"perspective\" \"blackbody c\" [-5 1]", "1:22",
     "the temperature of \"blackbody c\" is -5; it must be above 0"},
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
    {"Camera \"perspective\" \"float f\" [1 Infinity]", "1:35", "not-a-number and infinity have no place"},
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
    {"WorldBegin\nScale 1e30 1e30 1e30 Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 1e30 0 0]", "2:22",
     "out of range after the transformation"},
};

// Each is a warning, and an error in strict mode: pbrt-v3 prints a message and goes on. To add one: a row
// here.
constexpr Wrong kForgiven[] = {
    {"WorldBegin\nShape \"spere\"", "2:7",
     "Shape \"spere\" is not known; it is left out, as by pbrt-v3. Did you mean \"sphere\"?"},
    {"WorldBegin\nMaterial \"hairy\"", "2:10", "Did you mean \"hair\"?"},
    {"WorldBegin MakeNamedMaterial \"a\"\n \"string type\" \"plastik\"", "2:2", "Did you mean \"plastic\"?"},
    {"WorldBegin MakeNamedMaterial \"a\"", "1:12", "needs a parameter \"string type\""},
    {"WorldBegin Texture \"a\" \"colour\" \"scale\"", "1:24",
     "must be \"float\", \"color\" or \"spectrum\", not \"colour\"; it is left out, as by pbrt-v3. Did you "
     "mean \"color\"?"},
    {"WorldBegin Texture \"a\" \"color\" \"imagmap\"", "1:32", "Did you mean \"imagemap\"?"},
    {"Shape \"sphere\"", "1:1", "WorldBegin has not come yet"},
    {"WorldBegin WorldBegin", "1:12", "a second WorldBegin"},
    {"CoordSysTransform \"camra\"", "1:19", "no coordinate system \"camra\""},
    {"WorldBegin ObjectInstance \"x\"", "1:27", "no object \"x\" has been defined"},
    {"WorldBegin ObjectBegin \"a\" ObjectBegin \"b\"", "1:28", "which has no ObjectEnd yet"},
    {"WorldBegin ObjectBegin \"a\" ObjectInstance \"a\"", "1:28", "inside the definition of an object"},
    {"WorldBegin Material \"matte\" \"texture Kd\" \"wod\"", "1:42",
     "no texture \"wod\" has been defined here"},
    {"WorldBegin Texture \"wood\" \"color\" \"constant\"\nMaterial \"matte\" \"texture Kd\" \"wod\"", "2:31",
     "Did you mean \"wood\"?"},
    {"WorldBegin AttributeEnd", "1:12", "AttributeEnd without AttributeBegin"},
    {"WorldBegin\nAttributeBegin\nWorldEnd", "3:1",
     "AttributeBegin at test.pbrt:2:1 has no AttributeEnd before WorldEnd"},
    {"WorldBegin\nTransformBegin\n", "3:1",
     "TransformBegin at test.pbrt:2:1 has no TransformEnd before the end of the file"},
    {"WorldBegin ObjectBegin \"a\" WorldEnd", "1:28", "ObjectBegin at test.pbrt:1:12 has no ObjectEnd"},
    {"WorldBegin ObjectEnd", "1:12", "ObjectEnd without ObjectBegin"},
    {"Camera \"perspective\" \"fov\" 30", "1:22", "\"type name\""},
    {"Camera \"perspective\" \"float fov x\" 30", "1:22", "\"type name\""},
    {"Camera \"perspective\" \"flaot fov\" 30", "1:22",
     "parameter type \"flaot\" is not known, and \"flaot fov\" is ignored, as by pbrt-v3. Did you mean "
     "\"float\"?"},
    {"Camera \"perspective\" \"int fov\" 30", "1:22", "is ignored, as by pbrt-v3. Did you mean \"integer\"?"},
    {"Camera \"perspective\" \"float fov\" \"30\"", "1:34", "\"float fov\" takes numbers, not \"30\""},
    {"Camera \"perspective\" \"string s\" 1", "1:22", "takes a string in quotes, not 1; it is ignored"},
    {"Camera \"perspective\" \"bool b\" 1", "1:22", "takes \"true\" or \"false\", not 1; it is ignored"},
    {"Camera \"perspective\" \"bool b\" \"yes\"", "1:31", "takes \"true\" or \"false\", not \"yes\""},
    {"Camera \"perspective\" \"rgb c\" [1 2]", "1:22",
     "a colour of 3 numbers (or several), not 2 numbers (the last is 2); it is ignored"},
    {"Camera \"perspective\" \"rgb c\" []", "1:22", "not 0 numbers"},
    {"Camera \"perspective\" \"spectrum c\" [400 1 500]", "1:22",
     "pairs of wavelength in nm and value, not 3"},
    {"Camera \"perspective\" \"spectrum c\" \"no.spd\"", "1:35", "cannot open the spectrum file"},
    {"Camera \"perspective\" \"texture t\" [\"a\" \"b\"]", "1:22", "the name of one texture, not 2"},
    // curves
    {"WorldBegin\nShape \"curve\" \"float width\" 1", "2:1", "needs control points"},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 1 1 2 2 2]", "2:1",
     "Shape \"curve\": 3 control points for a curve of degree 3 in the Bezier basis: n * 3 + 1 are needed, n "
     ">= "
     "1; the curve is left out, as by pbrt-v3"},
    {"WorldBegin\nShape \"curve\" \"string basis\" \"bspline\" \"point P\" [0 0 0 1 1 1 2 2 2]", "2:1",
     "at least 4 are needed; the curve is left out, as by pbrt-v3"},
    {"WorldBegin\nShape \"curve\"\n  \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4]", "3:3",
     "no multiple of 3; the last is ignored, as by pbrt-v3"},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribbon\" \"normal "
     "N\" "
     "[0 0 1]",
     "2:74", "1 normals for a ribbon of 1 segments: 2 are needed; the curve is left out, as by pbrt-v3"},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float type\" 1", "2:51",
     "\"type\" is written \"string type\" name; it is ignored, as by pbrt-v3"},
    {"WorldBegin\nShape \"curve\" \"float P\" [0 0 0 1 1 1 2 2 2 3 3 3]", "2:15",
     "\"P\" is written \"point P\""},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n\"string type\" \"cylindr\"", "3:1",
     "it is taken as \"cylinder\", as by pbrt-v3 (Did you mean \"cylinder\"?)"},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n \"integer degree\" 4", "3:2",
     "must be 2 or 3"},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string basis\" \"hermite\"", "2:51",
     "\"basis\" cannot be \"hermite\""},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribbon\"", "2:1",
     "needs \"normal N\""},
    {"WorldBegin\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" [1 2]", "2:51",
     "takes one number, not 2; it is ignored, as by pbrt-v3"},
};

TEST(ParserErrors, NameThePlaceAndWhatWouldBeRight) {
    for (const Wrong &c : kWrong) {
        const std::string error = ErrorOf(c.text);
        EXPECT_TRUE(error.starts_with("test.pbrt:" + std::string(c.place) + ": error: "))
            << c.text << "\ngave " << error;
        EXPECT_TRUE(Has(error, c.message)) << c.text << "\ngave " << error;
    }
    FlushWarnings();
}

TEST(ParserErrors, WhatPbrtForgivesIsAWarning) {
    for (const Wrong &c : kForgiven) {
        const std::string warning = WarningOf(c.text);
        EXPECT_TRUE(warning.starts_with("test.pbrt:" + std::string(c.place) + ": error: "))
            << c.text << "\ngave " << warning;
        EXPECT_TRUE(Has(warning, c.message)) << c.text << "\ngave " << warning;
        const bool hasWorld = Has(c.text, "WorldBegin");
        EXPECT_EQ(ErrorOf(c.text + std::string(hasWorld ? "" : " WorldBegin WorldEnd")), "") << c.text;
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
    const auto s = ParseSceneText(TestPlugins(),
                                  "Film \"rgb\"\nCamera \"perspective\" \"float fov\" x\nWorldBegin\nShape "
                                  "\"sphere\" \"float radius\" [1\n"
                                  "Shape \"disk\"\nAttributeEnd\nShape \"curve\" \"point P\" [0 0 "
                                  "0]\n\"unclosed\nShape \"sphere\"\nWorldEnd",
                                  "test.pbrt", ".", options);
    EXPECT_EQ(s.shapes.size(), 2u);
    const char *places[] = {"1:6", "2:34", "4:31", "8:1"};
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
    const auto s = ParseSceneText(TestPlugins(), World("Include \"utf16.pbrt\"\nShape \"sphere\""), "t",
                                  folder.Path(), options);
    EXPECT_EQ(s.shapes.size(), 1u);
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_TRUE(Has(errors[0], "utf16.pbrt:1:1: error: this is UTF-16 text")) << errors[0];
}

} // namespace
} // namespace cuticle
