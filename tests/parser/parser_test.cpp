#include "parser/test_scenes.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

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

TEST(Parser, ShapeParametersAreTheMaterialsByItsRow) {
    const std::string curve = "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] ";
    const std::string own = "\"string model\" \"deon\" \"float azimuth_R\" 9 \"float roughness_u\" .2\n";
    const std::string text = World("Material \"hair\"\n" + curve + own);
    EXPECT_EQ(WarningOf(text), "");
    const SceneDescription s = Parse(text);
    ASSERT_EQ(s.materials.size(), 3u);
    EXPECT_EQ(s.materials[2].params.FindString("model", ""), "deon");
    EXPECT_EQ(s.materials[2].params.FindFloat("azimuth_R", 0), 9);
    EXPECT_EQ(s.materials[2].params.FindFloat("roughness_u", 0), .2f);
    // Of a material that does not name it, it is the shape's, which has no use for it.
    EXPECT_TRUE(Has(WarningOf(World("Material \"matte\"\n" + curve + "\"float azimuth_R\" 9")),
                    "Shape \"curve\" has no use for parameter \"azimuth_R\""));
}

TEST(Parser, NamesOfAKindWithoutATableAreNotChecked) {
    const auto s = ParseSceneText({}, World("Shape \"spere\" Material \"hairy\""), "test.pbrt");
    EXPECT_EQ(s.shapes.at(0).type, "spere");
    EXPECT_TRUE(Has(WarningOf(World("Shape \"spere\"")), "not known"));
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

// Something stands in where pbrt-v3 prints a message and goes on.
TEST(Parser, GoesOnAsPbrtDoes) {
    auto s = Parse(World("Material \"BUSH1\" Shape \"sphere\""));
    EXPECT_EQ(s.materials[static_cast<size_t>(s.shapes[0].state.material)].type, "matte");
    s = Parse(
        World("MakeNamedMaterial \"a\" \"string type\" \"nothing\" NamedMaterial \"a\" Shape \"sphere\""));
    EXPECT_EQ(s.materials[static_cast<size_t>(s.shapes[0].state.material)].type, "matte");
    s = Parse(World("MakeNamedMaterial \"a\" NamedMaterial \"a\" Shape \"sphere\""));
    EXPECT_EQ(s.materials[static_cast<size_t>(s.shapes[0].state.material)].type, "");
    s = Parse(World("Material \"mix\" \"string namedmaterial1\" \"no\" Shape \"sphere\""));
    const MaterialEntity &mix = s.materials[static_cast<size_t>(s.shapes[0].state.material)];
    EXPECT_EQ(mix.mixed[0], 0);
    EXPECT_EQ(mix.mixed[1], 0);
    EXPECT_EQ(s.materials[0].type, "matte");
    // a texture that is none leaves the parameter at its default
    s = Parse(World("Material \"hair\" \"texture eumelanin\" \"no\" \"float beta_m\" .5 Shape \"sphere\""));
    const ParamSet &hair = s.materials[static_cast<size_t>(s.shapes[0].state.material)].params;
    ASSERT_EQ(hair.params.size(), 1u);
    EXPECT_EQ(hair.params[0].name, "beta_m");
    s = Parse(World("Texture \"t\" \"float\" \"no\" Shape \"pyramid\" LightSource \"sun\" Shape \"disk\""));
    EXPECT_TRUE(s.floatTextures.empty());
    ASSERT_EQ(s.shapes.size(), 1u);
    EXPECT_EQ(s.shapes[0].type, "disk");
    // values in excess, and of the wrong type
    s = Parse(World("Shape \"sphere\" \"rgb Kd\" [1 2 3 4] \"float radius\" \"x\" \"bool b\" \"maybe\" "
                    "\"float zmin\" 2"));
    ASSERT_EQ(s.shapes[0].params.params.size(), 3u);
    EXPECT_EQ(s.shapes[0].params.params[0].numbers, (std::vector<double>{1, 2, 3}));
    EXPECT_FALSE(s.shapes[0].params.FindBool("b", true));
    EXPECT_EQ(s.shapes[0].params.FindFloat("radius", 7), 7);
    // blocks and objects
    s = Parse("AttributeBegin " +
              World("AttributeEnd ObjectInstance \"no\" ObjectBegin \"a\" Shape \"sphere\" "
                    "ObjectInstance \"a\" ObjectEnd AttributeBegin Shape \"disk\""));
    EXPECT_EQ(s.shapes.size(), 1u);
    EXPECT_EQ(s.objects.size(), 1u);
    EXPECT_TRUE(s.instances.empty());
    s = Parse("Accelerator \"octree\" LookAt 0 1 0 0 0 0 0 1 0 CoordSysTransform \"no\" " +
              World("Shape \"sphere\""));
    EXPECT_EQ(s.accelerator.type, "bvh");
    EXPECT_TRUE(s.shapes[0].objectToWorld.IsIdentity());
    EXPECT_GT(FlushWarnings(), 15u);
}

// Curves are forgiven as CreateCurveShape of pbrt-v3 has it: an unknown type is a cylinder; what is of
// another type or has another number of values than one is not found; coordinates in excess are dropped; a
// wrong number of control points or normals, an unknown basis and another degree leave the curve out.
TEST(Parser, ForgivesCurvesAsPbrtDoes) {
    const std::string points = "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] ";
    const auto curve = [&](const std::string &rest) { return Parse(World("Shape \"curve\" " + rest)); };
    auto s = curve(points + "\"string type\" \"cylindr\" \"float width\" [3 4] \"float width1\" .5");
    ASSERT_EQ(s.curves.segments.size(), 1u);
    EXPECT_EQ(s.curveGroups[s.curves.segments[0].group].type, CurveType::Cylinder);
    EXPECT_EQ(s.curves.segments[0].width[0], 1);
    EXPECT_EQ(s.curves.segments[0].width[1], 0.5f);
    s = curve("\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 9 9] \"float type\" 1 \"string width0\" \"x\"");
    ASSERT_EQ(s.curves.segments.size(), 1u);
    EXPECT_EQ(s.curveGroups[s.curves.segments[0].group].type, CurveType::Flat);
    EXPECT_EQ(s.curves.segments[0].cp[3], Point3f(3, 0, 0));
    for (const std::string &left :
         {points + "\"integer degree\" 4", points + "\"string basis\" \"hermite\"",
          points + "\"string type\" \"ribbon\"", std::string("\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0]"),
          points + "\"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1 0 0 1]",
          points + "\"string type\" \"ribbon\" \"vector N\" [0 0 1 0 0 1]"}) {
        s = curve(left + " Shape \"sphere\"");
        EXPECT_TRUE(s.curves.segments.empty()) << left;
        EXPECT_EQ(s.shapes.size(), 1u) << left;
        const StrictWarnings strict;
        EXPECT_THROW(curve(left), Error) << left;
    }
    FlushWarnings();
}

// A matrix that scales by its last element is none that projects.
TEST(Parser, HomogeneousMatricesAreAffine) {
    const auto s = Parse(World("Transform [2 0 0 0 0 2 0 0 0 0 2 0 4 6 8 2] Shape \"sphere\""));
    ExpectNear(ImageOf(s.shapes[0].objectToWorld, {1, 1, 1}), {3, 4, 5}, 0);
    EXPECT_EQ(s.shapes[0].objectToWorld.M()[3][3], 1);
}

} // namespace
} // namespace cuticle
