// Colours of strands, from a file to the light that a fiber scatters.
#include "core/error.h"
#include "grooms/hair_file.h"
#include "materials/hair_material.h"
#include "materials/material.h"
#include "scene/plugins.h"
#include "scene/scene.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <unistd.h>

using namespace cuticle;
namespace fs = std::filesystem;

namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins(), &ShapePlugins(), &LightPlugins(),
                            &AreaLightPlugins()};

const Spectrum kRoot{0.8f, 0.2f, 0.1f}, kTip{0.1f, 0.3f, 0.9f}, kOther{0.5f, 0.9f, 0.3f};

class StrandColor : public testing::Test {
  protected:
    StrandColor() {
        folder_ = fs::path(testing::TempDir()) / ("cuticle_strands_" + std::to_string(::getpid()) + Name());
        fs::create_directories(folder_);
        FlushWarnings();
        // Strand 0 along y at x = 0, from one colour to another; strand 1 at x = 1 of one colour
        Groom g;
        g.width = 0.2f;
        g.hasColor = true;
        for (int strand = 0; strand < 2; ++strand) {
            for (int k = 0; k < 3; ++k) {
                const float t = 0.5f * static_cast<float>(k);
                g.points.push_back({static_cast<float>(strand), 4 * t, 0});
                g.pointColors.push_back(strand == 0 ? kRoot * (1 - t) + kTip * t : kOther);
            }
            g.strandOffsets.push_back(static_cast<uint32_t>(g.points.size()));
        }
        WriteHairFile((folder_ / "two.hair").string(), g);
        g.pointColors.clear(); // one colour for all
        g.color = kOther;
        WriteHairFile((folder_ / "one.hair").string(), g);
    }
    ~StrandColor() override {
        FlushWarnings();
        fs::remove_all(folder_);
    }
    static std::string Name() { return testing::UnitTest::GetInstance()->current_test_info()->name(); }

    std::unique_ptr<Scene> Make(const std::string &shapes, bool binary = false) const {
        SceneDescription d = ParseSceneText(
            kPlugins,
            "WorldBegin LightSource \"infinite\" Texture \"c\" \"spectrum\" \"strandcolor\" \"rgb default\" "
            "[0.25 0.5 0.75] Material \"hair\" \"texture color\" \"c\"\n" +
                shapes + "\nWorldEnd",
            "test.pbrt", folder_.string());
        SceneOptions options;
        options.binaryCurves = binary;
        return std::make_unique<Scene>(&d, options);
    }
    // f of what a ray along -z meets at (x, y).
    static Spectrum F(const Scene &scene, float x, float y) {
        SurfaceInteraction si;
        SceneRay ray;
        ray.ray = {{x, y, 5}, {0, 0, -1}};
        if (!scene.Intersect(ray, &si))
            return Spectrum(-1);
        BSDF bsdf;
        bsdf.SetFrame(si.shading, si.n);
        si.material->MakeBSDF(si, &bsdf);
        float pdf = 0;
        return bsdf.FCos(si.wo, Normalize(Vector3f{0.3f, 0.2f, -0.9f}), &pdf);
    }
    // The same of a scene whose hair has one constant colour.
    Spectrum Expected(const Spectrum &color, float x, float y) const {
        SceneDescription d = ParseSceneText(
            kPlugins,
            "WorldBegin LightSource \"infinite\" Material \"hair\" \"rgb color\" [" +
                std::to_string(color[0]) + " " + std::to_string(color[1]) + " " + std::to_string(color[2]) +
                "] Shape \"hairfile\" \"string filename\" \"two.hair\" WorldEnd",
            "test.pbrt", folder_.string());
        const Scene scene(&d, {});
        return F(scene, x, y);
    }
    static void ExpectNear(const Spectrum &a, const Spectrum &b) {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(a[c], b[c], 1e-4f * std::abs(b[c])) << c;
    }
    fs::path folder_;
};

TEST_F(StrandColor, ReachesTheScatteredLight) {
    for (const bool binary : {false, true}) {
        const auto scene = Make("Shape \"hairfile\" \"string filename\" \"two.hair\"", binary);
        for (const float y : {0.4f, 1.f, 1.7f, 2.6f, 3.9f}) {
            const float t = y / 4;
            ExpectNear(F(*scene, 0.03f, y), Expected(kRoot * (1 - t) + kTip * t, 0.03f, y));
            ExpectNear(F(*scene, 1.03f, y), Expected(kOther, 1.03f, y));
        }
        // The colours do differ
        EXPECT_GT(std::abs(F(*scene, 0.03f, 0.4f)[2] - F(*scene, 0.03f, 3.9f)[2]),
                  0.1f * F(*scene, 0.03f, 3.9f)[2]);
    }
    EXPECT_EQ(FlushWarnings(), 0u);
}

