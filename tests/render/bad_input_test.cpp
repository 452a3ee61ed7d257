// Numbers without meaning, from scene text to pixel: each is refused at its place, or used within bounds with
// a warning that says where; no sample becomes NaN or infinite.
#include "render/renderer.h"
#include "warnings.h"

#include "core/error.h"
#include "grooms/hair_file.h"
#include "grooms/procedural.h"
#include "render/plugins.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <unistd.h>

using namespace cuticle;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Files that a scene names; gone with the test.
class BadInput : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::temp_directory_path() / ("cuticle-bad-input-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string Write(const std::string &name, const std::string &bytes) const {
        const std::string path = (folder_ / name).string();
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }

    // A PFM picture, little-endian, of these values (RGB), `width` of them a row.
    std::string WritePfm(const std::string &name, int width, const std::vector<float> &values) const {
        const int height = static_cast<int>(values.size()) / (3 * width);
        std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1\n";
        for (const float v : values) {
            char four[4];
            std::memcpy(four, &v, 4);
            bytes.append(four, 4);
        }
        return Write(name, bytes);
    }

    // A scene with what the options and the world add to it, both in lines of their own: 3 and 5.
    static std::string Text(const std::string &options, const std::string &world) {
        return "LookAt 0 0 3 0 0 0 0 1 0\n"
               "Camera \"perspective\" \"float fov\" 40 Sampler \"halton\" \"integer pixelsamples\" 4 "
               "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n" +
               options +
               "\nWorldBegin LightSource \"infinite\" \"rgb L\" [.5 .5 .5] LightSource \"point\" \"point "
               "from\" [0 2 2]\n" +
               world + "\n" +
               R"(Shape "sphere" "float radius" .8
Material "hair" Shape "curve" "point P" [-1 0 1 0 1 1 0 -1 1 1 0 1] "float width" .3
WorldEnd
)";
    }

    struct Outcome {
        std::string error, warnings;
        RenderStats stats;
        bool finite = true; // every pixel
    };
    Outcome Run(const std::string &text) const {
        Outcome o;
        testing::internal::CaptureStderr();
        try {
            SceneDescription description = ParseSceneText(AllPlugins(), text, "test.pbrt", folder_.string());
            const Scene scene(&description, {});
            RenderOptions options;
            const Image image = Render(description, scene, options, &o.stats);
            for (const float v : image.data)
                o.finite &= std::isfinite(v);
        } catch (const Error &e) {
            o.error = e.what();
        }
        FlushWarnings();
        o.warnings = testing::internal::GetCapturedStderr();
        return o;
    }

    std::filesystem::path folder_;
};

struct BadInputCase {
    const char *options, *world, *says;
};

} // namespace

