// The chart of I_0, its logarithm and M_p, in every way that papers and renderers compute them.
#include "core/special.h"
#include "fibers/hair_as_printed.h"
#include "fibers/mp.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"

#include <fmt/format.h>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

using Big = boost::multiprecision::cpp_bin_float_50;

// --- the truth, in 50 digits -------------------------------------------------------------------------------

// exp(-x) I_0(x): the power series below x = 80, the asymptotic one above, where its smallest term is of the
// order of exp(-160).
Big ExactI0e(const Big &x) {
    const Big enough("1e-52");
    Big term = 1, sum = 1;
    if (x < 80) {
        for (int k = 1; term > sum * enough; ++k) {
            term *= x * x / (4 * Big(k) * k);
            sum += term;
        }
        return sum * exp(-x);
    }
    for (int k = 1; term > enough; ++k) {
        term *= Big(2 * k - 1) * (2 * k - 1) / (8 * Big(k) * x);
        sum += term;
    }
    return sum / sqrt(2 * boost::math::constants::pi<Big>() * x);
}

// M_p at the angles whose sines and cosines, rounded, are given.
Big ExactMp(double cosI, double cosO, double sinI, double sinO, double variance) {
    const Big v = variance, lengthI = sqrt(Big(cosI) * cosI + Big(sinI) * sinI),
              lengthO = sqrt(Big(cosO) * cosO + Big(sinO) * sinO);
    const Big ci = cosI / lengthI, co = cosO / lengthO, si = sinI / lengthI, so = sinO / lengthO;
    return ExactI0e(ci * co / v) * exp(-(1 - ci * co + si * so) / v) / (v * (1 - exp(-2 / v)));
}

// --- ways to compute I_0 -----------------------------------------------------------------------------------

// d'Eon 2011's sum to i = 10, as renderers that follow it have it: 11 terms.
template <typename T>
T SumOf11(T x) {
    T sum = 1, power = x * x, denominator = 4;
    for (int i = 1; i <= 10; ++i) {
        sum += power / denominator;
        power *= x * x;
        denominator *= 4 * T(i + 1) * T(i + 1);
    }
    return sum;
}
// Pharr's: 10 terms, each with its factorial, squared in integers.
template <typename T>
T SumOf10WithFactorials(T x) {
    T sum = 0, power = 1;
    int64_t factorial = 1, four = 1;
    for (int i = 0; i < 10; ++i) {
        factorial *= i > 1 ? i : 1;
        sum += power / static_cast<T>(four * (factorial * factorial));
        power *= x * x;
        four *= 4;
    }
    return sum;
}
// Abramowitz and Stegun 9.8.1 and 9.8.2 without the exponential: exp(-x) I_0(x) above x = 3.75.
template <typename T>
T HandbookI0e(T x) {
    if (x < T(3.75)) {
        const T t = x / T(3.75), y = t * t;
        return std::exp(-x) *
               (1 +
                y * (T(3.5156229) +
                     y * (T(3.0899424) +
                          y * (T(1.2067492) + y * (T(0.2659732) + y * (T(0.0360768) + y * T(0.0045813)))))));
    }
    const T y = T(3.75) / x;
    const T polynomial =
        T(0.39894228) +
        y * (T(0.01328592) +
             y * (T(0.00225319) +
                  y * (T(-0.00157565) +
                       y * (T(0.00916281) +
                            y * (T(-0.02057706) +
                                 y * (T(0.02635537) + y * (T(-0.01647633) + y * T(0.00392377))))))));
    return polynomial / std::sqrt(x);
}
// The standard library's, as far as it reaches.
double LibraryI0(double x) { return x > 700 ? INFINITY : std::cyl_bessel_i(0., x); }
// The asymptotic logarithm with 1/(8x) where the series has it, outside the factor 1/2.
template <typename T>
T MendedLogI0(T x) {
    if (x > 12)
        return x - T(0.5) * std::log(2 * kPi<T> * x) + 1 / (8 * x);
    return std::log(as_printed::I0(x));
}

// --- ways to compute M_p -----------------------------------------------------------------------------------

