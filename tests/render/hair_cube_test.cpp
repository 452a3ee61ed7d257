// Pharr's figure 1.20: a mass of hair looks like the colour from which its absorption was found.
#include "core/color.h"
#include "fibers/hair.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

// The front of the cube of 100 x 100 hairs under a white dome, without its edges: the mean colour. A matte sphere beside it
// would show its own.
Spectrum CubeFront(const Spectrum &sigmaA, float betaN) {
    std::ostringstream text;
    text << R"(Film "image" "integer xresolution" 16 "integer yresolution" 16 PixelFilter "box"
LookAt 0 0 9  0 0 0  0 1 0 Camera "orthographic" "float screenwindow" [-0.8 0.8 -0.8 0.8]
Sampler "sobol" "integer pixelsamples" 64 Integrator "path" "integer maxdepth" 500
WorldBegin LightSource "infinite" "rgb L" [1 1 1]
Material "hair" "rgb sigma_a" [)"
         << sigmaA[0] << " " << sigmaA[1] << " " << sigmaA[2] << R"(] "float beta_n" )" << betaN << R"(
Shape "groom" "string kind" "hair-cube" "integer strands" 10000 WorldEnd)";
    SceneDescription description = ParseSceneText(text.str(), "cube.pbrt");
    const Scene scene(&description, {});
    RenderOptions options;
    options.progress = false;
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

// No bound on a colour difference follows from physics. But the absorption that the formula finds must be a better one than
// half and than twice of it: a formula without its square, of the diameter, or of another roughness is not.
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

// The absorption that is printed under the figure's upper cube is the formula's for beta_n = 0.8, and shows the colour in
// such hair, not in that of the caption's 0.3.
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
