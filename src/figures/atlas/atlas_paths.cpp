// The atlas's maps of paths through the fiber: A_p, the last lobe, Marschner's cubic, reciprocity,
// polarisation. Faults 7, 8, 9, 12, 13, 16 and 26.
#include "fibers/ap.h"
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"
#include "figures/atlas/atlas.h"

#include <limits>

namespace cuticle {

namespace {

constexpr double kEta = 1.55;

size_t Cells(const AtlasOptions &o) { return o.quick ? 10 : 30; }

// Pharr's listing: the sines and cosines that it forms, from sin theta alone, and the series' rest divided as
// printed. In long double, and told the cosine, it is the truth of these maps: nothing of ours is in it.
template <typename T>
struct PrintedPath {
    PrintedPath(T sinThetaO, T h, T sigma)
        : PrintedPath(sinThetaO, std::sqrt(std::max(T(0), 1 - Sqr(sinThetaO))), h, sigma) {}
    PrintedPath(T sinThetaO, T cosThetaO, T h, T sigma) {
        const T eta = static_cast<T>(kEta);
        const T cosThetaT = std::sqrt(std::max(T(0), 1 - Sqr(sinThetaO / eta)));
        const T etaPrime = std::sqrt(eta * eta - Sqr(sinThetaO)) / cosThetaO, sinGammaT = h / etaPrime;
        const T cosGammaT = std::sqrt(std::max(T(0), 1 - Sqr(sinGammaT)));
        const T t = std::exp(-sigma * (2 * cosGammaT / cosThetaT));
        const T cosine = cosThetaO * std::sqrt(std::max(T(0), 1 - h * h));
        const T inside = std::sqrt(std::max(T(0), 1 - (1 - cosine * cosine) / (eta * eta)));
        const T parallel = (eta * cosine - inside) / (eta * cosine + inside),
                across = (cosine - eta * inside) / (cosine + eta * inside);
        const T f = (parallel * parallel + across * across) / 2;
        transmitted = Sqr(1 - f) * t;
        tail = transmitted * t * f * f * t / (1 - t * f);
    }
    T transmitted, tail; // A_1, A_3
};
template <typename T>
struct OurPath {
    OurPath(T cosThetaO, T h, T sigma) {
        const T eta = static_cast<T>(kEta);
        const Refraction<T> inside =
            Refract(cosThetaO, h, std::sqrt((1 - h) * (1 + h)), eta, (eta - 1) * (eta + 1));
        const FresnelPair<T> f = Fresnel(inside.cosIncident, inside.t, eta);
        const T depth = sigma * inside.length;
        const auto ap = Ap(f.f, f.oneMinusF, std::exp(-depth), -std::expm1(-depth));
        transmitted = ap[1], tail = ap[3];
    }
    T transmitted, tail;
};

// The error of a share, relative to 1, the light that comes in: shares themselves may vanish.
double ErrorOf(double value, long double exact) { return std::abs(static_cast<double>(value - exact)); }

AtlasMap EdgeMap(const AtlasOptions &) {
    AtlasMap map;
    map.name = "edge",
    map.title = "The rest of the series, A_{3}, towards the edge of a clear fiber (θ_o = 30°)";
    map.quantity = "error, of 1";
    map.x = {"digits of 9 in h; 10 to 11: h = 1", "nines_of_h", 0, 11, 11};
    map.y = {"absorption σ_a", "sigma_a", -9, 1, 10, true};
    map.min = 1e-18, map.max = 1;
    const auto error = [](auto type, bool published, double x, double sigma) {
        using T = decltype(type);
        const long double nines = std::floor(x),
                          away = nines >= 10 ? 0 : std::pow(10.L, -nines - (nines == 0 ? 0.3L : 0));
        const T h = static_cast<T>(1 - away);
        const long double theta = 30 * kDegree;
        const long double exact = PrintedPath<long double>(std::sin(theta), std::cos(theta), h, sigma).tail;
        const T s = static_cast<T>(sigma);
        const T value = published ? PrintedPath<T>(static_cast<T>(std::sin(theta)), h, s).tail
                                  : OurPath<T>(static_cast<T>(std::cos(theta)), h, s).tail;
        return ErrorOf(static_cast<double>(value), exact);
    };
    map.panels = FourPanels(map, error);
    map.findings = {{7, "largest error of A_3, float (inf: NaN)", WorstOf(map.panels[1].values),
                     WorstOf(map.panels[3].values), false, WorstOf(map.panels[2].values)}};
    return map;
}

AtlasMap GrazingMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "grazing",
    map.title = "Light that passes straight through, A_{1}, for a viewer near the fiber's axis";
    map.quantity = "error, of A_{1}";
    map.x = {"digits: 90° - θ_o = 10^{-x} rad", "digits", 0, 6, o.quick ? size_t(6) : size_t(30)};
    map.y = {"offset h", "h", -1, 1, Cells(o)};
    map.min = 1e-16, map.max = 10;
    const auto error = [](auto type, bool published, double digits, double offset) {
        using T = decltype(type);
        const long double away = std::pow(10.L, static_cast<long double>(-digits));
        const T h = static_cast<T>(offset);
        const long double exact =
            PrintedPath<long double>(std::cos(away), std::sin(away), h, 0.1L).transmitted;
        const T sigma = static_cast<T>(0.1L);
        const T value = published ? PrintedPath<T>(static_cast<T>(std::cos(away)), h, sigma).transmitted
                                  : OurPath<T>(static_cast<T>(std::sin(away)), h, sigma).transmitted;
        return ErrorOf(static_cast<double>(value), exact) / static_cast<double>(exact);
    };
    map.panels = FourPanels(map, error);
    // The loop that wraps by whole turns stands still where a turn is less than half a unit in the last
    // place.
    double stuck = 1;
    while (static_cast<float>(stuck) - 2 * static_cast<float>(kPi<double>) != static_cast<float>(stuck))
        stuck *= 2;
    const auto wrapped = static_cast<double>(std::abs(WrapAngle(static_cast<float>(stuck))));
    map.findings = {
        {8, "largest relative error of A_1, float", WorstOf(map.panels[1].values),
         WorstOf(map.panels[3].values), false, WorstOf(map.panels[2].values)},
        {8, "an angle from which on the wrapping loop never ends; what ours makes of it", stuck, wrapped}};
    return map;
}

AtlasMap LastLobeMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "last-lobe",
    map.title = "Orders without a lobe of their own, which one uniform lobe stands for";
    map.quantity = "share of all light";
    map.x = {"θ_o (degrees)", "theta_o_deg", 0, 90, Cells(o)};
    map.y = {"absorption σ_a", "sigma_a", -3, 1, Cells(o), true};
    map.min = 1e-6, map.max = 1;
    // The mean over the width, where lobesAt(h, sigma, cos theta) orders have a lobe.
    const auto share = [](const auto &lobesAt) {
        return [=](double theta, double sigma) {
            const double cosTheta = std::cos(theta * kDegree);
            const SmoothFiber<double> fiber(cosTheta, kEta);
            const std::array<double, 3> s = {sigma, sigma, sigma};
            const auto mean = MeanOverWidth<40, double>([&](double gamma) {
                const int lobes = lobesAt(std::sin(gamma), sigma, cosTheta);
                return std::array<double, 3>{fiber.Tail(lobes, gamma, s, SegmentLength::Chord)[0],
                                             fiber.Tail(1, gamma, s, SegmentLength::Chord)[0],
                                             fiber.Attenuation(0, gamma, s, SegmentLength::Chord)[0]};
            });
            return mean[0] / (mean[1] + mean[2]);
        };
    };
    constexpr double kTailShare = 0.01;
    const auto three = [](double, double, double) { return 3; };
    const auto chosen = [](double h, double sigma, double cosTheta) {
        DEonParameters p;
        p.lobes = 16;
        p.h = static_cast<float>(h);
        p.sigmaA.fill(static_cast<float>(sigma));
        return ChosenLobes<double>(p, kTailShare).LobesAt(cosTheta);
    };
    map.panels = {{"as published, and ours: three lobes", FillMap(map.x, map.y, share(three))},
                  {"ours, a hundredth for the tail: up to 16 lobes", FillMap(map.x, map.y, share(chosen))}};
    const double worst = WorstOf(map.panels[0].values);
    map.findings = {{12, "largest share of orders from 3 on, the default", worst, worst, true},
                    {12, "largest share of orders without a lobe, tail_share 0.01", worst,
                     WorstOf(map.panels[1].values)}};
    return map;
}

