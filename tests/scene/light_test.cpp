// Lights against radiometry: densities that integrate to one, samples that say what the light says,
// irradiances known in closed form; and the words that scenes use for them.
#include "scene/light.h"
#include "warnings.h"

#include "core/error.h"
#include "core/sampling.h"
#include "images/image.h"
#include "materials/material.h"
#include "sampler_ends.h"
#include "scene/camera.h"
#include "scene/plugins.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <gtest/gtest.h>

namespace cuticle {
namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins(), &ShapePlugins(), &LightPlugins(),
                            &AreaLightPlugins()};

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
const Bounds3f kUnitBound{{-1, -1, -1}, {1, 1, 1}};

LightEntity Named(const std::string &type, const Transform &ctm = Transform()) {
    LightEntity entity;
    entity.type = type;
    entity.ctm = ctm;
    return entity;
}
void Set(ParamSet *params, ParamType type, const std::string &name, std::vector<double> numbers) {
    Param p;
    p.type = type;
    p.name = name;
    p.numbers = std::move(numbers);
    params->params.push_back(std::move(p));
}
void SetString(ParamSet *params, const std::string &name, const std::string &value) {
    Param p;
    p.type = ParamType::String;
    p.name = name;
    p.strings = {value};
    params->params.push_back(std::move(p));
}

// A map written to a file, since that is how lights get theirs.
LightEntity WithMap(const Image &image, const Transform &ctm, const std::string &name,
                    const std::string &type) {
    const std::string path = testing::TempDir() + "cuticle_light_" + name + ".exr";
    WriteImage(path, image);
    LightEntity entity = Named(type, ctm);
    SetString(&entity.params, "mapname", path);
    return entity;
}
std::unique_ptr<Light> MapLight(const Image &image, const Transform &ctm, const std::string &name,
                                std::vector<double> L = {1, 1, 1}) {
    LightEntity entity = WithMap(image, ctm, name, "infinite");
    Set(&entity.params, ParamType::Spectrum, "L", std::move(L));
    return MakeLight(entity, kUnitBound);
}
void Paint(Image *image, int x, int y, const Spectrum &s) {
    for (int c = 0; c < 3; ++c)
        image->At(x, y, static_cast<size_t>(c)) = s[c];
}
// Dim noise, a black half row, a sun of a few pixels near the pole, another at the seam.
Image Sky(int width, int height) {
    Image image(width, height, {"R", "G", "B"});
    RNG rng(17);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            Paint(&image, x, y,
                  {0.2f * rng.UniformFloat(), 0.3f * rng.UniformFloat(), 0.5f * rng.UniformFloat()});
    for (int x = 0; x < width; ++x)
        for (int y = height / 2; y < height * 3 / 4; ++y)
            Paint(&image, x, y, Spectrum(0.f));
    Paint(&image, width / 3, height / 8, {9000, 8000, 6000});
    Paint(&image, width / 3 + 1, height / 8, {5000, 5000, 3000});
    Paint(&image, 0, height / 3, {0, 0, 700});
    Paint(&image, width / 2, 0, {300, 0, 0});
    Paint(&image, width - 1, height - 1, {50, 60, 70});
    return image;
}
Vector3f Direction(double z, double phi) {
    const double s = std::sqrt(std::max(0., (1 - z) * (1 + z)));
    return Vector3f(Vector3d(s * std::cos(phi), s * std::sin(phi), z));
}

// Integrates over all directions by midpoints, `fine` to a half-texel cell in each of phi and theta.
template <typename F>
double IntegrateSphere(int width, int height, int fine, F f) {
    const int nu = 2 * width * fine, nv = 2 * height * fine;
    double sum = 0;
    for (int j = 0; j < nv; ++j) {
        const double z0 = std::cos(kPi<double> * j / nv), z1 = std::cos(kPi<double> * (j + 1) / nv);
        for (int i = 0; i < nu; ++i)
            sum += static_cast<double>(f(Direction((z0 + z1) / 2, 2 * kPi<double> * (i + 0.5) / nu))) *
                   (z0 - z1);
    }
    return sum * 2 * kPi<double> / nu;
}

