// Materials as a scene names them: their parameters, mixes, bump maps, stand-ins.
#include "materials/material.h"
#include "warnings.h"

#include "core/metal_spectra.h"
#include "core/sampling.h"
#include "materials/subsurface.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins()};

// The materials of a scene's text, in the order of the description; [0] is the default.
struct Made {
    SceneDescription scene;
    TextureTable textures;
    std::vector<std::unique_ptr<Material>> materials;
};

Made MakeAll(const std::string &world) {
    Made made;
    made.scene =
        ParseSceneText(kPlugins, "WorldBegin\n" + world + "\nShape \"sphere\"\nWorldEnd\n", "test.pbrt");
    made.textures = TextureTable(made.scene.floatTextures, made.scene.spectrumTextures);
    for (const MaterialEntity &entity : made.scene.materials)
        made.materials.push_back(MakeMaterial(entity, made.textures, {}, made.materials));
    return made;
}

SurfaceInteraction FlatInteraction() {
    SurfaceInteraction si;
    si.p = {0.3f, -0.2f, 0};
    si.n = {0, 0, 1};
    si.wo = {0, 0, 1};
    si.dpdu = {1, 0, 0};
    si.dpdv = {0, 1, 0};
    si.uv = {0.4f, 0.6f};
    si.t = 3;
    return si;
}

Spectrum FCos(const Material &material, const SurfaceInteraction &si, const Vector3f &wo,
              const Vector3f &wi) {
    BSDF bsdf;
    bsdf.SetFrame(si.shading, si.n);
    material.MakeBSDF(si, &bsdf);
    float pdf = 0;
    return bsdf.FCos(wo, wi, &pdf);
}

