// The atlas's maps along the fiber: the Bessel function, M_p and its sampling. Faults 1 to 5 and 15.
#include "fibers/hair_as_printed.h"
#include "fibers/longitudinal_forms.h"
#include "figures/atlas/atlas.h"
#include "figures/atlas/atlas_fibers.h"

namespace cuticle {

namespace {

AtlasAxis Roughness(double exponent, const AtlasOptions &o) {
    return {"β_m", "beta_m", exponent, 0, o.quick ? size_t(10) : size_t(40), true};
}
AtlasAxis Inclination(const AtlasOptions &o) {
    return {"θ_o (degrees)", "theta_o_deg", 0, 90, o.quick ? size_t(9) : size_t(30)};
}

double RelativeError(double value, long double exact) {
    return std::abs(static_cast<double>((static_cast<long double>(value) - exact) / exact));
}

// As M_p uses it: a = cos^2 theta / v.
AtlasMap BesselMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "bessel", map.title = "I_0 as M_p uses it, of cos^{2}θ / v";
    map.quantity = "relative error";
    map.x = {"variance v", "v", -3, 1, o.quick ? size_t(12) : size_t(40), true};
    map.y = Inclination(o);
    map.min = 1e-16, map.max = 1e-1;
    const auto error = [](auto type, bool published, double v, double theta) {
        using T = decltype(type);
        const T a = static_cast<T>(Sqr(std::cos(theta * kDegree)) / v);
        const T value = !published ? I0e(a)
                        : v <= 0.1 ? std::exp(as_printed::LogI0(a) - a)
                                   : as_printed::I0(a) * std::exp(-a);
        return RelativeError(static_cast<double>(value), I0e(static_cast<long double>(a)));
    };
    map.panels = FourPanels(map, error);
    // The two faults lie on the two sides of a = 12.
    double series = 0, logarithm = 0, ours[2] = {0, 0}, inDouble[2] = {0, 0};
    for (size_t i = 0; i < map.x.cells * map.y.cells; ++i) {
        const double a = Sqr(std::cos(map.y.At(i / map.x.cells) * kDegree)) / map.x.At(i % map.x.cells);
        double &published = a > 12 ? logarithm : series;
        published = std::max(published, map.panels[0].values[i]);
        ours[a > 12] = std::max(ours[a > 12], map.panels[3].values[i]);
        inDouble[a > 12] = std::max(inDouble[a > 12], map.panels[2].values[i]);
    }
    // and next to it, which no cell's middle meets
    const double at12 = error(double(), true, 1 / 12., 0), after12 = error(double(), true, 1 / 12.0000001, 0);
    map.findings = {{1, "largest error of exp(-x) I_0(x) up to x = 12; ours in float", std::max(series, at12),
                     ours[0], false, inDouble[0]},
                    {2, "largest error of exp(-x) I_0(x) beyond x = 12; ours in float",
                     std::max(logarithm, after12), ours[1], false, inDouble[1]}};
    return map;
}

// |integral of M_p cos theta_i dtheta_i - 1|, M_p in T.
template <typename T>
double MassError(bool published, double betaM, double thetaO) {
    const T v = LongitudinalVariance(static_cast<T>(betaM))[0];
    const ThetaRule rule = MakeThetaRule({{-thetaO, std::sqrt(static_cast<double>(v))}}, 16);
    const T sinO = static_cast<T>(std::sin(thetaO)), cosO = static_cast<T>(std::cos(thetaO));
    double sum = 0;
    for (size_t i = 0; i < rule.theta.size(); ++i) {
        const T s = static_cast<T>(std::sin(rule.theta[i])), c = static_cast<T>(std::cos(rule.theta[i]));
        const T m = published ? as_printed::Mp(c, cosO, s, sinO, v) : Mp(c, cosO, s, sinO, v);
        sum += rule.weight[i] * std::cos(rule.theta[i]) * static_cast<double>(m);
    }
    return std::abs(sum - 1);
}

AtlasMap MassMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "mp-energy", map.title = "Energy of the R lobe's M_p";
    map.quantity = "|integral - 1|";
    map.x = Roughness(-2, o), map.y = Inclination(o);
    map.min = 1e-10, map.max = 1;
    map.panels = FourPanels(map, [](auto type, bool published, double beta, double theta) {
        return MassError<decltype(type)>(published, beta, theta * kDegree);
    });
    map.findings = {
        {3, "largest |E - 1|, double", WorstOf(map.panels[0].values), WorstOf(map.panels[2].values)},
        {3, "largest |E - 1|, float", WorstOf(map.panels[1].values), WorstOf(map.panels[3].values), false,
         WorstOf(map.panels[2].values)}};
    return map;
}