TEST(InfiniteLight, DensityIntegratesToOne) {
    for (const Point2i &size : {Point2i(64, 32), Point2i(7, 5), Point2i(1, 1), Point2i(2, 9)}) {
        const auto light = MapLight(Sky(std::max(size.x, 2), std::max(size.y, 2)), Transform(), "one");
        const double integral = IntegrateSphere(std::max(size.x, 2), std::max(size.y, 2), 4,
                                                [&](const Vector3f &w) { return light->Pdf_Li({}, w); });
        EXPECT_NEAR(integral, 1, 1e-5) << size;
    }
    // A map finer than the table of 2048 x 1024 cells is averaged into it; no light is lost.
    const auto light = MapLight(Sky(2500, 1300), Transform(), "fine");
    const double integral =
        IntegrateSphere(1024, 512, 1, [&](const Vector3f &w) { return light->Pdf_Li({}, w); });
    EXPECT_NEAR(integral, 1, 1e-5);
    RNG rng(8);
    for (int i = 0; i < 200000; ++i) {
        const Vector3f w = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
        if (!light->Le({{}, w}).IsBlack()) {
            ASSERT_GT(light->Pdf_Li({}, w), 0) << w;
        }
    }
}

// Sample_Li, Pdf_Li and Le agree on a direction to the bit; and where there is light, there is
// density.
TEST(InfiniteLight, SamplePdfAndRadianceAgree) {
    const Transform turned = Transform::Rotate(40, {1, 2, 3}) * Transform::Scale(-1, 1, 1);
    const Transform skewed = Transform::Rotate(70, {0, 1, 3}) * Transform::Scale(3, 1, 0.5);
    int k = 0;
    for (const Transform &ctm : {Transform(), turned, skewed}) {
        const auto light = MapLight(Sky(64, 32), ctm, "agree" + std::to_string(k++), {1, 2, 0.5});
        RNG rng(4);
        int taken = 0;
        for (int i = 0; i < 100000; ++i) {
            LightSample s;
            if (!light->Sample_Li({}, {rng.UniformFloat(), rng.UniformFloat()}, &s))
                continue;
            ++taken;
            ASSERT_EQ(s.pdf, light->Pdf_Li({}, s.wi));
            ASSERT_EQ(s.L, light->Le({{}, s.wi}));
            ASSERT_NEAR(s.wi.Length(), 1, 1e-6);
            ASSERT_EQ(s.distance, Infinity);
            ASSERT_FALSE(s.delta);
        }
        EXPECT_GT(taken, 99900);
        for (int i = 0; i < 100000; ++i) {
            const Vector3f w = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            if (!light->Le({{}, w}).IsBlack()) {
                ASSERT_GT(light->Pdf_Li({}, w), 0) << w;
            }
        }
    }
}

// The mean of L / pdf is the integral of L, in each channel, under a rotation and under a skewed
// transformation, whose density needs its Jacobian: 5 standard errors of 10^6 samples, and 2e-4 for the
// quadrature.
TEST(InfiniteLight, EstimatesTheIntegralOfRadiance) {
    const Transform skewed = Transform::Rotate(70, {0, 1, 3}) * Transform::Scale(2, 1, 0.7);
    int k = 0;
    for (const Transform &ctm : {Transform(), Transform::Rotate(33, {1, 1, 0}), skewed}) {
        const Image sky = Sky(32, 16);
        const auto light = MapLight(sky, ctm, "mean" + std::to_string(k++));
        std::array<double, 3> exact{}, mean{}, square{};
        // In the light's space, where the patches are smooth; d omega of the world is |det A| / |A w|^3 of
        // it.
        const auto &m = ctm.M();
        const double det = std::abs(ctm.Determinant());
        for (int c = 0; c < 3; ++c)
            exact[static_cast<size_t>(c)] = IntegrateSphere(32, 16, 8, [&](const Vector3f &w) {
                const Vector3d v(m[0][0] * w.x + m[0][1] * w.y + m[0][2] * w.z,
                                 m[1][0] * w.x + m[1][1] * w.y + m[1][2] * w.z,
                                 m[2][0] * w.x + m[2][1] * w.y + m[2][2] * w.z);
                return static_cast<double>(light->Le({{}, Vector3f(v)})[c]) * det / std::pow(v.Length(), 3);
            });
        constexpr int n = 1000000;
        RNG rng(14);
        for (int i = 0; i < n; ++i) {
            LightSample s;
            if (light->Sample_Li({}, {rng.UniformFloat(), rng.UniformFloat()}, &s))
                for (size_t c = 0; c < 3; ++c) {
                    const double value = static_cast<double>(s.L[static_cast<int>(c)] / s.pdf);
                    mean[c] += value / n;
                    square[c] += value * value / n;
                }
        }
        for (size_t c = 0; c < 3; ++c) {
            const double error = std::sqrt((square[c] - mean[c] * mean[c]) / n);
            EXPECT_LT(error, 0.01 * exact[c]) << "importance sampling is no help in channel " << c;
            EXPECT_NEAR(mean[c], exact[c], 5 * error + 2e-4 * exact[c])
                << "channel " << c << " transformation " << k;
        }
    }
}

