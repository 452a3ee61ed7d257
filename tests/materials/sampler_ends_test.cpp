// Materials hold at the ends of the random numbers and of their parameters: one law for every row of the
// table.
#include "core/sampling.h"
#include "materials/hair_models.h"
#include "materials/material.h"
#include "sampler_ends.h"
#include "warnings.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// Values for the parameters of a row, from the ends and the middle of their ranges: k chooses.
std::vector<double> EdgeValues(const ParamInfo &p, RNG &rng) {
    std::vector<double> values;
    const bool color = p.type.starts_with("spectrum");
    const double low = std::isfinite(p.low) ? p.low : 0;
    const double high = std::isfinite(p.high) ? p.high : low == 0 ? 1 : 1e3; // an index may be any
    for (int i = 0; i < (color ? 3 : 1); ++i) {
        const double inner =
            low + (p.name == "eta" || p.name == "index" ? 2 : high - low) * double{rng.UniformFloat()};
        switch (rng.UniformUInt32() % 6) {
        case 0:
            values.push_back(low);
            break;
        case 1:
            values.push_back(high);
            break;
        case 2: // an index near 1; a small number
            values.push_back(low == 1e-3 ? 1 + std::pow(10., -1 - 7 * double{rng.UniformFloat()})
                                         : inner * 0.01);
            break;
        case 3:
            values.push_back(low == 1e-3 ? 1 : inner * 1e-6);
            break;
        default:
            values.push_back(inner);
        }
    }
    return values;
}
// A set of a row's parameters, each given one time in two.
ParamSet EdgeParams(const PluginInfo &row, RNG &rng) {
    ParamSet set;
    for (const ParamInfo &p : row.params) {
        if (p.name == "bumpmap" || p.name == "scatterdistance" || rng.UniformFloat() < 0.4f)
            continue;
        Param given;
        given.name = p.name;
        if (p.type == "bool") {
            given.type = ParamType::Bool;
            given.bools = {rng.UniformFloat() < 0.5f};
        } else if (p.type.starts_with("spectrum") || p.type.starts_with("float")) {
            given.type = p.type.starts_with("spectrum") ? ParamType::Spectrum : ParamType::Float;
            given.numbers = EdgeValues(p, rng);
        } else {
            continue;
        }
        set.params.push_back(std::move(given));
    }
    return set;
}

// Directions over, in and under the surface: along the normal, oblique, and grazing down to where a cosine is
// lost in the other components' rounding.
std::vector<Vector3f> Views() {
    std::vector<Vector3f> views;
    for (const float z : {1.f, 0.7f, 0.1f, 1e-3f, 1e-6f, 1e-12f, 1e-30f, 0.f})
        for (const float side : {1.f, -1.f})
            for (const float phi : {0.f, 0.5f * Pi, 2.1f}) {
                const float s = std::sqrt((1 - z) * (1 + z));
                views.emplace_back(s * std::cos(phi), s * std::sin(phi), side * z);
            }
    return views;
}

// The largest weights that were seen, for the bounds below.
struct Largest {
    double weight = 0;
    std::string at;
};

