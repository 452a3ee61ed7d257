// The hair model against the portable reference values of tests/vectors, which another program computed with
// forty digits. Every row of every file, in every precision and by every kernel, within the tolerance that
// the files themselves state.
#include "core/error.h"
#include "core/sampling.h"
#include "fibers/deon.h"
#include "fibers/every_kernel.h"
#include "fibers/fiber_simulator.h"
#include "fibers/hair.h"
#include "fibers/hair_model.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"
#include "fibers/smooth_fiber.h"

#include <boost/math/special_functions/gamma.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <fstream>

namespace cuticle {
namespace {

// One file. Columns are asked for by name.
class Vectors {
  public:
    explicit Vectors(const std::string &name) {
        std::ifstream file(std::string(CUTICLE_SOURCE_DIR) + "/tests/vectors/" + name + ".json");
        const nlohmann::json json = nlohmann::json::parse(file);
        if (json.at("version") != 1)
            throw Error("the vectors are of another version");
        columns_ = json.at("columns").get<std::vector<std::string>>();
        rows_ = json.at("rows").get<std::vector<std::vector<double>>>();
    }
    size_t Rows() const { return rows_.size(); }
    size_t Column(const std::string &name) const {
        const auto found = std::find(columns_.begin(), columns_.end(), name);
        if (found == columns_.end())
            throw Error("the vectors have no column " + name);
        return static_cast<size_t>(found - columns_.begin());
    }
    double At(size_t row, size_t column) const { return rows_[row].at(column); }
    double At(size_t row, const std::string &column) const { return At(row, Column(column)); }
    std::string Describe(size_t row) const {
        std::string text;
        for (size_t c = 0; c < std::min<size_t>(columns_.size(), 20); ++c)
            text += columns_[c] + " " + std::to_string(At(row, c)) + ", ";
        return text;
    }

  private:
    std::vector<std::string> columns_;
    std::vector<std::vector<double>> rows_;
};

// Counts values and remembers the worst, in units of its tolerance.
template <typename T>
class Judge {
  public:
    // The files' rule: u (16 + 2 condition), of |expected| or, for angles, of 1.
    void Relative(const Vectors &vectors, size_t row, T value, const char *column, double absolute = 0) {
        const double expected = vectors.At(row, column);
        Count(vectors, row, value, expected, Unit(vectors, row) * std::abs(expected) + absolute, column);
    }
    void Angle(const Vectors &vectors, size_t row, T value, const char *column) {
        const double expected = vectors.At(row, column);
        const double turns = std::nearbyint((static_cast<double>(value) - expected) / (2 * kPi<double>));
        Count(vectors, row, value - static_cast<T>(2 * turns) * kPi<T>, expected, Unit(vectors, row), column);
    }
    ~Judge() {
        std::printf("%zu values, the worst at %.2f of its tolerance\n", count_, worst_);
        EXPECT_GT(count_, 0u);
    }
    static constexpr double kUnit = static_cast<double>(std::numeric_limits<T>::epsilon()) / 2;

  private:
    static double Unit(const Vectors &vectors, size_t row) {
        // The files hold 17 digits, rounded once more to a double: no type is asked for more
        return std::max(kUnit, 0x1p-53) * (16 + 2 * vectors.At(row, "condition"));
    }
    void Count(const Vectors &vectors, size_t row, T value, double expected, double tolerance,
               const char *column) {
        ++count_;
        const double miss = std::abs(static_cast<double>(value) - expected) / tolerance;
        if (expected != static_cast<double>(value))
            worst_ = std::max(worst_, miss);
        EXPECT_LE(std::abs(static_cast<double>(value) - expected), tolerance)
            << column << " of row " << row << ": " << vectors.Describe(row);
    }
    size_t count_ = 0;
    double worst_ = 0;
};

template <typename T>
class HairVectors : public testing::Test {
  public:
    static T In(const Vectors &v, size_t row, const char *column) {
        return static_cast<T>(v.At(row, column));
    }
};
using Types = testing::Types<float, double, long double>;
TYPED_TEST_SUITE(HairVectors, Types);

TYPED_TEST(HairVectors, Bessel) {
    const Vectors v("bessel");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        judge.Relative(v, i, I0e(this->In(v, i, "x")), "i0e");
}

TYPED_TEST(HairVectors, Mp) {
    using T = TypeParam;
    const Vectors v("mp");
    Judge<T> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const T o = this->In(v, i, "theta_o"), in = this->In(v, i, "theta_i");
        judge.Relative(v, i, Mp(std::cos(in), std::cos(o), std::sin(in), std::sin(o), this->In(v, i, "v")),
                       "mp");
    }
}

TYPED_TEST(HairVectors, PhiAndNp) {
    using T = TypeParam;
    const Vectors v("np");
    Judge<T> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const T h = this->In(v, i, "h"), theta = this->In(v, i, "theta_o"), eta = this->In(v, i, "eta");
        const auto p = static_cast<int>(v.At(i, "p"));
        const T gammaO = std::asin(h), gammaT = SmoothFiber<T>(std::cos(theta), eta).GammaT(h);
        judge.Angle(v, i, Phi(p, gammaO, gammaT), "turn");
        judge.Relative(v, i,
                       Np(this->In(v, i, "phi"), p, AzimuthalScale(this->In(v, i, "beta_n")), gammaO, gammaT),
                       "np");
    }
}