// Long because: it is a table of cases.
TEST_F(BadInput, IsRefusedAtItsPlace) {
    GroomParams many = MakeGroomParams("ball", "");
    many.strands = 14000, many.segments = 1;
    WriteHairFile((folder_ / "many.hair").string(), MakeGroom(many));
    std::string giants;
    for (int i = 0; i < 2000; ++i)
        giants += "Shape \"curve\" \"point P\" [0 0 0 .3 0 0 .6 0 0 1 0 0] \"float width\" 1e16 ";
    const BadInputCase rows[] = {
        // Numbers
        {"Film \"image\" \"integer xresolution\" 1e999", "", "3:36: error: the number 1e999 is out of range"},
        {"Film \"image\" \"integer xresolution\" 1000000000000000000000000000000", "",
         "an integer has 32 bits"},
        {"Film \"image\" \"float scale\" nan", "", "3:28: error: expected the value"},
        {"Scale 1 inf 1", "", "not-a-number and infinity have no place"},
        {"Scale 1e300 1 1", "", "3:7: error: the number"},
        {"Scale 0 1 1", "", "3:1: error: Scale makes a transformation that cannot be inverted"},
        {"",
         "Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 "
         "Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 Scale 1e38 1e38 1e38 Scale 1e38 "
         "1e38 1e38",
         "cannot be inverted"},
        {"", "AttributeBegin Translate 3e38 0 0 Shape \"sphere\" AttributeEnd",
         "test.pbrt:5:35: error: sphere: its coordinates are not finite"},
        {"", "Material \"matte\" \"xyz Kd\" [3e38 0 0]", "the colour of \""},
        {"", "Material \"matte\" \"blackbody Kd\" [5000 3e38]", "the colour of \""},
        {"", "Material \"matte\" \"blackbody Kd\" [0 1]", "is 0; it must be above 0"},
        {"", "Material \"matte\" \"spectrum Kd\" [400 3e38 500 -3e38 600 3e38]",
         "the colour of \"spectrum Kd\" has the red inf"},
        // Film
        {"Film \"image\" \"integer xresolution\" 1000000000", "", "3:1: error: a film of 1000000000 x 720"},
        {"Film \"image\" \"integer xresolution\" 0", "", "3:1: error: a film of 0 x 720"},
        {"Film \"image\" \"integer yresolution\" -5", "", "3:1: error: a film of 1280 x -5"},
        {"Film \"image\" \"float scale\" 3e38", "", "3:1: error: the film's \"scale\""},
        {"Film \"image\" \"float scale\" 0", "", "3:1: error: the film's \"scale\""},
        {"Film \"image\" \"float maxsampleluminance\" -1", "",
         "3:1: error: the film's \"maxsampleluminance\""},
        {"Film \"image\" \"float cropwindow\" [.5 .5 0 1]", "", "3:1: error: the crop window holds no pixel"},
        // Sampler
        {"Sampler \"halton\" \"integer pixelsamples\" 1000000000000", "",
         "3:18: error: \"pixelsamples\" is 1e+12, which is out of range"},
        {"Sampler \"halton\" \"integer pixelsamples\" 2000000000", "",
         "3:1: error: sampler: the samples per pixel"},
        {"Sampler \"halton\" \"integer pixelsamples\" 0", "", "3:1: error: sampler: the samples per pixel"},
        {"Sampler \"halton\" \"integer pixelsamples\" -4", "", "3:1: error: sampler: the samples per pixel"},
        {"Sampler \"stratified\" \"integer xsamples\" 100000 \"integer ysamples\" 100000", "",
         "3:1: error: sampler"},
        {"Sampler \"stratified\" \"integer xsamples\" 0", "", "3:1: error: sampler"},
        // Filter
        {"PixelFilter \"box\" \"float xwidth\" 0", "", "3:1: error: filter box: its width"},
        {"PixelFilter \"gaussian\" \"float xwidth\" 1e38", "", "3:1: error: filter gaussian: its width"},
        {"PixelFilter \"gaussian\" \"float alpha\" -1e30", "", "3:1: error: filter gaussian"},
        {"PixelFilter \"mitchell\" \"float B\" 1e38", "", "3:1: error: filter mitchell"},
        {"PixelFilter \"sinc\" \"float tau\" 0", "", "3:1: error: filter sinc: tau"},
        // Camera
        {"Camera \"perspective\" \"float fov\" 180", "", "3:1: error: camera: fov"},
        {"Camera \"perspective\" \"float fov\" -3e38", "", "3:1: error: camera: fov"},
        {"Camera \"perspective\" \"float lensradius\" -1", "", "3:1: error: camera: lensradius"},
        {"Camera \"perspective\" \"float lensradius\" 3e38", "",
         "3:1: error: the camera's rays are out of range"},
        {"Camera \"perspective\" \"float focaldistance\" 0", "", "3:1: error: camera: focaldistance"},
        {"Camera \"perspective\" \"float focaldistance\" 1e-40 \"float lensradius\" 1", "",
         "3:1: error: the camera's rays are out of range"},
        {"Camera \"perspective\" \"float screenwindow\" [-3e38 3e38 -1 1]", "", "3:1: error: camera"},
        {"Camera \"perspective\" \"float screenwindow\" [1 1 -1 1]", "", "3:1: error: camera: screenwindow"},
        {"Camera \"perspective\" \"float frameaspectratio\" 0", "", "3:1: error: camera: frameaspectratio"},
        {"LookAt 2e18 0 0 0 0 0 0 1 0 Camera \"perspective\"", "",
         "3:29: error: the camera's rays are out of range: one begins at 2e+18 0 0"},
        {"Translate 0 0 3e18 Camera \"orthographic\"", "", "3:20: error: the camera's rays are out of range"},
        {"Translate 0 0 3e18 Camera \"environment\"", "", "3:20: error: the camera's rays are out of range"},
        {"Camera \"orthographic\" \"float screenwindow\" [2e18 3e18 0 1]", "",
         "3:1: error: the camera's rays"},
        {"Transform [1 0 0 0 0 1 0 0 0 0 1 .1 0 0 5 1] Camera \"perspective\"", "",
         "3:1: error: Transform: the matrix is projective"},
        {"Scale 1e38 1e38 1e38 Camera \"perspective\" \"float fov\" 30", "",
         "3:22: error: the camera's rays"},
        // Integrator
        {"Integrator \"path\" \"integer maxdepth\" -1", "", "3:1: error: \"maxdepth\""},
        {"Integrator \"path\" \"integer maxdepth\" 3000000000", "",
         "\"maxdepth\" is 3e+09, which is out of range"},
        // Lights
        {"", "LightSource \"distant\" \"point from\" [1 1 1] \"point to\" [1 1 1]",
         "5:1: error: distant light"},
        {"",
         "Shape \"sphere\" AttributeBegin Translate 3e38 0 0 LightSource \"point\" \"point from\" [3e38 0 0] "
         "AttributeEnd",
         "5:50: error: point light: its place (inf"},
        {"", "LightSource \"spot\" \"point from\" [0 3 3.4e38]",
         "5:1: error: spot light: its place (0, 3, 3.4e+38)"},
        {"", "Translate 0 0 2e18 LightSource \"goniometric\" Identity",
         "error: goniometric light: its place"},
        {"", "Translate 0 0 2e18 LightSource \"projection\" Identity", "error: projection light: its place"},
        {"", "LightSource \"spot\" \"point from\" [1 1 1] \"point to\" [1 1 1]", "5:1: error: spot light"},
        {"", "LightSource \"spot\" \"float coneangle\" 3e38", "5:1: error: spot light: coneangle"},
        // Shapes
        {"", "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]",
         "5:1: error: triangle mesh: 2 indices"},
        {"", "Shape \"hairfile\" \"string filename\" \"nowhere.hair\"", " (used at test.pbrt:5:1)"},
        {"", "Shape \"groom\" \"integer strands\" 2000000000", "5:1: error: "},
        {"", "Shape \"groom\" \"integer strands\" -1", "5:1: error: "},
        {"", "Shape \"groom\" \"integer strands\" 4000000 \"integer segments\" 1000",
         "5:1: error: there would be 4000000000 curve segments"},
        {"", "Shape \"hairfile\" \"string filename\" \"many.hair\" \"integer segments\" 10000",
         "5:1: error: there would be 140000001 curve segments"},
        {"", "Shape \"hairfile\" \"string filename\" \"many.hair\" \"float widthscale\" 1e36",
         "5:1: error: 14000 curve segments are wider"},
        {"", "Shape \"hairfile\" \"string filename\" \"many.hair\" \"float width\" 1e36",
         "5:1: error: 14000 curve segments are wider"},
        {"", "Shape \"groom\" \"integer strands\" 2000 \"float width\" 1e36", "5:1: error: "},
        {"", "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3e38 0 0]",
         "5:1: error: Shape \"curve\": a control point"},
        {"", "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 3e38",
         "5:1: error: Shape \"curve\": the width"},
        {"",
         "AttributeBegin Scale 1e30 1e30 1e30 Shape \"hairfile\" \"string filename\" \"many.hair\" "
         "AttributeEnd",
         "error: a strand is out of range"},
        {"", "Material \"hair\" \"string model\" \"tabulated\" \"integer samples\" 100000000",
         "error: \"samples\" must be"},
        {"", giants.c_str(), "5:1: error: 2000 curve segments are wider"},
        {"", "Shape \"groomhead\" \"float spacing\" 1e-30", "5:1: error: the spacing"},
        {"", "Scale 1e38 1 1 Shape \"curve\" \"point P\" [3e38 0 0 3e38 0 0 2 0 0 3 0 0]",
         "out of range after the transformation"},
        // Instances: rays in their space
        {"",
         "ObjectBegin \"a\" Shape \"sphere\" \"float radius\" 9e17 ObjectEnd Scale 1e-18 1e-18 1e-18 "
         "ObjectInstance \"a\" Identity",
         "error: the instance's transformation is extreme"},
        {"",
         "Shape \"sphere\" \"float radius\" 30 ObjectBegin \"a\" Shape \"sphere\" \"float radius\" 1e17 "
         "ObjectEnd Scale 1e-17 1e-17 1e-17 ObjectInstance \"a\" Identity",
         "error: the instance's transformation is extreme"},
        // ... whose origins are near and whose directions are long, or too short
        {"",
         "Scale 1e-17 1e-17 1e-17 ObjectBegin \"a\" Shape \"sphere\" \"float radius\" 1e17 ObjectEnd "
         "Scale 1e-17 1e-17 1e-17 ObjectInstance \"a\" Identity",
         "error: the instance's transformation is extreme: it scales by 1e+34"},
        {"",
         "ObjectBegin \"a\" Shape \"sphere\" \"float radius\" 1e-20 ObjectEnd Scale 1e21 1e21 1e21 "
         "ObjectInstance \"a\" Identity",
         "error: the instance's transformation is extreme: it scales by 1e+21"},
        {"",
         "ObjectBegin \"a\" Shape \"sphere\" \"float radius\" 10 ObjectEnd Scale 3e17 1 1 ObjectInstance "
         "\"a\" "
         "Identity",
         "the instance's coordinates are not finite or beyond 1e18"},
        // Textures
        {"", "Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 1000000000", "dimension"},
    };
    for (const BadInputCase &row : rows) {
        const Outcome o = Run(Text(row.options, row.world));
        EXPECT_TRUE(o.error.find(row.says) != std::string::npos)
            << row.options << row.world << "\n  says: " << o.error << "\n  not: " << row.says;
        EXPECT_TRUE(o.error.find("test.pbrt:") != std::string::npos) << o.error;
    }
}

