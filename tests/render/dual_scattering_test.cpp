// Laws of Integrator "dualscattering": the mean scattering of a fiber against quadrature, sums between fibers
// against the paths that they sum up, light through layers, and the limits in which nothing is left out.
#include "render/dual_scattering.h"

#include "fibers/models.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

SceneDescription Described(const std::string &integrator, const std::string &world) {
    return ParseSceneText(
        AllPlugins(),
        "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 24 PixelFilter "
        "\"box\"\nIntegrator " +
            integrator +
            "\nLookAt 0 0 -4  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]\n"
            "WorldBegin\n" +
            world + "\nWorldEnd\n",
        "dual_scattering_test");
}

Image RenderOf(const std::string &integrator, const std::string &world, int spp) {
    SceneDescription description = Described(integrator, world);
    const Scene scene(&description, {});
    RenderOptions options;
    options.spp = spp;
    RenderStats stats;
    return Render(description, scene, options, &stats);
}

double MeanOf(const Image &image, size_t from = 0, size_t to = 24) {
    double sum = 0;
    for (size_t y = from; y < to; ++y)
        for (size_t x = from; x < to; ++x)
            sum += static_cast<double>(image.RGB(x, y)[1]) / static_cast<double>((to - from) * (to - from));
    return sum;
}

// The table of one hair of this material.
FiberAlbedoTable TableOf(const std::string &material) {
    SceneDescription description = Described(
        "\"path\"", "LightSource \"distant\" " + material +
                        " Shape \"curve\" \"point P\" [-9 0 0 -3 0 0 3 0 0 9 0 0] \"float width\" 1");
    const Scene scene(&description, {});
    SurfaceInteraction si;
    EXPECT_TRUE(scene.Intersect(SceneRay{{.o = {0, 0.1f, -4}, .d = {0, 0, 1}}, {}, false}, &si));
    return FiberAlbedoTable(*si.material, std::span(&si, 1));
}

// Integrates what leaves a fiber over the sphere and over h, in double, with the model's own evaluation.
struct HalvesByQuadrature {
    double forward = 0, backward = 0, forwardAngle = 0;
};
HalvesByQuadrature Integrate(float sigmaA, double theta) {
    FiberInputs at;
    at.sigmaA = {sigmaA, sigmaA, sigmaA};
    HalvesByQuadrature sum;
    constexpr int kH = 24, kTheta = 90, kPhi = 120;
    const auto maker = FindFiberModel("chiang")->prepare(FiberValues(*FindFiberModel("chiang"), at, {}));
    for (int i = 0; i < kH; ++i) {
        at.h = -1 + 2 * (static_cast<float>(i) + 0.5f) / kH;
        const auto fiber = maker->MakeInDouble(at);
        const Vector3d wo(std::sin(theta), 0, std::cos(theta));
        for (int j = 0; j < kTheta; ++j)
            for (int k = 0; k < kPhi; ++k) {
                const double t = kPi<double> * ((j + 0.5) / kTheta - 0.5),
                             phi = 2 * kPi<double> * (k + 0.5) / kPhi;
                const Vector3d wi(std::sin(t), std::cos(t) * std::sin(phi), std::cos(t) * std::cos(phi));
                const double f = fiber->Evaluate(wo, wi).fCos[0] * std::cos(t) * 2 * kPi<double> *
                                 kPi<double> / (kH * kTheta * kPhi);
                (wi.z < 0 ? sum.forward : sum.backward) += f;
                if (wi.z < 0)
                    sum.forwardAngle += f * (t + theta);
            }
    }
    sum.forwardAngle /= sum.forward;
    return sum;
}

TEST(FiberAlbedo, IsWhatQuadratureOverTheSphereSays) {
    const FiberAlbedoTable table = TableOf("Material \"hair\" \"rgb sigma_a\" [0.3 0.3 0.3]");
    for (const double theta : {-0.8, 0., 0.4}) {
        const HalvesByQuadrature truth = Integrate(0.3f, theta);
        const FiberAlbedo a = table.At(static_cast<float>(std::sin(theta)));
        EXPECT_NEAR(double{a.forward.albedo[1]}, truth.forward, 0.01) << theta;
        EXPECT_NEAR(double{a.backward.albedo[1]}, truth.backward, 0.01) << theta;
        EXPECT_NEAR(double{a.forward.shift}, truth.forwardAngle, 0.01) << theta;
    }
}

