// Curves as users write them: what they cover under transformations that scale unevenly, what textures see
// along a strand, and what is said of curves that are left out. The right values are worked out by hand.
#include "core/error.h"
#include "core/memory_budget.h"
#include "grooms/hair_file.h"
#include "grooms/hash.h"
#include "materials/material.h"
#include "scene/plugins.h"
#include "scene/scene.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <unistd.h>

using namespace cuticle;
namespace fs = std::filesystem;

namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins(), &ShapePlugins(), &LightPlugins(),
                            &AreaLightPlugins()};

// A straight hair along y, .5 long and .1 wide, about the origin.
constexpr char kHair[] = "Shape \"curve\" \"string type\" \"cylinder\" \"float width\" .1 \"point P\" "
                         "[0 -.25 0 0 -.0833333333 0 0 .0833333333 0 0 .25 0] ";

class CurveCases : public testing::Test {
  protected:
    CurveCases() {
        const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = fs::path(testing::TempDir()) / ("cuticle_curves_" + std::to_string(::getpid()) + name);
        fs::create_directories(folder_);
        FlushWarnings();
    }
    ~CurveCases() override {
        FlushWarnings();
        fs::remove_all(folder_);
    }
    std::unique_ptr<Scene> Make(const std::string &world, bool binary = false) const {
        SceneDescription d = ParseSceneText(
            kPlugins, "WorldBegin LightSource \"infinite\" Material \"matte\"\n" + world + "\nWorldEnd",
            "test.pbrt", folder_.string());
        SceneOptions options;
        options.binaryCurves = binary;
        return std::make_unique<Scene>(&d, options);
    }
    void Write(const std::string &name, const std::string &text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    // The area that parallel rays along -z meet in the square from -1 to 1. The rays of each row are shifted
    // by the golden ratio against those of the row before, so that the rows' errors cancel; edges along x lie
    // between rows.
    static double Area(const Scene &scene) {
        constexpr int rows = 200, columns = 100;
        int hits = 0;
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const double shift = 0.6180339887498949 * y;
                SceneRay ray;
                ray.ray = {{static_cast<float>(-1 + (x + shift - std::floor(shift)) * 2 / columns),
                            static_cast<float>(-1 + (y + 0.5) * 2 / rows), 10},
                           {0, 0, -1}};
                SurfaceInteraction si;
                const bool hit = scene.Intersect(ray, &si);
                EXPECT_EQ(hit, scene.Occluded(ray));
                hits += hit;
            }
        return hits * 4. / (rows * columns);
    }
    // What a ray along -z meets at (x, y).
    static SurfaceInteraction At(const Scene &scene, float x, float y) {
        SceneRay ray;
        ray.ray = {{x, y, 10}, {0, 0, -1}};
        SurfaceInteraction si;
        EXPECT_TRUE(scene.Intersect(ray, &si)) << x << " " << y;
        return si;
    }
    fs::path folder_;
};

// pbrt-v3 keeps a curve in its own coordinates and brings the ray there. Seen along z the hair is a ribbon of
// .5 by .1 across x; Scale 2 1 1 makes that .5 by .2, Scale 1 2 1 makes it 1 by .1, Scale 1 1 2 changes
// nothing that is seen.
struct UnevenScale {
    const char *numbers;
    double area;
};
constexpr UnevenScale kScales[] = {{"2 1 1", .1}, {"1 2 1", .1}, {"1 1 2", .05}, {"3 1 .5", .15}};