// d'Eon et al. 2011, equation 7, letter by letter.
template <typename T>
T Equation7(T cosI, T cosO, T sinI, T sinO, T v) {
    return 1 / std::sinh(1 / v) / (2 * v) * std::exp(-sinI * sinO / v) * SumOf11(cosI * cosO / v);
}
// As printed by Pharr, with the mended logarithm.
template <typename T>
T MendedMp(T cosI, T cosO, T sinI, T sinO, T v) {
    const T a = cosI * cosO / v, b = sinI * sinO / v;
    if (v <= T(0.1))
        return std::exp(MendedLogI0(a) - b - 1 / v + std::log(1 / v));
    return std::exp(-b) * as_printed::I0(a) / (std::sinh(1 / v) * 2 * v);
}

// --- measuring ---------------------------------------------------------------------------------------------

// The quantity that a method computes: I_0, exp(-x) I_0, log I_0 (its absolute error becomes a relative one
// of M_p), or M_p.
enum class BesselForm { Plain, Scaled, Logarithm, Lobe };
// Colours of the methods.
enum BesselFamily { Paper = 1, Renderers = 4, Mended = 3, Library = 7, Ours = 0 };

// The numbers that a method is given, rounded to T: x, or cos theta_i, cos theta_o, sin theta_i, sin theta_o,
// v. exact: exp(-x) I_0(x), or M_p, for the rounded numbers.
template <typename T>
struct Numbers {
    std::array<T, 5> x;
    Big exact;
};
struct BesselArgument {
    Numbers<float> narrow;
    Numbers<double> wide;
    template <typename T>
    const Numbers<T> &As() const {
        if constexpr (std::same_as<T, float>)
            return narrow;
        else
            return wide;
    }
};
struct BesselMethod {
    std::string name;
    BesselFamily family;
    BesselForm form;
    double (*value)(const BesselArgument &);
    bool narrow; // computes in binary32
};

template <typename T, T (*function)(T)>
BesselMethod OfOne(const char *name, BesselFamily family, BesselForm form) {
    return {name, family, form,
            [](const BesselArgument &p) { return static_cast<double>(function(p.As<T>().x[0])); },
            std::same_as<T, float>};
}
template <typename T, T (*function)(T, T, T, T, T)>
BesselMethod OfFive(const char *name, BesselFamily family) {
    const auto value = [](const BesselArgument &p) {
        const auto &x = p.As<T>().x;
        return static_cast<double>(function(x[0], x[1], x[2], x[3], x[4]));
    };
    return {name, family, BesselForm::Lobe, value, std::same_as<T, float>};
}
template <typename T>
T OurLogI0(T x) {
    return x + std::log(I0e(x));
}

// Rounds the numbers; exact computes the truth from the rounded ones.
template <typename Exact>
BesselArgument MakeArgument(const std::array<double, 5> &numbers, Exact exact) {
    BesselArgument p;
    for (size_t i = 0; i < 5; ++i)
        p.narrow.x[i] = static_cast<float>(numbers[i]), p.wide.x[i] = numbers[i];
    p.narrow.exact = exact(p.narrow.x), p.wide.exact = exact(p.wide.x);
    return p;
}

// The relative error; infinite where the method gives no number.
double ErrorOf(const BesselMethod &m, const BesselArgument &p) {
    const double value = m.value(p);
    if (!std::isfinite(value))
        return INFINITY;
    const Big x = m.narrow ? Big(p.narrow.x[0]) : Big(p.wide.x[0]),
              exact = m.narrow ? p.narrow.exact : p.wide.exact;
    Big error;
    switch (m.form) {
    case BesselForm::Plain:
        error = value * exp(-x) / exact - 1;
        break;
    case BesselForm::Scaled:
    case BesselForm::Lobe:
        error = value / exact - 1;
        break;
    case BesselForm::Logarithm:
        error = value - x - log(exact);
        break;
    }
    return static_cast<double>(abs(error));
}