TYPED_TEST(HairVectors, Ap) {
    using T = TypeParam;
    const Vectors v("ap");
    Judge<T> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const auto in = [&](const char *name) { return static_cast<float>(v.At(i, name)); };
        const float sigma = in("sigma_a");
        const HairLobes<T> hair(
            {in("h"), in("eta"), {sigma, sigma, sigma}, 0.3f, 0.3f, 2, ScaleTilt::RootToTip});
        const T theta = this->In(v, i, "theta_o");
        const auto ap = hair.Attenuations({std::sin(theta), std::cos(theta), T(0)});
        const double absolute = std::abs(v.At(i, "h")) == 1 ? 64 * Judge<float>::kUnit : 0;
        T total = 0;
        for (size_t p = 0; p < kLobes; ++p) {
            judge.Relative(v, i, ap[p][0], std::array{"a0", "a1", "a2", "a3"}[p], absolute);
            total += ap[p][0];
        }
        judge.Relative(v, i, total, "total", absolute);
    }
}

HairParameters ParametersOf(const Vectors &v, size_t row) {
    const auto in = [&](const char *name) { return static_cast<float>(v.At(row, name)); };
    return {in("h"),
            in("eta"),
            {in("sigma_r"), in("sigma_g"), in("sigma_b")},
            in("beta_m"),
            in("beta_n"),
            in("alpha"),
            in("tilt") > 0 ? ScaleTilt::RootToTip : ScaleTilt::PbrtV3};
}
HairBSDF Bsdf(const HairParameters &p) {
    return {p.h, p.eta, Spectrum(p.sigmaA[0], p.sigmaA[1], p.sigmaA[2]), p.betaM, p.betaN, p.alpha, p.tilt};
}
template <typename T>
Vector3<T> Direction(T theta, T phi) {
    return {std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi)};
}
constexpr double kViewAzimuth = 0.7; // anywhere: only the difference counts

template <typename T>
void JudgeValue(Judge<T> &judge, const Vectors &v, size_t row, const std::array<T, 3> &fCos, T pdf) {
    judge.Relative(v, row, fCos[0], "f_cos_r");
    judge.Relative(v, row, fCos[1], "f_cos_g");
    judge.Relative(v, row, fCos[2], "f_cos_b");
    judge.Relative(v, row, pdf, "pdf");
}

TYPED_TEST(HairVectors, BsdfAndPdf) {
    using T = TypeParam;
    const Vectors v("bsdf");
    Judge<T> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const T turn = static_cast<T>(kViewAzimuth);
        const auto value = HairLobes<T>(ParametersOf(v, i))
                               .Evaluate(Direction(this->In(v, i, "theta_o"), turn),
                                         Direction(this->In(v, i, "theta_i"), turn + this->In(v, i, "phi")));
        JudgeValue(judge, v, i, value.fCos, value.pdf);
    }
}

std::array<double, 4> NumbersOf(const Vectors &v, size_t row) {
    return {v.At(row, "u_lobe"), v.At(row, "u_azimuth"), v.At(row, "u_cosine"), v.At(row, "u_turn")};
}

