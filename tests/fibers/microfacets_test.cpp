// The random surface of the fiber simulator, against integrals over its slopes.
#include "fibers/microfacets.h"

#include "core/sampling.h"

#include <gtest/gtest.h>

#include <functional>

namespace cuticle {
namespace {

using Kind = MicrofacetDistribution;
constexpr double kAlphaX = 0.4, kAlphaY = 0.15;

// The integral over all slopes of P(slope) f(normal, its projection), f given the unnormalised normal (-x,
// -y, 1): a midpoint rule in the radius' distribution function and in the angle.
double OverSlopes(Kind kind, const std::function<double(const Vector3d &)> &f) {
    const int n = 1200, m = 180;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        // u = s^2 (3 - 2 s) has its nodes close up at both ends, where slopes are flat or endless.
        const double s = (i + 0.5) / n, u = s * s * (3 - 2 * s), weight = 6 * s * (1 - s) / n;
        const double r = kind == Kind::Beckmann ? std::sqrt(-std::log1p(-u)) : std::sqrt(u / (1 - u));
        for (int j = 0; j < m; ++j) {
            const double a = 2 * kPi<double> * (j + 0.5) / m;
            sum += weight / m * f({-kAlphaX * r * std::cos(a), -kAlphaY * r * std::sin(a), 1});
        }
    }
    return sum;
}

const Vector3d kDirections[] = {Vector3d(0.3, 0.2, 0.9), Vector3d(-0.9, 0.1, 0.2), Vector3d(0.1, 0.95, 0.05),
                                Vector3d(0.8, -0.3, -0.1), Vector3d(0.5, 0.5, -0.3)};

// The area that facets show to w is (1 + Lambda(w)) w.z, above the horizon and below it.
TEST(Microfacets, LambdaIsTheAreaThatIsTurnedAway) {
    for (const Kind kind : {Kind::Beckmann, Kind::GGX})
        for (const Vector3d &d : kDirections) {
            const Vector3d w = Normalize(d);
            const Microfacets surface(kind, kAlphaX, kAlphaY);
            const double area = OverSlopes(kind, [&](const Vector3d &m) { return std::max(0., Dot(m, w)); });
            EXPECT_NEAR((1 + surface.Lambda(w)) * w.z, area, 2e-3 * area + 2e-5) << w;
            EXPECT_NEAR(surface.Lambda(-w), -1 - surface.Lambda(w), 1e-12);
        }
}

// Moments of the sampled visible normals against their integrals; 5 standard errors (p = 6e-7 each, 60 of
// them), n = 200000.
TEST(Microfacets, VisibleNormalsFollowTheirDensity) {
    const int n = 200000;
    RNG rng(1);
    const auto uniform = [&] { return (rng.UniformUInt32() + 0.5) * 0x1p-32; };
    const std::function<double(const Vector3d &)> moments[] = {
        [](const Vector3d &m) { return m.x; },       [](const Vector3d &m) { return m.y; },
        [](const Vector3d &m) { return m.z; },       [](const Vector3d &m) { return m.x * m.x; },
        [](const Vector3d &m) { return m.x * m.y; }, [](const Vector3d &m) { return m.y * m.y; }};
    for (const Kind kind : {Kind::Beckmann, Kind::GGX})
        for (const Vector3d &d : kDirections) {
            const Vector3d w = Normalize(d);
            const Microfacets surface(kind, kAlphaX, kAlphaY);
            std::array<double, 6> sum = {}, squares = {};
            for (int i = 0; i < n; ++i) {
                const double u0 = uniform(), u1 = uniform();
                const Vector3d m = surface.VisibleNormal(w, u0, u1);
                ASSERT_GE(Dot(m, w), -1e-9);
                for (size_t k = 0; k < 6; ++k) {
                    const double v = moments[k](m);
                    sum[k] += v, squares[k] += v * v;
                }
            }
            const double area = OverSlopes(kind, [&](const Vector3d &m) { return std::max(0., Dot(m, w)); });
            for (size_t k = 0; k < 6; ++k) {
                const double expected =
                    OverSlopes(kind,
                               [&](const Vector3d &m) {
                                   return std::max(0., Dot(m, w)) * moments[k](Normalize(m));
                               }) /
                    area;
                const double mean = sum[k] / n, error = std::sqrt((squares[k] / n - mean * mean) / n);
                EXPECT_NEAR(mean, expected, 5 * error + 1e-3 * std::abs(expected) + 1e-4)
                    << "moment " << k << " " << w;
            }
        }
}

// The share c^Lambda of rays that climb from height h leaves; the rest meets the surface above h. 5 standard
// errors, n = 100000.
TEST(Microfacets, HeightsAboveAreMetOrLeft) {
    const Microfacets surface(Kind::Beckmann, kAlphaX, kAlphaY);
    const Vector3d up = Normalize(Vector3d(0.9, 0, 0.2));
    RNG rng(2);
    const int n = 100000;
    for (const double h : {-0.9, 0., 0.7}) {
        int left = 0;
        for (int i = 0; i < n; ++i) {
            const double u = (rng.UniformUInt32() + 0.5) * 0x1p-32, next = surface.NextHeight(up, h, u);
            left += next > 1;
            EXPECT_GE(next, h - 1e-12);
            EXPECT_LE(surface.NextHeight(-up, h, u), h + 1e-12);
        }
        const double p = std::pow((h + 1) / 2, surface.Lambda(up));
        EXPECT_NEAR(static_cast<double>(left) / n, p, 5 * std::sqrt(p * (1 - p) / n)) << h;
    }
}

} // namespace
} // namespace cuticle