// Fills the table and returns the points of one panel. Times are those of the values that are numbers, in the
// order of v.
std::vector<CostPoint> Measure(const char *quantity, const std::vector<BesselMethod> &methods,
                               const std::vector<BesselArgument> &places, int rounds, Table *table) {
    std::vector<CostPoint> points;
    std::vector<std::vector<BesselArgument>> computed(methods.size());
    std::vector<double> mean(methods.size());
    for (size_t k = 0; k < methods.size(); ++k) {
        double largest = 0;
        for (const BesselArgument &p : places) {
            const double e = ErrorOf(methods[k], p);
            largest = std::max(largest, e);
            if (std::isfinite(e))
                computed[k].push_back(p), mean[k] += e;
        }
        mean[k] /= static_cast<double>(computed[k].size());
        points.push_back({PlainText(methods[k].name), 0, largest, methods[k].family});
    }
    std::vector<std::function<void()>> jobs;
    for (size_t k = 0; k < methods.size(); ++k)
        jobs.push_back([&methods, &computed, k] {
            for (const BesselArgument &p : computed[k])
                Keep(methods[k].value(p));
        });
    const std::vector<double> seconds = TimeInTurns(jobs, rounds);
    for (size_t k = 0; k < methods.size(); ++k) {
        const auto finite = static_cast<double>(computed[k].size()), n = static_cast<double>(places.size());
        points[k].cost = 1e9 * seconds[k] / finite;
        table->Add({quantity, methods[k].name, points[k].error, mean[k], 1 - finite / n, points[k].cost});
    }
    return points;
}

// The largest error of each method at every v; arguments come in blocks of one v.
PlotPanel ErrorAgainstV(const std::vector<BesselMethod> &methods, const std::vector<BesselArgument> &places) {
    PlotPanel panel;
    panel.title = "M_p by roughness variance";
    panel.right = 0.55;
    panel.x = {.label = "v (rad^2)", .log = true, .min = 1e-8, .max = 100};
    panel.y = {.label = "largest relative error", .log = true, .min = 1e-17, .max = 10};
    for (const BesselMethod &m : methods) {
        PlotSeries line;
        line.label = PlainText(m.name);
        line.color = m.family;
        line.dash = m.narrow ? PlotDash::Solid : PlotDash::Dashed;
        for (const BesselArgument &p : places) {
            const double v = p.wide.x[4];
            if (line.x.empty() || v != line.x.back())
                line.x.push_back(v), line.y.push_back(0);
            line.y.back() = std::max(line.y.back(), ErrorOf(m, p));
        }
        panel.series.push_back(line);
    }
    return panel;
}

// Ways to compute I_0, log I_0 and M_p. To add one: write it above as a template, and give it a row here.
using enum BesselForm;
const std::vector<BesselMethod> kI0 = {
    OfOne<float, as_printed::I0<float>>("10 terms (Pharr), float", Paper, Plain),
    OfOne<double, as_printed::I0<double>>("10 terms (Pharr), double", Paper, Plain),
    OfOne<double, SumOf11<double>>("11 terms (d'Eon), double", Paper, Plain),
    OfOne<float, SumOf11<float>>("11 terms (Mitsuba 3, Tungsten), float", Renderers, Plain),
    OfOne<float, SumOf10WithFactorials<float>>("10 terms (pbrt-v3, -v4, Cycles), float", Renderers, Plain),
    OfOne<float, HandbookI0e<float>>("handbook 9.8 (vkdt), scaled, float", Renderers, Scaled),
    OfOne<double, HandbookI0e<double>>("handbook 9.8, scaled, double", Library, Scaled),
    OfOne<double, LibraryI0>("std::cyl_bessel_i to x = 700, double", Library, Plain),
    OfOne<float, I0e<float>>("ours, scaled, float", Ours, Scaled),
    OfOne<double, I0e<double>>("ours, scaled, double", Ours, Scaled),
};
const std::vector<BesselMethod> kLogarithm = {
    OfOne<float, as_printed::LogI0<float>>("d'Eon 2013, Pharr, all renderers, float", Paper, Logarithm),
    OfOne<double, as_printed::LogI0<double>>("the same, double", Paper, Logarithm),
    OfOne<float, MendedLogI0<float>>("with 1/(8x) in its place, float", Mended, Logarithm),
    OfOne<double, MendedLogI0<double>>("with 1/(8x) in its place, double", Mended, Logarithm),
    OfOne<float, OurLogI0<float>>("ours, x + log(scaled), float", Ours, Logarithm),
    OfOne<double, OurLogI0<double>>("ours, x + log(scaled), double", Ours, Logarithm),
};
const std::vector<BesselMethod> kMp = {
    OfFive<float, Equation7<float>>("d'Eon 2011, equation 7, float", Paper),
    OfFive<double, Equation7<double>>("d'Eon 2011, equation 7, double", Paper),
    OfFive<float, as_printed::Mp<float>>("Pharr, all renderers, float", Renderers),
    OfFive<double, as_printed::Mp<double>>("Pharr, double", Paper),
    OfFive<float, MendedMp<float>>("Pharr, logarithms mended, float", Mended),
    OfFive<double, MendedMp<double>>("Pharr, logarithms mended, double", Mended),
    OfFive<float, Mp<float>>("ours, float", Ours),
    OfFive<double, Mp<double>>("ours, double", Ours),
};