// Chi-squared of 10^6 samples against the density, over blocks of 4 x 4 half-texels, in each of which the
// density is a constant, so that the expected numbers are exact; blocks of few are merged. Significance 1e-4.
TEST(InfiniteLight, SamplesFollowTheDensity) {
    const auto light = MapLight(Sky(64, 32), Transform(), "chi");
    constexpr int kRows = 16, kColumns = 32, kBlock = 4, n = 1000000;
    std::vector<double> expected(kRows * kColumns), counts(kRows * kColumns);
    for (int j = 0; j < kRows * kBlock; ++j)
        for (int i = 0; i < kColumns * kBlock; ++i) {
            const double z0 = std::cos(kPi<double> * j / (kRows * kBlock));
            const double z1 = std::cos(kPi<double> * (j + 1) / (kRows * kBlock));
            const Vector3f w = Direction((z0 + z1) / 2, 2 * kPi<double> * (i + 0.5) / (kColumns * kBlock));
            expected[static_cast<size_t>((j / kBlock) * kColumns + i / kBlock)] +=
                static_cast<double>(light->Pdf_Li({}, w)) * n * (z0 - z1) * 2 * kPi<double> /
                (kColumns * kBlock);
        }
    RNG rng(9);
    for (int i = 0; i < n; ++i) {
        LightSample s;
        ASSERT_TRUE(light->Sample_Li({}, {rng.UniformFloat(), rng.UniformFloat()}, &s));
        const Vector3d w(s.wi);
        double phi = std::atan2(w.y, w.x) / (2 * kPi<double>);
        phi -= std::floor(phi);
        const double theta = std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z) / kPi<double>;
        const int row = std::min(static_cast<int>(theta * kRows), kRows - 1);
        const int column = std::min(static_cast<int>(phi * kColumns), kColumns - 1);
        ++counts[static_cast<size_t>(row * kColumns + column)];
    }
    double chi2 = 0, mergedExpected = 0, mergedCount = 0;
    int cells = 0;
    for (size_t k = 0; k < counts.size(); ++k) {
        if (expected[k] < 10) {
            mergedExpected += expected[k];
            mergedCount += counts[k];
            continue;
        }
        chi2 += Sqr(counts[k] - expected[k]) / expected[k];
        ++cells;
    }
    if (mergedExpected > 5) {
        chi2 += Sqr(mergedCount - mergedExpected) / mergedExpected;
        ++cells;
    }
    EXPECT_GT(cells, 50);
    EXPECT_LT(chi2, quantile(boost::math::chi_squared(cells - 1), 1 - 1e-4)) << cells << " cells, n = " << n;
}

// pbrt-v3: row 0 is +z, column 0 is at phi = 0 (+x), columns run toward +y.
TEST(InfiniteLight, MapsAreOrientedAsInPbrt) {
    Image image(8, 4, {"R", "G", "B"});
    for (int x = 0; x < 8; ++x)
        Paint(&image, x, 0, {1, 0, 0});
    Paint(&image, 2, 1, {0, 1, 0}); // phi 112.5 degrees, theta 67.5
    Paint(&image, 0, 2, {0, 0, 1}); // phi 22.5, theta 112.5
    const auto light = MapLight(image, Transform(), "orient");
    EXPECT_EQ(light->Le({{}, {0, 0, 3}}), Spectrum(1, 0, 0));
    EXPECT_EQ(light->Le({{}, {0, 0, -3}}), Spectrum(0, 0, 0));
    const auto at = [](float theta, float phi) {
        return Vector3f(std::sin(Radians(theta)) * std::cos(Radians(phi)),
                        std::sin(Radians(theta)) * std::sin(Radians(phi)), std::cos(Radians(theta)));
    };
    EXPECT_NEAR(light->Le({{}, at(67.5f, 112.5f)})[1], 1, 1e-5);
    EXPECT_NEAR(light->Le({{}, at(112.5f, 22.5f)})[2], 1, 1e-5);
    // Around the seam it is smooth: half way between columns 7 and 0.
    EXPECT_NEAR(light->Le({{}, at(112.5f, 0)})[2], 0.5, 1e-5);
    // The usual turn of exporters, y up.
    const auto turned = MapLight(image, Transform::Rotate(-90, {1, 0, 0}), "turned");
    EXPECT_EQ(turned->Le({{}, {0, 1, 0}}), Spectrum(1, 0, 0));
}

