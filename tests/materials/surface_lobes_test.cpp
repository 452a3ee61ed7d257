// The lobes of ordinary surfaces: energy, reciprocity, and samples that follow the density that is stated
// for them.
#include "materials/bsdf.h"
#include "materials/surface_lobes.h"

#include "core/sampling.h"

#include <boost/math/special_functions/gamma.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace cuticle {
namespace {

const Spectrum kGoldEta(0.143f, 0.375f, 1.442f), kGoldK(3.983f, 2.386f, 1.603f);

struct Case {
    std::string name;
    std::function<void(SurfaceLobes &)> add;
    bool reciprocal = true; // f(wo, wi) = f(wi, wo); transmission scales by the squared index
    double maxEnergy = 1;   // what the model, as published, may give back of white light
};

// Disney's sums are not bounded by 1: Burley fitted the look of measured materials, and retro-reflection and
// the clear coat are added, not layered. The bounds are what the formulas give, rounded up.
const std::vector<Case> &Cases() {
    static const std::vector<Case> cases = {
        {"Lambert", [](SurfaceLobes &l) { l.AddLambertReflection(Spectrum(1)); }},
        {"OrenNayar", [](SurfaceLobes &l) { l.AddOrenNayar(Spectrum(1), 40); }},
        {"LambertBothWays",
         [](SurfaceLobes &l) {
             l.AddLambertReflection(Spectrum(0.4f));
             l.AddLambertTransmission(Spectrum(0.6f));
         }},
        {"Dielectric", [](SurfaceLobes &l) { l.AddMicrofacetReflection(Spectrum(1), 0.3f, 0.3f, 1.5f); }},
        {"GlassRough",
         [](SurfaceLobes &l) {
             l.AddMicrofacetReflection(Spectrum(1), 0.3f, 0.3f, 1.5f);
             l.AddMicrofacetTransmission(Spectrum(1), 0.3f, 0.3f, 1.5f);
         },
         false},
        {"Gold",
         [](SurfaceLobes &l) { l.AddConductorReflection(Spectrum(1), 0.2f, 0.2f, kGoldEta, kGoldK); }},
        {"GoldBrushed",
         [](SurfaceLobes &l) { l.AddConductorReflection(Spectrum(1), 0.5f, 0.1f, kGoldEta, kGoldK); }},
        {"CoatedDiffuse",
         [](SurfaceLobes &l) { l.AddCoatedDiffuse(Spectrum(1, 0.5f, 0.2f), Spectrum(0, 0.04f, 0.3f)); }},
        {"Substrate",
         [](SurfaceLobes &l) {
             l.AddCoatedDiffuse(Spectrum(0.5f, 0.8f, 1), Spectrum(0.04f));
             l.AddCoat(Spectrum(0.04f), 0.2f, 0.3f);
         }},
        {"SubstrateShiny",
         [](SurfaceLobes &l) {
             l.AddCoatedDiffuse(Spectrum(1), Spectrum(0.5f));
             l.AddCoat(Spectrum(0.5f), 0.15f, 0.15f);
         }},
        {"DisneyDiffuse", [](SurfaceLobes &l) { l.AddDisneyDiffuse(Spectrum(1)); }},
        {"DisneyRough",
         [](SurfaceLobes &l) {
             l.AddDisneyDiffuse(Spectrum(1));
             l.AddDisneyRetro(Spectrum(1), 0.5f);
         },
         true, 1.024},
        {"DisneyFlat", [](SurfaceLobes &l) { l.AddDisneyFlat(Spectrum(1), 0.5f); }, true, 1.287},
        {"DisneySheen", [](SurfaceLobes &l) { l.AddDisneySheen(Spectrum(1)); }},
        {"DisneyMetal",
         [](SurfaceLobes &l) { l.AddDisneySpecular(Spectrum(1, 0.7f, 0.3f), 1, 1.5f, 0.3f, 0.15f); }},
        {"DisneyClearcoat", [](SurfaceLobes &l) { l.AddDisneyClearcoat(1, 0); }},
        {"DisneyGlass",
         [](SurfaceLobes &l) {
             l.AddDisneySpecular(Spectrum(0.04f), 0, 1.5f, 0.25f, 0.25f);
             l.AddMicrofacetTransmission(Spectrum(1), 0.25f, 0.25f, 1.5f, true);
         },
         false},
        {"DisneyAll",
         [](SurfaceLobes &l) {
             // A thin sheet of colour 1, metallic 0.3, flatness and transmitted share 0.25
             l.AddDisneyDiffuse(Spectrum(0.394f));
             l.AddDisneyFlat(Spectrum(0.131f), 0.4f);
             l.AddDisneyRetro(Spectrum(0.7f), 0.4f);
             l.AddDisneySheen(Spectrum(0.1f));
             l.AddLambertTransmission(Spectrum(0.175f));
             l.AddDisneySpecular(Spectrum(0.328f), 0.3f, 1.5f, 0.16f, 0.16f);
             l.AddDisneyClearcoat(0.7f, 0.1f);
         },
         true, 1.525},
    };
    return cases;
}

BSDF Make(const Case &c) {
    BSDF bsdf;
    bsdf.SetFrame({}, {0, 0, 1});
    c.add(bsdf.SetSurface());
    return bsdf;
}

Vector3f Direction(double cosTheta, double phi) {
    const double sinTheta = std::sqrt(1 - cosTheta * cosTheta);
    return Vector3f(Vector3d(sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta));
}

const double kCosines[] = {1, 0.8, 0.5, 0.25, 0.1};

// Midpoints of the sphere in theta and phi, where the glossy lobes are smooth. Calls back with solid angles.
template <class F>
void OverSphere(int rows, F each) {
    const double step = kPi<double> / rows;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < 2 * rows; ++j) {
            const double theta = (i + 0.5) * step;
            each(Direction(std::cos(theta), (j + 0.5) * step), step * step * std::sin(theta));
        }
}