TYPED_TEST(HairVectors, Samples) {
    using T = TypeParam;
    const Vectors v("samples");
    Judge<T> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const std::array<double, 4> u = NumbersOf(v, i);
        Vector3<T> wi;
        const auto value = HairLobes<T>(ParametersOf(v, i))
                               .Sample(Direction(this->In(v, i, "theta_o"), static_cast<T>(kViewAzimuth)),
                                       {static_cast<T>(u[0]), static_cast<T>(u[1]), static_cast<T>(u[2]),
                                        static_cast<T>(u[3])},
                                       &wi);
        judge.Angle(v, i, std::atan2(wi.x, std::hypot(wi.y, wi.z)), "theta_i");
        judge.Angle(v, i, std::atan2(wi.z, wi.y) - static_cast<T>(kViewAzimuth), "phi");
        JudgeValue(judge, v, i, value.fCos, value.pdf);
    }
}

// The class that renders, with every kernel.
class HairVectorsBsdf : public EveryKernel {};
CUTICLE_WITH_EVERY_KERNEL(HairVectorsBsdf);

std::array<float, 3> WithCosine(const Spectrum &f, const Vector3f &wi) {
    return {f[0] * std::abs(wi.z), f[1] * std::abs(wi.z), f[2] * std::abs(wi.z)};
}

TEST_P(HairVectorsBsdf, ValuesAndDensities) {
    const Vectors v("bsdf");
    Judge<float> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const Vector3f wo(Direction(v.At(i, "theta_o"), kViewAzimuth)),
            wi(Direction(v.At(i, "theta_i"), kViewAzimuth + v.At(i, "phi")));
        float pdf = 0;
        const Spectrum f = Bsdf(ParametersOf(v, i)).FPdf(wo, wi, &pdf);
        JudgeValue(judge, v, i, WithCosine(f, wi), pdf);
    }
}

TEST_P(HairVectorsBsdf, Samples) {
    const Vectors v("samples");
    Judge<float> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const std::array<double, 4> u = NumbersOf(v, i);
        Vector3f wi;
        float pdf = 0;
        const Spectrum f = Bsdf(ParametersOf(v, i))
                               .Sample_f(Vector3f(Direction(v.At(i, "theta_o"), kViewAzimuth)), &wi,
                                         {static_cast<float>(u[0]), static_cast<float>(u[1]),
                                          static_cast<float>(u[2]), static_cast<float>(u[3])},
                                         &pdf);
        judge.Angle(v, i, std::atan2(wi.x, std::hypot(wi.y, wi.z)), "theta_i");
        judge.Angle(v, i, std::atan2(wi.z, wi.y) - static_cast<float>(kViewAzimuth), "phi");
        JudgeValue(judge, v, i, WithCosine(f, wi), pdf);
    }
}

// Pearson's chi-squared of where n samples fall, for one row of a file of cells; significance 0.01 / tests.
void ExpectCells(const Vectors &v, size_t row, const FiberBxDF &fiber, int n, size_t tests) {
    const size_t rows = 16, columns = 12, first = v.Column("p_0_0");
    const Vector3f wo(Direction(v.At(row, "theta_o"), kViewAzimuth));
    std::array<double, rows * columns> counted{};
    RNG rng(MixBits(row + 1));
    for (int k = 0; k < n; ++k) {
        Vector3f wi;
        float pdf = 0;
        fiber.Sample_f(
            wo, &wi, {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()}, &pdf);
        const double phi = WrapAngle(static_cast<double>(std::atan2(wi.z, wi.y)) - kViewAzimuth);
        const auto cell = [](double x, size_t cells) {
            return std::min(static_cast<size_t>(x * static_cast<double>(cells)), cells - 1);
        };
        ++counted[cell((static_cast<double>(wi.x) + 1) / 2, rows) * columns +
                  cell((phi / kPi<double> + 1) / 2, columns)];
    }
    double chiSquared = 0, expected = 0, observed = 0;
    int cells = 0;
    for (size_t c = 0; c < counted.size(); ++c) { // pooled until 8 are expected
        expected += n * v.At(row, first + c), observed += counted[c];
        if (expected < 8)
            continue;
        chiSquared += Sqr(observed - expected) / expected;
        ++cells;
        expected = observed = 0;
    }
    chiSquared += Sqr(observed - expected) / std::max(expected, 1.);
    const double p = boost::math::gamma_q((cells - 1) / 2., chiSquared / 2);
    EXPECT_GT(cells, 8);
    EXPECT_GT(p, 0.01 / static_cast<double>(tests)) << "chi-squared " << chiSquared << " in " << cells
                                                    << " cells of " << n << " samples, " << v.Describe(row);
}

