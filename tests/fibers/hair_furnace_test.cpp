// The white furnace: a fiber that absorbs nothing returns all light. By quadrature of f itself, since a
// furnace that samples the BSDF returns the sum of A_p whatever M_p and N_p are.
#include "fibers/every_kernel.h"
#include "fibers/furnace.h"
#include "fibers/hair_peaks.h"

#include "core/sampling.h"
#include "fibers/hair.h"
#include "fibers/hair_as_printed.h"
#include "fibers/hair_model.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <string>

namespace cuticle {
namespace {

const std::vector<float> kBetas = {0,    1e-4f, 1e-3f, 0.01f, 0.05f, 0.1f, 0.2f, 0.3f,
                                   0.4f, 0.5f,  0.6f,  0.7f,  0.8f,  0.9f, 1};
const std::vector<float> kAlphas = {0, 2, 10};
const std::vector<float> kThetas = {-89.9f, -85, -60, -30, 0, 15, 45, 75, 89, 89.9f};
const std::vector<float> kOffsets = {-1, -0.999f, -0.5f, 0, 0.3f, 0.9f, 0.99999f, 1};

HairParameters White(float h, float betaM, float betaN, float alpha) {
    return {h, 1.55f, {0, 0, 0}, betaM, betaN, alpha, ScaleTilt::RootToTip};
}

Vector3f Direction(double theta, double phi) {
    return {static_cast<float>(std::sin(theta)), static_cast<float>(std::cos(theta) * std::cos(phi)),
            static_cast<float>(std::cos(theta) * std::sin(phi))};
}

// The integral of M_p cos theta_i d theta_i, M_p and its arguments in T.
template <typename T>
double LongitudinalMass(const HairLobes<T> &hair, size_t p, double thetaO) {
    const T sinO = static_cast<T>(std::sin(thetaO)), cosO = static_cast<T>(std::cos(thetaO));
    const SinCosine<T> axis = Tilted(sinO, cosO, hair.sinTilt[p], hair.cosTilt[p]);
    const double centre = -std::atan2(static_cast<double>(axis.sin), static_cast<double>(axis.cos));
    const double width = std::sqrt(static_cast<double>(hair.v[p]));
    const furnace::Mesh mesh = furnace::ThetaMesh({{centre, width}});
    return furnace::Integrate(mesh, [&](double theta, double *actual) {
        const T s = static_cast<T>(std::sin(theta)), c = static_cast<T>(std::cos(theta));
        *actual = std::atan2(static_cast<double>(s), static_cast<double>(c));
        return static_cast<double>(hair.Longitudinal(p, sinO, cosO, s, c)) * std::cos(*actual);
    });
}

// The integral of N_p d phi for an azimuthal lobe: from its centre, which only moves it.
template <typename T>
double AzimuthalMass(const HairLobes<T> &hair, size_t p) {
    const furnace::Mesh mesh = furnace::PhiMesh({{0, static_cast<double>(hair.s)}}, -std::numbers::pi);
    return furnace::Integrate(mesh, [&](double phi, double *actual) {
        const T rounded = static_cast<T>(phi);
        *actual = static_cast<double>(rounded);
        return static_cast<double>(hair.Azimuthal(p, rounded));
    });
}

// E = sum A_p (integral M_p)(integral N_p) over the whole grid of the roughnesses, tilts, angles and offsets.
template <typename T>
double WorstFurnace(std::string *where) {
    double worst = 0;
    for (const float betaM : kBetas)
        for (const float alpha : kAlphas)
            for (const float theta : kThetas) {
                std::array<double, kLobes> m;
                const double thetaO = static_cast<double>(theta) * std::numbers::pi / 180;
                const HairLobes<T> lobes(White(0, betaM, 0.3f, alpha));
                for (size_t p = 0; p < kLobes; ++p)
                    m[p] = LongitudinalMass(lobes, p, thetaO);
                for (const float betaN : kBetas) {
                    static std::map<float, std::array<double, kLobes>> azimuthal; // of T
                    auto n = azimuthal.find(betaN);
                    if (n == azimuthal.end()) {
                        const HairLobes<T> hair(White(0, betaM, betaN, alpha));
                        std::array<double, kLobes> masses;
                        for (size_t p = 0; p < kLobes; ++p)
                            masses[p] = AzimuthalMass(hair, p);
                        n = azimuthal.emplace(betaN, masses).first;
                    }
                    for (const float h : kOffsets) {
                        const HairLobes<T> hair(White(h, betaM, betaN, alpha));
                        const auto ap = hair.Attenuations(
                            {static_cast<T>(std::sin(thetaO)), static_cast<T>(std::cos(thetaO)), T(0)});
                        double e = 0;
                        for (size_t p = 0; p < kLobes; ++p)
                            e += static_cast<double>(ap[p][0]) * m[p] * n->second[p];
                        if (!(std::abs(e - 1) <= worst)) {
                            worst = std::abs(e - 1);
                            *where = "beta_m " + std::to_string(betaM) + " beta_n " + std::to_string(betaN) +
                                     " alpha " + std::to_string(alpha) + " theta_o " + std::to_string(theta) +
                                     " h " + std::to_string(h) + " E " + std::to_string(e);
                        }
                    }
                }
            }
    return worst;
}

TEST(Hair, WhiteFurnaceByQuadratureInDouble) {
    std::string where;
    const double worst = WorstFurnace<double>(&where);
    std::printf("furnace, double: max |E - 1| = %.3g at %s\n", worst, where.c_str());
    EXPECT_LE(worst, 1e-8) << where; // this also is the error of the quadrature
}

TEST(Hair, WhiteFurnaceByQuadratureInFloat) {
    std::string where;
    const double worst = WorstFurnace<float>(&where);
    std::printf("furnace, float: max |E - 1| = %.3g at %s\n", worst, where.c_str());
    EXPECT_LE(worst, 1e-5) << where;
}

// The energy and the integral of the density, of the public class with the kernels, over the whole sphere at
// once.
//
// Binary32 rounds cos theta and the azimuth of a direction by 6e-8, which is up to 2e-3 of the width of the
// narrowest lobes and makes single values of f that noisy. The noise averages out; what is left of it in the
// sum is measured, on every 13th node, against the same model in double at the same direction, and stated as
// a standard deviation.
struct Energy {
    double e, pdf, noise;
    size_t evaluations;
};
Energy OverSphere(const HairBSDF &hair, const HairParameters &parameters, double thetaO, double phiO) {
    const HairLobes<double> lobes(parameters);
    const Vector3f wo = Direction(thetaO, phiO);
    const HairPeaks peaks(lobes, Vector3d(wo));
    const furnace::Mesh thetaMesh = furnace::ThetaMesh(peaks.theta);
    const furnace::Mesh phiMesh = furnace::PhiMesh(peaks.phi, 0.1);
    const size_t rows = thetaMesh.x.size(), columns = phiMesh.x.size();
    std::vector<double> f(rows * columns), pdf(rows * columns), dTheta(rows * columns), dPhi(rows * columns);
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < columns; ++j) {
            const Vector3f wi = Direction(thetaMesh.x[i], phiMesh.x[j]);
            const Vector3d exact(wi);
            const double theta = std::atan2(exact.x, std::hypot(exact.y, exact.z));
            Float density = 0;
            const Spectrum value = hair.FPdf(wo, wi, &density);
            const size_t at = i * columns + j;
            f[at] = static_cast<double>(value[1]) * std::abs(exact.z) * std::cos(theta);
            pdf[at] = static_cast<double>(density) * std::cos(theta);
            dTheta[at] = theta - thetaMesh.x[i];
            dPhi[at] = std::remainder(std::atan2(exact.z, exact.y) - phiMesh.x[j], 2 * std::numbers::pi);
        }
    Energy energy{0, 0, 0, rows * columns};
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < columns; ++j) {
            const size_t at = i * columns + j;
            const double weight = thetaMesh.weight[i] * phiMesh.weight[j];
            const auto carried = [&](const std::vector<double> &values) {
                return values[at] - dTheta[at] * furnace::Slope(thetaMesh, &values[j], columns, i) -
                       dPhi[at] * furnace::Slope(phiMesh, &values[i * columns], 1, j);
            };
            energy.e += weight * carried(f);
            energy.pdf += weight * carried(pdf);
            if (at % 13 == 0) {
                const Vector3d wi(Direction(thetaMesh.x[i], phiMesh.x[j]));
                const double exact = lobes.Evaluate(Vector3d(wo), wi).fCos[1] * std::hypot(wi.y, wi.z);
                energy.noise += 13 * Sqr(weight * (f[at] - exact));
            }
        }
    energy.noise = std::sqrt(energy.noise);
    return energy;
}