// A scene that can be drawn all the same is drawn, without a sample that is not a number. Warnings name
// a place.
// Long because: it is a table of cases.
TEST_F(BadInput, IsDrawnWithinBounds) {
    WritePfm("nan.pfm", 2, {kNaN, 0, 0, Infinity, 1, 1, -Infinity, 1, kNaN, 1, 1, 1});
    WritePfm("huge.pfm", 2, {3e38f, 3e38f, 0, 3e38f, 3e38f, 3e38f, 1, 1, 1, 1, 1, 1});
    const std::string mesh =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty "
        "float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
    Write("nan.ply", mesh + "-1 -1 0 nan 0 1 0 0\n1 -1 0 0 0 1 inf 0\n1 1 0 0 0 1 1 nan\n-1 nan 0 0 0 1 0 1\n"
                            "3 0 1 2\n3 0 2 3\n");
    Write("overflow.ply",
          mesh + "-1 -1 0 0 0 1e39 0 0\n1 -1 0 0 0 1 1e999 0\n1 1 0 0 0 1 1 -1e999\n-1 1e40 0 0 0 1 0 1\n"
                 "3 0 1 2\n3 0 2 3\n");
    const std::string material = "Material \"matte\" \"texture Kd\" \"t\"";
    const std::string nanMap = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"nan.pfm\" ";
    const struct {
        std::string options, world, says; // "": nothing
    } rows[] = {
        {"", nanMap + material,
         "test.pbrt:5:35: warning: 4 values of the texture's image are NaN or infinite"},
        {"",
         "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"huge.pfm\" \"float scale\" 1e30 " +
             material,
         "test.pbrt:5:35: warning: 5 values"},
        {"", "LightSource \"infinite\" \"string mapname\" \"nan.pfm\"", "test.pbrt:5:24: warning: "},
        {"", "LightSource \"infinite\" \"string mapname\" \"huge.pfm\"", "test.pbrt:5:24: warning: "},
        {"", "LightSource \"infinite\" \"rgb L\" [3e38 3e38 3e38]", "test.pbrt:5:1: warning: infinite light"},
        {"", "LightSource \"point\" \"rgb I\" [3e38 -1 3e38] \"rgb scale\" [3e38 3e38 3e38]",
         "test.pbrt:5:1: warning: point light"},
        {"", "LightSource \"point\" \"rgb I\" [1e30 1e30 1e30] \"point from\" [0 0 1.0001]",
         "test.pbrt:5:1: warning: point light"},
        {"", "LightSource \"distant\" \"rgb L\" [1e38 1e38 1e38]", "test.pbrt:5:1: warning: distant light"},
        {"", "AreaLightSource \"diffuse\" \"rgb L\" [3e38 1 1] Shape \"sphere\" \"float radius\" .1",
         "test.pbrt:5:1: warning: area light"},
        {"", "Shape \"plymesh\" \"string filename\" \"nan.ply\"", "test.pbrt:5:1: warning: "},
        {"",
         "Texture \"c\" \"spectrum\" \"checkerboard\" Material \"matte\" \"texture Kd\" \"c\" "
         "Shape \"plymesh\" \"string filename\" \"overflow.ply\"",
         "test.pbrt:5:"},
        {"", "Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 3e38 3e38 0] \"integer indices\" [0 1 2]",
         "test.pbrt:5:1: warning: triangle mesh: 1 of 1 triangles dropped"},
        {"",
         "Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0] \"normal N\" [0 0 0 3e38 3e38 3e38 0 0 "
         "0] "
         "\"float uv\" [3e38 -3e38 -3e38 3e38 0 0] \"integer indices\" [0 1 2]",
         ""},
        {"",
         "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [3e38 3e38 3e38] Texture \"t\" \"spectrum\" "
         "\"scale\" "
         "\"texture tex1\" \"a\" \"texture tex2\" \"a\" " +
             material,
         "test.pbrt:5:64: warning: texture \"t\" has values"},
        {"",
         "Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [3e38 3e38 3e38] \"rgb tex2\" [3e38 3e38 3e38] "
         "\"float amount\" 3e38 " +
             material,
         "test.pbrt:5:1: warning: texture \"t\" has values"},
        {"",
         "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 3e38 \"float vscale\" 3e38 \"float "
         "udelta\" 3e38 " +
             material,
         "test.pbrt:5:1: warning: texture \"t\" has values"},
        {"",
         "Texture \"b\" \"float\" \"scale\" \"float tex1\" 3e38 \"float tex2\" -3e38 Material \"hair\" "
         "\"texture beta_m\" \"b\" "
         "\"texture beta_n\" \"b\" \"texture alpha\" \"b\" \"texture eta\" \"b\"",
         "test.pbrt:5:1: warning: texture \"b\" has values"},
        {"",
         "Material \"hair\" \"float beta_m\" 3e38 \"float beta_n\" -3e38 \"float alpha\" 3e38 \"float eta\" "
         "3e38",
         "test.pbrt:5:17: warning: hair: \"beta_m\" is 3e+38 and is taken as 1; it may be 0 to 1"},
        {"", "Material \"hair\" \"float beta_m\" 0 \"float beta_n\" 0 \"float alpha\" -3e38 \"float eta\" 0",
         "hair: \"eta\" is 0 and is taken as 0.001; it may be 0.001 to 1000"},
        {"", "Material \"hair\" \"float eumelanin\" 3e38 \"float pheomelanin\" 3e38", ""},
        {"", "Material \"hair\" \"rgb color\" [0 0 0]", ""},
        {"", "Material \"hair\" \"rgb color\" [-1 3e38 1]", "hair: \"color\" is -1 and is taken as 0"},
        {"", "Material \"hair\" \"rgb sigma_a\" [-1 3e38 1]",
         "hair: \"sigma_a\" is -1 and is taken as 0; it may be 0 or more"},
        {"", "Material \"hair\" \"string model\" \"kajiya-kay\" \"rgb Kd\" [1e38 1e38 1e38]",
         "test.pbrt:5:45: warning: \"Kd\" is a share of the light"},
        {"", "Material \"hair\" \"string model\" \"kajiya-kay\" \"rgb Ks\" [1 -1 1]",
         "test.pbrt:5:45: warning: \"Ks\" is a share of the light"},
        {"", "Material \"hair\" \"string model\" \"marschner\" \"rgb Kd\" [0 0 3e38]",
         "test.pbrt:5:44: warning: \"Kd\" is a share of the light"},
        {"", "Material \"matte\" \"rgb Kd\" [-1 3e38 1] \"float sigma\" 3e38", ""},
        {"", "Material \"plastic\" \"rgb Kd\" [3e38 1 1] \"float roughness\" 3e38", ""},
        {"", "Material \"plastic\" \"float roughness\" -3e38 \"bool remaproughness\" \"false\"", ""},
        {"", "Material \"plastic\" \"float roughness\" 3e38 \"bool remaproughness\" \"false\"", ""},
        {"", "Material \"glass\" \"float eta\" 3e38", ""},
        {"", "Material \"glass\" \"float eta\" 0", ""},
        {"", "Material \"glass\" \"float eta\" -3e38 \"float uroughness\" .1 \"float vroughness\" 3e38", ""},
        {"",
         "Material \"uber\" \"rgb opacity\" [3e38 -1 .5] \"rgb Kt\" [1 1 1] \"float eta\" 3e38 \"float "
         "roughness\" 0",
         ""},
        {"Integrator \"path\" \"integer maxdepth\" 2147483647 \"float rrthreshold\" -3e38",
         "Material \"mirror\" \"rgb Kr\" [3e38 3e38 3e38]", ""},
        {"Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 \"float scale\" 1e12",
         "LightSource \"point\" \"rgb I\" [1e17 1e17 1e17]", ""},
        // What pbrt-v3 goes on after
        {"Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 \"float cropwindow\" [0 1]", "",
         "3:62: warning: \"cropwindow\" takes 4"},
        {"Camera \"perspective\" \"float screenwindow\" [0 1]", "",
         "3:1: warning: camera: screenwindow needs"},
        {"Sampler \"halton\" \"integer pixelsamples\" 1.5", "",
         "3:18: warning: \"pixelsamples\" is 1.5, and must be a whole number; 1 is taken"},
        {"Sampler \"halton\" \"rgb pixelsamples\" [1 1 1]", "",
         "3:18: warning: \"pixelsamples\" is given as rgb; it must be \"integer pixelsamples\", and is "
         "ignored"},
        {"Integrator \"directlighting\" \"string strategy\" \"some\"", "",
         "warning: unknown strategy \"some\"; it is \"all\""},
        {"", "LightSource \"infinite\" \"string mapname\" \"nowhere.exr\"", "5:24: warning: "},
        {"", "LightSource \"infinite\" \"string mapname\" \".\"", "the light has no map, as by pbrt-v3"},
        {"", "Shape \"trianglemesh\" \"point P\" [] \"integer indices\" []",
         "5:1: warning: a trianglemesh needs \"integer indices\" and \"point P\"; \"indices\" is missing or "
         "empty; it "
         "is left out, as by pbrt-v3"},
        {"", "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 7]",
         "5:52: warning: vertex index 7 is out of range, for there are 3 points"},
        {"", "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 -2]",
         "vertex index -2"},
        {"",
         "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 2] \"integer indices\" [0 1 2] \"normal N\" "
         "[0 0 1]",
         "warning: there are 1 normals for 3 points; they are ignored"},
        {"", "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 2] \"integer indices\" [0 1 2]",
         "no multiple of 3"},
        {"",
         "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"float uv\" "
         "[0 0 1 0 0 1 5 5]",
         "4 texture coordinates for 3 points; those in excess are ignored, as by pbrt-v3"},
        {"",
         "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"float uv\" "
         "[0 0 1 0]",
         "2 texture coordinates for 3 points; they are ignored, as by pbrt-v3"},
        {"", "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0]",
         "5:1: warning: Shape \"curve\": 3 control points for a curve of degree 3 in the Bezier basis: n * 3 "
         "+ 1 "
         "are needed, n >= 1; the curve is left out, as by pbrt-v3"},
        {"", "Shape \"plymesh\" \"string filename\" \"nowhere.ply\"", "the shape is left out, as by pbrt-v3"},
        {"", "Shape \"plymesh\" \"string filename\" \".\"", "the shape is left out, as by pbrt-v3"},
        {"", "Shape \"plymesh\"", "5:1: warning: this shape needs \"string filename\"; it is left out"},
        {"", "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"nowhere.png\" " + material,
         "a grey of 0.5 takes the place of the texture's image, as by pbrt-v3"},
        {"", "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \".\" " + material,
         "a grey of 0.5"},
        {"", "Texture \"t\" \"spectrum\" \"imagemap\" " + material, "needs \"string filename\"; a grey"},
        {"",
         "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"nan.pfm\" \"string wrap\" \"x\" "
         "\"string "
         "mapping\" \"y\" " +
             material,
         "there is no wrap mode \"x\"; the image repeats"},
        {"", "Texture \"t\" \"float\" \"constant\" " + material,
         "warning: texture \"t\" is no spectrum texture, as \"Kd\" needs; that is left at its default"},
        {"Camera \"perspective\" \"float fov\" 179.99", "", ""},
        {"Camera \"perspective\" \"float fov\" 1e-30", "", ""},
        {"PixelFilter \"triangle\" \"float xwidth\" 1e-30 \"float ywidth\" 1000", "", ""},
    };
    for (const auto &row : rows) {
        const Outcome o = Run(Text(row.options, row.world));
        EXPECT_EQ(o.error, "") << row.options << row.world;
        EXPECT_EQ(o.stats.nanSamples, 0u) << row.options << row.world;
        EXPECT_TRUE(o.finite) << row.options << row.world;
        EXPECT_TRUE(o.warnings.find(row.says) != std::string::npos)
            << row.options << row.world << "\n  warns: " << o.warnings << "\n  not: " << row.says;
    }
}