TEST_P(HairVectorsBsdf, SamplesFallIntoCellsAsTheyShould) {
    const Vectors v("cells");
    for (size_t i = 0; i < v.Rows(); ++i)
        ExpectCells(v, i, Bsdf(ParametersOf(v, i)), 100000, v.Rows() * HairKernelNames().size());
}

// The energies over the width of a fiber, by our own quadrature of our own A_p.
TEST(HairVectorsEnergy, OverTheWidth) {
    const Vectors v("energies");
    double worst = 0;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const double theta = v.At(i, "theta_o");
        const auto sigma = static_cast<float>(v.At(i, "sigma_a"));
        std::array<double, kLobes> sum{};
        const GaussLegendreRule rule = MakeGaussLegendreRule(200);
        for (size_t k = 0; k < 200; ++k) {
            const double gamma = kPi<double> / 2 * rule.x[k];
            HairLobes<double> hair({0,
                                    static_cast<float>(v.At(i, "eta")),
                                    {sigma, sigma, sigma},
                                    0.3f,
                                    0.3f,
                                    2,
                                    ScaleTilt::RootToTip});
            hair.h = std::sin(gamma), hair.cosGammaO = std::cos(gamma);
            const auto ap = hair.Attenuations({std::sin(theta), std::cos(theta), 0});
            for (size_t p = 0; p < kLobes; ++p)
                sum[p] += kPi<double> / 4 * rule.w[k] * std::cos(gamma) * ap[p][0];
        }
        for (size_t p = 0; p < kLobes; ++p) {
            const double expected = v.At(i, std::array{"e0", "e1", "e2", "e3"}[p]);
            worst = std::max(worst, std::abs(sum[p] - expected));
            EXPECT_NEAR(sum[p], expected, 1e-12) << v.Describe(i);
        }
        EXPECT_NEAR(sum[0] + sum[1] + sum[2] + sum[3], v.At(i, "albedo"), 1e-12) << v.Describe(i);
    }
    std::printf("energies over the width: off by at most %.2g\n", worst);
}

TEST(HairVectorsColor, SigmaAFromReflectance) {
    const Vectors v("reflectance");
    Judge<float> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        judge.Relative(v, i,
                       HairBSDF::SigmaAFromReflectance(Spectrum(static_cast<float>(v.At(i, "reflectance"))),
                                                       static_cast<float>(v.At(i, "beta_n")))[0],
                       "sigma_a");
}

// The models that came before, evaluated and sampled.
constexpr std::array<const char *, 3> kRgb = {"r", "g", "b"}, kLobeNames = {"R", "TT", "TRT"};
template <typename T>
std::array<T, 3> Three(const Vectors &v, size_t row, const std::string &name,
                       const std::array<const char *, 3> &suffixes) {
    std::array<T, 3> three;
    for (size_t i = 0; i < 3; ++i)
        three[i] = static_cast<T>(v.At(row, name + "_" + suffixes[i]));
    return three;
}
template <typename T>
KajiyaKay<T> ConesOf(const Vectors &v, size_t row) {
    return {Three<T>(v, row, "kd", kRgb), Three<T>(v, row, "ks", kRgb),
            static_cast<T>(v.At(row, "exponent"))};
}
template <typename T>
Marschner<T> MarschnerOf(const Vectors &v, size_t row) {
    const auto in = [&](const char *name) { return static_cast<float>(v.At(row, name)); };
    MarschnerParameters p;
    p.eta = in("eta"), p.sigmaA = Three<float>(v, row, "sigma", kRgb);
    p.alpha = Three<float>(v, row, "alpha", kLobeNames), p.beta = Three<float>(v, row, "beta", kLobeNames);
    p.eccentricity = in("eccentricity"), p.kd = Three<float>(v, row, "kd", kRgb);
    p.kG = in("k_g"), p.wc = in("w_c"), p.etaRange = in("delta_eta"), p.maxH = in("delta_h");
    if (in("printed") != 0) {
        p.roots = RootMethod::Cubic, p.length = SegmentLength::Printed;
        p.longitudinal = LongitudinalForm::HalfAngle, p.printedEccentricity = true;
    }
    return Marschner<T>(CheckedMarschner(p));
}
DEonParameters DEonParametersOf(const Vectors &v, size_t row) {
    DEonParameters p;
    p.eta = static_cast<float>(v.At(row, "eta")), p.sigmaA = Three<float>(v, row, "sigma", kRgb);
    p.alpha = Three<float>(v, row, "alpha", kLobeNames);
    p.betaM = Three<float>(v, row, "beta_m", kLobeNames);
    p.betaN = Three<float>(v, row, "beta_n", kLobeNames);
    p.lobes = static_cast<int>(v.At(row, "lobes"));
    if (v.At(row, "printed") != 0)
        p.tail = false, p.halfAngleFresnel = true, p.length = SegmentLength::Printed;
    return p;
}
template <typename T>
DEon<T, DEonQuadrature<T>> NearDEonOf(const Vectors &v, size_t row) {
    DEonParameters p = DEonParametersOf(v, row);
    p.h = static_cast<float>(v.At(row, "h"));
    p = CheckedDEon(p);
    return {p, DEonQuadrature<T>(p)};
}

