// The measurements that the laws of model_laws.h are made of, for any model of a fiber: its density
// integrates to 1, its samples follow that density (Pearson's chi-squared), its samples' weights are bounded,
// and how much energy it returns.
#pragma once

#include "core/sampling.h"
#include "fibers/bxdf.h"
#include "fibers/furnace.h"

#include <boost/math/special_functions/gamma.hpp>

#include <functional>

namespace cuticle::laws {

// The model in double: value and density for two unit directions.
using Reference = std::function<FiberValue<double>(const Vector3d &wo, const Vector3d &wi)>;

// The peaks that a model has for one viewer: angles along and around the fiber, and widths.
struct Peaks {
    std::vector<furnace::Peak> theta, phi;
};

inline Vector3d Direction(double theta, double phi) {
    return {std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi)};
}
inline constexpr double kFrom = 0.1; // where the azimuths of a mesh begin

struct Integrals {
    std::array<double, 3> energy; // of f |cos| over the sphere
    double pdf;
};
inline Integrals OverSphere(const Reference &model, const Vector3d &wo, const Peaks &peaks,
                            double panel = furnace::kPanel) {
    const furnace::Mesh theta = furnace::ThetaMesh(peaks.theta, panel),
                        phi = furnace::PhiMesh(peaks.phi, kFrom, panel);
    Integrals sum{{0, 0, 0}, 0};
    for (size_t i = 0; i < theta.x.size(); ++i)
        for (size_t j = 0; j < phi.x.size(); ++j) {
            const double weight = theta.weight[i] * phi.weight[j] * std::cos(theta.x[i]);
            const FiberValue<double> value = model(wo, Direction(theta.x[i], phi.x[j]));
            for (size_t c = 0; c < 3; ++c)
                sum.energy[c] += weight * value.fCos[c];
            sum.pdf += weight * value.pdf;
        }
    return sum;
}

struct SampleTest {
    double p;             // of chi-squared: the chance of so large a deviation
    size_t cells;         // after pooling
    double pdf;           // integral of the density
    double largestWeight; // of f |cos| / pdf, any colour
    double worstMismatch; // of the density that Sample_f states against Pdf's in double, relative
};
// n directions drawn by the BSDF against the density of the reference. Cells are the panels of the furnace's
// quadrature, 8 x 8 nodes each, pooled until each expects 8.
inline SampleTest ChiSquared(const FiberBxDF &bsdf, const Reference &model, const Vector3d &wo,
                             const Peaks &peaks, uint64_t seed, int n) {
    const double turn = 2 * std::numbers::pi;
    const furnace::Mesh theta = furnace::ThetaMesh(peaks.theta, 1.3),
                        phi = furnace::PhiMesh(peaks.phi, kFrom, 1.3);
    const size_t rows = theta.edges.size() - 1, columns = phi.edges.size() - 1;
    std::vector<double> expected(rows * columns), counted(rows * columns);
    for (size_t i = 0; i < theta.x.size(); ++i)
        for (size_t j = 0; j < phi.x.size(); ++j)
            expected[i / furnace::kNodes * columns + j / furnace::kNodes] +=
                n * theta.weight[i] * phi.weight[j] * std::cos(theta.x[i]) *
                model(wo, Direction(theta.x[i], phi.x[j])).pdf;
    SampleTest result{1, 0, 0, 0, 0};
    RNG rng(MixBits(seed));
    const Vector3f view(wo);
    for (int k = 0; k < n; ++k) {
        Vector3f wi;
        float pdf = 0;
        const Spectrum f = bsdf.Sample_f(
            view, &wi, {rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat(), rng.UniformFloat()},
            &pdf);
        if (!(pdf > 0))
            continue;
        const Vector3d w(wi);
        for (int c = 0; c < 3; ++c)
            result.largestWeight = std::max(result.largestWeight, static_cast<double>(f[c]) * std::abs(w.z) /
                                                                      static_cast<double>(pdf));
        if (k < 1000) {
            const double exact = model(wo, w).pdf;
            result.worstMismatch =
                std::max(result.worstMismatch, std::abs(static_cast<double>(pdf) - exact) / (exact + 1e-3));
        }
        double azimuth = std::atan2(w.z, w.y);
        azimuth -= turn * std::floor((azimuth - kFrom) / turn);
        const auto cell = [](const std::vector<double> &edges, double x) {
            return static_cast<size_t>(std::upper_bound(edges.begin() + 1, edges.end() - 1, x) -
                                       edges.begin()) -
                   1;
        };
        ++counted[cell(theta.edges, std::atan2(w.x, std::hypot(w.y, w.z))) * columns +
                  cell(phi.edges, azimuth)];
    }
    double chiSquared = 0, e = 0, o = 0;
    for (size_t k = 0; k < expected.size(); ++k) {
        e += expected[k], o += counted[k], result.pdf += expected[k] / n;
        if (e >= 8) {
            chiSquared += (o - e) * (o - e) / e;
            ++result.cells;
            e = o = 0;
        }
    }
    if (e > 0) // what remains counts as one more cell, if it is not too small to be one
        chiSquared += (o - e) * (o - e) / std::max(e, 1.);
    result.p = boost::math::gamma_q(static_cast<double>(result.cells - 1) / 2, chiSquared / 2);
    return result;
}

} // namespace cuticle::laws