TEST(SurfaceLobes, DoNotMakeEnergy) {
    for (const Case &c : Cases()) {
        const BSDF bsdf = Make(c);
        double largest = 0;
        for (const double cosine : kCosines)
            for (const double side : {1., -1.}) {
                std::array<double, 3> energy{};
                OverSphere(180, [&](const Vector3f &wi, double solidAngle) {
                    float pdf = 0;
                    const Spectrum f = bsdf.FCos(Direction(side * cosine, 0.6), wi, &pdf);
                    // What crosses is squeezed by the squared index, which is no loss
                    const double scale = c.name.find("Glass") != std::string::npos && wi.z * side < 0
                                             ? (side > 0 ? 1.5 * 1.5 : 1 / (1.5 * 1.5))
                                             : 1;
                    for (int i = 0; i < 3; ++i)
                        energy[static_cast<size_t>(i)] += static_cast<double>(f[i]) * scale * solidAngle;
                });
                for (const double e : energy) {
                    EXPECT_GE(e, 0) << c.name;
                    largest = std::max(largest, e);
                }
            }
        EXPECT_LE(largest, c.maxEnergy + 2e-3) << c.name;
        std::printf("%-16s gives back at most %.4f\n", c.name.c_str(), largest);
    }
}

TEST(SurfaceLobes, AreReciprocal) {
    for (const Case &c : Cases()) {
        if (!c.reciprocal)
            continue;
        const BSDF bsdf = Make(c);
        RNG rng(1);
        for (int n = 0; n < 2000; ++n) {
            const Vector3f a = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()}),
                           b = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            float pdf = 0;
            const Spectrum ab = bsdf.FCos(a, b, &pdf) / std::abs(b.z),
                           ba = bsdf.FCos(b, a, &pdf) / std::abs(a.z);
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(ab[i], ba[i], 2e-4f * std::max(1.f, ab[i])) << c.name << " " << a << " " << b;
        }
    }
}

