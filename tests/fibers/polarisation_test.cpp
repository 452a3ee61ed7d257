// The simulator's polarised light against closed forms and against a tracer that carries fields.
#include "core/angles.h"
#include "core/quadrature.h"
#include "fibers/fiber_simulator.h"
#include "fibers/smooth_fiber.h"

#include <gtest/gtest.h>

#include <complex>

namespace cuticle {
namespace {

using Complex = std::complex<double>;

FiberHistogram OneRay(const FiberDescription &fiber, double theta, double phi, double h, int orders = 6) {
    FiberMeasurement m;
    m.samples = 2, m.orders = orders, m.cells = {1, 1}, m.faint = 0;
    return SimulateFiber(fiber, {theta, phi, h}, m);
}

// --- the smooth circle -------------------------------------------------------------------------------------

// The amplitudes r_s and r_p of a ray that meets a circle at h from theta.
struct Amplitudes {
    double sinThetaT, sinGammaT, s, p;
    Amplitudes(double eta, double theta, double h) {
        sinThetaT = std::sin(theta) / eta;
        const double cosThetaT = std::sqrt(1 - sinThetaT * sinThetaT);
        sinGammaT = h * std::cos(theta) / (eta * cosThetaT);
        const double ci = std::cos(theta) * std::sqrt(1 - h * h),
                     ct = cosThetaT * std::sqrt(1 - sinGammaT * sinGammaT);
        s = (eta * ct - ci) / (eta * ct + ci);
        p = (ct - eta * ci) / (ct + eta * ci);
    }
};

// The share of order p of a clear circle. All bounces inside have the same angles, so that the amplitudes of
// a path are a product of 2 x 2 matrices: T Q (D Q)^(p-1) T with T and D of the interface, and Q that turns
// one plane of incidence to the next.
double ClosedForm(double eta, double theta, double h, int p) {
    const Amplitudes r(eta, theta, h);
    if (p == 0)
        return (r.s * r.s + r.p * r.p) / 2;
    const double psi = 2 * std::atan2(r.sinGammaT / std::sqrt(1 - r.sinGammaT * r.sinGammaT), r.sinThetaT);
    const double c = std::cos(psi), s = std::sin(psi);
    const double ts = std::sqrt(1 - r.s * r.s), tp = std::sqrt(1 - r.p * r.p);
    double m[2][2] = {{ts, 0}, {0, tp}};
    for (int k = 1; k <= p; ++k) {
        const double ds = k == p ? ts : r.s, dp = k == p ? tp : r.p;
        for (auto column : {0, 1}) {
            const double above = m[0][column], below = m[1][column];
            m[0][column] = ds * (c * above - s * below);
            m[1][column] = dp * (s * above + c * below);
        }
    }
    return (m[0][0] * m[0][0] + m[0][1] * m[0][1] + m[1][0] * m[1][0] + m[1][1] * m[1][1]) / 2;
}

TEST(Polarisation, ACirclesOrdersAreTheProductsOfMatrices) {
    double worst = 0;
    for (const double eta : {1.33, 1.55, 1.8})
        for (const double theta : {-85., -60., -30., 0., 45., 75., 85.})
            for (const double h : {-0.95, -0.5, 0., 0.2, 0.7, 0.99}) {
                FiberDescription fiber;
                fiber.eta = eta, fiber.polarised = true;
                const FiberHistogram seen = OneRay(fiber, theta * kDegree, 0.3, h);
                for (int p = 0; p <= 5; ++p) {
                    const double expected = ClosedForm(eta, theta * kDegree, h, p);
                    const double miss = std::abs(seen.Albedo(static_cast<size_t>(p), 0) - expected);
                    EXPECT_LT(miss, 1e-9) << "eta " << eta << " theta " << theta << " h " << h << " p " << p;
                    worst = std::max(worst, miss);
                    const SmoothFiber<double> smooth(std::cos(theta * kDegree), eta);
                    EXPECT_NEAR(smooth.PolarisedShare(p, std::asin(h)), expected, 1e-12) << p;
                    const SmoothFiber<float> inFloat(static_cast<float>(std::cos(theta * kDegree)),
                                                     static_cast<float>(eta));
                    EXPECT_NEAR(inFloat.PolarisedShare(p, static_cast<float>(std::asin(h))), expected, 2e-5);
                }
                EXPECT_NEAR(seen.Albedo(seen.Sum(), 0) + seen.Lost(), 1, 1e-9);
            }
    std::printf("polarised orders of a circle are those of the closed form within %.1e\n", worst);
}

// At theta = 0 all planes of incidence are one, and the two polarisations stay apart, as in every textbook:
// each has its own reflectance R and (1 - R)^2 R^(p-1). Over the whole width, light is averaged at the end
// and not at each bounce: TRT of hair is 0.0508 then, and not 0.0557.
TEST(Polarisation, AtRightAnglesTheTwoPolarisationsStayApart) {
    FiberDescription fiber;
    FiberMeasurement m;
    m.samples = 200'000, m.orders = 4, m.cells = {1, 1};
    fiber.polarised = true;
    const FiberHistogram polarised = SimulateFiber(fiber, {}, m);
    fiber.polarised = false;
    const FiberHistogram averaged = SimulateFiber(fiber, {}, m);
    const GaussLegendreRule &rule = GaussLegendre(64);
    for (size_t p = 1; p <= 3; ++p) {
        const auto path = [p](double r) { return Sqr(1 - r) * std::pow(r, static_cast<double>(p) - 1); };
        double apart = 0, mixed = 0;
        for (size_t i = 0; i < rule.x.size(); ++i) {
            const double gamma = kPi<double> / 2 * rule.x[i];
            const double weight = kPi<double> / 4 * rule.w[i] * std::cos(gamma);
            const Amplitudes r(1.55, 0, std::sin(gamma));
            apart += weight * (path(r.s * r.s) + path(r.p * r.p)) / 2;
            mixed += weight * path((r.s * r.s + r.p * r.p) / 2);
        }
        EXPECT_NEAR(polarised.Albedo(p, 0), apart, 5 * polarised.AlbedoError(p, 0)) << p;
        EXPECT_NEAR(averaged.Albedo(p, 0), mixed, 5 * averaged.AlbedoError(p, 0)) << p;
        if (p == 2) {
            EXPECT_NEAR(apart, 0.0508, 5e-5);
            EXPECT_NEAR(mixed, 0.0557, 5e-5);
        }
    }
}

// --- any section: fields instead of Stokes parameters ------------------------------------------------------

// A ray with the fields of two independent polarisations, as vectors in space.
struct FieldRay {
    double y, z;
    Vector3d w;
    Complex field[2][3];
    double Power() const {
        double sum = 0;
        for (const auto &f : field)
            for (const Complex &x : f)
                sum += std::norm(x) / 2;
        return sum;
    }
};

// Reflects and refracts at a smooth surface whose normal looks against the ray: n1 on this side, n2 beyond.
// Returns whether all is reflected.
bool Interface(const FieldRay &ray, const Vector3d &n, double n1, double n2, FieldRay *back,
               FieldRay *beyond) {
    const double c1 = -Dot(ray.w, n), sin2 = n1 / n2 * std::sqrt(std::max(0., 1 - c1 * c1));
    const bool total = sin2 > 1;
    const Complex c2 = std::sqrt(Complex(1 - sin2 * sin2, 0));
    const Complex rs = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2),
                  rp = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
    *back = *beyond = ray;
    back->w = ray.w + n * (2 * c1);
    beyond->w = Normalize((ray.w + n * c1) * (n1 / n2) - n * c2.real());
    const Vector3d s = Normalize(Cross(ray.w, n)), p = Cross(s, ray.w), pBack = Cross(s, back->w),
                   pBeyond = Cross(s, beyond->w);
    for (int k = 0; k < 2; ++k) {
        const Complex *f = ray.field[k];
        const Complex es = f[0] * s.x + f[1] * s.y + f[2] * s.z, ep = f[0] * p.x + f[1] * p.y + f[2] * p.z;
        const double ts = std::sqrt(std::max(0., 1 - std::norm(rs))),
                     tp = std::sqrt(std::max(0., 1 - std::norm(rp)));
        for (int i = 0; i < 3; ++i) {
            back->field[k][i] = rs * es * s[i] + rp * ep * pBack[i];
            beyond->field[k][i] = ts * es * s[i] + tp * ep * pBeyond[i];
        }
    }
    return total;
}

// The shares of orders 0 to 5 of a smooth clear ellipse with semi-axes a and b; counts total reflections.
std::array<double, 6> TraceFields(double a, double b, double eta, double theta, double psi, double h,
                                  int *totals) {
    const double offset = -h * std::hypot(a * std::sin(psi), b * std::cos(psi));
    const auto meet = [&](double y, double z, double wy, double wz, double sign) {
        const double qa = wy * wy / (a * a) + wz * wz / (b * b), qb = y * wy / (a * a) + z * wz / (b * b),
                     qc = y * y / (a * a) + z * z / (b * b) - 1;
        return (-qb + sign * std::sqrt(qb * qb - qa * qc)) / qa;
    };
    FieldRay ray{};
    ray.w = {-std::sin(theta), -std::cos(theta) * std::cos(psi), -std::cos(theta) * std::sin(psi)};
    const double y0 = -offset * std::sin(psi) - 9 * ray.w.y, z0 = offset * std::cos(psi) - 9 * ray.w.z;
    const double t = meet(y0, z0, ray.w.y, ray.w.z, -1);
    ray.y = y0 + t * ray.w.y, ray.z = z0 + t * ray.w.z;
    Vector3d e0, e1;
    CoordinateSystem(ray.w, &e0, &e1);
    for (int i = 0; i < 3; ++i)
        ray.field[0][i] = e0[i], ray.field[1][i] = e1[i];
    const auto outward = [&](const FieldRay &r) {
        return Normalize(Vector3d(0, r.y / (a * a), r.z / (b * b)));
    };
    std::array<double, 6> shares{};
    FieldRay back, beyond;
    Interface(ray, outward(ray), 1, eta, &back, &beyond);
    shares[0] = back.Power();
    for (size_t p = 1; p < 6; ++p) {
        ray = beyond;
        const double way = meet(ray.y, ray.z, ray.w.y, ray.w.z, 1);
        ray.y += way * ray.w.y, ray.z += way * ray.w.z;
        const bool total = Interface(ray, -outward(ray), eta, 1, &back, &beyond);
        *totals += total;
        shares[p] = total ? 0 : beyond.Power();
        beyond = back;
    }
    return shares;
}

TEST(Polarisation, EllipsesTurnPhasesWhereTheyReflectAll) {
    int totals = 0, leftAfterwards = 0;
    double worst = 0, fromAveraged = 0;
    for (const double ratio : {0.45, 0.8, 2.2})
        for (const double theta : {-60., -20., 40., 75.})
            for (const double phi : {0.3, 1.2, 2.9})
                for (const double h : {-0.9, -0.45, 0.1, 0.6, 0.85}) {
                    FiberDescription fiber;
                    fiber.axisRatio = ratio, fiber.rotation = 0.4, fiber.polarised = true;
                    const FiberHistogram seen = OneRay(fiber, theta * kDegree, phi, h);
                    fiber.polarised = false;
                    const FiberHistogram mixed = OneRay(fiber, theta * kDegree, phi, h);
                    const int before = totals;
                    const std::array<double, 6> expected = TraceFields(
                        1 / std::sqrt(ratio), std::sqrt(ratio), 1.55, theta * kDegree, phi - 0.4, h, &totals);
                    leftAfterwards += totals > before && expected[5] > 1e-3;
                    for (size_t p = 0; p < 6; ++p) {
                        const double miss = std::abs(seen.Albedo(p, 0) - expected[p]);
                        EXPECT_LT(miss, 1e-9) << "axis ratio " << ratio << " theta " << theta << " phi "
                                              << phi << " h " << h << " p " << p;
                        worst = std::max(worst, miss);
                        fromAveraged = std::max(fromAveraged, std::abs(mixed.Albedo(p, 0) - expected[p]));
                    }
                }
    EXPECT_GT(totals, 20) << "the test sees no total reflection";
    EXPECT_GT(leftAfterwards, 5) << "no light leaves after a total reflection";
    EXPECT_GT(fromAveraged, 0.02);
    std::printf("polarised orders of ellipses are those of traced fields within %.1e; %d total reflections; "
                "averaged: off by %.3f of the light\n",
                worst, totals, fromAveraged);
}

// A core that scatters takes the memory away: what it has touched goes on as if it came unpolarised, and
// without absorption all light is still there.
TEST(Polarisation, NothingIsLost) {
    FiberDescription fiber;
    fiber.polarised = true, fiber.axisRatio = 0.75, fiber.alpha = 4 * kDegree;
    fiber.roughnessU = 0.2, fiber.roughnessV = 0.3;
    for (const double medulla : {0., 0.4}) {
        fiber.medullaRatio = medulla, fiber.medullaSigmaS = 1;
        for (const double theta : {-60., 0., 75.}) {
            FiberMeasurement m;
            m.samples = 20'000, m.cells = {1, 1};
            const FiberHistogram seen = SimulateFiber(fiber, {theta * kDegree, 0.3, {}}, m);
            EXPECT_NEAR(seen.Albedo(seen.Sum(), 0), 1, 5 * seen.AlbedoError(seen.Sum(), 0) + 1e-12) << theta;
            EXPECT_LT(seen.AlbedoError(seen.Sum(), 0), 1e-3);
            EXPECT_EQ(seen.Lost(), 0);
        }
    }
}

} // namespace
} // namespace cuticle