std::string MessageOf(const std::string &world) {
    try {
        MakeAll(world);
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

const Vector3f kWo = Normalize(Vector3f(0.3f, 0.2f, 0.8f)), kWi = Normalize(Vector3f(-0.5f, 0.1f, 0.6f));

// --- mixes ----------------------------------------------------------------------------------------------

const std::string kTwo = "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [0.8 0.4 0.2]\n"
                         "MakeNamedMaterial \"b\" \"string type\" \"substrate\" \"rgb Kd\" [0.1 0.2 0.3]\n";

TEST(Mix, IsTheWeightedSumOfBoth) {
    FlushWarnings();
    const Made made =
        MakeAll(kTwo + "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" "
                       "\"rgb amount\" [0.25 0.5 1]");
    const size_t n = made.materials.size();
    const SurfaceInteraction si = FlatInteraction();
    const Spectrum a = FCos(*made.materials[n - 3], si, kWo, kWi),
                   b = FCos(*made.materials[n - 2], si, kWo, kWi),
                   mix = FCos(*made.materials[n - 1], si, kWo, kWi), amount(0.25f, 0.5f, 1);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(mix[i], amount[i] * a[i] + (1 - amount[i]) * b[i], 1e-6f);
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST(Mix, NestsAndKeepsItsScale) {
    const Made made = MakeAll(kTwo + "MakeNamedMaterial \"inner\" \"string type\" \"mix\" \"string "
                                     "namedmaterial1\" \"a\" \"string namedmaterial2\" "
                                     "\"b\" \"rgb amount\" [0.5 0.5 0.5]\n"
                                     "Material \"mix\" \"string namedmaterial1\" \"inner\" \"string "
                                     "namedmaterial2\" \"b\" \"rgb amount\" [0.4 0.4 "
                                     "0.4]");
    const size_t n = made.materials.size();
    const SurfaceInteraction si = FlatInteraction();
    const Spectrum a = FCos(*made.materials[n - 4], si, kWo, kWi),
                   b = FCos(*made.materials[n - 3], si, kWo, kWi),
                   mix = FCos(*made.materials[n - 1], si, kWo, kWi);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(mix[i], 0.2f * a[i] + 0.8f * b[i], 1e-6f);
}

// Hair is chosen at random: the mean over many places is the mix. n = 40000; the bound is 5 standard errors.
TEST(Mix, WithHairIsRightInTheMean) {
    const Made made =
        MakeAll("MakeNamedMaterial \"h\" \"string type\" \"hair\" \"rgb sigma_a\" [0.2 0.5 1]\n"
                "MakeNamedMaterial \"m\" \"string type\" \"matte\" \"rgb Kd\" [0.5 0.5 0.5]\n"
                "Material \"mix\" \"string namedmaterial1\" \"h\" \"string namedmaterial2\" \"m\" "
                "\"rgb amount\" [0.1 0.3 0.5]");
    const size_t n = made.materials.size();
    SurfaceInteraction si = FlatInteraction();
    si.isCurve = true;
    const Spectrum h = FCos(*made.materials[n - 3], si, kWo, kWi),
                   m = FCos(*made.materials[n - 2], si, kWo, kWi), amount(0.1f, 0.3f, 0.5f);
    std::array<double, 3> sum{}, sum2{};
    constexpr int count = 40000;
    RNG rng(5);
    for (int k = 0; k < count; ++k) {
        si.p = {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()};
        const Spectrum f = FCos(*made.materials[n - 1], si, kWo, kWi);
        for (size_t i = 0; i < 3; ++i) {
            const double v = f[static_cast<int>(i)];
            sum[i] += v, sum2[i] += v * v;
        }
    }
    for (size_t i = 0; i < 3; ++i) {
        const int c = static_cast<int>(i);
        const double mean = sum[i] / count, error = std::sqrt((sum2[i] / count - mean * mean) / count);
        EXPECT_NEAR(mean, amount[c] * h[c] + (1 - amount[c]) * m[c], 5 * error + 1e-7) << "n " << count;
    }
}

TEST(Mix, RefusesWhatItCannotMix) {
    EXPECT_NE(MessageOf(kTwo +
                        "MakeNamedMaterial \"none\" \"string type\" \"none\"\n"
                        "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"none\"")
                  .find("light passes it"),
              std::string::npos);
    std::string deep = "MakeNamedMaterial \"0\" \"string type\" \"disney\" \"float sheen\" 1\n";
    for (int i = 0; i < 2; ++i)
        deep += "MakeNamedMaterial \"" + std::to_string(i + 1) +
                "\" \"string type\" \"mix\" \"string namedmaterial1\" \"" + std::to_string(i) +
                "\" \"string namedmaterial2\" \"" + std::to_string(i) + "\"\n";
    EXPECT_NE(MessageOf(deep).find("32 lobes"), std::string::npos) << MessageOf(deep);
}

// --- bump maps ------------------------------------------------------------------------------------------

class Height : public Texture<float> {
  public:
    explicit Height(float (*f)(const TexturePoint &)) : f_(f) {}
    float Evaluate(const TexturePoint &point) const override { return f_(point); }

  private:
    float (*f_)(const TexturePoint &);
};

void ExpectNear(const Vector3f &a, const Vector3f &b, float tolerance) {
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(a[i], b[i], tolerance) << a << " against " << b;
}

// A plane stays a plane: z = 0.3 x - 0.7 y, whatever the parameterisation.
TEST(Bump, TiltsAPlane) {
    const Height slope([](const TexturePoint &q) { return 0.3f * q.p.x - 0.7f * q.p.y; });
    SurfaceInteraction si = FlatInteraction();
    const Vector3f expected = Normalize(Vector3f(-0.3f, 0.7f, 1));
    for (const auto &[u, v] : {std::pair<Vector3f, Vector3f>{{1, 0, 0}, {0, 1, 0}},
                               {{3, 0, 0}, {0.5f, 2, 0}},
                               {{0, 0.1f, 0}, {100, 0, 0}}}) {
        si.dpdu = u, si.dpdv = v;
        const Frame frame = BumpedFrame(si, slope);
        ExpectNear(frame.z, expected, 2e-3f);
        EXPECT_NEAR(Dot(frame.x, frame.z), 0, 1e-5f);
        EXPECT_NEAR(frame.x.Length(), 1, 1e-5f);
        ExpectNear(Cross(frame.z, frame.x), frame.y, 1e-6f);
        // The normal stays on the side of the geometric one
        si.n = {0, 0, -1};
        si.shading = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
        EXPECT_LT(BumpedFrame(si, slope).z.z, 0);
        // and a height along it leans the other way
        ExpectNear(BumpedFrame(si, slope).z, Normalize(Vector3f(-0.3f, 0.7f, -1)), 2e-3f);
        si.n = {0, 0, 1};
        si.shading = {};
    }
}

TEST(Bump, ReadsTheShiftedCoordinates) {
    const Height slope([](const TexturePoint &q) { return 2 * q.uv.x + 0.5f * q.uv.y; });
    SurfaceInteraction si = FlatInteraction();
    si.dpdu = {4, 0, 0}, si.dpdv = {0, 5, 0};
    ExpectNear(BumpedFrame(si, slope).z, Normalize(Vector3f(-2 / 4.f, -0.5f / 5, 1)), 3e-3f);
}

TEST(Bump, LeavesFlatHeightsHairAndNonsenseAlone) {
    SurfaceInteraction si = FlatInteraction();
    si.shading =
        Frame::FromZ(Normalize(Vector3f(0.2f, 0.1f, 1))); // a smooth mesh: not the facet's own normal
    const Height flat([](const TexturePoint &) { return 0.4f; });
    ExpectNear(BumpedFrame(si, flat).z, si.shading.z, 1e-6f);
    const Height nonsense([](const TexturePoint &) { return std::nanf(""); });
    EXPECT_EQ(BumpedFrame(si, nonsense).z, si.shading.z);
    const Height slope([](const TexturePoint &q) { return q.p.x; });
    si.isCurve = true;
    EXPECT_EQ(BumpedFrame(si, slope).z, si.shading.z);
}

// Heights over a sphere that are a plane's cut through space: the gradient in the tangent plane leans the
// normal.
TEST(Bump, LeansByTheGradientOnASphere) {
    const Height slope([](const TexturePoint &q) { return 0.05f * q.p.x; });
    SurfaceInteraction si = FlatInteraction();
    si.p = Normalize(Vector3f(0.4f, 0.5f, 0.6f));
    si.n = si.p;
    si.shading = Frame::FromZ(si.p);
    si.dpdu = si.shading.x * 6.28f, si.dpdv = si.shading.y * 3.14f;
    const Vector3f gradient = Vector3f(0.05f, 0, 0) - si.n * (0.05f * si.n.x);
    ExpectNear(BumpedFrame(si, slope).z, Normalize(si.n - gradient), 1e-3f);
}

TEST(Bump, OfHairIsOneWarning) {
    MakeAll("Texture \"t\" \"float\" \"constant\"\nMaterial \"hair\" \"texture bumpmap\" \"t\"");
    EXPECT_EQ(FlushWarnings(), 1u);
}

// --- metals ---------------------------------------------------------------------------------------------

TEST(Metal, IsCopperWhereNothingElseIsSaid) {
    const Made made =
        MakeAll("Material \"metal\"\nShape \"sphere\"\n"
                "Material \"metal\" \"spectrum eta\" \"spds/Cu.eta.spd\" \"spectrum k\" \"Cu.k.spd\"");
    EXPECT_EQ(FlushWarnings(), 2u); // of one kind: the files are missing
    const size_t n = made.materials.size();
    const SurfaceInteraction si = FlatInteraction();
    const Vector3f wi(-kWo.x, -kWo.y, kWo.z);
    EXPECT_EQ(FCos(*made.materials[n - 2], si, kWo, wi), FCos(*made.materials[n - 1], si, kWo, wi));
    const StrictWarnings strict;
    EXPECT_NE(
        MessageOf("Material \"metal\" \"spectrum eta\" \"spds/Unobtainium.eta.spd\"").find("No such file"),
        std::string::npos);
}

TEST(Metal, RoughnessAlongOneAxisWinsOverTheCommonOne) {
    const Made made =
        MakeAll("Material \"metal\" \"float roughness\" 0.4 \"float vroughness\" 0.1\nShape \"sphere\"\n"
                "Material \"metal\" \"float uroughness\" 0.4 \"float vroughness\" 0.1\n");
    const size_t n = made.materials.size();
    EXPECT_EQ(FCos(*made.materials[n - 2], FlatInteraction(), kWo, kWi),
              FCos(*made.materials[n - 1], FlatInteraction(), kWo, kWi));
    EXPECT_EQ(FlushWarnings(), 0u);
}

// --- Disney ---------------------------------------------------------------------------------------------

// A metal has neither diffuse reflection nor transmission, whatever else is asked of it.
TEST(Disney, MetalsTransmitNothing) {
    const Made made =
        MakeAll("Material \"disney\" \"float metallic\" 1 \"float spectrans\" 1 \"bool thin\" \"true\"\n");
    const Vector3f below(kWi.x, kWi.y, -kWi.z);
    EXPECT_TRUE(FCos(*made.materials.back(), FlatInteraction(), kWo, below).IsBlack());
}

TEST(Disney, SubsurfaceScatteringIsOneWarningAndTheDiffuseLobe) {
    const Made made = MakeAll("Material \"disney\"\nShape \"sphere\"\n"
                              "Material \"disney\" \"rgb scatterdistance\" [1 0.5 0.2]\n");
    EXPECT_EQ(FlushWarnings(), 1u);
    const size_t n = made.materials.size();
    EXPECT_EQ(FCos(*made.materials[n - 2], FlatInteraction(), kWo, kWi),
              FCos(*made.materials[n - 1], FlatInteraction(), kWo, kWi));
    MakeAll("Material \"disney\" \"rgb scatterdistance\" [0 0 0]\n");
    EXPECT_EQ(FlushWarnings(), 0u);
}

// --- stand-ins ------------------------------------------------------------------------------------------

// One warning each: all of pbrt-v3's parameters are read.
TEST(StandIns, AreOneWarningEach) {
    for (const char *text :
         {"Material \"subsurface\" \"string name\" \"Skin1\" \"float scale\" 2 \"float eta\" 1.3 \"rgb Kr\" "
          "[1 1 1] \"rgb "
          "Kt\" [1 1 1] \"float uroughness\" 0.1 \"float vroughness\" 0.1 \"bool remaproughness\" \"false\" "
          "\"float g\" 0.1",
          "Material \"subsurface\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [1 2 3]",
          "Material \"kdsubsurface\" \"rgb Kd\" [1 1 1] \"rgb mfp\" [1 2 3] \"float g\" 0 \"float eta\" 1.3 "
          "\"float scale\" 1 "
          "\"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1] \"float uroughness\" 0.1 \"float vroughness\" 0.1",
          "Material \"fourier\" \"string bsdffile\" \"gold.bsdf\""}) {
        FlushWarnings();
        MakeAll(text);
        EXPECT_EQ(FlushWarnings(), 1u) << text;
    }
    MakeAll("Material \"subsurface\" \"string name\" \"Skin99\"");
    EXPECT_EQ(FlushWarnings(), 2u);
}

// The reflectance of the half space is the integral of the dipole's profile (Jensen et al. 2001, equation 4)
// over the plane, here in double over the logarithm of the radius.
TEST(StandIns, DipoleReflectanceIsTheIntegralOfItsProfile) {
    for (const double albedo : {0.05, 0.5, 0.9, 0.99, 0.999})
        for (const double eta : {1.0, 1.3, 1.5}) {
            const double sigmaT = 1, sigmaA = (1 - albedo) * sigmaT, sigmaTr = std::sqrt(3 * sigmaA * sigmaT);
            const double fdr = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
            const double a = (1 + fdr) / (1 - fdr), zr = 1 / sigmaT, zv = zr * (1 + 4. / 3 * a);
            const auto profile = [&](double r) {
                const auto source = [&](double z) {
                    const double d = std::sqrt(r * r + z * z);
                    return z * (sigmaTr * d + 1) * std::exp(-sigmaTr * d) / (d * d * d);
                };
                return albedo / (4 * kPi<double>)*(source(zr) + source(zv));
            };
            double total = 0;
            const double step = 1e-3;
            for (double x = -12; x < 9; x += step)
                total += profile(std::exp(x)) * 2 * kPi<double> * std::exp(2 * x) * step;
            EXPECT_NEAR(DipoleReflectance(static_cast<float>(albedo), static_cast<float>(eta)), total, 2e-5)
                << albedo << " " << eta;
        }
    EXPECT_NEAR(DipoleReflectance(1, 1.3f), 1, 1e-6f);
    EXPECT_EQ(DipoleReflectance(0, 1.3f), 0);
}

TEST(StandIns, MediaAreKnownByName) {
    const auto skin = FindScatteringMedium("Skin1");
    ASSERT_TRUE(skin);
    EXPECT_EQ(skin->sigmaA, Spectrum(0.032f, 0.17f, 0.48f));
    EXPECT_EQ(skin->reducedSigmaS, Spectrum(0.74f, 0.88f, 1.01f));
    EXPECT_FALSE(FindScatteringMedium("skin1"));
}

TEST(Materials, WrongNamesAreAnsweredWithTheRightOne) {
    MaterialEntity entity;
    entity.type = "metall";
    try {
        MakeMaterial(entity, {}, {});
        FAIL();
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("\"metal\""), std::string::npos) << e.what();
    }
}

} // namespace
} // namespace cuticle