AtlasMap CubicMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "cubic", map.title = "Marschner's cubic: γ_t, and the paths TRT that it finds";
    map.quantity = "error (degrees)";
    map.x = {"η'", "eta_prime", 1.2, 3, Cells(o)};
    map.y = {"γ_i (degrees)", "gamma_i_deg", 0, 90, Cells(o)};
    map.min = 1e-10, map.max = 30;
    const auto refraction = [](double eta, double gamma) {
        const double c = std::asin(1 / eta), pi = kPi<double>, g = gamma * kDegree;
        return std::abs(3 * c / pi * g - 4 * c / (pi * pi * pi) * g * g * g - std::asin(std::sin(g) / eta)) /
               kDegree;
    };
    const auto path = [](RootMethod method) {
        return [method](double eta, double gamma) {
            const SmoothFiber<double> fiber(1, eta);
            double nearest = 90;
            const PathRoots<double> roots = fiber.Roots(2, fiber.Phi(2, gamma * kDegree), method);
            for (size_t i = 0; i < roots.count; ++i)
                nearest = std::min(nearest, std::abs(roots.gamma[i] / kDegree - gamma));
            return nearest;
        };
    };
    map.panels = {{"published: γ_t of the cubic", FillMap(map.x, map.y, refraction)},
                  {"published: nearest root of the cubic", FillMap(map.x, map.y, path(RootMethod::Cubic))},
                  {"the cubic's roots, polished", FillMap(map.x, map.y, path(RootMethod::PolishedCubic))},
                  {"ours: all roots", FillMap(map.x, map.y, path(RootMethod::Exact))}};
    map.findings = {{13, "largest error of gamma_t over eta' 1.2 to 3, degrees; of our path",
                     WorstOf(map.panels[0].values), WorstOf(map.panels[3].values)},
                    {13, "largest error of a path (gamma_i), degrees", WorstOf(map.panels[1].values),
                     WorstOf(map.panels[3].values)}};
    return map;
}