TEST(InfiniteLight, ConstantIsUniform) {
    LightEntity entity = Named("infinite");
    Set(&entity.params, ParamType::Spectrum, "L", {1, 2, 3});
    Set(&entity.params, ParamType::Spectrum, "scale", {2, 2, 0.5});
    const auto light = MakeLight(entity, kUnitBound);
    LightSample s;
    ASSERT_TRUE(light->Sample_Li({}, {0.3f, 0.9f}, &s));
    EXPECT_EQ(s.L, Spectrum(2, 4, 1.5f));
    EXPECT_EQ(s.pdf, UniformSpherePdf());
    EXPECT_EQ(light->Pdf_Li({}, s.wi), s.pdf);
    EXPECT_EQ(light->Le({{}, {0, 5, 0}}), s.L);
    EXPECT_TRUE(light->IsInfinite() && !light->IsDelta());
    // pi r^2 for the sphere around the bound, 4 pi for the directions.
    EXPECT_NEAR(light->Power()[0], 2 * 4 * Pi * Pi * 3, 1e-3);
    // A map of one colour is the same light.
    Image image(4, 2, {"R", "G", "B"});
    for (int i = 0; i < 8; ++i)
        Paint(&image, i % 4, i / 4, {2, 4, 1.5f});
    const auto map = MapLight(image, Transform(), "constant");
    EXPECT_NEAR(map->Pdf_Li({}, {0, 0.6f, 0.8f}) / UniformSpherePdf(), 1, 1e-5);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(map->Power()[c] / light->Power()[c], 1, 1e-5);
}

TEST(InfiniteLight, BadTexelsAreCountedAndBlack) {
    Image image(4, 2, {"R", "G", "B"});
    Paint(&image, 1, 0, {kNaN, 1, 1});
    Paint(&image, 2, 1, {-3, Infinity, 2});
    FlushWarnings();
    const auto light = MapLight(image, Transform(), "bad");
    EXPECT_EQ(FlushWarnings(), 1u);
    RNG rng(5);
    for (int i = 0; i < 2000; ++i) {
        LightSample s;
        if (light->Sample_Li({}, {rng.UniformFloat(), rng.UniformFloat()}, &s)) {
            ASSERT_TRUE(s.L.IsFinite() && s.pdf > 0 && std::isfinite(s.pdf));
        }
    }
    // All black: no samples at all.
    const auto black = MapLight(Image(4, 2, {"R", "G", "B"}), Transform(), "black");
    LightSample s;
    EXPECT_FALSE(black->Sample_Li({}, {0.5f, 0.5f}, &s));
}

TEST(DistantLight, ShinesFromFromToTo) {
    LightEntity entity = Named("distant", Transform::Rotate(90, {0, 0, 1}));
    Set(&entity.params, ParamType::Point3, "from", {1, 0, 0});
    Set(&entity.params, ParamType::Point3, "to", {0, 0, 0});
    Set(&entity.params, ParamType::Spectrum, "L", {5, 6, 7});
    const auto light = MakeLight(entity, kUnitBound);
    LightSample s;
    ASSERT_TRUE(light->Sample_Li({3, 4, 5}, {0.1f, 0.2f}, &s));
    EXPECT_LT((s.wi - Vector3f(0, 1, 0)).Length(), 1e-6f);
    EXPECT_EQ(s.L, Spectrum(5, 6, 7));
    EXPECT_EQ(s.pdf, 1);
    EXPECT_TRUE(s.delta && light->IsDelta() && !light->IsInfinite());
    EXPECT_NEAR(light->Power()[0], 5 * Pi * 3, 1e-4);
    // pbrt's default: from the origin to +z, so it comes from -z.
    ASSERT_TRUE(MakeLight(Named("distant"), kUnitBound)->Sample_Li({}, {}, &s));
    EXPECT_EQ(s.wi, Vector3f(0, 0, -1));
}

