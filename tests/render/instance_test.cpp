// Objects that are stored once and placed many times, and meshes with holes.
#include "render/renderer.h"

#include "core/error.h"
#include "core/sampling.h"
#include "render/plugins.h"

#include <gtest/gtest.h>

using namespace cuticle;

namespace {

const char kShapes[] = R"(
  Material "matte" Shape "sphere" "float radius" 0.5
  Material "plastic" Shape "trianglemesh" "point P" [-1 -1 .2 1 -1 .2 1 1 .4 -1 1 .3]
   "integer indices" [0 1 2 2 3 0] "normal N" [0 0 1 .1 0 1 0 .1 1 0 0 1]
  Material "hair" Shape "curve" "string type" "flat" "point P" [-1 0 1 -.3 .5 1.2 .3 -.5 .8 1 0 1]
   "float width0" 0.2 "float width1" 0.1
  Shape "curve" "string type" "cylinder" "point P" [0 -1 -1 .5 -.3 -1.2 -.5 .3 -.8 0 1 -1] "float width" 0.15
)";

struct Made {
    SceneDescription description;
    std::unique_ptr<Scene> scene;
};
Made Make(const std::string &world, const SceneOptions &options = {}) {
    Made made{ParseSceneText(AllPlugins(), "WorldBegin " + world + " WorldEnd", "test.pbrt"), nullptr};
    made.scene = std::make_unique<Scene>(&made.description, options);
    return made;
}

} // namespace

// A similarity, mirrors among them, leaves everything alike: hits, normals, tangents and the place across a
// fiber.
TEST(Instances, AreWhatCopiesAre) {
    const char *placements[] = {
        "Translate 3 -2 5",
        "Translate 1 2 3 Rotate 40 1 2 3 Scale 2 2 2",
        "Rotate 130 -1 .5 .2 Scale -0.01 0.01 0.01",
        "Translate -400 300 200 Scale 50 50 -50 Rotate 77 1 0 0",
    };
    for (const bool binary : {false, true})
        for (const std::string placement : placements) {
            SceneOptions options;
            options.binaryCurves = binary;
            const Made copied = Make("AttributeBegin " + placement + kShapes + "AttributeEnd", options);
            const Made placed =
                Make("ObjectBegin \"thing\" " + std::string(kShapes) + " ObjectEnd AttributeBegin " +
                         placement + " ObjectInstance \"thing\" AttributeEnd",
                     options);
            EXPECT_EQ(placed.scene->Instances(), 1u);
            const Bounds3f bound = copied.scene->WorldBound();
            const Vector3f size = bound.Diagonal();
            RNG rng(7);
            int hits = 0, curves = 0, differ = 0;
            for (int i = 0; i < 4000; ++i) {
                const auto uniform = [&] { return static_cast<float>(rng.UniformUInt32()) * 0x1p-32f; };
                const Point3f from =
                    bound.Center() + UniformSampleSphere({uniform(), uniform()}) * (2 * size.Length());
                const Point3f to =
                    bound.pMin + Vector3f(uniform() * size.x, uniform() * size.y, uniform() * size.z);
                SceneRay ray;
                ray.ray = {from, Normalize(to - from)};
                SurfaceInteraction a, b;
                const bool hitA = copied.scene->Intersect(ray, &a), hitB = placed.scene->Intersect(ray, &b);
                EXPECT_EQ(placed.scene->Occluded(ray), hitB);
                const float tolerance = 2e-6f * a.t + 1e-5f * size.Length();
                if (hitA != hitB || (hitA && !(std::abs(a.t - b.t) <= tolerance))) {
                    ++differ; // past an edge the one, behind it the other
                    continue;
                }
                if (!hitA)
                    continue;
                EXPECT_EQ(a.isCurve, b.isCurve);
                ++hits;
                curves += a.isCurve;
                EXPECT_EQ(b.instance, 0);
                EXPECT_LT((a.p - b.p).Length(), 2e-5f * (size.Length() + Vector3f(a.p).Length()));
                EXPECT_GT(Dot(a.n, b.n), 1 - 1e-3f) << placement << " curve " << a.isCurve;
                EXPECT_GT(Dot(a.shading.x, b.shading.x), 1 - 1e-3f);
                EXPECT_GT(Dot(a.shading.y, b.shading.y), 1 - 1e-3f) << placement << " curve " << a.isCurve;
                EXPECT_GT(Dot(a.shading.z, b.shading.z), 1 - 1e-3f);
                EXPECT_NEAR(a.uv.x, b.uv.x, 2e-3f);
                EXPECT_NEAR(a.uv.y, b.uv.y, 1e-2f) << placement << " curve " << a.isCurve;
            }
            EXPECT_GT(hits, 1500);
            EXPECT_GT(curves, 150);
            EXPECT_LT(differ, 4);
        }
}