TEST_F(CurveCases, WidthsUnderUnevenScales) {
    Groom hair;
    hair.width = 0.1f;
    hair.points = {{0, -0.25f, 0}, {0, 0, 0}, {0, 0.25f, 0}};
    hair.strandOffsets.push_back(3);
    WriteHairFile((folder_ / "a.hair").string(), hair);
    for (const auto &[numbers, area] : kScales) {
        std::string commas = numbers;
        std::replace(commas.begin(), commas.end(), ' ', ',');
        Write("a.usda",
              "#usda 1.0\ndef Xform \"g\" {\n float3 xformOp:scale = (" + commas +
                  ")\n uniform token[] xformOpOrder = [\"xformOp:scale\"]\n def BasisCurves \"c\" {\n"
                  " uniform token type = \"linear\"\n int[] curveVertexCounts = [2]\n"
                  " point3f[] points = [(0, -0.25, 0), (0, 0.25, 0)]\n float[] widths = [0.1]\n}\n}\n");
        const std::string scale = std::string("Scale ") + numbers + " ";
        for (const bool binary : {false, true}) {
            const std::string worlds[] = {
                scale + kHair,
                scale + "Shape \"hairfile\" \"string filename\" \"a.hair\"",
                "Shape \"hairfile\" \"string filename\" \"a.usda\"",
                std::string("ObjectBegin \"o\" ") + kHair + "ObjectEnd " + scale + "ObjectInstance \"o\"",
                "ObjectBegin \"o\" " + scale + kHair + "ObjectEnd ObjectInstance \"o\"",
                "ObjectBegin \"o\" " + scale +
                    "Shape \"hairfile\" \"string filename\" \"a.hair\" ObjectEnd ObjectInstance \"o\"",
            };
            for (const std::string &world : worlds)
                EXPECT_NEAR(Area(*Make(world, binary)), area, 1e-3) << world << " binary " << binary;
        }
    }
    EXPECT_EQ(FlushWarnings(), 0u);
    // Even ones, mirrors among them, are what they were
    EXPECT_NEAR(Area(*Make(std::string("Scale 2 2 2 ") + kHair)), .2, 1e-3);
    EXPECT_NEAR(Area(*Make(std::string("Scale -1 1 1 ") + kHair)), .05, 1e-3);
    EXPECT_EQ(Make(std::string("Scale -1 1 1 ") + kHair)->Instances(), 0u);
}

// A scale within an object and one of its place, each uneven, and uneven together: 2 along x, 2 along y.
TEST_F(CurveCases, UnevenWithinUneven) {
    const auto scene = Make("ObjectBegin \"o\" AttributeBegin Scale 2 1 1 " + std::string(kHair) +
                            "AttributeEnd AttributeBegin Translate -.5 0 0 " + kHair +
                            "AttributeEnd ObjectEnd Scale 1 2 1 ObjectInstance \"o\"");
    EXPECT_NEAR(Area(*scene), .2 + .1, 1e-3);
    EXPECT_EQ(scene->Curves(), 2u);
}

// Any transformation: what a curve is under it, an instance of the curve is too, hit for hit. And curves that
// share a transformation share an instance, whatever stands between them.
TEST_F(CurveCases, UnevenCurvesAreInstances) {
    const std::string place = "Translate .1 -.2 .3 Rotate 30 1 2 3 Scale 1 .4 2 Rotate 50 0 1 0 ";
    const std::string ribbon =
        "Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 0 1 1 1 0 1] \"float width0\" .3 "
        "\"float "
        "width1\" .1 \"point P\" [-.5 0 0 -.3 .4 .2 0 .1 0 .1 0 0 .2 .1 .2 .4 .3 .1 .6 .4 .2] ";
    const auto copied = Make("AttributeBegin " + place + kHair + ribbon + "AttributeEnd");
    const auto placed = Make(std::string("ObjectBegin \"o\" ") + kHair + ribbon + "ObjectEnd " + place +
                             "ObjectInstance \"o\"");
    EXPECT_EQ(copied->Instances(), 1u);
    int hits = 0;
    for (uint64_t i = 0; i < 20000; ++i) {
        const HashStream r(3, 1, i);
        SceneRay ray;
        ray.ray.o = Point3f{r.Signed(0), r.Signed(1), r.Signed(2)} * 3;
        ray.ray.d = Normalize(Point3f{r.Signed(3), r.Signed(4), r.Signed(5)} * 0.5f - ray.ray.o);
        SurfaceInteraction a, b;
        const bool hitA = copied->Intersect(ray, &a), hitB = placed->Intersect(ray, &b);
        ASSERT_EQ(hitA, hitB);
        if (!hitA)
            continue;
        ++hits;
        EXPECT_EQ(a.t, b.t);
        EXPECT_EQ(a.uv.x, b.uv.x);
        EXPECT_EQ(a.uv.y, b.uv.y);
        EXPECT_EQ(a.n, b.n);
    }
    EXPECT_GT(hits, 300);
    EXPECT_EQ(Make("AttributeBegin Scale 1 2 1 " + std::string(kHair) + "AttributeEnd " + kHair +
                   "Material \"hair\" Scale 1 2 1 " + kHair)
                  ->Instances(),
              1u);
}