AtlasMap AttenuationReciprocityMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "ap-reciprocity", map.title = "A_{TT} over the width at σ_a = 1, which knows θ_o alone";
    map.quantity = "A_{TT}(θ_i) / A_{TT}(θ_o)";
    map.x = {"θ_o (degrees)", "theta_o_deg", 0, 90, Cells(o)};
    map.y = {"θ_i (degrees)", "theta_i_deg", 0, 90, Cells(o)};
    map.min = 1e-2, map.max = 1e2;
    const auto passed = [](double theta) {
        const SmoothFiber<double> fiber(std::cos(theta * kDegree), kEta);
        return MeanOverWidth<40, double>([&](double gamma) {
            return fiber.Attenuation(1, gamma, {1, 1, 1}, SegmentLength::Chord);
        })[0];
    };
    map.panels = {{"as published, and ours", FillMap(map.x, map.y, [&](double theta, double other) {
                       return passed(other) / passed(theta);
                   })}};
    const double at60 = passed(60) / passed(0);
    map.findings = {{16, "A_TT(60 degrees) / A_TT(0), 1 if reciprocal", at60, at60}};
    return map;
}

AtlasMap PolarisationMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "polarisation", map.title = "A_{p} over the width, averaged over polarisations at every "
                                           "bounce, over that with polarisation followed";
    map.quantity = "averaged / followed";
    map.x = {"θ_o (degrees)", "theta_o_deg", 0, 90, Cells(o)};
    map.y = {"index η", "eta", 1.3, 1.8, Cells(o)};
    map.log = false, map.min = 0.5, map.max = 1.5;
    const auto ratio = [](int p, double theta, double eta) {
        const SmoothFiber<double> fiber(std::cos(theta * kDegree), eta);
        const auto means = MeanOverWidth<40, double>([&](double gamma) {
            const double averaged = fiber.Attenuation(p, gamma, {0, 0, 0}, SegmentLength::Chord)[0];
            return std::array<double, 3>{averaged, fiber.PolarisedShare(p, gamma), 0};
        });
        return means[0] / means[1];
    };
    for (const auto &[p, name] : {std::pair{1, "TT"}, {2, "TRT"}, {3, "TRRT"}})
        map.panels.push_back({name, FillMap(map.x, map.y, [&, order = p](double theta, double eta) {
                                  return ratio(order, theta, eta);
                              })});
    const auto finding = [&](int p, double theta, const char *what) {
        const double value = ratio(p, theta, kEta);
        return AtlasFinding{26, what, value, value, true};
    };
    map.findings = {finding(2, 0, "TRT at 0 degrees over its true share"),
                    finding(2, 45, "TRT at 45 degrees over its true share"),
                    finding(2, 75, "TRT at 75 degrees over its true share"),
                    finding(3, 45, "TRRT at 45 degrees over its true share")};
    map.note = "The simulator follows polarisation where it is asked to; the models average.";
    return map;
}

AtlasMap ReflectanceMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "reflectance",
    map.title = "Absorption from a reflectance: Chiang's fit as it stands, and clamped";
    map.quantity = "σ_a";
    map.x = {"reflectance; first cell: 0", "reflectance", 0, 1.4, 28};
    map.y = {"β_n", "beta_n", 0, 1, Cells(o)};
    map.min = 1e-5, map.max = 10;
    const auto printed = [](double c, double b) {
        return Sqr(std::log(c < 0.05 ? 0 : c) / Polynomial(b, 5.969, -0.215, 2.532, -10.73, 5.574, 0.245));
    };
    const auto ours = [](double c, double b) {
        const Spectrum colour(c < 0.05 ? 0.f : static_cast<float>(c));
        return static_cast<double>(HairBSDF::SigmaAFromReflectance(colour, static_cast<float>(b))[0]);
    };
    map.panels = {{"published", FillMap(map.x, map.y, printed)}, {"ours", FillMap(map.x, map.y, ours)}};
    map.findings = {{9, "sigma_a of reflectance 0 at beta_n 0.3", printed(0, 0.3), ours(0, 0.3)},
                    {9, "sigma_a of reflectance 1.4 at beta_n 0.3", printed(1.4, 0.3), ours(1.4, 0.3)}};
    return map;
}

} // namespace

std::vector<AtlasMap> PathMaps(const AtlasOptions &options) {
    return {EdgeMap(options),
            GrazingMap(options),
            LastLobeMap(options),
            CubicMap(options),
            AttenuationReciprocityMap(options),
            PolarisationMap(options),
            ReflectanceMap(options)};
}

} // namespace cuticle
