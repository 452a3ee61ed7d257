// Which model of a fiber a scene gets, and what it is told.
#include "materials/hair_models.h"
#include "materials/material.h"
#include "warnings.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <fstream>

namespace cuticle {
namespace {

const PluginTables kPlugins{&MaterialPlugins(), &TexturePlugins()};

// The one hair material of a scene with these parameters.
std::unique_ptr<Material> HairOf(const std::string &parameters, const std::string &override = "") {
    const SceneDescription scene = ParseSceneText(
        kPlugins, "WorldBegin\nMaterial \"hair\" " + parameters + "\nShape \"sphere\"\nWorldEnd\n",
        "scene.pbrt");
    const TextureTable textures(scene.floatTextures, scene.spectrumTextures);
    MaterialOptions options;
    options.hairModel = override;
    return MakeMaterial(scene.materials[static_cast<size_t>(scene.shapes[0].state.material)], textures,
                        options);
}

SurfaceInteraction OnFiber(float v) {
    SurfaceInteraction si;
    si.uv = {0.5f, v};
    si.isCurve = true;
    return si;
}

Spectrum Value(const std::string &parameters, const std::string &override = "") {
    BSDF bsdf;
    const auto hair = HairOf(parameters, override);
    hair->MakeBSDF(OnFiber(0.3f), &bsdf);
    bsdf.SetFrame({}, {0, 0, 1});
    EXPECT_TRUE(bsdf.IsHair());
    EXPECT_TRUE(bsdf.HasNonSpecular());
    float pdf = 0;
    return bsdf.FCos({0.1f, 0.6f, std::sqrt(1 - 0.37f)}, {-0.2f, -0.5f, std::sqrt(1 - 0.29f)}, &pdf);
}

TEST(HairModels, NamesAndErrors) {
    for (const std::string_view name : HairModelNames())
        EXPECT_GT(Value("\"string model\" \"" + std::string(name) + "\"").y(), 0) << name;
    try {
        HairOf("\"string model\" \"chang\"");
        FAIL();
    } catch (const Error &e) {
        EXPECT_STREQ(e.what(),
                     "scene.pbrt:2:17: error: unknown hair model \"chang\". Did you mean \"chiang\"?");
    }
}

TEST(HairModels, TheDefaultIsChiang) { EXPECT_EQ(Value(""), Value("\"string model\" \"chiang\"")); }

// A ray that is wider than the fiber sees the mean of value and density over offsets that are spread
// evenly; directions are drawn with that density. A model that knows no offset stays as it is.
TEST(HairModels, AMeanOverTheWidthIsTheMeanOfItsFibers) {
    const Vector3f wo(0.1f, 0.6f, std::sqrt(1 - 0.37f)), wi(-0.2f, -0.5f, std::sqrt(1 - 0.29f));
    constexpr size_t kOffsets = 4;
    for (const char *parameters :
         {"\"rgb sigma_a\" [.2 .4 .8]", "\"string model\" \"deon\" \"string field\" \"near\""}) {
        const auto hair = HairOf(parameters);
        FiberStrata strata;
        BSDF mean;
        mean.SetFrame({}, {0, 0, 1});
        mean.AskForMean(&strata, kOffsets);
        hair->MakeBSDF(OnFiber(0.3f), &mean);
        Spectrum f(0);
        float pdf = 0, density = 0;
        for (const float v : {0.3f, 0.55f, 0.8f, 0.05f}) {
            BSDF one;
            one.SetFrame({}, {0, 0, 1});
            hair->MakeBSDF(OnFiber(v), &one);
            f += one.FCos(wo, wi, &density) * 0.25f;
            pdf += density / 4;
        }
        const Spectrum got = mean.FCos(wo, wi, &density);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(got[c], f[c], 1e-5f * f[c]) << parameters;
        EXPECT_NEAR(density, pdf, 1e-5f * pdf) << parameters;
        for (const float u : {0.01f, 0.2f, 0.3f, 0.6f, 0.999f}) { // of each of the four
            BSDFSample sample;
            Spectrum weight;
            ASSERT_TRUE(mean.Sample_f(wo, {u, 0.4f, 0.7f, 0.2f}, &sample, &weight));
            const Spectrum there = mean.FCos(wo, sample.wi, &density);
            EXPECT_NEAR(sample.pdf, density, 1e-3f * density) << parameters << u;
            EXPECT_NEAR(weight[1], there[1] / density, 1e-3f * weight[1]) << parameters << u;
        }
    }
    for (const char *parameters : {"\"string model\" \"marschner\"", "\"string model\" \"deon\""}) {
        FiberStrata strata;
        BSDF mean;
        mean.AskForMean(&strata, kOffsets);
        HairOf(parameters)->MakeBSDF(OnFiber(0.3f), &mean);
        EXPECT_EQ(strata.others[0].Get(), nullptr) << parameters;
    }
}

// README's table is that of the rows.
TEST(HairModels, StandInTheReadme) {
    std::ifstream file(std::string(CUTICLE_SOURCE_DIR) + "/README.md");
    const std::string readme((std::istreambuf_iterator<char>(file)), {});
    for (const FiberModel &model : FiberModels()) {
        std::string own;
        for (const ParamInfo &p : model.params)
            own += fmt::format("{}{}", own.empty() ? "" : ", ", p.name);
        const std::string row =
            fmt::format("| `{}` | {}: {} | {} |\n", model.name, model.paper, model.meaning, own);
        EXPECT_NE(readme.find(row), std::string::npos) << row;
    }
}

// The command line's choice is the scene's with another name.
TEST(HairModels, OverrideIsTheScenesChoice) {
    for (const std::string_view name : HairModelNames())
        EXPECT_EQ(Value("\"float beta_m\" 0.2", std::string(name)),
                  Value("\"float beta_m\" 0.2 \"string model\" \"" + std::string(name) + "\""));
}

// A table and the quadrature behind it are one model; a near field is another.
TEST(HairModels, TablesAreTheQuadrature) {
    const std::string deon = "\"string model\" \"deon\" \"float eumelanin\" 0.3 ";
    const Spectrum table = Value(deon), exact = Value(deon + "\"string evaluation\" \"quadrature\"");
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(table[c], exact[c], 0.005f * exact[c]);
    EXPECT_GT(std::abs(Value(deon + "\"string field\" \"near\"").y() - exact.y()), 0.01f * exact.y());
    EXPECT_THROW(HairOf(deon + "\"string field\" \"near\" \"string evaluation\" \"table\""), Error);
    EXPECT_THROW(HairOf(deon + "\"string detector\" \"wraped\""), Error);
    EXPECT_THROW(HairOf(deon + "\"integer lobes\" 0"), Error);
}

// "lobes" of the default model: three is the paper. More change a pale fiber, and not one so dark that no
// light is left for them.
TEST(HairModels, ChiangWithMoreLobes) {
    const auto withLobes = [](const std::string &sigmaA, const std::string &lobes) {
        return Value("\"rgb sigma_a\" [" + sigmaA + "] " + lobes).y();
    };
    const std::string pale = "0.02 0.02 0.02", dark = "9 9 9", six = "\"integer lobes\" 6";
    EXPECT_EQ(withLobes(pale, ""), withLobes(pale, "\"integer lobes\" 3"));
    EXPECT_NE(withLobes(pale, ""), withLobes(pale, six));
    EXPECT_NEAR(withLobes(dark, six) / withLobes(dark, ""), 1, 1e-3);
    EXPECT_THROW(HairOf("\"integer lobes\" 17"), Error);
}

// A share for the tail of 1 leaves one lobe, one of 0 all that there are. Beyond 1 is taken as 1.
TEST(HairModels, ChiangWithAShareForTheTail) {
    const auto with = [](const std::string &parameters) {
        return Value("\"rgb sigma_a\" [0.02 0.02 0.02] " + parameters).y();
    };
    EXPECT_EQ(with("\"float tail_share\" 1"), with("\"integer lobes\" 1"));
    EXPECT_EQ(with("\"float tail_share\" 0"), with("\"integer lobes\" 16"));
    EXPECT_EQ(with("\"float tail_share\" 0 \"integer lobes\" 5"), with("\"integer lobes\" 5"));
    EXPECT_EQ(with("\"float tail_share\" 7"), with("\"float tail_share\" 1"));
}

// Eccentric fibers need the direction that their strands carry; round ones look the same from all sides.
TEST(HairModels, EccentricFibersAskForTheStrandsAxis) {
    const auto valueAt = [](const std::string &parameters, const Vector3f &axis) {
        const auto hair = HairOf("\"string model\" \"marschner\" \"float eumelanin\" 0.1 " + parameters);
        EXPECT_EQ(hair->WantsStrandNormals(), !parameters.empty());
        SurfaceInteraction si = OnFiber(0.5f);
        si.strandNormal = axis;
        BSDF bsdf;
        hair->MakeBSDF(si, &bsdf);
        bsdf.SetFrame({}, {0, 0, 1});
        float pdf = 0;
        return bsdf.FCos({0, 0, 1}, {0.1f, 0.3f, std::sqrt(0.9f)}, &pdf).y();
    };
    EXPECT_NE(valueAt("\"float eccentricity\" 0.85", {0, 1, 0}),
              valueAt("\"float eccentricity\" 0.85", {0, 0, 1}));
    EXPECT_EQ(valueAt("", {0, 1, 0}), valueAt("", {0, 0, 1}));
}

// A table is of one fiber; its colour alone may vary. What a fiber cannot be is an error at the material's
// place.
TEST(HairModels, TablesAreOfOneFiber) {
    const std::string tabulated = "\"string model\" \"tabulated\" \"integer samples\" 64 ";
    const auto message = [&](const std::string &parameters, const std::string &textures) {
        try {
            const SceneDescription scene =
                ParseSceneText(kPlugins,
                               "WorldBegin\n" + textures + "Material \"hair\" " + tabulated + parameters +
                                   "\nShape \"sphere\"\nWorldEnd\n",
                               "scene.pbrt");
            const TextureTable table(scene.floatTextures, scene.spectrumTextures);
            MakeMaterial(scene.materials[static_cast<size_t>(scene.shapes[0].state.material)], table, {});
        } catch (const Error &e) {
            return std::string(e.what());
        }
        return std::string();
    };
    const std::string texture = "Texture \"t\" \"float\" \"constant\" \"float value\" 0.3\n";
    EXPECT_EQ(message("\"texture eumelanin\" \"t\"", texture), "");
    EXPECT_NE(
        message("\"texture beta_m\" \"t\"", texture).find("error: the model \"tabulated\" needs one number"),
        std::string::npos);
    EXPECT_NE(message("\"float eta\" 20", "").find("scene.pbrt:2:1: error: a fiber's index"),
              std::string::npos)
        << message("\"float eta\" 20", "");
    EXPECT_NE(message("\"string distribution\" \"gggx\"", "").find("Did you mean \"ggx\"?"),
              std::string::npos);
}

// A parameter of another model is reported as without use.
TEST(HairModels, ForeignParametersWarn) {
    const StrictWarnings strict;
    EXPECT_THROW(HairOf("\"float exponent\" 20"), Error);
    EXPECT_NO_THROW(HairOf("\"float exponent\" 20 \"string model\" \"kajiya-kay\""));
}

} // namespace
} // namespace cuticle