TEST(Instances, AHundredThousandTuftsTakeLittleMemory) {
    std::string world =
        "ObjectBegin \"tuft\" Material \"hair\" Shape \"groom\" \"string kind\" \"ball\" \"integer strands\" "
        "2000 \"float radius\" 0.1 ObjectEnd ";
    for (int i = 0; i < 100000; ++i)
        world += "TransformBegin Translate " + std::to_string(i % 317) + " 0 " + std::to_string(i / 317) +
                 " ObjectInstance \"tuft\" TransformEnd\n";
    const Made made = Make(world);
    EXPECT_EQ(made.scene->Instances(), 100000u);
    EXPECT_LT(made.scene->Curves(), 100000u);
    const double tuft = 350.0 * static_cast<double>(made.scene->Curves());
    EXPECT_LT(static_cast<double>(made.scene->MemoryBytes()), tuft + 500.0 * 100000);
    SceneRay ray;
    ray.ray = {{200, 5, 150}, {0, -1, 0}};
    SurfaceInteraction si;
    EXPECT_TRUE(made.scene->Intersect(ray, &si));
    EXPECT_TRUE(si.isCurve);
}

// Every object keeps surfaces of its own; the library under them must not run out of anything.
TEST(Instances, ThousandsOfObjectsStandBesideOneAnother) {
    constexpr int kObjects = 3000;
    std::string world;
    for (int i = 0; i < kObjects; ++i) {
        const std::string name = "\"o" + std::to_string(i) + "\"";
        world += "ObjectBegin " + name +
                 " Shape \"sphere\" \"float radius\" 0.4 ObjectEnd TransformBegin Translate " +
                 std::to_string(i) + " 0 0 ObjectInstance " + name + " TransformEnd\n";
    }
    const Made made = Make(world);
    EXPECT_EQ(made.scene->Instances(), static_cast<size_t>(kObjects));
    for (int i = 0; i < kObjects; ++i) {
        SceneRay ray;
        ray.ray = {{static_cast<float>(i), 5, 0}, {0, -1, 0}};
        SurfaceInteraction si;
        ASSERT_TRUE(made.scene->Intersect(ray, &si)) << i;
        EXPECT_EQ(si.instance, i);
        EXPECT_NEAR(si.t, 4.6, 1e-4);
    }
}

// White hair vanishes in a white dome from within instances of any size: no light is lost where a ray leaves
// its hair.
TEST(Instances, WhiteHairVanishesAtEveryScale) {
    for (const double scale : {1e-3, 1., 1e3}) {
        const std::string s = std::to_string(scale);
        SceneDescription description = ParseSceneText(
            AllPlugins(),
            "Film \"image\" \"integer xresolution\" 12 \"integer yresolution\" 12 PixelFilter \"box\" LookAt "
            "0 0 " +
                std::to_string(3 * scale) +
                " 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 30 Sampler \"halton\" "
                "\"integer pixelsamples\" 16 Integrator \"path\" \"integer maxdepth\" 10000 WorldBegin "
                "LightSource "
                "\"infinite\" ObjectBegin \"ball\" Material \"hair\" \"color sigma_a\" [0 0 0] Shape "
                "\"groom\" \"string "
                "kind\" \"ball\" \"integer strands\" 400 \"float width\" 0.03 ObjectEnd Scale " +
                s + " " + s + " " + s + " Rotate 30 1 1 0 ObjectInstance \"ball\" WorldEnd",
            "test.pbrt");
        const Scene scene(&description, {});
        RenderOptions options;
        RenderStats stats;
        const Image image = Render(description, scene, options, &stats);
        double mean = 0;
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x)
                mean += static_cast<double>(image.RGB(x, y)[1]) / 144;
        // 2304 paths whose weights deviate by some percent: 5 standard errors are about 0.01
        EXPECT_NEAR(mean, 1, 0.01) << scale;
        EXPECT_EQ(stats.nanSamples, 0u);
    }
}