template <typename T>
class OlderModelVectors : public HairVectors<T> {
  public:
    // phiO, phiI: the azimuths of the directions.
    template <class Model>
    void Value(Judge<T> &judge, const Vectors &v, size_t row, const Model &model, double phiO, double phiI) {
        const FiberValue<T> value =
            model.Evaluate(Direction(this->In(v, row, "theta_o"), static_cast<T>(phiO)),
                           Direction(this->In(v, row, "theta_i"), static_cast<T>(phiI)));
        JudgeValue(judge, v, row, value.fCos, value.pdf);
    }
    // Returns the azimuth that was chosen.
    template <class Model>
    T Sample(Judge<T> &judge, const Vectors &v, size_t row, const Model &model, double phiO) {
        std::array<T, 4> u;
        const std::array<double, 4> numbers = NumbersOf(v, row);
        std::copy(numbers.begin(), numbers.end(), u.begin());
        Vector3<T> wi;
        const FiberValue<T> value =
            model.Sample(Direction(this->In(v, row, "theta_o"), static_cast<T>(phiO)), u, &wi);
        judge.Angle(v, row, std::atan2(wi.x, std::hypot(wi.y, wi.z)), "theta_i");
        JudgeValue(judge, v, row, value.fCos, value.pdf);
        return std::atan2(wi.z, wi.y);
    }
};
using OlderTypes = testing::Types<float, double>;
TYPED_TEST_SUITE(OlderModelVectors, OlderTypes);

TYPED_TEST(OlderModelVectors, KajiyaKay) {
    const Vectors v("kajiya_kay");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        this->Value(judge, v, i, ConesOf<TypeParam>(v, i), kViewAzimuth, -1.3);
}
TYPED_TEST(OlderModelVectors, KajiyaKaySamples) {
    const Vectors v("kajiya_kay_samples");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        this->Sample(judge, v, i, ConesOf<TypeParam>(v, i), kViewAzimuth);
}
TYPED_TEST(OlderModelVectors, Marschner) {
    const Vectors v("marschner");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        this->Value(judge, v, i, MarschnerOf<TypeParam>(v, i), v.At(i, "phi_o"), v.At(i, "phi_i"));
}
TYPED_TEST(OlderModelVectors, MarschnerSamples) {
    const Vectors v("marschner_samples");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const double view = v.At(i, "phi_o");
        const TypeParam phi = this->Sample(judge, v, i, MarschnerOf<TypeParam>(v, i), view);
        judge.Angle(v, i, phi - static_cast<TypeParam>(view), "phi");
    }
}
TYPED_TEST(OlderModelVectors, DEonNear) {
    const Vectors v("deon_near");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i)
        this->Value(judge, v, i, NearDEonOf<TypeParam>(v, i), kViewAzimuth, kViewAzimuth + v.At(i, "phi"));
}
TYPED_TEST(OlderModelVectors, DEonNearSamples) {
    const Vectors v("deon_samples");
    Judge<TypeParam> judge;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const TypeParam phi = this->Sample(judge, v, i, NearDEonOf<TypeParam>(v, i), kViewAzimuth);
        judge.Angle(v, i, phi - static_cast<TypeParam>(kViewAzimuth), "phi");
    }
}

