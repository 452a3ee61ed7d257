// Laws of Integrator "hairlight": light through layers of hair, deep shadows against traced ones, and the
// shell's factor.
#include "render/hair_light.h"

#include "render/plugins.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

Image RenderSmall(const std::string &integrator, const std::string &world, int spp = 16) {
    SceneDescription description = ParseSceneText(
        AllPlugins(),
        "Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 24 PixelFilter \"box\"\n"
        "Integrator \"hairlight\" " +
            integrator +
            "\nLookAt 0 0 -4  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]\n"
            "WorldBegin\n" +
            world + "\nWorldEnd\n",
        "hair_light_test");
    const Scene scene(&description, {});
    RenderOptions options;
    options.spp = spp;
    RenderStats stats;
    return Render(description, scene, options, &stats);
}
double MeanOf(const Image &image) {
    double sum = 0;
    for (size_t y = 8; y < 16; ++y)
        for (size_t x = 8; x < 16; ++x)
            sum += static_cast<double>(image.RGB(x, y)[1]) / 64;
    return sum;
}

// A white wall behind n wide flat curves, each of which covers all of it, lit along the view from behind the
// viewer: the wall has (1 - opacity)^n of the light. The camera looks past the curves from between them and
// the wall.
std::string Layers(int n, const std::string &light) {
    std::string world = light +
                        "\nAttributeBegin Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"trianglemesh\" "
                        "\"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 -9 2 9 -9 2 9 9 2 -9 9 2] "
                        "AttributeEnd Material \"hair\"\n";
    for (int i = 0; i < n; ++i) {
        const std::string z = std::to_string(-5 - i);
        world += "Shape \"curve\" \"point P\" [-9 0 " + z + " -3 0 " + z + " 3 0 " + z + " 9 0 " + z +
                 "] \"float width\" 18\n";
    }
    return world;
}

TEST(HairLight, EachLayerTakesItsShare) {
    for (const char *light : {"LightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 0]",
                              "LightSource \"point\" \"point from\" [0 0 -40] \"rgb I\" [1600 1600 1600]"}) {
        const double free = MeanOf(RenderSmall("", Layers(0, light)));
        ASSERT_GT(free, 0.1);
        for (const char *shadow : {"traced", "deepmap"})
            for (const int n : {1, 2, 5}) {
                const Image image =
                    RenderSmall(std::string("\"float opacity\" 0.3 \"float maperror\" 0.001 "
                                            "\"integer mapresolution\" 64 \"string shadow\" \"") +
                                    shadow + "\"",
                                Layers(n, light));
                EXPECT_NEAR(MeanOf(image) / free, std::pow(0.7, n), 0.003) << shadow << " " << n << light;
            }
        EXPECT_EQ(MeanOf(RenderSmall("", Layers(1, light))), 0) << "opaque by default";
    }
}

// A white wall in parallel light looks as anybody computes it, hair or no hair in the integrator.
TEST(HairLight, AWallHasLambertsLight) {
    const double wall =
        MeanOf(RenderSmall("\"bool shellnormals\" true",
                           Layers(0, "LightSource \"distant\" \"point from\" [0 0 -1] \"rgb L\" [2 2 2]")));
    EXPECT_NEAR(wall, 2 / kPi<double>, 1e-4);
}

// Root mean square of the difference between two pictures, of the green of all pixels.
double RmsBetween(const Image &a, const Image &b) {
    double sum = 0;
    for (size_t y = 0; y < 24; ++y)
        for (size_t x = 0; x < 24; ++x)
            sum += Sqr(static_cast<double>(a.RGB(x, y)[1] - b.RGB(x, y)[1])) / (24 * 24);
    return std::sqrt(sum);
}

// Deep shadows come near to traced ones as the map grows and as the stated error of its functions falls.
TEST(HairLight, DeepShadowsConvergeToTracedOnes) {
    const std::string ball =
        "Scale 0.9 0.9 0.9 LightSource \"distant\" \"point from\" [-1 0.5 -0.6] \"rgb L\" [3 3 3]\n"
        "Material \"hair\" \"string model\" \"kajiya-kay\"\n"
        "Shape \"groom\" \"string kind\" \"ball\" \"integer strands\" 1500 \"float width\" 0.02";
    const auto render = [&](const std::string &how) {
        return RenderSmall("\"float opacity\" 0.2 \"integer mapsamples\" 2 " + how, ball, 64);
    };
    const Image truth = render("\"string shadow\" \"traced\"");
    const auto errorOf = [&](int side, const char *error) {
        return RmsBetween(truth, render("\"string shadow\" \"deepmap\" \"integer mapresolution\" " +
                                        std::to_string(side) + " \"float maperror\" " + error));
    };
    const double coarse = errorOf(8, "0.003"), middle = errorOf(32, "0.003"), fine = errorOf(128, "0.003"),
                 rough = errorOf(128, "0.3");
    printf("[ deep shadows against traced ones, rms: map of 8: %.4f, 32: %.4f, 128: %.4f; of 128 to 0.3: "
           "%.4f ]\n",
           coarse, middle, fine, rough);
    EXPECT_LT(middle, 0.7 * coarse);
    EXPECT_LT(fine, 0.7 * middle);
    EXPECT_LT(fine, 0.7 * rough);
}

// The factor of the shell of a ball of hair is the cosine about the ball's own normal, and wraps around it.
TEST(HairLight, TheShellsFactorIsTheCosineAboutIt) {
    SceneDescription description = ParseSceneText(
        AllPlugins(),
        "WorldBegin LightSource \"distant\" Material \"hair\" Shape \"groom\" \"string kind\" \"fur-ball\" "
        "\"integer strands\" 20000 \"float radius\" 1 \"float length\" 0.6 WorldEnd",
        "hair_light_test");
    const Scene scene(&description, {});
    const Vector3f wi = Normalize(Vector3f{1, 2, -1});
    for (const float wrap : {0.f, 0.5f}) {
        HairLightIntegrator::Settings settings;
        settings.shellNormals = true, settings.wrap = wrap, settings.shellCell = 0.12f;
        HairLightIntegrator integrator(settings);
        EXPECT_EQ(integrator.ShellFactor({0, 1, 0}, wi), 1) << "before the shell is made";
        integrator.Prepare(scene, MakeCamera(description.camera, {8, 8}));
        double mean = 0;
        for (int i = 0; i < 200; ++i) {
            const float z = (static_cast<float>(i) + 0.5f) / 100 - 1, phi = 2.4f * static_cast<float>(i);
            const float r = std::sqrt(1 - z * z);
            const Vector3f n{r * std::cos(phi), r * std::sin(phi), z};
            const float expected = std::max(0.f, (Dot(n, wi) + wrap) / (1 + wrap));
            mean += static_cast<double>(std::abs(integrator.ShellFactor(n * 1.45f, wi) - expected)) / 200;
        }
        EXPECT_LT(mean, 0.1) << wrap;
    }
}

TEST(HairLight, WrongSettingsAreErrors) {
    for (const char *wrong : {"\"string shadow\" \"deep\"", "\"float opacity\" 2",
                              "\"integer mapresolution\" 0", "\"float wrap\" -1", "\"integer maxdepth\" -1"})
        EXPECT_THROW(RenderSmall(wrong, Layers(1, "LightSource \"distant\"")), Error) << wrong;
}

} // namespace
} // namespace cuticle