// Refraction: f(wo -> wi) / eta_i^2 = f(wi -> wo) / eta_o^2 for radiance (Veach 1997, section 5.2).
TEST(SurfaceLobes, TransmissionIsReciprocalUpToTheSquaredIndex) {
    SurfaceLobes lobes;
    lobes.AddMicrofacetTransmission(Spectrum(1), 0.3f, 0.2f, 1.5f);
    RNG rng(2);
    for (int n = 0; n < 2000; ++n) {
        Vector3f a = UniformSampleHemisphere({rng.UniformFloat(), rng.UniformFloat()}),
                 b = -UniformSampleHemisphere({rng.UniformFloat(), rng.UniformFloat()});
        float pdf = 0;
        const float ab = lobes.f(a, b, false, &pdf)[0], ba = lobes.f(b, a, false, &pdf)[0];
        // wi = b lies inside: radiance that comes out is smaller by the squared index
        EXPECT_NEAR(ab * Sqr(1.5f), ba, 1e-3f * std::max(1.f, ba)) << a << " " << b;
    }
}

TEST(SurfaceLobes, SamplesCarryTheirOwnDensityAndValue) {
    for (const Case &c : Cases()) {
        const BSDF bsdf = Make(c);
        RNG rng(3);
        for (int n = 0; n < 3000; ++n) {
            const Vector3f wo = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()});
            BSDFSample sample;
            Spectrum weight;
            if (!bsdf.Sample_f(wo, {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), 0}, &sample,
                               &weight))
                continue;
            EXPECT_NEAR(sample.wi.Length(), 1, 1e-5f);
            float pdf = 0;
            const Spectrum f = bsdf.FCos(wo, sample.wi, &pdf);
            // Rounding of wi moves sharp lobes a little
            EXPECT_NEAR(pdf / sample.pdf, 1, 5e-3f) << c.name;
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(f[i], weight[i] * sample.pdf, 5e-3f * (1 + f[i])) << c.name;
        }
    }
}

// Pearson's test over 20 x 24 cells in theta and phi, and one more for samples that find no direction.
double PValue(const BSDF &sampled, const BSDF &stated, const Vector3f &wo, uint64_t seed, int n) {
    constexpr int rows = 20, columns = 24, fine = 16;
    std::vector<double> expected(rows * columns + 1), counted(rows * columns + 1);
    const double step = kPi<double> / (rows * fine), stepPhi = 2 * kPi<double> / (columns * fine);
    double total = 0;
    for (int i = 0; i < rows * fine; ++i)
        for (int j = 0; j < columns * fine; ++j) {
            const double theta = (i + 0.5) * step;
            float pdf = 0;
            stated.FCos(wo, Direction(std::cos(theta), (j + 0.5) * stepPhi), &pdf);
            const double mass = static_cast<double>(pdf) * step * stepPhi * std::sin(theta);
            expected[static_cast<size_t>(i / fine * columns + j / fine)] += n * mass;
            total += mass;
        }
    EXPECT_LT(total, 1.002);
    expected.back() = n * std::max(0., 1 - total);
    RNG rng(MixBits(seed));
    for (int k = 0; k < n; ++k) {
        BSDFSample sample;
        Spectrum weight;
        size_t cell = rows * columns;
        if (sampled.Sample_f(wo, {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), 0}, &sample,
                             &weight)) {
            const double theta = std::acos(std::clamp(static_cast<double>(sample.wi.z), -1., 1.));
            double phi = std::atan2(static_cast<double>(sample.wi.y), static_cast<double>(sample.wi.x));
            phi += phi < 0 ? 2 * kPi<double> : 0;
            cell = static_cast<size_t>(std::min(rows - 1, static_cast<int>(theta / (step * fine))) * columns +
                                       std::min(columns - 1, static_cast<int>(phi / (stepPhi * fine))));
        }
        ++counted[cell];
    }
    double chiSquared = 0, e = 0, o = 0;
    int cells = 0;
    for (size_t i = 0; i < expected.size(); ++i) {
        e += expected[i], o += counted[i];
        if (e >= 8) {
            chiSquared += (o - e) * (o - e) / e;
            ++cells;
            e = o = 0;
        }
    }
    chiSquared += (o - e) * (o - e) / std::max(e, 1.);
    return boost::math::gamma_q((cells - 1) / 2., chiSquared / 2);
}