TEST(PointLight, ObeysTheInverseSquare) {
    LightEntity entity = Named("point", Transform::Translate({1, 0, 0}));
    Set(&entity.params, ParamType::Point3, "from", {0, 2, 0});
    Set(&entity.params, ParamType::Spectrum, "I", {8, 4, 2});
    const auto light = MakeLight(entity, kUnitBound);
    for (const float d : {0.01f, 1.f, 300.f}) {
        LightSample s;
        ASSERT_TRUE(light->Sample_Li({1, 2 - d, 0}, {}, &s));
        EXPECT_LT((s.wi - Vector3f(0, 1, 0)).Length(), 1e-6f);
        EXPECT_NEAR(s.L[0] * d * d, 8, 1e-4 * 8);
        EXPECT_NEAR(s.distance / d, 1, 1e-4);
        EXPECT_EQ(s.pdf, 1);
        EXPECT_TRUE(s.delta);
    }
    LightSample s;
    EXPECT_FALSE(light->Sample_Li({1, 2, 0}, {}, &s)) << "at the light itself";
    EXPECT_NEAR(light->Power()[1], 4 * 4 * Pi, 1e-4);
}

TEST(SpotLight, FallsOffAsInPbrt) {
    LightEntity entity = Named("spot");
    Set(&entity.params, ParamType::Point3, "from", {0, 0, 4});
    Set(&entity.params, ParamType::Point3, "to", {0, 0, 0});
    Set(&entity.params, ParamType::Spectrum, "I", {16, 16, 16});
    Set(&entity.params, ParamType::Float, "coneangle", {40});
    Set(&entity.params, ParamType::Float, "conedeltaangle", {15});
    const auto light = MakeLight(entity, kUnitBound);
    for (const float angle : {0.f, 10.f, 24.f, 26.f, 30.f, 39.f, 41.f, 120.f}) {
        const Point3f p =
            Point3f(0, 0, 4) + Vector3f(std::sin(Radians(angle)), 0, -std::cos(Radians(angle))) * 2.f;
        const double c = std::cos(static_cast<double>(angle) * kPi<double> / 180);
        const double end = std::cos(40 * kPi<double> / 180), start = std::cos(25 * kPi<double> / 180);
        const double delta = std::clamp((c - end) / (start - end), 0., 1.);
        LightSample s;
        const bool lit = light->Sample_Li(p, {}, &s);
        EXPECT_EQ(lit, angle < 40);
        if (lit) {
            EXPECT_NEAR(s.L[0], 4 * std::pow(delta, 4), 1e-4) << angle;
        }
    }
}

// --- lights that show a picture -----------------------------------------------------------------------

// Intensity toward w (unit length) of a light at p, as a surface at distance 3 sees it; a point has one
// direction, which no other strategy finds.
Spectrum Intensity(const Light &light, const Point3f &p, const Vector3f &w) {
    LightSample s;
    if (!light.Sample_Li(p + w * 3, {0.3f, 0.7f}, &s))
        return Spectrum(0.f);
    EXPECT_EQ(s.pdf, 1);
    EXPECT_TRUE(s.delta && light.IsDelta() && !light.IsInfinite());
    EXPECT_NEAR(s.distance, 3, 1e-5);
    EXPECT_LT((s.wi + w).Length(), 1e-5f);
    EXPECT_EQ(light.Pdf_Li(p + w * 3, s.wi), 0);
    return s.L * 9;
}

// pbrt-v3: theta from the light's +y down the rows, phi from +x toward +z along them.
TEST(GoniometricLight, MapsAreOrientedAsInPbrt) {
    Image image(4, 2, {"R", "G", "B"});
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 2; ++y)
            Paint(&image, x, y, {static_cast<float>(x), static_cast<float>(y), 1});
    LightEntity entity = WithMap(image, Transform::Translate({1, 2, 3}), "gonio", "goniometric");
    Set(&entity.params, ParamType::Spectrum, "I", {2, 2, 2});
    Set(&entity.params, ParamType::Spectrum, "scale", {3, 3, 3});
    FlushWarnings();
    const auto light = MakeLight(entity, kUnitBound);
    EXPECT_EQ(FlushWarnings(), 0u);
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 2; ++y) {
            const double theta = kPi<double> * (y + 0.5) / 2, phi = 2 * kPi<double> * (x + 0.5) / 4;
            const Vector3f w(
                Vector3d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)));
            const Spectrum I = Intensity(*light, {1, 2, 3}, w);
            EXPECT_NEAR(I[0], 6 * x, 1e-4) << x << ", " << y;
            EXPECT_NEAR(I[1], 6 * y, 1e-4) << x << ", " << y;
        }
    // Without a map it is a point light
    EXPECT_NEAR(Intensity(*MakeLight(Named("goniometric"), kUnitBound), {0, 0, 0}, {0, 0.6f, 0.8f})[1], 1,
                1e-6);
}

