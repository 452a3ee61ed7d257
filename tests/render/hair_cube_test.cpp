// Pharr's figure 1.20: a mass of hair looks like the colour from which its absorption was found.
#include "core/color.h"
#include "fibers/hair.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

// The front of a cube of hairs under a white dome, without its edges: the mean colour. A matte sphere beside
// it would show its own. size 1: the figure's 100 x 100 hairs.
Spectrum CubeFront(const Spectrum &sigmaA, float betaN, int size = 1) {
    const double window = 0.8 * size;
    std::ostringstream text;
    text << R"(Film "image" "integer xresolution" 16 "integer yresolution" 16 PixelFilter "box"
LookAt 0 0 99  0 0 0  0 1 0 Camera "orthographic" "float screenwindow" [)"
         << -window << " " << window << " " << -window << " " << window << R"(]
Sampler "sobol" "integer pixelsamples" 64 Integrator "path" "integer maxdepth" 500
WorldBegin LightSource "infinite" "rgb L" [1 1 1]
Material "hair" "rgb sigma_a" [)"
         << sigmaA[0] << " " << sigmaA[1] << " " << sigmaA[2] << R"(] "float beta_n" )" << betaN << R"(
Shape "groom" "string kind" "hair-cube" "integer strands" )"
         << 10000 * size * size << " \"float side\" " << 2 * size << " WorldEnd";
    SceneDescription description = ParseSceneText(AllPlugins(), text.str(), "cube.pbrt");
    const Scene scene(&description, {});
    RenderOptions options;
    RenderStats stats;
    const Image image = Render(description, scene, options, &stats);
    Spectrum sum(0);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            sum += image.RGB(x, y);
    return sum / static_cast<float>(image.width * image.height);
}
double Difference(const Spectrum &a, const Spectrum &b) {
    return CIEDE2000(XYZToLab(RGBToXYZ(a)), XYZToLab(RGBToXYZ(b)));
}

// No bound on a colour difference follows from physics. But the absorption that the formula finds must be a
// better one than half and than twice of it: a formula without its square, of the diameter, or of another
// roughness is not.
TEST(HairCube, LooksLikeTheColourThatWasAsked) {
    const struct {
        Spectrum color;
        float betaN;
    } cubes[] = {{{0.8f, 0.4f, 0.05f}, 0.3f}, {{0.2f, 0.8f, 0.3f}, 0.8f}};
    for (const auto &cube : cubes) {
        const Spectrum sigmaA = HairBSDF::SigmaAFromReflectance(cube.color, cube.betaN);
        const Spectrum seen = CubeFront(sigmaA, cube.betaN);
        const double found = Difference(seen, cube.color),
                     half = Difference(CubeFront(sigmaA * 0.5f, cube.betaN), cube.color),
                     twice = Difference(CubeFront(sigmaA * 2.f, cube.betaN), cube.color);
        std::printf("asked (%.2f, %.2f, %.2f), seen (%.2f, %.2f, %.2f): CIEDE2000 %.1f; of half the "
                    "absorption %.1f, of twice %.1f\n",
                    cube.color[0], cube.color[1], cube.color[2], seen[0], seen[1], seen[2], found, half,
                    twice);
        EXPECT_LT(found, half);
        EXPECT_LT(found, twice);
        // darker where less was asked
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                EXPECT_EQ(cube.color[a] < cube.color[b], seen[a] < seen[b]);
    }
}

// Why the figure's cubes miss their colours: light that enters by the other sides of so small a cube reaches
// the front where hardly anything is absorbed, and less of it does in a larger one; and R is white.
TEST(HairCube, TheInsideOfALargerMassIsNearer) {
    const Spectrum color(0.8f, 0.4f, 0.05f), sigmaA = HairBSDF::SigmaAFromReflectance(color, 0.3f);
    const Spectrum small = CubeFront(sigmaA, 0.3f), large = CubeFront(sigmaA, 0.3f, 4),
                   black = CubeFront(Spectrum(1e3f), 0.3f);
    std::printf("red of 0.80: %.2f of 100 x 100 hairs, %.2f of 400 x 400; of black hair %.3f\n", small[0],
                large[0], black[0]);
    EXPECT_LT(large[0], small[0]);
    EXPECT_LT(std::abs(large[0] - color[0]), std::abs(small[0] - color[0]) / 2);
    EXPECT_GT(black[0], (small[2] - color[2]) / 2) << "most of what blue has too much";
}

// The absorption that is printed under the figure's upper cube is the formula's for beta_n = 0.8, and shows
// the colour in such hair, not in that of the caption's 0.3.
TEST(HairCube, TheAbsorptionInTheCaptionIsOfRougherHair) {
    const Spectrum color(0.8f, 0.4f, 0.05f), printed(0.003f, 0.046f, 0.488f);
    const double smooth = Difference(CubeFront(printed, 0.3f), color),
                 rough = Difference(CubeFront(printed, 0.8f), color),
                 found = Difference(CubeFront(HairBSDF::SigmaAFromReflectance(color, 0.3f), 0.3f), color);
    std::printf("as printed, beta_n 0.3: CIEDE2000 %.1f, 0.8: %.1f; as computed, 0.3: %.1f\n", smooth, rough,
                found);
    EXPECT_LT(2 * rough, smooth);
    EXPECT_LT(2 * found, smooth);
}

} // namespace
} // namespace cuticle