// The law: what is evaluated is finite and not negative; what is sampled is so too, of unit length, and has
// the value and the density that the BSDF states for it, to the last bits. (Hair is evaluated at the sampled
// angles, see HairLobes::Sample.) No weight is beyond 10, the most by which a coat's colour exceeds its share
// in the choice of lobes.
void ExpectHolds(const BSDF &bsdf, const std::string &name, Largest *largest) {
    const float rounding = bsdf.IsHair() ? 1e-2f : 1e-5f;
    const std::vector<Vector3f> views = Views();
    for (const Vector3f &wo : views) {
        for (const Vector3f &wi : views) {
            float pdf = 0;
            const Spectrum f = bsdf.FCos(wo, wi, &pdf);
            ASSERT_EQ(FaultOf(f, pdf), "") << name << ": f at " << wo << " " << wi;
        }
        for (const float uLobe : {0.f, 0.3f, 0.5f, 0.8f, OneMinusEpsilon})
            ForEachEnd([&](const Point2f &u) {
                BSDFSample s;
                Spectrum weight;
                if (!bsdf.Sample_f(wo, {uLobe, u.x, u.y, 0.5f}, &s, &weight))
                    return;
                const std::string at =
                    fmt::format("{}: wo {} {} {}, u {} {} {}", name, wo.x, wo.y, wo.z, uLobe, u.x, u.y);
                ASSERT_EQ(FaultOf(s.f, s.pdf), "") << at;
                ASSERT_EQ(FaultOf(weight, s.pdf), "") << at;
                ASSERT_GT(s.pdf, 0) << at;
                ASSERT_TRUE(IsUnit(s.wi)) << at << ", length " << s.wi.Length();
                // Refracted radiance is squeezed by the squared index. Oren and Nayar's lobe, Disney's flat
                // one and the coats of Ashikhmin and Shirley grow, as published, by the inverse of the larger
                // cosine.
                const float larger = std::max(std::abs(wo.z), std::abs(s.wi.z));
                const double w =
                    double{weight.MaxComponentValue()} * Sqr(double{s.eta}) / (1 + 1 / double{larger});
                if (w > largest->weight)
                    *largest = {w, at};
                if (s.specular)
                    return;
                float pdf = 0;
                const Spectrum f = bsdf.FCos(wo, s.wi, &pdf);
                ASSERT_NEAR(pdf / s.pdf, 1, rounding) << at;
                for (int i = 0; i < 3; ++i)
                    ASSERT_NEAR(f[i] / s.pdf, weight[i], rounding * (weight[i] + 1e-6f)) << at;
            });
    }
}

void ExpectMaterialHolds(const Material &material, const std::string &name, Largest *largest) {
    SurfaceInteraction si;
    si.n = {0, 0, 1}, si.wo = {0, 0, 1}, si.dpdu = {1, 0, 0}, si.dpdv = {0, 1, 0}, si.t = 1;
    si.uv = {0.5f, 0.3f};
    BSDF bsdf;
    bsdf.SetFrame(si.shading, si.n);
    material.MakeBSDF(si, &bsdf);
    ExpectHolds(bsdf, name, largest);
}

TEST(Materials, SamplersHoldAtTheEnds) {
    struct Silence : WarningSink {
        void Warn(const FileLoc &, const std::string &, const std::string &) override {}
    } silence;
    const WarningScope quiet(&silence);
    const TextureTable textures;
    for (const PluginInfo &row : MaterialPlugins().rows) {
        if (row.name == "mix" || row.params.empty()) // two of the others, below; light passes
            continue;
        RNG rng(5);
        Largest largest;
        for (int k = 0; k < (row.name == "hair" ? 1 : 60); ++k) { // hair has a law of its own, in fibers
            MaterialEntity entity;
            entity.type = row.name;
            if (k > 0)
                entity.params = EdgeParams(row, rng);
            std::string name(row.name);
            for (const Param &p : entity.params.params) {
                name += " " + p.name;
                for (const double v : p.numbers)
                    name += fmt::format(" {:.9g}", v);
            }
            ExpectMaterialHolds(*MakeMaterial(entity, textures, {}), name, &largest);
        }
        EXPECT_LT(largest.weight, 10) << largest.at;
        std::printf("%-12s weighs at most %.3g (%s)\n", std::string(row.name).c_str(), largest.weight,
                    largest.at.c_str());
    }
}

TEST(Mix, SamplersHoldAtTheEnds) {
    const PluginTables plugins{&MaterialPlugins(), &TexturePlugins()};
    const SceneDescription scene = ParseSceneText(
        plugins,
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"glass\" \"float uroughness\" 0.2\n"
        "MakeNamedMaterial \"b\" \"string type\" \"substrate\" \"float uroughness\" 0\n"
        "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [0 "
        ".5 1]\n"
        "Shape \"sphere\" WorldEnd",
        "test.pbrt");
    std::vector<std::unique_ptr<Material>> made;
    const TextureTable textures;
    for (const MaterialEntity &entity : scene.materials)
        made.push_back(MakeMaterial(entity, textures, {}, made));
    Largest largest;
    ExpectMaterialHolds(*made.back(), "mix", &largest);
    EXPECT_LT(largest.weight, 10) << largest.at;
}

} // namespace
} // namespace cuticle