// One warning each: what is under it that cannot emit does not make the light's own parameters unknown.
TEST_F(BadInput, LightsThatNothingEmitsAreOneWarning) {
    const std::string light =
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" \"true\" ";
    const std::string curve =
        "Shape \"curve\" \"point P\" [0 -.5 0 0 -.2 0 0 .2 0 0 .5 0] \"float width\" .4 ";
    const std::pair<std::string, int> rows[] = {
        {light + curve + "AttributeEnd", 1},
        {light + "AttributeEnd", 0},
        {light + "ObjectBegin \"a\" Shape \"sphere\" ObjectEnd AttributeEnd", 1},
        {"AttributeBegin AreaLightSource \"diffuse\" \"rgb LL\" [1 1 1] " + curve + "AttributeEnd", 2},
    };
    for (const auto &[world, count] : rows) {
        const Outcome o = Run(Text("", world));
        EXPECT_EQ(o.error, "") << world;
        int warnings = 0;
        for (size_t at = 0; (at = o.warnings.find("warning:", at)) != std::string::npos; ++at)
            ++warnings;
        EXPECT_EQ(warnings, count) << world << "\n" << o.warnings;
    }
}

// Between perfect mirrors no path would end: roulette ends it, whatever the scene says.
TEST_F(BadInput, MirrorBoxEnds) {
    const Outcome o =
        Run("LookAt 0 0 .5 0 0 0 0 1 0 Camera \"perspective\" Sampler \"random\" \"integer pixelsamples\" 1\n"
            "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\n"
            "Integrator \"path\" \"integer maxdepth\" 2147483647 \"float rrthreshold\" 0\n"
            "WorldBegin LightSource \"infinite\" Material \"mirror\" \"rgb Kr\" [1 1 1] Shape \"sphere\" "
            "WorldEnd\n");
    EXPECT_EQ(o.error, "");
    EXPECT_EQ(o.stats.nanSamples, 0u);
    // A thousand bounces, then on the average twenty more
    EXPECT_LT(o.stats.rays, 16u * 3000u);
    EXPECT_GT(o.stats.rays, 16u * 1000u);
}