class HairFurnace : public EveryKernel {};
CUTICLE_WITH_EVERY_KERNEL(HairFurnace);

// A Latin choice from the grid: every roughness of either kind, tilt, angle and offset occurs, in changing
// company.
TEST_P(HairFurnace, OverTheSphere) {
    double worst = 0, worstPdf = 0, worstNoise = 0;
    std::string where;
    size_t evaluations = 0;
    for (size_t k = 0; k < 45; ++k) {
        const HairParameters parameters = White(kOffsets[(3 * k + 1) % kOffsets.size()], kBetas[k % 15],
                                                kBetas[(7 * k + k / 15) % 15], kAlphas[(k + k / 15) % 3]);
        const double theta =
            static_cast<double>(kThetas[(3 * k + k / 15) % kThetas.size()]) * std::numbers::pi / 180;
        const HairBSDF hair(parameters.h, 1.55f, Spectrum(0.f), parameters.betaM, parameters.betaN,
                            parameters.alpha);
        const Energy energy = OverSphere(hair, parameters, theta, 0.4 + static_cast<double>(k));
        evaluations += energy.evaluations;
        if (!(std::abs(energy.e - 1) <= worst))
            worst = std::abs(energy.e - 1), where = hair.ToString() + " theta_o " + std::to_string(theta);
        worstPdf = std::max(worstPdf, std::abs(energy.pdf - 1));
        const double bound = 1e-5 + 4 * energy.noise;
        worstNoise = std::max(worstNoise, energy.noise);
        EXPECT_NEAR(energy.e, 1, bound) << hair.ToString() << " theta_o " << theta;
        EXPECT_NEAR(energy.pdf, 1, bound) << hair.ToString() << " theta_o " << theta;
    }
    std::printf(
        "furnace over the sphere, %s: max |E - 1| = %.3g, of the density %.3g, rounding noise at most %.3g, "
        "%zu evaluations, at %s\n",
        GetParam().c_str(), worst, worstPdf, worstNoise, evaluations, where.c_str());
}

} // namespace
} // namespace cuticle