// The picture's row 0 at -y, column 0 at -x; black beyond its borders and behind.
TEST(ProjectionLight, ThrowsThePictureAlongZ) {
    for (const bool wide : {true, false}) {
        Image image(wide ? 4 : 2, wide ? 2 : 4, {"R", "G", "B"});
        for (int x = 0; x < image.width; ++x)
            for (int y = 0; y < image.height; ++y)
                Paint(&image, x, y, {static_cast<float>(x), static_cast<float>(y), 1});
        LightEntity entity = WithMap(image, Transform(), wide ? "wide" : "tall", "projection");
        Set(&entity.params, ParamType::Float, "fov", {60});
        const auto light = MakeLight(entity, kUnitBound);
        // The shorter side spans the field of view, in steps of a texel's half here
        const double step = std::tan(kPi<double> / 6) / 2;
        for (int i = -2 * image.width; i <= 2 * image.width; ++i)
            for (int j = -2 * image.height; j <= 2 * image.height; ++j) {
                const double x = (i + 0.25) / 2, y = (j + 0.25) / 2; // in texels from the centre
                const Vector3f w = Normalize(Vector3f(Vector3d(2 * x * step, 2 * y * step, 1)));
                const double column = x + image.width / 2. - 0.5, row = y + image.height / 2. - 0.5;
                const bool inside = std::abs(x) < image.width / 2. && std::abs(y) < image.height / 2.;
                const Spectrum I = Intensity(*light, {}, w);
                EXPECT_NEAR(I[2], inside ? 1 : 0, 1e-5) << x << ", " << y;
                if (inside) {
                    EXPECT_NEAR(I[0], std::clamp(column, 0., image.width - 1.), 1e-4) << x << ", " << y;
                    EXPECT_NEAR(I[1], std::clamp(row, 0., image.height - 1.), 1e-4) << x << ", " << y;
                }
                EXPECT_TRUE(Intensity(*light, {}, -w).IsBlack());
            }
    }
}

// The power is the integral of the intensity over all directions, whichever way the light is turned.
TEST(PictureLights, PowerIsTheIntegralOfIntensity) {
    const Transform turn = Transform::Translate({1, -2, 0.5}) * Transform::Rotate(70, {1, 2, 3});
    const auto light = [&](const char *type, double fov) {
        LightEntity entity = WithMap(Sky(24, 16), turn, std::string("power_") + type, type);
        Set(&entity.params, ParamType::Spectrum, "I", {1, 2, 0.5});
        if (fov > 0)
            Set(&entity.params, ParamType::Float, "fov", {fov});
        return MakeLight(entity, kUnitBound);
    };
    const auto check = [&](const Light &l, int fine) {
        // About the axes of the light's own map, where its cells are those of the grid
        for (int c = 0; c < 3; ++c) {
            const double power = IntegrateSphere(24, 16, fine, [&](const Vector3f &w) {
                return Intensity(l, turn.Point({}), turn.Vector({w.x, w.z, w.y}))[c];
            });
            EXPECT_NEAR(l.Power()[c] / power, 1, 0.01) << "channel " << c;
        }
    };
    check(*light("goniometric", 0), 4);
    // Some ten directions of the grid fall on a texel's side
    check(*light("projection", 30), 24);
    check(*light("projection", 120), 8);
    // A square white picture of 90 degrees is one side of a cube: 4 pi / 6
    LightEntity white = Named("projection");
    Set(&white.params, ParamType::Float, "fov", {90});
    EXPECT_NEAR(MakeLight(white, kUnitBound)->Power()[0], 4 * Pi / 6, 1e-5);
    EXPECT_NEAR(MakeLight(Named("goniometric"), kUnitBound)->Power()[0], 4 * Pi, 1e-5);
}

// --- lights where the camera is -----------------------------------------------------------------------