// The methods are measured at these: x = 1 / v, the argument at normal incidence; for M_p theta_o over a
// quarter, theta_i up to three widths off the mirror direction.
struct BesselArguments {
    std::vector<BesselArgument> x, mp;
};
BesselArguments ArgumentsOf(bool quick) {
    BesselArguments at;
    for (const double v : Logspace(1e-8, 100, quick ? 41 : 201)) {
        at.x.push_back(MakeArgument({1 / v, 0, 0, 0, 0}, [](const auto &x) { return ExactI0e(x[0]); }));
        for (const double thetaO : {0., 0.4, 0.8, 1.2, 1.5})
            for (const double widths : {-3., -1., 0., 1., 3.}) {
                const double thetaI = std::clamp(-thetaO + widths * std::sqrt(v), -1.57, 1.57);
                at.mp.push_back(
                    MakeArgument({std::cos(thetaI), std::cos(thetaO), std::sin(thetaI), std::sin(thetaO), v},
                                 [](const auto &x) { return ExactMp(x[0], x[1], x[2], x[3], x[4]); }));
            }
    }
    return at;
}

} // namespace

FigureData BesselChart(const FigureOptions &options) {
    const BesselArguments at = ArgumentsOf(options.quick);
    FigureData data{Table({"quantity", "method", "greatest_error", "mean_error_where_finite", "failing_share",
                           "ns_per_value"})};
    const int rounds = options.quick ? 10 : 300;
    const char *const cost = "CPU time of a value (ns)";
    const auto i0Points = Measure("I0", kI0, at.x, rounds * 10, &data.table);
    const auto logPoints = Measure("log I0", kLogarithm, at.x, rounds * 10, &data.table);
    const auto mpPoints = Measure("Mp", kMp, at.mp, rounds, &data.table);
    data.plot.width = 960, data.plot.height = 400;
    data.plot.panels = {
        CostPanel("exp(-x) I_0(x)", cost, "largest relative error", i0Points, 1e-17, 10),
        CostPanel("log I_0(x)", cost, "largest error, absolute", logPoints, 1e-17, 10),
        CostPanel("M_p", cost, "largest relative error", mpPoints, 1e-17, 10),
        ErrorAgainstV({kMp[0], kMp[2], kMp[3], kMp[5], kMp[6], kMp[7]}, at.mp),
    };
    data.checks = {
        {"exp(-x) I_0 of ours in binary32 is off by at most", i0Points[8].error, 0, 5e-7},
        {"exp(-x) I_0 of ours in binary64 is off by at most", i0Points[9].error, 0, 1e-14},
        {"M_p of ours in binary32 is off by at most", mpPoints[6].error, 0, 5e-6},
        {"M_p as printed, in binary32, is off by more than", mpPoints[2].error, 1, INFINITY},
        {"M_p of ours in binary64 is off by at most", mpPoints[7].error, 0, 1e-10},
    };
    data.note = fmt::format(
        "As the renderers have it in binary32, M_p is off by up to a factor of {:.0f} (at v = 10^{{-8}}); "
        "ours by {:.1g}, for {:.2f} of the time. Failures, and errors above 10, are drawn at 10.",
        1 + mpPoints[2].error, mpPoints[6].error, mpPoints[6].cost / mpPoints[2].cost);
    return data;
}

} // namespace cuticle