TEST(FiberAlbedo, AWhiteFiberReturnsAllLight) {
    // d'Eon's form keeps its energy less exactly than it samples (see its laws)
    for (const auto &[model, tolerance] : {std::pair("chiang", 0.002), std::pair("deon", 0.03)}) {
        const FiberAlbedoTable table = TableOf(
            std::string("Material \"hair\" \"rgb sigma_a\" [0 0 0] \"string model\" \"") + model + "\"");
        for (const float s : {-0.7f, 0.f, 0.9f}) {
            const FiberAlbedo a = table.At(s);
            EXPECT_NEAR(double{a.forward.albedo[0] + a.backward.albedo[0]}, 1, tolerance) << model << s;
        }
    }
}

// Follows light along a row of fibers, each of which sends it on or back: out past fiber 0 again after one or
// three times back.
TEST(FiberAlbedo, MultipleBackscatterSumsUpPathsAlongARow) {
    FiberAlbedo albedo;
    albedo.forward.albedo = Spectrum(0.6f), albedo.backward.albedo = Spectrum(0.15f);
    constexpr int kRow = 60;
    // light[back][direction][fiber]: what is about to meet that fiber
    std::vector<std::array<std::array<double, kRow + 2>, 2>> light(6);
    light[0][0][1] = 0.6; // it has passed fiber 0
    double out[6] = {};
    for (int step = 0; step < 2000; ++step) {
        std::vector<std::array<std::array<double, kRow + 2>, 2>> next(6);
        for (size_t back = 0; back < 4; ++back)
            for (size_t direction = 0; direction < 2; ++direction)
                for (size_t i = 0; i < kRow; ++i) {
                    const double l = light[back][direction][i];
                    if (l == 0)
                        continue;
                    const double on = 0.6 * l, turned = 0.15 * l;
                    if (direction == 0)
                        next[back][0][i + 1] += on,
                            i > 0 ? next[back + 1][1][i - 1] += turned : out[5] += turned;
                    else {
                        i > 0 ? next[back][1][i - 1] += on : out[back] += on;
                        next[back + 1][0][i + 1] += turned;
                    }
                }
        light = next;
    }
    EXPECT_NEAR(double{MultipleBackscatter(albedo).albedo[0]}, out[1] + out[3], 1e-5);
}

// A white wall behind n wide flat hairs, each of which covers it: (mean forward albedo)^n of the light.
std::string Layers(int n) {
    std::string world = "LightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 0]\n"
                        "AttributeBegin Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"trianglemesh\" "
                        "\"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 -9 2 9 -9 2 9 9 2 -9 9 2] "
                        "AttributeEnd Material \"hair\" \"rgb sigma_a\" [0.3 0.3 0.3]\n";
    for (int i = 0; i < n; ++i) {
        const std::string z = std::to_string(-5 - i);
        world += "Shape \"curve\" \"point P\" [-9 0 " + z + " -3 0 " + z + " 3 0 " + z + " 9 0 " + z +
                 "] \"float width\" 18\n";
    }
    return world;
}

TEST(DualScattering, EachLayerPassesItsForwardAlbedo) {
    const double albedo = Integrate(0.3f, 0).forward;
    const double free = MeanOf(RenderOf("\"dualscattering\"", Layers(0), 4), 8, 16);
    ASSERT_NEAR(free, 1 / kPi<double>, 1e-3);
    for (const int n : {1, 2, 5}) {
        const double dense =
            MeanOf(RenderOf("\"dualscattering\" \"float forwarddensity\" 0.8", Layers(n), 4), 8, 16);
        EXPECT_NEAR(dense / free, 0.8 * std::pow(albedo, n), 0.02 * n * std::pow(albedo, n)) << n;
    }
}

