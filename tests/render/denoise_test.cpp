// Denoising: what smoothing keeps, what it gains, and whether its own account of the error is true.
#include "render/denoise.h"

#include "core/parallel.h"
#include "render/guides.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

namespace cuticle {
namespace {

constexpr Point2i kSize{96, 80};
constexpr size_t kPixels = size_t{96} * 80;

std::vector<Spectrum> PictureOf(const std::function<double(int x, int y)> &value) {
    std::vector<Spectrum> picture(kPixels);
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x)
            picture[static_cast<size_t>(y * kSize.x + x)] = Spectrum(static_cast<float>(value(x, y)));
    return picture;
}

// Both halves of a picture with independent noise of a standard deviation; uniform, so that it has bounds.
PartHalves WithNoise(const std::vector<Spectrum> &truth, double sigma, uint64_t seed) {
    RNG rng(seed);
    PartHalves halves{truth, truth};
    for (std::vector<Spectrum> *half : {&halves.a, &halves.b})
        for (Spectrum &s : *half)
            for (float &c : s.c)
                c += static_cast<float>(sigma * std::sqrt(12) * (double{rng.UniformFloat()} - 0.5));
    return halves;
}

double RmsError(const std::vector<Spectrum> &picture, const std::vector<Spectrum> &truth) {
    double sum = 0;
    for (size_t i = 0; i < truth.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            sum += Sqr(double{picture[i].c[c]} - double{truth[i].c[c]});
    return std::sqrt(sum / (3. * static_cast<double>(truth.size())));
}

TEST(Smoothed, IsAGaussian) {
    const auto point = PictureOf([](int x, int y) { return x == 40 && y == 30 ? 1 : 0; });
    const std::vector<Spectrum> smooth = Smoothed(point, kSize, 2);
    double sum = 0, xx = 0, yy = 0;
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x) {
            const double w{smooth[static_cast<size_t>(y * kSize.x + x)].c[0]};
            sum += w, xx += w * (x - 40) * (x - 40), yy += w * (y - 30) * (y - 30);
        }
    EXPECT_NEAR(sum, 1, 1e-5);
    double expected = 0, weights = 0; // along one axis, cut off at three standard deviations
    for (int i = -6; i <= 6; ++i)
        expected += i * i * std::exp(-i * i / 8.), weights += std::exp(-i * i / 8.);
    EXPECT_NEAR(xx, expected / weights, 1e-4);
    EXPECT_NEAR(yy, expected / weights, 1e-4);
    for (const Spectrum &s : Smoothed(PictureOf([](int, int) { return 3; }), kSize, 5))
        EXPECT_NEAR(s.c[1], 3, 1e-5) << "also at the edges";
    EXPECT_EQ(Smoothed(point, kSize, 0), point);
}

// Halves that agree have no noise: nothing is changed, not by a bit.
TEST(Denoise, LeavesAloneWhatHasNoNoise) {
    const auto truth = PictureOf([](int x, int y) { return 1 + (x % 7) * (y % 3) + (x > 40 ? 5 : 0); });
    const DenoisedPicture denoised = Denoise(kSize, std::vector{PartHalves{truth, truth}});
    EXPECT_EQ(denoised.picture, truth);
    EXPECT_EQ(denoised.before.pixels, 0);
    EXPECT_EQ(denoised.after.pixels, 0);
    const std::vector<Spectrum> black(kPixels);
    EXPECT_EQ(Denoise(kSize, std::vector{PartHalves{black, black}}).picture, black);
}

// A wall of one brightness: the error falls to that of means over the widest kernel, 1 / (2 sqrt(pi) 5.6),
// times about 1.5 for what smoothing twice gives back. The program's own account is the true error.
TEST(Denoise, SmoothsAWall) {
    const auto truth = PictureOf([](int, int) { return 2; });
    const PartHalves noisy = WithNoise(truth, 0.4, 1);
    const DenoisedPicture denoised = Denoise(kSize, std::vector{noisy});
    const double before = 0.4 / std::sqrt(2.), after = RmsError(denoised.picture, truth);
    EXPECT_LT(after, before / 8);
    // The picture weighs errors by its brightness and a tenth of its mean's square
    const double weight = 1 / std::sqrt(4 + 0.1 * 4);
    EXPECT_NEAR(denoised.before.pixels, before * weight, 0.03 * before * weight);
    EXPECT_NEAR(denoised.after.pixels, after * weight, 0.35 * after * weight)
        << "the least of nine estimates flatters a little";
}

// Wide kernels work on halved pictures: a plane that falls in both directions keeps its slope, at edges of
// odd sizes too, up to what the mean over a kernel that the edge cuts off is shifted by. A picture may be one
// pixel wide.
TEST(Denoise, KeepsSlopesInPicturesOfAnySize) {
    for (const Point2i size :
         {Point2i{1, 1}, Point2i{1, 40}, Point2i{37, 1}, Point2i{2, 3}, Point2i{61, 47}}) {
        const auto n = static_cast<size_t>(size.x * size.y);
        std::vector<Spectrum> truth(n);
        for (size_t i = 0; i < n; ++i) {
            const auto x = static_cast<float>(i % static_cast<size_t>(size.x)),
                       y = static_cast<float>(i / static_cast<size_t>(size.x));
            truth[i] = Spectrum(20 + 0.1f * x + 0.15f * y);
        }
        const PartHalves noisy = WithNoise(truth, 1, 9);
        const DenoisedPicture denoised = Denoise(size, std::vector{noisy});
        ASSERT_EQ(denoised.picture.size(), n);
        std::vector<Spectrum> mean(n);
        for (size_t i = 0; i < n; ++i) {
            mean[i] = (noisy.a[i] + noisy.b[i]) * 0.5f;
            ASSERT_TRUE(denoised.picture[i].IsFinite()) << size.x << " x " << size.y;
        }
        const double before = RmsError(mean, truth), after = RmsError(denoised.picture, truth);
        EXPECT_LE(after, before * (n > 1000 ? 0.2 : 1.001))
            << size.x << " x " << size.y << " " << after / before;
    }
}

// Detail that stands above the noise stays: a strand a pixel wide loses less than a tenth of its contrast.
TEST(Denoise, KeepsStrands) {
    const auto truth = PictureOf([](int x, int y) { return (x + y) % 6 == 0 ? 4 : 1; });
    const DenoisedPicture denoised = Denoise(kSize, std::vector{WithNoise(truth, 0.2, 2)});
    const auto at = [&](int x, int y) { return denoised.picture[static_cast<size_t>(y * kSize.x + x)].c[0]; };
    double strand = 0, beside = 0;
    for (int y = 20; y < 60; ++y)
        for (int x = 20; x < 70; ++x)
            ((x + y) % 6 == 0 ? strand : beside) += double{at(x, y)};
    const double contrast = strand / (40 * 50 / 6.) - beside / (40 * 50 * 5 / 6.);
    EXPECT_GT(contrast, 0.9 * 3);
    EXPECT_LE(RmsError(denoised.picture, truth), 0.2 / std::sqrt(2.) * 1.02);
}

// Two parts: sharp strands without noise, and a smooth and noisy rest. Apart, the rest is smoothed and the
// strands stay; as one they cannot have both.
TEST(Denoise, PartsAreSmoothedEachByItsOwn) {
    const auto strands = PictureOf([](int x, int) { return x % 4 == 0 ? 3 : 0; });
    const auto rest = PictureOf([](int x, int y) { return 2 + 0.01 * x + 0.005 * y; });
    auto truth = strands;
    for (size_t i = 0; i < truth.size(); ++i)
        truth[i] += rest[i];
    const PartHalves noisy = WithNoise(rest, 0.6, 3);
    PartHalves one = noisy;
    for (size_t i = 0; i < truth.size(); ++i)
        one.a[i] += strands[i], one.b[i] += strands[i];
    const double apart =
        RmsError(Denoise(kSize, std::vector{PartHalves{strands, strands}, noisy}).picture, truth);
    const double together = RmsError(Denoise(kSize, std::vector{one}).picture, truth);
    EXPECT_LT(apart, 0.6 / std::sqrt(2.) / 8);
    EXPECT_LT(apart, together / 3);
}

// Strands far below the noise stay where a guide shows them: the picture is 1 beside them and 3 on them,
// slowly brighter to the right. A guide that knows nothing of the picture changes next to nothing.
TEST(Denoise, GuidesKeepStrandsBelowTheNoise) {
    const auto strand = [](int x, int y) { return (3 * x + y) % 11 < 2 ? 1. : 0.; };
    const auto truth = PictureOf([&](int x, int y) { return 1 + (2 + 0.01 * x) * strand(x, y); });
    Guides guides, useless;
    guides[0].resize(kPixels), guides[1].resize(kPixels), useless = guides;
    RNG rng(3);
    for (size_t i = 0; i < kPixels; ++i) {
        guides[0][i] = static_cast<float>(strand(static_cast<int>(i % 96), static_cast<int>(i / 96)));
        useless[0][i] = rng.UniformFloat(), useless[1][i] = rng.UniformFloat();
    }
    const std::vector parts{WithNoise(truth, 2, 5)};
    const double alone = RmsError(Denoise(kSize, parts).picture, truth),
                 guided = RmsError(Denoise(kSize, parts, &guides).picture, truth),
                 misguided = RmsError(Denoise(kSize, parts, &useless).picture, truth);
    EXPECT_LT(guided, alone / 4);
    EXPECT_LT(misguided, alone * 1.05);
    std::swap(guides[0], guides[1]);
    EXPECT_LT(RmsError(Denoise(kSize, parts, &guides).picture, truth), alone / 4) << "the other guide";
    std::vector<Spectrum> one, two;
    OnThreads(1, [&] { one = Denoise(kSize, parts, &guides).picture; });
    OnThreads(2, [&] { two = Denoise(kSize, parts, &guides).picture; });
    EXPECT_EQ(one, two);
}

// The block error that is reported is measured, not hoped for: over many noises its mean is the true one's.
TEST(Denoise, SaysHowFarBlocksAreOff) {
    const auto truth = PictureOf([](int x, int y) { return 2 + std::sin(0.3 * x) * std::cos(0.2 * y); });
    double said = 0, was = 0;
    constexpr int kRuns = 12;
    for (int run = 0; run < kRuns; ++run) {
        const DenoisedPicture d =
            Denoise(kSize, std::vector{WithNoise(truth, 0.8, 10 + static_cast<uint64_t>(run))});
        said += Sqr(d.after.blocks) / kRuns;
        double sum = 0, n = 0, mean = 0;
        for (const Spectrum &s : truth)
            mean += double{s.c[0]} / double(kPixels);
        for (int v = 0; v < kSize.y; v += 8)
            for (int u = 0; u < kSize.x; u += 8, ++n) {
                Spectrum off, bright;
                for (int y = v; y < v + 8; ++y)
                    for (int x = u; x < u + 8; ++x) {
                        const auto i = static_cast<size_t>(y * kSize.x + x);
                        off += (d.picture[i] - truth[i]) * (1 / 64.f), bright += truth[i] * (1 / 64.f);
                    }
                sum += (Sqr(double{off.c[0]}) + Sqr(double{off.c[1]}) + Sqr(double{off.c[2]})) / 3 /
                       (Sqr(double{bright.c[0]}) + 0.1 * mean * mean);
            }
        was += sum / n / kRuns;
    }
    EXPECT_NEAR(std::sqrt(said / was), 1, 0.25) << said << " " << was;
}

TEST(Denoise, IsTheSameForAnyNumberOfThreads) {
    const auto truth = PictureOf([](int x, int y) { return 1 + std::sin(0.1 * x * y); });
    const std::vector parts{WithNoise(truth, 0.3, 4)};
    std::vector<Spectrum> one, two;
    OnThreads(1, [&] { one = Denoise(kSize, parts).picture; });
    OnThreads(2, [&] { two = Denoise(kSize, parts).picture; });
    EXPECT_EQ(one, two);
}

// --- pictures ---------------------------------------------------------------------------------------------
std::string BallText(const std::string &film, int spp, int depth) {
    return "Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 40 " + film +
           fmt::format(
               " Sampler \"sobol\" \"integer pixelsamples\" {} Integrator \"path\" \"integer maxdepth\" {} ",
               spp, depth) +
           "LookAt 0 0 -14 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 16 WorldBegin "
           "LightSource \"infinite\" \"rgb L\" [.1 .12 .15] LightSource \"distant\" \"point from\" [1 2 -2] "
           "\"rgb L\" [3 2.8 2.4] Material \"hair\" \"float eumelanin\" .1 Shape \"groom\" \"string kind\" "
           "\"ball\" \"integer strands\" 1000 \"float width\" .03 WorldEnd";
}

struct Made {
    SceneDescription description;
    std::unique_ptr<Scene> scene;
    explicit Made(const std::string &text) : description(ParseSceneText(AllPlugins(), text, "test.pbrt")) {
        scene = std::make_unique<Scene>(&description, SceneOptions{});
    }
    Image Take(const RenderOptions &options, RenderStats *stats = nullptr) const {
        return Render(description, *scene, options, stats);
    }
};

// The picture of a ball of hair is better by pixel and no worse in blocks, as it says itself.
TEST(DenoisedRender, IsNearerToTheTruth) {
    const Made few(BallText("\"bool denoise\" \"true\"", 16, 30)), many(BallText("", 2048, 30));
    RenderOptions other;
    other.seed = 5;
    const Image truth = many.Take(other);
    RenderStats stats;
    const Image image = few.Take({}, &stats);
    ASSERT_EQ(image.channels,
              (std::vector<std::string>{"R", "G", "B", "unfiltered.R", "unfiltered.G", "unfiltered.B"}));
    EXPECT_NE(stats.denoised.find("pixels are off by"), std::string::npos) << stats.denoised;
    double denoised = 0, unfiltered = 0, blocks[2] = {};
    for (size_t v = 0; v < 40; v += 8)
        for (size_t u = 0; u < 40; u += 8) {
            double off[2][3] = {};
            for (size_t y = v; y < v + 8; ++y)
                for (size_t x = u; x < u + 8; ++x)
                    for (size_t c = 0; c < 3; ++c) {
                        const double t{truth.At(x, y, c)};
                        denoised += Sqr(double{image.At(x, y, c)} - t);
                        unfiltered += Sqr(double{image.At(x, y, c + 3)} - t);
                        off[0][c] += double{image.At(x, y, c)} - t;
                        off[1][c] += double{image.At(x, y, c + 3)} - t;
                    }
            for (size_t k = 0; k < 2; ++k)
                for (const double o : off[k])
                    blocks[k] += o * o;
        }
    EXPECT_LT(denoised, unfiltered / 3)
        << "mean square errors; " << stats.denoised << " blocks " << blocks[0] << " " << blocks[1];
    EXPECT_LT(blocks[0], 1.1 * blocks[1]);
}

// The direct light that a sample tells of is the light of the same path cut off after one scattering.
TEST(DenoisedRender, DirectLightIsThatOfPathsOfDepthOne) {
    const Made deep(BallText("", 4, 30)), shallow(BallText("", 4, 1));
    const auto integrator = [](const Made &made) {
        return MakeIntegrator(made.description.integrator, made.description.integrator.type);
    };
    const auto deepOne = integrator(deep), shallowOne = integrator(shallow);
    double indirect = 0;
    for (int i = 0; i < 400; ++i) {
        const Ray ray({0, 0, -14}, Normalize(Vector3f(0.008f * static_cast<float>(i % 20 - 10),
                                                      0.008f * static_cast<float>(i / 20 - 10), 1)));
        PixelSampler a(SamplerKind::Independent, 4, 7), b = a;
        a.Start(i, 0, 0), b.Start(i, 0, 0);
        RayCounts counts;
        LightParts parts;
        const Spectrum whole = deepOne->LiInParts(ray, *deep.scene, a, counts, &parts);
        EXPECT_EQ(parts.direct, shallowOne->Li(ray, *shallow.scene, b, counts)) << i;
        indirect += double{(whole - parts.direct).y()};
    }
    EXPECT_GT(indirect, 10);
}

// A wall that fills the left half of the picture covers half of it. A lamp far away sends it E cos / pi times
// its reflectance, also where another wall, out of sight, stands before the lamp.
TEST(DenoisedRender, GuidesSeeCoverageAndUnshadowedLight) {
    const Made made(
        "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 2 LookAt 0 0 -5 0 0 0 0 1 0 "
        "Camera \"orthographic\" \"float screenwindow\" [-2 2 -1 1] PixelFilter \"box\" WorldBegin "
        "LightSource \"distant\" \"point from\" [0 3 -4] \"point to\" [0 0 0] \"rgb L\" [2 2 2] Material "
        "\"matte\" \"rgb Kd\" "
        "[.5 .5 .5] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" "
        "[-9 -9 0 -.5 -9 0 -.5 9 0 -9 9 0] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
        "\"point P\" [-9 2 -1 9 2 -1 9 2 -9 -9 2 -9] WorldEnd");
    const Camera camera = MakeCamera(made.description.camera, {4, 2});
    const Filter filter = MakeFilter(made.description.filter);
    const Guides guides = SeeGuides(*made.scene, camera, filter, {{0, 0}, {4, 2}, 64, 1});
    const double light = 0.5 / Pi * 2 * 0.8;
    for (size_t y = 0; y < 2; ++y)
        for (size_t x = 0; x < 4; ++x) {
            const bool mirrored = guides[0][0] < guides[0][3];
            const double covered = std::array{1., 0.5, 0., 0.}[mirrored ? 3 - x : x];
            EXPECT_NEAR(guides[0][4 * y + x], covered, 1e-6) << x;
            EXPECT_NEAR(guides[1][4 * y + x], covered * light, 1e-5) << x;
        }
    const Guides part = SeeGuides(*made.scene, camera, filter, {{1, 1}, {3, 2}, 64, 1});
    EXPECT_EQ(part[0], (std::vector<float>{guides[0][5], guides[0][6]})) << "a window sees the same";
}

TEST(DenoisedRender, IsRefusedWhereItCannotBe) {
    const Made made(BallText("\"bool denoise\" \"true\"", 1, 3));
    const auto says = [&](const RenderOptions &options) -> std::string {
        try {
            made.Take(options);
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    EXPECT_NE(says({}).find("take 2 or more"), std::string::npos);
    RenderOptions options;
    options.spp = 2;
    EXPECT_EQ(says(options), "");
    options.variance = true;
    options.film.denoise = true;
    EXPECT_NE(says(options).find("no variance"), std::string::npos);
    options.film.denoise = false;
    EXPECT_EQ(says(options), "");
    options.film.denoise.reset();
    EXPECT_EQ(says(options), "") << "who asks for variances does not get the scene's wish";
}

} // namespace
} // namespace cuticle