// The far field of a smooth fiber: all its paths, and N_p.
TEST(FarFieldVectors, SmoothNp) {
    const Vectors v("smooth_np");
    double worst = 0;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const SmoothFiber<double> fiber(std::cos(v.At(i, "theta_d")), v.At(i, "eta"));
        const auto p = static_cast<int>(v.At(i, "p"));
        const double sigma = v.At(i, "sigma_a");
        const PathRoots<double> roots = fiber.Roots(p, v.At(i, "phi"));
        ASSERT_EQ(roots.count, static_cast<size_t>(v.At(i, "paths"))) << v.Describe(i);
        double np = 0;
        for (size_t k = 0; k < roots.count; ++k)
            np += fiber.Density(p, roots.gamma[k]) *
                  fiber.Attenuation(p, roots.gamma[k], {sigma, sigma, sigma}, SegmentLength::Chord)[0];
        worst = std::max(worst, std::abs(np / v.At(i, "np") - 1));
        EXPECT_NEAR(np / v.At(i, "np"), 1, 1e-11) << v.Describe(i);
    }
    std::printf("%zu values of N_p, smooth: off by at most %.2g\n", v.Rows(), worst);
}
// And of a rough one, through the Gaussian detector: by many nodes, which tests the table, and by the order
// that our model chooses, whose root mean square error is stated as 1e-3; a single value may be three times
// that.
TEST(FarFieldVectors, RoughNp) {
    const Vectors v("rough_np");
    double worst = 0, worstOurs = 0;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const auto p = static_cast<int>(v.At(i, "p"));
        const double theta = v.At(i, "theta_d"), sigma = v.At(i, "sigma_a"), beta = v.At(i, "beta"),
                     phi = v.At(i, "phi"), expected = v.At(i, "np");
        const SmoothFiber<double> fiber(std::cos(theta), v.At(i, "eta"));
        double dense = 0, square = 0;
        const GaussLegendreRule rule = MakeGaussLegendreRule(400);
        for (size_t k = 0; k < rule.x.size(); ++k) {
            const double gamma = kPi<double> / 2 * rule.x[k], weight = kPi<double> / 4 * rule.w[k];
            const double a = fiber.Attenuation(p, gamma, {sigma, sigma, sigma}, SegmentLength::Chord)[0];
            dense += weight * std::cos(gamma) * a * GaussianDetector(beta, phi - fiber.Phi(p, gamma));
        }
        worst = std::max(worst, std::abs(dense / expected - 1));
        EXPECT_NEAR(dense / expected, 1, 1e-9) << v.Describe(i);

        DEonParameters parameters;
        parameters.eta = static_cast<float>(v.At(i, "eta"));
        parameters.sigmaA.fill(static_cast<float>(sigma));
        parameters.betaN.fill(static_cast<float>(beta * 180 / kPi<double>));
        const DEonQuadrature<double> quadrature(parameters);
        const auto inside = quadrature.At(std::cos(theta));
        const auto ours = [&](double x) { return quadrature.Value(static_cast<size_t>(p), inside, x).n[0]; };
        for (int k = 0; k < 90; ++k)
            square += Sqr(ours(2 * kPi<double> * k / 90)) / 90;
        const double miss = std::abs(ours(phi) - expected) / std::sqrt(square);
        worstOurs = std::max(worstOurs, miss);
        EXPECT_LT(miss, 3e-3) << v.Describe(i);
    }
    std::printf("%zu values of N_p, rough: off by at most %.2g, our quadrature by %.2g of the lobe's RMS\n",
                v.Rows(), worst, worstOurs);
}

// The whole model, over the width: to the 1e-3 that the quadrature promises of N_p, in the root of the mean
// square there and of each value here, where no row lies far from all lobes.
template <typename T>
class FarDEonVectors : public HairVectors<T> {};
TYPED_TEST_SUITE(FarDEonVectors, OlderTypes);

