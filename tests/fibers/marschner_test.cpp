// Marschner's model: its parts against optics, its sampling exact, its energy what it is.
#include "fibers/marschner.h"
#include "fibers/np.h"

#include "core/angles.h"
#include "core/error.h"
#include "fibers/fiber_laws.h"
#include "fibers/longitudinal_forms.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cuticle {
namespace {

using std::numbers::pi;

laws::Reference ReferenceOf(const MarschnerParameters &p) {
    return [model = Marschner<double>(CheckedMarschner(p))](const Vector3d &wo, const Vector3d &wi) {
        return model.Evaluate(wo, wi);
    };
}

// The places of the lobes, for meshes: along the fiber the three cones, around it the glints of a few
// inclinations.
laws::Peaks PeaksOf(const MarschnerParameters &p, double theta) {
    laws::Peaks peaks;
    for (size_t i = 0; i < 3; ++i)
        peaks.theta.push_back({2 * kDegree * static_cast<double>(p.alpha[i]) - theta,
                               2 * kDegree * std::max(static_cast<double>(p.beta[i]), 0.01)});
    const double eta = p.eta, dark = 2 * std::asin(1 / SmoothFiber<double>(std::cos(theta), eta).etaPrime);
    for (const double off : {0., 0.2}) {
        const SmoothFiber<double> fiber(std::cos(std::min(std::abs(theta) + off, 1.55)), eta);
        const double caustic = WrapAngle(fiber.Phi(2, fiber.TurningPoint(2)));
        for (const double sign : {-1., 1.})
            peaks.phi.push_back({0.6 + sign * caustic, 0.02});
    }
    for (const double sign : {-1., 1.})
        peaks.phi.push_back({0.6 + sign * dark, 0.05});
    return peaks;
}

// The cubic stands in for Snell's law: how far it is off, in gamma_t.
TEST(RootMethods, ErrorOfTheCubic) {
    const auto worst = [](double etaPrime) {
        const double c = std::asin(1 / etaPrime);
        double error = 0;
        for (double g = 0; g <= pi / 2; g += 1e-4)
            error = std::max(error, std::abs(3 * c / pi * g - 4 * c / (pi * pi * pi) * g * g * g -
                                             std::asin(std::sin(g) / etaPrime)));
        return error / kDegree;
    };
    std::printf(
        "Marschner's cubic is off by at most %.3f degrees at eta' 1.5, %.3f at 1.55, %.3f at 1.3, %.3f at "
        "1.165\n",
        worst(1.5), worst(1.55), worst(1.3), worst(1.165));
    EXPECT_LT(worst(1.5), 0.75); // the paper's bound
    EXPECT_GT(worst(1.3), 1.5);  // wet hair
}

// The cubic's roots solve the cubic, all of them; polished they are exact roots; and the exact ones nearly
// all of these.
TEST(RootMethods, PolishedRootsAreExact) {
    size_t found = 0, exact = 0;
    for (const double etaPrime : {1.3, 1.55, 1.8, 1.99, 2.2, 3.})
        for (int p = 0; p < 5; ++p) {
            const SmoothFiber<double> fiber(1, etaPrime);
            for (double phi = -3.14; phi < 3.14; phi += 0.0137) {
                const PathRoots<double> cubic = fiber.Roots(p, phi, RootMethod::Cubic),
                                        polished = fiber.Roots(p, phi, RootMethod::PolishedCubic),
                                        all = fiber.Roots(p, phi);
                for (size_t r = 0; r < cubic.count; ++r) {
                    const double value = PathCubic<double>(p, etaPrime).Value(cubic.gamma[r]) + p * pi;
                    EXPECT_NEAR(std::remainder(value - phi, 2 * pi), 0, 1e-9) << p << " " << etaPrime;
                    EXPECT_LE(std::abs(cubic.gamma[r]), pi / 2);
                }
                for (size_t r = 0; r < polished.count; ++r) {
                    double nearest = 10;
                    for (size_t q = 0; q < all.count; ++q)
                        nearest = std::min(nearest, std::abs(all.gamma[q] - polished.gamma[r]));
                    found += nearest < 1e-4;
                }
                exact += all.count;
            }
        }
    std::printf("polished cubic: %zu of %zu roots\n", found, exact);
    EXPECT_GT(static_cast<double>(found), 0.99 * static_cast<double>(exact));
    EXPECT_LE(found, exact);
}

// Integrates over the circle a function with singularities like 1 / sqrt(x) at the given places: between each
// two of them a substitution whose slope vanishes at both takes them away.
template <typename F>
double OverCircle(std::vector<double> places, F f) {
    std::sort(places.begin(), places.end());
    places.push_back(places.front() + 2 * pi);
    const int n = 500;
    double sum = 0;
    for (size_t k = 0; k + 1 < places.size(); ++k)
        for (int i = 0; i < n; ++i) {
            const double t = (i + 0.5) / n, length = places[k + 1] - places[k];
            sum += f(places[k] + length * t * t * (3 - 2 * t)) * length * 6 * t * (1 - t) / n;
        }
    return sum;
}
// Every ray leaves somewhere: over phi, the densities of the roots add up to the width. Of the polished roots
// some are missing near caustics, and none is counted twice.
TEST(RootMethods, DensitiesAddUpToTheWidth) {
    double least = 1, minEta = 0;
    int minPath = 0;
    for (const double etaPrime : {1.4, 1.55, 2.5})
        for (int p = 0; p < 4; ++p) {
            const SmoothFiber<double> fiber(1, etaPrime);
            const PathCubic<double> cubic(p, etaPrime);
            const double turns[] = {fiber.Phi(p, fiber.TurningPoint(p)) - p * pi,
                                    fiber.Phi(p, pi / 2) - p * pi,
                                    p > 0 ? cubic.Value(cubic.TurningPoint()) : 0};
            std::vector<double> places;
            for (const double x : turns)
                for (const double sign : {-1., 1.})
                    places.push_back(WrapAngle(p * pi + sign * x));
            const auto width = [&](RootMethod method) {
                return OverCircle(places, [&](double phi) {
                    const PathRoots<double> roots = fiber.Roots(p, phi, method);
                    double sum = 0;
                    for (size_t r = 0; r < roots.count; ++r)
                        sum += fiber.Density(p, roots.gamma[r], method);
                    return sum;
                });
            };
            EXPECT_NEAR(width(RootMethod::Exact), 1, 1e-3) << etaPrime << " " << p;
            EXPECT_NEAR(width(RootMethod::Cubic), 1, 1e-3) << etaPrime << " " << p;
            const double polished = width(RootMethod::PolishedCubic);
            EXPECT_LT(polished, 1.001) << etaPrime << " " << p;
            if (polished < least)
                least = polished, minEta = etaPrime, minPath = p;
        }
    std::printf("polished cubic: at least %.3f of the width, p = %d at eta' = %.3g\n", least, minPath,
                minEta);
    EXPECT_GT(least, 0.6);
}

// N_R and N_TT are what passes through the fiber: their integrals over phi are the means of A_p over the
// width.
TEST(Marschner, AzimuthalEnergyIsTheMeanOfTheAttenuation) {
    MarschnerParameters p;
    p.sigmaA = {0, 0.3f, 2};
    const Marschner<double> model(p);
    for (const double cosThetaD : {1., 0.7, 0.2}) {
        const SmoothFiber<double> fiber(cosThetaD, static_cast<double>(p.eta));
        for (int order = 0; order < 2; ++order) {
            const std::array<double, 3> expected = MeanOverWidth<64, double>([&](double gamma) {
                return fiber.Attenuation(order, gamma, {0, static_cast<double>(p.sigmaA[1]), 2}, p.length);
            });
            std::array<double, 3> sum{};
            const int n = 20000;
            for (int i = 0; i < n; ++i) {
                const auto value = model.Azimuthal(order, cosThetaD, 2 * pi * (i + 0.5) / n - pi, 0);
                for (size_t c = 0; c < 3; ++c)
                    sum[c] += value[c] * 2 * pi / n;
            }
            for (size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(sum[c], expected[c], 1e-4 * expected[c]) << order << " " << cosThetaD;
        }
    }
}

// S is symmetric in its two directions, with every parameter in use.
TEST(Marschner, Reciprocity) {
    MarschnerParameters p;
    p.eccentricity = 0.88f, p.axis = 25, p.kd = {0.1f, 0.2f, 0.3f};
    for (const LongitudinalForm form : {LongitudinalForm::HalfAngle, LongitudinalForm::FullAngle}) {
        p.longitudinal = form;
        const Marschner<double> model(p);
        RNG rng(MixBits(3));
        const auto u = [&rng] { return static_cast<double>(rng.UniformFloat()); };
        for (int k = 0; k < 500; ++k) {
            const Vector3d a = laws::Direction(3 * u() - 1.5, 6.28 * u()),
                           b = laws::Direction(3 * u() - 1.5, 6.28 * u());
            const double forth = model.Evaluate(a, b).fCos[0] / std::hypot(b.y, b.z),
                         back = model.Evaluate(b, a).fCos[0] / std::hypot(a.y, a.z);
            EXPECT_NEAR(forth, back, 1e-7 * (forth + back) + 1e-12);
        }
    }
}

// The lobe's direction: with alpha_R < 0, R is shifted toward the root for light from either end.
TEST(Marschner, ScalesTiltTowardTheRoot) {
    MarschnerParameters p;
    p.sigmaA = {1e6f, 1e6f, 1e6f}; // R alone
    const Marschner<double> model(CheckedMarschner(p));
    for (const double thetaO : {-0.7, 0., 0.7}) {
        double best = 0, at = 0;
        for (double theta = -1.5; theta < 1.5; theta += 1e-3) {
            const double value =
                model.Evaluate(laws::Direction(thetaO, 0), laws::Direction(theta, 0)).fCos[0];
            if (value > best)
                best = value, at = theta;
        }
        EXPECT_LT(at + thetaO, -5 * kDegree) << thetaO;
    }
}

// How much of the light comes back at all, with one width for all lobes and eta so high that all is
// reflected.
double EnergyOfReflection(LongitudinalForm form, double width, double theta) {
    const LongitudinalLobe<double> lobe(form, width, 0);
    const Inclination<double> o{std::sin(theta), std::cos(theta)};
    return furnace::Integrate(furnace::ThetaMesh({{-theta, width}}), [&](double t, double *) {
        return lobe.Value(o, {std::sin(t), std::cos(t)}) * std::cos(t);
    });
}
TEST(LongitudinalLobe, EnergyOfTheThreeForms) {
    for (const double degrees : {5., 30.}) {
        double least[3] = {10, 10, 10}, most[3] = {0, 0, 0};
        for (double theta = 0; theta < 1.57; theta += 0.02)
            for (size_t form = 0; form < 3; ++form) {
                const double e =
                    EnergyOfReflection(static_cast<LongitudinalForm>(form), degrees * kDegree, theta);
                least[form] = std::min(least[form], e), most[form] = std::max(most[form], e);
            }
        std::printf(
            "energy at width %g degrees, least to most over theta: half angle %.3f to %.3f, full angle %.3f "
            "to %.3f, spherical %.9f to %.9f\n",
            degrees, least[0], most[0], least[1], most[1], least[2], most[2]);
        EXPECT_NEAR(least[2], 1, 1e-7);
        EXPECT_NEAR(most[2], 1, 1e-7);
        EXPECT_GT(most[0], 1.9); // Marschner's, as printed, doubles the light
        EXPECT_GT(most[1], 1.05);
        EXPECT_LT(least[1], 0.96);
    }
}
// With width sigma of theta_i + theta_o, d'Eon's figure 3 has g(beta; theta_h) at sigma = 2 beta.
TEST(LongitudinalLobe, HalfAngleIsTwiceFullAngle) {
    const Inclination<double> o{0.3, std::sqrt(1 - 0.09)}, i{-0.2, std::sqrt(1 - 0.04)};
    const double theta = std::asin(0.3) + std::asin(-0.2),
                 cosD = std::cos((std::asin(0.3) - std::asin(-0.2)) / 2);
    EXPECT_NEAR(LongitudinalLobe<double>(LongitudinalForm::HalfAngle, 0.2, 0.1).Value(o, i),
                Gaussian(0.1, theta / 2 - 0.05) * i.cos / Sqr(cosD), 1e-12);
    EXPECT_NEAR(LongitudinalLobe<double>(LongitudinalForm::FullAngle, 0.2, 0.1).Value(o, i),
                Gaussian(0.2, theta - 0.1) * i.cos / Sqr(cosD), 1e-12);
}

// An ellipse, traced exactly in the normal plane: where the TRT light of a beam from azimuth phiI turns back.
// Half axes 1 and a; the relative azimuth of the extreme nearest the incidence plane, in degrees.
double EllipseCaustic(double a, double eta, double phiI) {
    struct V {
        double x, y;
    };
    const auto dot = [](V p, V q) { return p.x * q.x + p.y * q.y; };
    const auto normal = [a](V p) {
        const double x = p.x, y = p.y / (a * a), l = std::hypot(x, y);
        return V{x / l, y / l};
    };
    const V in{-std::cos(phiI), -std::sin(phiI)};
    double extreme = 0, before = 0, slope = 0;
    for (int k = -4999; k < 5000; ++k) {
        // The ray's foot on a line through the middle, at right angles to the beam, and its first meeting.
        const double half = std::hypot(std::sin(phiI), a * std::cos(phiI)), s = k / 5000. * half;
        const V foot{-in.y * s, in.x * s};
        const auto meet = [a](V p, V d, bool first) {
            const double A = d.x * d.x + d.y * d.y / (a * a), B = p.x * d.x + p.y * d.y / (a * a),
                         C = p.x * p.x + p.y * p.y / (a * a) - 1,
                         root = std::sqrt(std::max(0., B * B - A * C)), t = (-B + (first ? -root : root)) / A;
            return V{p.x + t * d.x, p.y + t * d.y};
        };
        V p = meet(foot, in, true), n = normal(p);
        const double cosI = -dot(in, n), cosT = std::sqrt(1 - (1 - cosI * cosI) / (eta * eta));
        V d{in.x / eta + n.x * (cosI / eta - cosT), in.y / eta + n.y * (cosI / eta - cosT)};
        p = meet(p, d, false), n = normal(p);
        d = {d.x - 2 * dot(d, n) * n.x, d.y - 2 * dot(d, n) * n.y};
        p = meet(p, d, false), n = normal(p);
        const double cosOut = dot(d, n), sin2 = eta * eta * (1 - cosOut * cosOut);
        if (sin2 >= 1)
            continue;
        const double c = std::sqrt(1 - sin2);
        const V out{eta * d.x + n.x * (c - eta * cosOut), eta * d.y + n.y * (c - eta * cosOut)};
        const double phi = std::remainder(std::atan2(out.y, out.x) - phiI, 2 * pi);
        if (k > -4999 && slope * (phi - before) < 0 && std::abs(phi - before) < 0.01)
            extreme = std::abs(before);
        slope = phi - before, before = phi;
    }
    return extreme / kDegree;
}
TEST(Marschner, EccentricityMovesTheGlintsTheRightWay) {
    MarschnerParameters p;
    const auto caustic = [&](double phiH) {
        const SmoothFiber<double> bent(1, Marschner<double>(CheckedMarschner(p)).EtaStar(phiH));
        return std::abs(WrapAngle(bent.Phi(2, bent.TurningPoint(2)))) / kDegree;
    };
    EXPECT_NEAR(EllipseCaustic(1, 1.55, 0), caustic(0), 0.01);
    p.eccentricity = 0.9f;
    const double along = EllipseCaustic(0.9, 1.55, 0), across = EllipseCaustic(0.9, 1.55, pi / 2);
    std::printf("glints of an ellipse, a = 0.9: traced %.2f and %.2f degrees; eta* %.2f and %.2f", along,
                across, caustic(0), caustic(pi / 2));
    EXPECT_NEAR(caustic(0), along, 1);
    EXPECT_NEAR(caustic(pi / 2), across, 9);
    p.printedEccentricity = true;
    std::printf("; as printed %.2f and %.2f\n", caustic(0), caustic(pi / 2));
    EXPECT_GT(caustic(0), 30);
    EXPECT_LT(caustic(pi / 2), 5);
    p.eccentricity = 0.6f; // eta* would fall below 1
    EXPECT_GE(Marschner<double>(p).EtaStar(0), 1.0);
}

// The caustics' width in h, 2 sqrt(2 w_c / |Phi''|), grows without bound as eta' goes to 2: from where on
// maxH limits it.
TEST(Marschner, TheGlintsAreLimitedBeforeTheyMeet) {
    const MarschnerParameters p;
    const auto width = [](double etaPrime, double wc) {
        const SmoothFiber<double> fiber(1, etaPrime);
        return 2 *
               std::sqrt(2 * wc * kDegree / std::abs(fiber.PhiCurvature(2, std::sin(fiber.TurningPoint(2)))));
    };
    double limited = 2;
    while (limited > 1.1 && width(limited - 1e-3, 1.5) > static_cast<double>(p.maxH))
        limited -= 1e-3;
    std::printf("w_c 1.5 degrees: the glints are limited from eta' = %.2f on\n", limited);
    EXPECT_GT(limited, 1.55);
    EXPECT_LT(limited, 1.95);
}

// The glints' power fades between eta' = 2 and 2 + range, and is limited where the caustics meet.
TEST(Marschner, GlintsAreBoundedWhereCausticsMeet) {
    for (const float wc : {1.5f, 10.f, 25.f}) {
        MarschnerParameters p;
        p.wc = wc, p.sigmaA = {0, 0, 0}, p.kG = 5;
        const Marschner<double> model(p);
        for (double theta = 0; theta < 1.57; theta += 0.003)
            for (double phi = -3.1; phi < 3.14; phi += 0.1) {
                const double n = model.Azimuthal(2, std::cos(theta), phi, 0)[0];
                EXPECT_TRUE(n >= 0 && n < 20 / static_cast<double>(wc)) << theta << " " << phi << " " << n;
            }
        // Beyond the fade N_TRT is the path's own light.
        const double cosThetaD = 0.45;
        const SmoothFiber<double> fiber(cosThetaD, static_cast<double>(p.eta));
        ASSERT_GT(fiber.etaPrime, 2.4);
        const PathRoots<double> roots = fiber.Roots(2, 0.3);
        ASSERT_EQ(roots.count, 1u);
        EXPECT_NEAR(model.Azimuthal(2, cosThetaD, 0.3, 0)[0],
                    fiber.Attenuation(2, roots.gamma[0], {0, 0, 0}, p.length)[0] *
                        fiber.Density(2, roots.gamma[0]),
                    1e-12);
    }
}

// Over the sphere the caustics are curves through the cells, on which quadrature is good to a few parts in
// 1e4 only: n is what that allows.
TEST(Marschner, SamplesFollowThePdf) {
    const int n = 100000;
    const double significance = 0.01;
    std::vector<std::pair<MarschnerParameters, double>> cases;
    const auto add = [&cases](double theta, auto change) {
        MarschnerParameters p;
        change(p);
        cases.emplace_back(CheckedMarschner(p), theta);
    };
    add(0, [](auto &) {});
    add(0.5, [](auto &p) { p.longitudinal = LongitudinalForm::HalfAngle; });
    add(-1, [](auto &p) { p.longitudinal = LongitudinalForm::Spherical; });
    add(1.3, [](auto &p) { p.kd = {0.5f, 0.3f, 0.1f}; });
    add(-1.55, [](auto &p) { p.kG = 0; });
    add(0.3, [](auto &p) { p.eccentricity = 0.85f, p.axis = 40; });
    add(-0.6, [](auto &p) { p.eccentricity = 1.1f, p.kG = 4, p.wc = 10, p.sigmaA = {0, 0, 0}; });
    add(0.2, [](auto &p) { p.roots = RootMethod::Cubic, p.sigmaA = {0, 0.1f, 0.5f}; });
    add(0.8, [](auto &p) { p.roots = RootMethod::PolishedCubic, p.beta = {2, 1, 4}; });
    add(0.4, [](auto &p) { p.sigmaA = {50, 50, 50}; });
    uint64_t seed = 10;
    double smallest = 1, largest = 0;
    for (const auto &[p, theta] : cases) {
        const MarschnerBSDF bsdf(p);
        const laws::SampleTest result =
            laws::ChiSquared(bsdf, ReferenceOf(p), laws::Direction(theta, 0.6), PeaksOf(p, theta), ++seed, n);
        EXPECT_GT(result.p, significance / static_cast<double>(cases.size()))
            << bsdf.ToString() << " theta " << theta << " n " << n << " cells " << result.cells;
        EXPECT_NEAR(result.pdf, 1, 2e-3) << bsdf.ToString() << " theta " << theta;
        smallest = std::min(smallest, result.p), largest = std::max(largest, result.largestWeight);
    }
    std::printf("Marschner: smallest p %.3g of %zu cases, largest weight %.3g\n", smallest, cases.size(),
                largest);
    EXPECT_LT(largest, 40);
}

// Around the fiber alone, with lobes so narrow along it that theta_d is one number: cells end at the
// caustics, and the density is integrated through its singularities.
TEST(Marschner, AzimuthsFollowThePdf) {
    const int n = 300000;
    const double significance = 0.01, theta = 0.3, phiO = 0.6;
    double smallest = 1;
    struct Case {
        RootMethod method;
        float a, kG;
    };
    const Case cases[] = {
        {RootMethod::Exact, 1, 1}, {RootMethod::Cubic, 1, 0.5f}, {RootMethod::Exact, 0.9f, 0}};
    for (const Case &c : cases) {
        MarschnerParameters p;
        p.roots = c.method, p.eccentricity = c.a, p.kG = c.kG, p.sigmaA = {0, 0, 0};
        p.alpha = {0, 0, 0}, p.beta = {0.003f, 0.003f, 0.003f};
        const Marschner<double> model(CheckedMarschner(p));
        const Vector3d wo = laws::Direction(theta, phiO);
        std::vector<double> places;
        const auto add = [&](double etaPrime, int order) {
            const SmoothFiber<double> fiber(1, etaPrime);
            const PathCubic<double> cubic(order, etaPrime);
            for (const double x : {fiber.Phi(order, fiber.TurningPoint(order)), fiber.Phi(order, pi / 2),
                                   cubic.Value(cubic.TurningPoint()) + order * pi})
                for (const double sign : {-1., 1.})
                    places.push_back(WrapAngle(phiO + sign * x));
        };
        add(SmoothFiber<double>(std::cos(theta), model.EtaStar(phiO)).etaPrime, 2);
        add(SmoothFiber<double>(std::cos(theta), 1.55f).etaPrime, 1);
        for (int i = 0; i < 48; ++i)
            places.push_back(pi * (i - 24) / 24);
        std::sort(places.begin(), places.end());
        places.push_back(places.front() + 2 * pi);
        std::vector<double> expected(places.size() - 1), counted(expected.size());
        double sum = 0;
        for (size_t k = 0; k < expected.size(); ++k) {
            const int m = 100;
            for (int i = 0; i < m; ++i) {
                const double t = (i + 0.5) / m, length = places[k + 1] - places[k];
                expected[k] +=
                    length * t * (1 - t) *
                    model.Evaluate(wo, laws::Direction(-theta, places[k] + length * t * t * (3 - 2 * t))).pdf;
            }
            sum += expected[k];
        }
        RNG rng(MixBits(5));
        const auto u = [&rng] { return (static_cast<double>(rng.UniformUInt32()) + 0.5) / 4294967296.; };
        for (int k = 0; k < n; ++k) {
            Vector3d wi;
            model.Sample(wo, {u(), u(), u(), u()}, &wi);
            double azimuth = std::atan2(wi.z, wi.y);
            azimuth += azimuth < places.front() ? 2 * pi : 0;
            ++counted[static_cast<size_t>(std::upper_bound(places.begin() + 1, places.end() - 1, azimuth) -
                                          places.begin()) -
                      1];
        }
        double chiSquared = 0, e = 0, o = 0;
        int cells = 0;
        for (size_t k = 0; k < expected.size(); ++k) {
            e += expected[k] / sum * n, o += counted[k];
            if (e > 50)
                chiSquared += (o - e) * (o - e) / e, ++cells, e = o = 0;
        }
        const double chance = boost::math::gamma_q((cells - 1) / 2., chiSquared / 2);
        EXPECT_GT(chance, significance / std::size(cases))
            << static_cast<int>(c.method) << " a " << c.a << " n " << n << " cells " << cells;
        smallest = std::min(smallest, chance);
    }
    std::printf("Marschner around the fiber: smallest p %.3g\n", smallest);
}

TEST(Marschner, BadInput) {
    MarschnerParameters p;
    p.beta[1] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(MarschnerBSDF{p}, Error);
    p = {};
    p.eta = Infinity;
    EXPECT_THROW(MarschnerBSDF{p}, Error);
    p = {};
    p.eta = 0, p.beta = {0, -1, 1e9f}, p.wc = 0, p.etaRange = 0, p.eccentricity = 0, p.maxH = -1;
    float pdf = 0;
    Vector3f wi;
    for (const MarschnerParameters &q : {p, MarschnerParameters{}})
        for (const Vector3f &w :
             {Vector3f(1, 0, 0), Vector3f(-1, 0, 0), Vector3f(0, 1, 0), Vector3f(0, 0, -1)}) {
            const MarschnerBSDF bsdf(q);
            EXPECT_TRUE((bsdf.FPdf(w, {-1, 0, 0}, &pdf) * 1e-20f).IsFinite());
            for (const float u : {0.f, 0.4f, 0.9f, 1.f}) {
                EXPECT_TRUE(bsdf.Sample_f(w, &wi, {u, 1.f, 0.f, 0.5f}, &pdf).IsFinite());
                EXPECT_NEAR(wi.Length(), 1, 1e-5);
            }
        }
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(MarschnerBSDF(MarschnerParameters{}).f({nan, 0, 1}, {0, 0, 1}).HasNaNs());
}

} // namespace
} // namespace cuticle