// CoordSysTransform "camera" goes to the camera's own space and a named system to where it was named, for
// lights that have a place, a direction, an axis or a map.
TEST(LightsInNamedSystems, AreWhereTheyWerePut) {
    const SceneDescription scene = ParseSceneText(
        kPlugins,
        "Scale -1 1 1 LookAt 4 5 6  1 2 0  0 0 1 Camera \"perspective\" \"float fov\" 40\n"
        "WorldBegin Translate 10 0 0 Rotate 90 0 0 1 CoordinateSystem \"shelf\"\n"
        "AttributeBegin CoordSysTransform \"camera\" LightSource \"point\"\n"
        "LightSource \"spot\" \"float coneangle\" 1 \"float conedeltaangle\" 0\n"
        "LightSource \"distant\" \"point from\" [0 0 0] \"point to\" [0 0 1]\n"
        "LightSource \"projection\" \"float fov\" 40\n"
        "Translate 0 0 2 LightSource \"goniometric\" AttributeEnd\n"
        "AttributeBegin CoordSysTransform \"world\" CoordSysTransform \"shelf\" Translate 1 0 0\n"
        "LightSource \"point\" AttributeEnd LightSource \"point\" WorldEnd",
        "test.pbrt");
    std::vector<std::unique_ptr<Light>> lights;
    for (const LightEntity &entity : scene.lights)
        lights.push_back(MakeLight(entity, kUnitBound));
    const Camera camera = MakeCamera(scene.camera, {64, 64});
    const Ray axis = camera.GenerateRay({32, 32}, {});
    const auto position = [](const Light &light, const Point3f &ref) {
        LightSample s;
        return light.Sample_Li(ref, {}, &s) ? ref + s.wi * s.distance : Point3f(1e9f, 0, 0);
    };
    const auto distance = [](const Point3f &a, const Point3f &b) { return (a - b).Length(); };
    EXPECT_LT(distance(position(*lights[0], {7, 8, 9}), {4, 5, 6}), 1e-5f);
    // What lies on the camera's axis is in the spot's narrow cone, what lies two degrees beside is not
    EXPECT_LT(distance(position(*lights[1], axis(5)), {4, 5, 6}), 1e-5f);
    LightSample s;
    EXPECT_FALSE(lights[1]->Sample_Li(camera.GenerateRay({32, 35}, {})(5), {}, &s));
    ASSERT_TRUE(lights[2]->Sample_Li({}, {}, &s));
    EXPECT_LT((s.wi + axis.d).Length(), 1e-5f);
    // The projector lights what the camera sees: just inside and just outside of the picture's corners
    for (const float x : {0.f, 64.f})
        for (const float y : {0.f, 64.f}) {
            const float in = 0.5f, out = -0.5f;
            const auto lit = [&](float d) {
                return lights[3]->Sample_Li(
                    camera.GenerateRay({x + (x == 0 ? d : -d), y + (y == 0 ? d : -d)}, {})(9), {}, &s);
            };
            EXPECT_TRUE(lit(in)) << x << ", " << y;
            EXPECT_FALSE(lit(out)) << x << ", " << y;
        }
    EXPECT_LT(distance(position(*lights[4], {1, 1, 1}), axis(2)), 1e-5f);
    EXPECT_LT(distance(position(*lights[5], {1, 1, 1}), {10, 1, 0}), 1e-5f);
    EXPECT_LT(distance(position(*lights[6], {1, 1, 1}), {10, 0, 0}), 1e-5f); // AttributeEnd restores
}

// --- all lights -------------------------------------------------------------------------------------------

// Places near and far from a light at the origin, in it, and on the axes, which maps and cones treat apart.
const Point3f kPlaces[] = {{0, 0, 0},     {0, 0, 1},           {0, 0, -1},         {1, 0, 0},
                           {0, -1, 0},    {0.3f, -0.7f, 0.2f}, {1e18f, 0, -1e18f}, {1e9f, 1e9f, 0},
                           {0, 1e-6f, 0}, {1e-18f, 0, 3e-19f}, {1e-22f, 0, 1e-23f}};