// A single hair has no neighbours: it looks as direct light makes it.
TEST(DualScattering, ASingleHairHasDirectLight) {
    const std::string world =
        "LightSource \"distant\" \"point from\" [-1 1 -1] \"rgb L\" [3 3 3] "
        "Material \"hair\" Shape \"curve\" \"point P\" [-1 -1 0 -.3 -.3 0 .3 .3 0 1 1 0] "
        "\"float width\" .4";
    const double direct = MeanOf(RenderOf("\"directlighting\"", world, 256));
    EXPECT_NEAR(MeanOf(RenderOf("\"dualscattering\" \"float backwarddensity\" 0", world, 256)) / direct, 1,
                0.01);
    EXPECT_GT(MeanOf(RenderOf("\"dualscattering\"", world, 256)) / direct, 1.02) << "neighbours behind it";
}

std::string Ball(const char *eumelanin, const char *strands, const char *width) {
    return std::string(
               "Scale 0.9 0.9 0.9 LightSource \"distant\" \"point from\" [-1 0.5 -0.6] \"rgb L\" [3 3 3]\n"
               "Material \"hair\" \"float eumelanin\" ") +
           eumelanin + " Shape \"groom\" \"string kind\" \"ball\" \"integer strands\" " + strands +
           " \"float width\" " + width;
}

// Black hair scatters little twice, so that path tracing says nearly the same; the lighter hair is, the more
// dual scattering leaves out.
TEST(DualScattering, BlackHairIsNearToPaths) {
    const auto ratio = [](const char *eumelanin) {
        const std::string ball = Ball(eumelanin, "4000", "0.01");
        return MeanOf(RenderOf("\"dualscattering\"", ball, 64)) /
               MeanOf(RenderOf("\"path\" \"integer maxdepth\" 60", ball, 64));
    };
    const double black = ratio("8"), brown = ratio("1.3"), blond = ratio("0.1");
    printf("[ dual scattering of the light of paths: black %.3f, brown %.3f, blond %.3f ]\n", black, brown,
           blond);
    EXPECT_NEAR(black, 1, 0.08);
    EXPECT_NEAR(brown, 1, 0.15);
    EXPECT_NEAR(blond, 1, 0.45);
    EXPECT_LT(std::abs(black - 1), std::abs(blond - 1));
}

// Hairs at random are counted by a grid as along rays, in the mean.
TEST(DualScattering, TheGridCountsAsRaysDo) {
    const std::string ball = Ball("0.3", "4000", "0.008");
    const double traced = MeanOf(RenderOf("\"dualscattering\"", ball, 64));
    EXPECT_NEAR(MeanOf(RenderOf("\"dualscattering\" \"string count\" \"grid\"", ball, 64)) / traced, 1, 0.06);
}

// Parallel hairs that fill a box: a ray at an angle a to them meets areas times sin a.
TEST(CrossingGrid, CountsParallelHairs) {
    constexpr size_t kSide = 60;
    const auto everyHair = [&](const CrossingGrid::UseCurve &use) {
        for (size_t i = 0; i < kSide * kSide; ++i) {
            const float y = (static_cast<float>(i % kSide) + 0.5f) / kSide,
                        z = (static_cast<float>(i / kSide) + 0.5f) / kSide;
            use({Point3f{0, y, z}, {1 / 3.f, y, z}, {2 / 3.f, y, z}, {1, y, z}}, {0.01f, 0.01f});
        }
    };
    const CrossingGrid grid = CrossingGrid::Of({{0, 0, 0}, {1, 1, 1}}, 0.1f, everyHair);
    const double area = kSide * kSide * 0.01; // per unit of volume
    for (const float angle : {0.2f, 0.8f, 1.5f}) {
        const auto c = grid.At({0.5f, 0.5f, 0.5f}, {std::cos(angle), std::sin(angle), 0});
        EXPECT_NEAR(double{c.perLength}, area * std::sin(double{angle}), 0.01 * area) << angle;
        EXPECT_NEAR(double{c.sineSquared}, Sqr(std::cos(double{angle})), 1e-4) << angle;
    }
    float t0 = 0, t1 = Infinity;
    ASSERT_TRUE(grid.Clip({0.5f, 0.5f, -2}, {0, 0, 1}, &t0, &t1));
    EXPECT_NEAR(t0, 2, 0.35);
    EXPECT_NEAR(t1, 3, 0.35);
    t0 = 0, t1 = Infinity;
    EXPECT_FALSE(grid.Clip({0.5f, 3, -2}, {0, 0, 1}, &t0, &t1));
}

} // namespace
} // namespace cuticle