// Ten thousand transformations of a hair each: as many instances, within a few KB each.
TEST_F(CurveCases, ManyUnevenTransformationsStaySmall) {
    std::string world;
    for (int i = 0; i < 10000; ++i)
        world +=
            fmt::format("TransformBegin Translate {} 0 0 Scale 1 {} 1 {}TransformEnd\n", i, 2 + i % 7, kHair);
    const auto scene = Make(world);
    EXPECT_EQ(scene->Instances(), 10000u);
    EXPECT_LT(scene->MemoryBytes(), 10000u * 8192);
}

// u is 0 at the root, 1 at the tip, and grows evenly on a straight strand of even pieces.
TEST_F(CurveCases, TexturesSeeTheWholeStrand) {
    for (const int pieces : {1, 2, 7, 300, 70000}) {
        Groom strand;
        strand.width = 0.2f;
        strand.spline = StrandSpline::Linear;
        std::string bezier, spline;
        for (int i = 0; i <= pieces; ++i)
            strand.points.push_back({0, -0.5f + static_cast<float>(i) / static_cast<float>(pieces), 0});
        strand.strandOffsets.push_back(static_cast<uint32_t>(strand.points.size()));
        for (int i = 0; i <= 3 * pieces; ++i)
            bezier += fmt::format("0 {:.9g} 0 ", -0.5 + i / (3. * pieces));
        for (int i = -1; i <= pieces + 1; ++i)
            spline += fmt::format("0 {:.9g} 0 ", -0.5 + 1. * i / pieces);
        std::vector<std::string> worlds{
            "Shape \"curve\" \"float width\" .2 \"point P\" [" + bezier + "]",
            "Shape \"curve\" \"float width\" .2 \"string basis\" \"bspline\" \"point P\" [" + spline + "]"};
        if (pieces < 65536) { // the most that a .hair file holds
            WriteHairFile((folder_ / "a.hair").string(), strand);
            worlds.push_back("Shape \"hairfile\" \"string filename\" \"a.hair\"");
            worlds.push_back("Shape \"hairfile\" \"string filename\" \"a.hair\" \"integer segments\" 5");
            worlds.push_back("Scale 1 1 3 Shape \"hairfile\" \"string filename\" \"a.hair\"");
        }
        for (const std::string &world : worlds)
            for (const bool binary : {false, true}) {
                if (binary && pieces > 1000)
                    continue;
                const auto scene = Make(world, binary);
                for (const float along : {0.001f, 0.1f, 0.25f, 0.4999f, 0.66f, 0.9f, 0.999f})
                    EXPECT_NEAR(At(*scene, 0.03f, along - 0.5f).uv.x, along, 1e-4f)
                        << pieces << " pieces " << world.substr(0, 80);
            }
    }
}