AtlasMap PeakMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "mp-peak", map.title = "M_p of the R lobe at its peak, θ_i = -θ_o";
    map.quantity = "relative error";
    map.x = Roughness(-4, o), map.y = Inclination(o);
    map.min = 1e-16, map.max = 1e2;
    map.panels = FourPanels(map, [](auto type, bool published, double beta, double theta) {
        using T = decltype(type);
        const long double angle = theta * kDegree;
        const T v = LongitudinalVariance(static_cast<T>(beta))[0];
        const T s = static_cast<T>(std::sin(angle)), c = static_cast<T>(std::cos(angle));
        const T m = published ? as_printed::Mp(c, c, -s, s, v) : Mp(c, c, -s, s, v);
        const long double exact = Mp(std::cos(angle), std::cos(angle), -std::sin(angle), std::sin(angle),
                                     static_cast<long double>(v));
        return RelativeError(static_cast<double>(m), exact);
    });
    map.findings = {{4, "largest error at the peak, float", WorstOf(map.panels[1].values),
                     WorstOf(map.panels[3].values), false, WorstOf(map.panels[2].values)}};
    return map;
}

AtlasMap SampledCosineMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "mp-sampling", map.title = "The sampled angle from the cone: 1 - cos of it";
    map.quantity = "relative error";
    map.x = Roughness(-4, o);
    map.y = {"random number u", "u", 0, 1, o.quick ? size_t(9) : size_t(30)};
    map.min = 1e-16, map.max = 1;
    map.panels = FourPanels(map, [](auto type, bool published, double beta, double number) {
        using T = decltype(type);
        const T v = LongitudinalVariance(static_cast<T>(beta))[0], u = static_cast<T>(number);
        const T printed = 1 - (1 + v * std::log(std::max(u, T(1e-5L)) + (1 - u) * std::exp(-2 / v)));
        const long double exact = -SampleMpCosine(static_cast<long double>(u), static_cast<long double>(v));
        return RelativeError(static_cast<double>(published ? printed : -SampleMpCosine(u, v)), exact);
    });
    map.findings = {{5, "largest error of 1 - cos, float", WorstOf(map.panels[1].values),
                     WorstOf(map.panels[3].values), false, WorstOf(map.panels[2].values)}};
    return map;
}

AtlasMap GaussianMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "gaussian-energy", map.title = "Energy of three forms of M";
    map.quantity = "energy, of 1";
    map.x = {"β, deviation of θ_i + θ_o (degrees)", "beta_deg", 0, 60, o.quick ? size_t(10) : size_t(30)};
    map.y = Inclination(o);
    map.log = false, map.min = 0, map.max = 2;
    const auto energy = [](LongitudinalForm form) {
        return [form](double beta, double theta) {
            const double thetaO = theta * kDegree, width = beta * kDegree;
            const LongitudinalLobe<double> lobe(form, width, 0);
            const cuticle::Inclination<double> view{std::sin(thetaO), std::cos(thetaO)};
            const ThetaRule rule = MakeThetaRule({{-thetaO, width}}, 16);
            double sum = 0;
            for (size_t i = 0; i < rule.theta.size(); ++i)
                sum += rule.weight[i] * std::cos(rule.theta[i]) *
                       lobe.Value(view, {std::sin(rule.theta[i]), std::cos(rule.theta[i])});
            return sum;
        };
    };
    map.panels = {{"Gaussian in θ_h", FillMap(map.x, map.y, energy(LongitudinalForm::HalfAngle))},
                  {"Gaussian in θ_i + θ_o", FillMap(map.x, map.y, energy(LongitudinalForm::FullAngle))},
                  {"d'Eon's, ours", FillMap(map.x, map.y, energy(LongitudinalForm::Spherical))}};
    const auto worst = [](std::vector<double> values) {
        for (double &v : values)
            v -= 1;
        return WorstOf(values);
    };
    const double ours = worst(map.panels[2].values);
    map.findings = {
        {15, "largest |E - 1|, Gaussian in theta_h", worst(map.panels[0].values), ours},
        {15, "largest |E - 1|, Gaussian in theta_i + theta_o", worst(map.panels[1].values), ours}};
    return map;
}

} // namespace

std::vector<AtlasMap> LongitudinalMaps(const AtlasOptions &options) {
    return {BesselMap(options), MassMap(options), PeakMap(options), SampledCosineMap(options),
            GaussianMap(options)};
}

} // namespace cuticle