// Resampled, moved, beside other curves, in an object: the colour goes with the strand.
TEST_F(StrandColor, GoesWithTheStrand) {
    const std::string before =
        "Shape \"curve\" \"point P\" [-3 0 0 -3 1 0 -3 2 0 -3 4 0] \"float width\" 0.2 "
        "AttributeBegin Translate -2 0 0 Shape \"hairfile\" \"string filename\" \"one.hair\" "
        "AttributeEnd ";
    const Spectrum wanted = Expected(kRoot * 0.35f + kTip * 0.65f, 0.03f, 2.6f);
    const auto scene = Make(before + "Translate 5 0 0 Shape \"hairfile\" \"string filename\" \"two.hair\" "
                                     "\"integer segments\" 5");
    ExpectNear(F(*scene, 5.03f, 2.6f), wanted);
    ExpectNear(F(*scene, -1.97f, 2.6f), Expected(kOther, 0.03f, 2.6f));
    const auto instanced =
        Make(before + "ObjectBegin \"o\" Shape \"hairfile\" \"string filename\" \"two.hair\" ObjectEnd "
                      "AttributeBegin Translate 7 0 0 ObjectInstance \"o\" AttributeEnd "
                      "AttributeBegin Translate 9 0 0 ObjectInstance \"o\" AttributeEnd");
    ExpectNear(F(*instanced, 7.03f, 2.6f), wanted);
    ExpectNear(F(*instanced, 9.03f, 2.6f), wanted);
    // Curves without a material are left out, and shift no colours
    const auto hidden = Make("AttributeBegin Material \"\" " + before +
                             " AttributeEnd Shape \"hairfile\" \"string filename\" \"two.hair\"");
    ExpectNear(F(*hidden, 0.03f, 2.6f), wanted);
}

// Texture "strandroot" looks its texture up where the strand begins: here a plane's corners, strand 0 at
// x = 0 and strand 1 at x = 1, both from y = 0 on; moved by an instance the root moves too. Without it the
// colour would go with y.
TEST_F(StrandColor, IsThatOfAPlaceOnTheScalp) {
    const std::string head =
        "WorldBegin LightSource \"infinite\" Texture \"plane\" \"spectrum\" \"bilerp\" \"string mapping\" "
        "\"planar\" \"vector v1\" [1 0 0] \"vector v2\" [0 1 0] \"rgb v00\" [0.8 0.2 0.1] \"rgb v10\" "
        "[0.5 0.9 0.3] \"rgb v01\" [0.1 0.3 0.9] \"rgb v11\" [0.1 0.3 0.9] "
        "Texture \"scalp\" \"spectrum\" \"strandroot\" \"texture value\" \"plane\" "
        "Material \"hair\" \"texture color\" \"scalp\" ";
    const auto make = [&](const std::string &shapes, bool binary) {
        SceneDescription d =
            ParseSceneText(kPlugins, head + shapes + " WorldEnd", "test.pbrt", folder_.string());
        SceneOptions options;
        options.binaryCurves = binary;
        return std::make_unique<Scene>(&d, options);
    };
    const std::string strands = "Shape \"hairfile\" \"string filename\" \"two.hair\" \"integer segments\" 5";
    for (const bool binary : {false, true}) {
        const auto scene = make(strands, binary);
        for (const float y : {0.1f, 1.f, 2.6f, 3.9f}) {
            ExpectNear(F(*scene, 0.03f, y), Expected(kRoot, 0.03f, y));
            ExpectNear(F(*scene, 1.03f, y), Expected(kOther, 1.03f, y));
        }
        // From the corners onward in x the plane goes on as it began
        const auto moved = make("ObjectBegin \"o\" " + strands +
                                    " ObjectEnd AttributeBegin Translate 0.5 0 0 "
                                    "ObjectInstance \"o\" AttributeEnd AttributeBegin Translate -1 0 9 "
                                    "ObjectInstance \"o\" AttributeEnd",
                                binary);
        ExpectNear(F(*moved, 0.53f, 2.6f), Expected((kRoot + kOther) * 0.5f, 0.03f, 2.6f));
    }
}

TEST_F(StrandColor, ElsewhereTheDefaultHolds) {
    const auto scene =
        Make("Shape \"curve\" \"point P\" [0 0 0 0 1 0 0 2 0 0 4 0] \"float width\" 0.2 "
             "AttributeBegin Translate 8 0 0 Shape \"hairfile\" \"string filename\" \"two.hair\" "
             "AttributeEnd");
    ExpectNear(F(*scene, 0.03f, 1.f), Expected({0.25f, 0.5f, 0.75f}, 0.03f, 1.f));
    EXPECT_EQ(FlushWarnings(), 0u);
    Make("Shape \"sphere\"");
    EXPECT_EQ(FlushWarnings(), 1u) << "no strand has colours";
}

TEST_F(StrandColor, HairfileRefusesWhatMakesNoSense) {
    const auto message = [&](const std::string &parameters) -> std::string {
        try {
            Make("Shape \"hairfile\" \"string filename\" \"two.hair\" " + parameters);
        } catch (const Error &e) {
            return e.what();
        }
        return "no error";
    };
    EXPECT_EQ(message("\"float width\" 0.1 \"string spline\" \"linear\""), "no error");
    EXPECT_NE(message("\"float width\" -1").find("test.pbrt:2:"), std::string::npos);
    EXPECT_NE(message("\"string spline\" \"liner\"").find("linear"), std::string::npos);
}

} // namespace