// At the ends of the square every light of the table, without and with a map, answers with a unit direction,
// a finite density above 0 and radiance that is finite; where rays can find the light too, its Pdf_Li and Le
// are the sample's. An infinite light is chosen in proportion to what it sends, but for what varies in a cell
// (four times its mean at most) and among colours (thirty times: see MapInfiniteLight::Importance).
TEST(Lights, SamplesHoldAtTheEnds) {
    const Image sky = Sky(12, 6);
    const Transform turned = Transform::Rotate(40, {1, 2, 3}) * Transform::Scale(-2, 2, 2);
    const Transform skewed = Transform::Rotate(70, {0, 1, 3}) * Transform::Scale(3, 1, 0.5);
    for (const PluginInfo &row : LightPlugins().rows)
        for (const Transform &ctm : {Transform(), turned, skewed})
            for (const bool map : {false, true}) {
                const std::string name(row.name);
                if (map && !row.FindParam("mapname"))
                    continue;
                LightEntity entity = map ? WithMap(sky, ctm, "ends", name) : Named(name, ctm);
                if (row.FindParam("I"))
                    Set(&entity.params, ParamType::Spectrum, "I", {1e-9, 0, 1e-12});
                const auto light = MakeLight(entity, kUnitBound);
                const double mean{light->Power()[0] + light->Power()[1] + light->Power()[2]};
                int sampled = 0;
                for (const Point3f &ref : kPlaces)
                    ForEachEnd([&](const Point2f &u) {
                        LightSample s;
                        if (!light->Sample_Li(ref, u, &s))
                            return;
                        ++sampled;
                        const std::string at = fmt::format("{} map {} at {} {} {} u {} {}", name, map, ref.x,
                                                           ref.y, ref.z, u.x, u.y);
                        ASSERT_EQ(FaultOf(s.L, s.pdf), "") << at;
                        ASSERT_TRUE(s.pdf > 0 && s.distance > 0) << at;
                        ASSERT_TRUE(IsUnit(s.wi)) << at << ", length " << s.wi.Length();
                        ASSERT_EQ(s.delta, light->IsDelta()) << at;
                        if (s.delta)
                            return;
                        ASSERT_TRUE(light->IsInfinite() && s.distance == Infinity) << at;
                        ASSERT_EQ(s.pdf, light->Pdf_Li(ref, s.wi)) << at;
                        ASSERT_EQ(s.L, light->Le({ref, s.wi})) << at;
                        for (int c = 0; c < 3; ++c)
                            ASSERT_LE(double{s.L[c] / s.pdf}, 4 * 30 * mean) << at;
                    });
                EXPECT_GT(sampled, 0) << name;
            }
}

// --- names and nonsense -------------------------------------------------------------------------------

TEST(MakeLight, NamesAreKnownReplacedOrRefused) {
    for (const char *name :
         {"infinite", "exinfinite", "distant", "point", "spot", "goniometric", "projection"})
        EXPECT_TRUE(MakeLight(Named(name), kUnitBound)) << name;
    const auto message = [](const LightEntity &entity) -> std::string {
        try {
            MakeLight(entity, kUnitBound);
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    EXPECT_NE(message(Named("infinit")).find("\"infinite\""), std::string::npos);
    for (const char *name : {"infinite", "goniometric", "projection"}) {
        LightEntity missing = Named(name);
        SetString(&missing.params, "mapname", "no_such_file.exr");
        EXPECT_TRUE(MakeLight(missing, kUnitBound)) << name; // without its map, as by pbrt-v3
        const StrictWarnings strict;
        EXPECT_NE(message(missing).find("no_such_file.exr"), std::string::npos) << name;
    }
    for (const double fov : {0., 180., static_cast<double>(kNaN)}) {
        LightEntity projector = Named("projection");
        Set(&projector.params, ParamType::Float, "fov", {fov});
        EXPECT_NE(message(projector).find("fov"), std::string::npos) << fov;
    }
    for (const char *name : {"distant", "spot"}) {
        LightEntity entity = Named(name);
        Set(&entity.params, ParamType::Point3, "from", {1, 2, 3});
        Set(&entity.params, ParamType::Point3, "to", {1, 2, 3});
        EXPECT_NE(message(entity).find("same point"), std::string::npos) << name;
    }
    for (const char *name : {"infinite", "distant", "point", "spot", "goniometric", "projection"})
        EXPECT_NE(message(Named(name, Transform::Scale(1, 0, 1))).find("no inverse"), std::string::npos)
            << name;
    LightEntity cone = Named("spot");
    Set(&cone.params, ParamType::Float, "coneangle", {static_cast<double>(kNaN)});
    EXPECT_NE(message(cone).find("coneangle"), std::string::npos);
    SolidSet solids;
    Entity area;
    area.type = "difuse";
    EXPECT_THROW(MakeAreaLight(area, &solids, 0), Error);
}

TEST(MakeLight, NegativeAndUndefinedAmountsAreSetToZeroAloud) {
    const struct {
        const char *light, *parameter;
    } cases[] = {{"infinite", "L"}, {"distant", "L"},     {"point", "I"},
                 {"spot", "I"},     {"goniometric", "I"}, {"projection", "I"}};
    for (const auto &c : cases)
        for (const double bad : {-1., static_cast<double>(kNaN), static_cast<double>(Infinity)}) {
            LightEntity entity = Named(c.light);
            Set(&entity.params, ParamType::Spectrum, c.parameter, {bad, 1, 1});
            FlushWarnings();
            const auto light = MakeLight(entity, kUnitBound);
            EXPECT_EQ(FlushWarnings(), 1u) << c.light << " " << bad;
            EXPECT_EQ(light->Power()[0], 0) << c.light << " " << bad;
            EXPECT_GT(light->Power()[1], 0);
        }
}

} // namespace
} // namespace cuticle