TYPED_TEST(FarDEonVectors, ValuesAndDensities) {
    using T = TypeParam;
    const Vectors v("deon_far");
    double worst = 0;
    for (size_t i = 0; i < v.Rows(); ++i) {
        const DEonParameters p = CheckedDEon(DEonParametersOf(v, i));
        const T turn = static_cast<T>(kViewAzimuth);
        const auto value = DEon<T, DEonQuadrature<T>>(p, DEonQuadrature<T>(p))
                               .Evaluate(Direction(this->In(v, i, "theta_o"), turn),
                                         Direction(this->In(v, i, "theta_i"), turn + this->In(v, i, "phi")));
        const std::array<T, 4> ours = {value.fCos[0], value.fCos[1], value.fCos[2], value.pdf};
        for (size_t k = 0; k < 4; ++k) {
            const double expected = v.At(i, std::array{"f_cos_r", "f_cos_g", "f_cos_b", "pdf"}[k]),
                         miss = std::abs(static_cast<double>(ours[k]) / expected - 1);
            worst = std::max(worst, miss);
            EXPECT_LT(miss, 1e-3) << v.Describe(i);
        }
    }
    EXPECT_GT(v.Rows(), 20u);
    std::printf("%zu rows, off by at most %.2g\n", v.Rows(), worst);
}

// Its samples fall by quadrature as from the table.
TEST(FarFieldVectors, DEonSamplesFallIntoCellsAsTheyShould) {
    const Vectors v("deon_cells");
    for (size_t i = 0; i < v.Rows(); ++i) {
        const DEonParameters p = DEonParametersOf(v, i);
        const auto table = DEonTable::Cached(p);
        ExpectCells(v, i, DEonBSDF(p), 30000, 2 * v.Rows());
        ExpectCells(v, i, TabulatedDEonBSDF(p, table.get()), 100000, 2 * v.Rows());
    }
}

// Another seed and fewer rays agree with the table within its error bars: Bonferroni over all cells,
// significance 0.01.
TEST(SimulatorVectors, AnotherSeedAgrees) {
    std::ifstream file(std::string(CUTICLE_SOURCE_DIR) + "/tests/vectors/simulator.json");
    const nlohmann::json json = nlohmann::json::parse(file);
    const double all = json.at("samples"), samples = 40000, degree = kPi<double> / 180;
    std::vector<FiberHistogram> histograms;
    for (const nlohmann::json &f : json.at("fibers")) {
        FiberDescription fiber;
        fiber.eta = f.at("eta"), fiber.sigmaA = {f.at("sigma_a")};
        fiber.alpha = f.value("alpha", 0.) * degree, fiber.axisRatio = f.value("axis_ratio", 1.);
        fiber.roughnessU = fiber.roughnessV = f.value("roughness", 0.);
        if (f.value("distribution", "") == "ggx")
            fiber.distribution = MicrofacetDistribution::GGX;
        FiberLight light;
        light.theta = f.at("theta_i").get<double>() * degree, light.phi = f.value("phi_i", 0.) * degree;
        FiberMeasurement measurement;
        measurement.samples = static_cast<uint64_t>(samples), measurement.seed = 2, measurement.orders = 3;
        measurement.cells = {8, 12, true};
        histograms.push_back(SimulateFiber(fiber, light, measurement));
    }
    const double larger = std::sqrt(1 + all / samples); // than the table's, the error of the difference
    int tested = 0;
    double worst = 0, squares = 0;
    const auto compare = [&](double value, double expected, double error, const std::string &what) {
        const double z = std::abs(value - expected) / (error * larger);
        ++tested, squares += z * z;
        worst = std::max(worst, z);
        EXPECT_LT(z, 4.7) << what; // 0.01 / 4000
    };
    for (const nlohmann::json &row : json.at("rows")) {
        const double density = row[4], error = row[5];
        if (density < 20 * error)
            continue; // of fewer than about 400 rays: not yet normal in ours
        const FiberHistogram &histogram = histograms.at(row[0]);
        compare(histogram.Density(row[1], 0, row[2], row[3]), density, error, row.dump());
    }
    for (const nlohmann::json &row : json.at("energies"))
        compare(histograms.at(row[0]).Albedo(row[1], 0), row[2], row[3], row.dump());
    std::printf("%d values, worst %.2f standard deviations, mean square %.3f\n", tested, worst,
                squares / tested);
    EXPECT_GT(tested, 200);
    EXPECT_NEAR(squares / tested, 1, 0.4);
}

} // namespace
} // namespace cuticle