// Meshes and quadrics are stretched, which bounds of rounding errors must follow: no ray that leaves a convex
// solid meets it again.
TEST(Instances, SpawnedRaysLeaveTheirSolid) {
    for (const std::string placement :
         {"Translate 3 -2 5", "Rotate 200 0 1 1 Scale 1000 1000 1000 Translate 1 0 0",
          "Translate 0.1 0 0 Scale 0.001 0.001 0.001",
          "Translate 300 4 0 Rotate 10 1 0 0 Scale 0.5 -3 1 Rotate 40 0 1 1"}) {
        SCOPED_TRACE(placement);
        const Made ball =
            Make("ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd " + placement + " ObjectInstance \"ball\"");
        const Bounds3f bound = ball.scene->WorldBound();
        RNG rng(11);
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            const auto uniform = [&] { return static_cast<float>(rng.UniformUInt32()) * 0x1p-32f; };
            SceneRay ray;
            ray.ray.o =
                bound.Center() + UniformSampleSphere({uniform(), uniform()}) * bound.Diagonal().Length();
            const Vector3f size = bound.Diagonal();
            const Point3f to =
                bound.pMin + Vector3f(uniform() * size.x, uniform() * size.y, uniform() * size.z);
            ray.ray.d = Normalize(to - ray.ray.o);
            SurfaceInteraction si;
            if (!ball.scene->Intersect(ray, &si))
                continue;
            ++hits;
            EXPECT_FALSE(ball.scene->Occluded(ball.scene->SpawnRay(si, si.wo)));
            const Vector3f grazing = Normalize(si.shading.x + Vector3f(si.n) * 1e-3f);
            EXPECT_FALSE(ball.scene->Occluded(ball.scene->SpawnRay(si, grazing)));
        }
        EXPECT_GE(hits, 500);
    }
}

TEST(Instances, TheNearestOfManyIsFound) {
    const Made made = Make("ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd "
                           "AttributeBegin Translate 0 0 9 ObjectInstance \"ball\" AttributeEnd "
                           "AttributeBegin Translate 0 0 6 Scale 2 1 1 ObjectInstance \"ball\" AttributeEnd "
                           "Translate 0 0 13 Shape \"sphere\"");
    const auto distance = [&](float z) {
        SceneRay ray;
        ray.ray = {{0, 0, z}, {0, 0, 1}};
        SurfaceInteraction si;
        const bool hit = made.scene->Intersect(ray, &si);
        return std::pair(hit ? si.t : Infinity, si.instance);
    };
    EXPECT_EQ(distance(0), std::pair(5.f, 1));
    EXPECT_EQ(distance(7.5f), std::pair(0.5f, 0));
    EXPECT_EQ(distance(10.5f), std::pair(1.5f, -1));
    EXPECT_EQ(distance(14.5f).first, Infinity);
}

TEST(Instances, ATransformationWithoutInverseIsAnError) {
    EXPECT_THROW(Make("ObjectBegin \"a\" Shape \"sphere\" ObjectEnd Scale 1 0 1 ObjectInstance \"a\""),
                 Error);
    EXPECT_EQ(
        Make("ObjectBegin \"empty\" ObjectEnd ObjectInstance \"empty\" Shape \"sphere\"").scene->Instances(),
        1u);
}

// Texture "dots" is a hole pattern; a ray through it goes on, a shadow ray asks "shadowalpha" as well.
TEST(MeshAlpha, ZeroIsAHole) {
    const std::string card =
        "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"point2 uv\" [0 0 1 0 1 1 0 1] "
        "\"integer indices\" [0 1 2 2 3 0] ";
    const std::string checker =
        "Texture \"holes\" \"float\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 2 \"float tex1\" 0 "
        "\"float tex2\" 1 ";
    const auto probe = [](const Made &made, float x, float y) {
        SceneRay ray;
        ray.ray = {{x, y, 1}, {0, 0, -1}};
        SurfaceInteraction si;
        return std::pair(made.scene->Intersect(ray, &si), made.scene->Occluded(ray));
    };
    const Made both = Make(checker + card + "\"texture alpha\" \"holes\"");
    const Made shadow = Make(checker + card + "\"texture shadowalpha\" \"holes\"");
    const Made gone = Make(card + "\"float alpha\" 0");
    for (const auto &[x, y] : {std::pair{.25f, .25f}, {.75f, .75f}, {.25f, .75f}, {.75f, .25f}}) {
        const bool hole = (x < .5f) == (y < .5f);
        EXPECT_EQ(probe(both, x, y), std::pair(!hole, !hole));
        EXPECT_EQ(probe(shadow, x, y), std::pair(true, !hole));
        EXPECT_EQ(probe(gone, x, y), std::pair(false, false));
    }
}