// A run of points that repeat adds no piece, and takes no part of u.
TEST_F(CurveCases, RepeatedPointsTakeNoPartOfTheStrand) {
    Groom strand;
    strand.width = 0.2f;
    strand.points = {{0, -0.5f, 0}, {0, -0.5f, 0}, {0, -0.5f, 0}, {0, 0, 0}, {0, 0.5f, 0}, {0, 0.5f, 0}};
    strand.strandOffsets.push_back(6);
    WriteHairFile((folder_ / "a.hair").string(), strand);
    const auto scene = Make("Shape \"hairfile\" \"string filename\" \"a.hair\"");
    for (const float along : {0.001f, 0.25f, 0.5f, 0.999f})
        EXPECT_NEAR(At(*scene, 0.03f, along - 0.5f).uv.x, along, 1e-4f);
    EXPECT_NEAR(Area(*scene), 0.2, 1e-3);
    // Control points may repeat at the ends of any curve
    for (const char *world :
         {"Shape \"curve\" \"float width\" .2 \"point P\" [0 -.5 0 0 -.5 0 0 .5 0 0 .5 0]",
          "Shape \"curve\" \"string basis\" \"bspline\" \"float width\" .2 \"point P\" [0 -.5 0 0 -.5 0 0 "
          "-.5 0 0 "
          "-.3 0 0 -.1 0 0 .1 0 0 .3 0 0 .5 0 0 .5 0 0 .5 0]"})
        EXPECT_NEAR(Area(*Make(world)), 0.2, 1e-3) << world;
    EXPECT_EQ(FlushWarnings(), 0u);
}

// Curves that are left out are said for what they are, at their place.
TEST_F(CurveCases, CurvesLeftOutAreNamed) {
    struct Sink : WarningSink {
        std::string all;
        void Warn(const FileLoc &place, const std::string &, const std::string &message) override {
            all += place.ToString() + " " + message + "\n";
        }
    } sink;
    const WarningScope scope(&sink);
    const std::string point = "Shape \"curve\" \"float width\" .2 \"point P\" [0 0 0 0 0 0 0 0 0 0 0 0] ";
    EXPECT_NEAR(Area(*Make(point + kHair)), 0.05, 1e-3);
    EXPECT_NE(sink.all.find("test.pbrt:2:1 1 curve segments are of length zero"), std::string::npos)
        << sink.all;
    EXPECT_EQ(sink.all.find("not finite"), std::string::npos) << sink.all;
    sink.all.clear();
    Make("Shape \"curve\" \"float width\" 0 \"point P\" [0 0 0 0 1 0 0 2 0 0 3 0]");
    EXPECT_NE(sink.all.find("1 curve segments are without width"), std::string::npos) << sink.all;
    sink.all.clear();
    Make("Scale 1 3 1 " + point);
    EXPECT_NE(sink.all.find("of length zero"), std::string::npos) << sink.all;
}

// Memory is claimed before it is allocated, and the largest claim is named with its size and place.
TEST_F(CurveCases, MemoryIsClaimedBeforeItIsTaken) {
    const auto message = [&](const std::string &world, uint64_t limit) -> std::string {
        MemoryBudget budget(limit);
        const MemoryBudgetScope scope(&budget);
        try {
            Make(world);
        } catch (const Error &e) {
            return e.what();
        }
        return "no error";
    };
    const std::string groom =
        "Shape \"sphere\"\nShape \"groom\" \"string kind\" \"hair-cube\" \"integer strands\" 100000";
    // A hundred thousand strands of one segment: 64 bytes of its points, and as many of its tree
    const std::string refused = message(groom, 12 << 20);
    EXPECT_NE(refused.find("99856 curve segments and their tree (test.pbrt:3:1)"), std::string::npos)
        << refused;
    EXPECT_EQ(message(groom, uint64_t{1} << 30), "no error");
    // The points of strands, before any is grown: 20 million times six of 12 bytes
    const std::string grown =
        message("Shape \"groom\" \"string kind\" \"hair-cube\" \"integer strands\" 20000000 "
                "\"integer segments\" 5",
                uint64_t{1} << 30);
    EXPECT_NE(grown.find("1.3 GB"), std::string::npos) << grown;
    EXPECT_NE(grown.find("strands (test.pbrt:2:1)"), std::string::npos) << grown;
}

} // namespace