TEST(SurfaceLobes, SamplesFollowTheirDensity) {
    constexpr int n = 40000;
    const std::vector<double> cosines = {0.95, 0.5, 0.15, -0.6};
    const double each = 0.01 / static_cast<double>(Cases().size() * cosines.size()); // significance 1% in all
    uint64_t seed = 0;
    double smallest = 1;
    for (const Case &c : Cases()) {
        const BSDF bsdf = Make(c);
        for (const double cosine : cosines) {
            const double p = PValue(bsdf, bsdf, Direction(cosine, 0.7), ++seed, n);
            smallest = std::min(smallest, p);
            EXPECT_GT(p, each) << c.name << ", cos theta_o " << cosine << ", n " << n;
        }
    }
    std::printf("smallest p %.3g of %zu, fails below %.3g\n", smallest, Cases().size() * cosines.size(),
                each);
}

// The test can fail: it sees a clear coat that is sampled with pbrt-v3's fixed roughness instead of its own,
// and a roughness that is 5% off.
TEST(SurfaceLobes, TheTestOfSamplesSeesErrors) {
    const auto make = [](float alpha) {
        return Make({"", [=](SurfaceLobes &l) {
                         l.AddConductorReflection(Spectrum(1), alpha, alpha, kGoldEta, kGoldK);
                     }});
    };
    EXPECT_LT(PValue(make(0.21f), make(0.2f), Direction(0.5, 0.7), 1, 40000), 1e-6);
}

// A model that gives no number is told of by name and place, and its sample goes on as what it is, so that
// the film counts it; a sample of density NaN is not taken for one that has no direction.
TEST(BSDF, FibersThatGiveNoNumberAreToldOf) {
    struct Broken final : FiberBxDF {
        Spectrum FPdf(const Vector3f &, const Vector3f &, Float *pdf) const override {
            *pdf = 1;
            return Spectrum(std::nanf(""));
        }
        Spectrum Sample_f(const Vector3f &, Vector3f *wi, const std::array<Float, 4> &,
                          Float *pdf) const override {
            *wi = Vector3f(0, 0, 1), *pdf = std::nanf("");
            return Spectrum(1);
        }
        std::string ToString() const override { return "broken"; }
    };
    struct Sink final : WarningSink {
        void Warn(const FileLoc &place, const std::string &, const std::string &message) override {
            told.push_back(place.ToString() + " " + message);
        }
        std::vector<std::string> told;
    } sink;
    const WarningScope scope(&sink);
    const FiberOrigin origin{{std::make_shared<const std::string>("hair.pbrt"), 8, 3}, "deon"};
    BSDF bsdf;
    bsdf.SetFrame(Frame(), {0, 0, 1});
    bsdf.SetFiber().Emplace<Broken>();
    bsdf.SetFiberOrigin(&origin);
    float pdf = 0;
    EXPECT_TRUE(bsdf.FCos({0, 0, 1}, {0, 0, 1}, &pdf).HasNaNs());
    BSDFSample sample;
    Spectrum weight;
    EXPECT_TRUE(bsdf.Sample_f({0, 0, 1}, {0, 0, 0, 0}, &sample, &weight));
    EXPECT_TRUE(weight.HasNaNs());
    ASSERT_EQ(sink.told.size(), 2u);
    for (const std::string &text : sink.told) {
        EXPECT_NE(text.find("hair.pbrt:8:3"), std::string::npos) << text;
        EXPECT_NE(text.find("the fiber model \"deon\""), std::string::npos) << text;
    }
}

} // namespace
} // namespace cuticle
