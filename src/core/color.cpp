#include "core/color.h"

#include "core/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cuticle {

namespace {

constexpr int lambdaMin = 360, lambdaMax = 830, lambdaStep = 5;
constexpr size_t nTabulated = (lambdaMax - lambdaMin) / lambdaStep + 1;

// x-bar, y-bar, z-bar of the CIE 1931 2-degree standard colorimetric observer, 360 to 830 nm in steps of 5
// nm: the table of CIE 15 (as the Colour and Vision Research Laboratory distributes it). The tests compare
// its sums with the published ones and every row with the fit of Wyman, Sloan and Shirley 2013.
constexpr std::array<std::array<double, 3>, nTabulated> observer = {{
    // clang-format off
    {0.000129900000, 0.000003917000, 0.000606100000}, // 360 nm
    {0.000232100000, 0.000006965000, 0.001086000000},
    {0.000414900000, 0.000012390000, 0.001946000000},
    {0.000741600000, 0.000022020000, 0.003486000000},
    {0.001368000000, 0.000039000000, 0.006450001000}, // 380
    {0.002236000000, 0.000064000000, 0.010549990000},
    {0.004243000000, 0.000120000000, 0.020050010000},
    {0.007650000000, 0.000217000000, 0.036210000000},
    {0.014310000000, 0.000396000000, 0.067850010000}, // 400
    {0.023190000000, 0.000640000000, 0.110200000000},
    {0.043510000000, 0.001210000000, 0.207400000000},
    {0.077630000000, 0.002180000000, 0.371300000000},
    {0.134380000000, 0.004000000000, 0.645600000000}, // 420
    {0.214770000000, 0.007300000000, 1.039050100000},
    {0.283900000000, 0.011600000000, 1.385600000000},
    {0.328500000000, 0.016840000000, 1.622960000000},
    {0.348280000000, 0.023000000000, 1.747060000000}, // 440
    {0.348060000000, 0.029800000000, 1.782600000000},
    {0.336200000000, 0.038000000000, 1.772110000000},
    {0.318700000000, 0.048000000000, 1.744100000000},
    {0.290800000000, 0.060000000000, 1.669200000000}, // 460
    {0.251100000000, 0.073900000000, 1.528100000000},
    {0.195360000000, 0.090980000000, 1.287640000000},
    {0.142100000000, 0.112600000000, 1.041900000000},
    {0.095640000000, 0.139020000000, 0.812950100000}, // 480
    {0.057950010000, 0.169300000000, 0.616200000000},
    {0.032010000000, 0.208020000000, 0.465180000000},
    {0.014700000000, 0.258600000000, 0.353300000000},
    {0.004900000000, 0.323000000000, 0.272000000000}, // 500
    {0.002400000000, 0.407300000000, 0.212300000000},
    {0.009300000000, 0.503000000000, 0.158200000000},
    {0.029100000000, 0.608200000000, 0.111700000000},
    {0.063270000000, 0.710000000000, 0.078249990000}, // 520
    {0.109600000000, 0.793200000000, 0.057250010000},
    {0.165500000000, 0.862000000000, 0.042160000000},
    {0.225749900000, 0.914850100000, 0.029840000000},
    {0.290400000000, 0.954000000000, 0.020300000000}, // 540
    {0.359700000000, 0.980300000000, 0.013400000000},
    {0.433449900000, 0.994950100000, 0.008749999000},
    {0.512050100000, 1.000000000000, 0.005749999000},
    {0.594500000000, 0.995000000000, 0.003900000000}, // 560
    {0.678400000000, 0.978600000000, 0.002749999000},
    {0.762100000000, 0.952000000000, 0.002100000000},
    {0.842500000000, 0.915400000000, 0.001800000000},
    {0.916300000000, 0.870000000000, 0.001650001000}, // 580
    {0.978600000000, 0.816300000000, 0.001400000000},
    {1.026300000000, 0.757000000000, 0.001100000000},
    {1.056700000000, 0.694900000000, 0.001000000000},
    {1.062200000000, 0.631000000000, 0.000800000000}, // 600
    {1.045600000000, 0.566800000000, 0.000600000000},
    {1.002600000000, 0.503000000000, 0.000340000000},
    {0.938400000000, 0.441200000000, 0.000240000000},
    {0.854449900000, 0.381000000000, 0.000190000000}, // 620
    {0.751400000000, 0.321000000000, 0.000100000000},
    {0.642400000000, 0.265000000000, 0.000049999990},
    {0.541900000000, 0.217000000000, 0.000030000000},
    {0.447900000000, 0.175000000000, 0.000020000000}, // 640
    {0.360800000000, 0.138200000000, 0.000010000000},
    {0.283500000000, 0.107000000000, 0.000000000000},
    {0.218700000000, 0.081600000000, 0.000000000000},
    {0.164900000000, 0.061000000000, 0.000000000000}, // 660
    {0.121200000000, 0.044580000000, 0.000000000000},
    {0.087400000000, 0.032000000000, 0.000000000000},
    {0.063600000000, 0.023200000000, 0.000000000000},
    {0.046770000000, 0.017000000000, 0.000000000000}, // 680
    {0.032900000000, 0.011920000000, 0.000000000000},
    {0.022700000000, 0.008210000000, 0.000000000000},
    {0.015840000000, 0.005723000000, 0.000000000000},
    {0.011359160000, 0.004102000000, 0.000000000000}, // 700
    {0.008110916000, 0.002929000000, 0.000000000000},
    {0.005790346000, 0.002091000000, 0.000000000000},
    {0.004109457000, 0.001484000000, 0.000000000000},
    {0.002899327000, 0.001047000000, 0.000000000000}, // 720
    {0.002049190000, 0.000740000000, 0.000000000000},
    {0.001439971000, 0.000520000000, 0.000000000000},
    {0.000999949300, 0.000361100000, 0.000000000000},
    {0.000690078600, 0.000249200000, 0.000000000000}, // 740
    {0.000476021300, 0.000171900000, 0.000000000000},
    {0.000332301100, 0.000120000000, 0.000000000000},
    {0.000234826100, 0.000084800000, 0.000000000000},
    {0.000166150500, 0.000060000000, 0.000000000000}, // 760
    {0.000117413000, 0.000042400000, 0.000000000000},
    {0.000083075270, 0.000030000000, 0.000000000000},
    {0.000058706520, 0.000021200000, 0.000000000000},
    {0.000041509940, 0.000014990000, 0.000000000000}, // 780
    {0.000029353260, 0.000010600000, 0.000000000000},
    {0.000020673830, 0.000007465700, 0.000000000000},
    {0.000014559770, 0.000005257800, 0.000000000000},
    {0.000010253980, 0.000003702900, 0.000000000000}, // 800
    {0.000007221456, 0.000002607800, 0.000000000000},
    {0.000005085868, 0.000001836600, 0.000000000000},
    {0.000003581652, 0.000001293400, 0.000000000000},
    {0.000002522525, 0.000000910930, 0.000000000000}, // 820
    {0.000001776509, 0.000000641530, 0.000000000000},
    {0.000001251141, 0.000000451810, 0.000000000000},
    // clang-format on
}};

// The integral of y-bar over the table in nm, by the rule that MatchingFunction() is linear between whole nm.
double YIntegral() {
    static const double integral = [] {
        double sum = 0;
        for (int l = lambdaMin; l < lambdaMax; ++l)
            sum += (MatchingFunction(l)[1] + MatchingFunction(l + 1)[1]) / 2;
        return sum;
    }();
    return integral;
}

// The value at wavelength l of a spectrum given by sorted samples: linear between them, constant beyond the
// ends.
double InterpolateSamples(const std::vector<double> &lambda, const std::vector<double> &values, double l) {
    const auto above = std::upper_bound(lambda.begin(), lambda.end(), l);
    if (above == lambda.begin())
        return values.front();
    if (above == lambda.end())
        return values.back();
    const size_t i = static_cast<size_t>(above - lambda.begin());
    const double t = (l - lambda[i - 1]) / (lambda[i] - lambda[i - 1]);
    return Lerp(t, values[i - 1], values[i]);
}

} // namespace

std::array<double, 3> MatchingFunction(double lambda) {
    if (!(lambda >= lambdaMin && lambda <= lambdaMax))
        return {0, 0, 0};
    // Find the interval, and the four rows around it for a cubic through them (shifted inward at the ends)
    const double position = (lambda - lambdaMin) / lambdaStep;
    const size_t first =
        static_cast<size_t>(std::clamp(std::floor(position) - 1, 0.0, double(nTabulated - 4)));
    const double t = position - static_cast<double>(first);
    // Lagrange's weights for the nodes 0, 1, 2, 3
    const std::array<double, 4> weights = {(t - 1) * (t - 2) * (t - 3) / -6, t * (t - 2) * (t - 3) / 2,
                                           t * (t - 1) * (t - 3) / -2, t * (t - 1) * (t - 2) / 6};
    std::array<double, 3> xyz{};
    for (size_t i = 0; i < 4; ++i)
        for (size_t c = 0; c < 3; ++c)
            xyz[c] += weights[i] * observer[first + i][c];
    return xyz;
}

double IlluminantD65(double lambda) {
    constexpr std::array<double, 41> table = {
        49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923,
        108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046, 100,     96.3342, 95.788,  88.6856,
        90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
        74.349,  61.604,  69.8856, 75.087,  63.5927, 46.4182, 66.8054, 63.3828};
    const double place = (lambda - 380) / 10;
    if (!(place >= 0 && place <= 40))
        return 0;
    const size_t i = std::min<size_t>(39, static_cast<size_t>(place));
    const double t = place - static_cast<double>(i);
    return (1 - t) * table[i] + t * table[i + 1];
}

std::array<double, 3> XYZToLab(const std::array<double, 3> &xyz) {
    static const std::array<double, 3> white = RGBToXYZ(Spectrum(1));
    std::array<double, 3> f;
    for (size_t i = 0; i < 3; ++i) {
        const double t = xyz[i] / white[i];
        f[i] = t > 216. / 24389 ? std::cbrt(t) : (24389. / 27 * t + 16) / 116;
    }
    return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

double CIEDE2000(const std::array<double, 3> &lab1, const std::array<double, 3> &lab2) {
    constexpr double degree = kPi<double> / 180;
    const auto pow7 = [](double x) { return std::pow(x, 7); };
    // Stretch a*, so that greys are judged as the eye does.
    const double meanC = (std::hypot(lab1[1], lab1[2]) + std::hypot(lab2[1], lab2[2])) / 2;
    const double g = (1 - std::sqrt(pow7(meanC) / (pow7(meanC) + pow7(25)))) / 2;
    const double a1 = (1 + g) * lab1[1], a2 = (1 + g) * lab2[1];
    const double c1 = std::hypot(a1, lab1[2]), c2 = std::hypot(a2, lab2[2]);
    // Hues in degrees, 0 to 360; of a grey 0.
    const auto hue = [&](double a, double b) {
        const double h = std::atan2(b, a) / degree;
        return h < 0 ? h + 360 : h;
    };
    const double h1 = hue(a1, lab1[2]), h2 = hue(a2, lab2[2]);
    const bool grey = c1 * c2 == 0;
    // The difference the short way round, and the mean on that arc.
    double dh = grey ? 0 : h2 - h1, h = h1 + h2;
    if (!grey) {
        if (std::abs(h1 - h2) > 180)
            h += h < 360 ? 360 : -360;
        h /= 2;
        dh -= dh > 180 ? 360 : dh < -180 ? -360 : 0;
    }
    const double dL = lab2[0] - lab1[0], dC = c2 - c1,
                 dH = 2 * std::sqrt(c1 * c2) * std::sin(dh / 2 * degree);
    const double l = (lab1[0] + lab2[0]) / 2, c = (c1 + c2) / 2, l50 = (l - 50) * (l - 50);
    const double t = 1 - 0.17 * std::cos((h - 30) * degree) + 0.24 * std::cos(2 * h * degree) +
                     0.32 * std::cos((3 * h + 6) * degree) - 0.20 * std::cos((4 * h - 63) * degree);
    const double sL = 1 + 0.015 * l50 / std::sqrt(20 + l50), sC = 1 + 0.045 * c, sH = 1 + 0.015 * c * t;
    const double turn = 30 * std::exp(-std::pow((h - 275) / 25, 2));
    const double rT = -2 * std::sqrt(pow7(c) / (pow7(c) + pow7(25))) * std::sin(2 * turn * degree);
    const double x = dL / sL, y = dC / sC, z = dH / sH;
    return std::sqrt(x * x + y * y + z * z + rT * y * z);
}

// The matrices are pbrt-v3's (Rec. 709 primaries, D65), so that a scene's "xyz" colours mean the same here.
Spectrum XYZToRGB(const std::array<double, 3> &xyz) {
    return {static_cast<float>(3.240479 * xyz[0] - 1.537150 * xyz[1] - 0.498535 * xyz[2]),
            static_cast<float>(-0.969256 * xyz[0] + 1.875991 * xyz[1] + 0.041556 * xyz[2]),
            static_cast<float>(0.055648 * xyz[0] - 0.204043 * xyz[1] + 1.057311 * xyz[2])};
}

std::array<double, 3> RGBToXYZ(const Spectrum &rgb) {
    const double r = rgb[0], g = rgb[1], b = rgb[2];
    return {0.412453 * r + 0.357580 * g + 0.180423 * b, 0.212671 * r + 0.715160 * g + 0.072169 * b,
            0.019334 * r + 0.119193 * g + 0.950227 * b};
}

std::array<double, 3> XYZFromSamples(std::vector<double> lambda, std::vector<double> values) {
    // Refuse what has no meaning
    if (lambda.empty())
        throw Error("a sampled spectrum needs at least one pair of wavelength and value");
    if (lambda.size() != values.size())
        throw Error("a sampled spectrum has {} wavelengths but {} values", lambda.size(), values.size());
    for (size_t i = 0; i < lambda.size(); ++i)
        if (!std::isfinite(lambda[i]) || !std::isfinite(values[i]))
            throw Error("pair {} of a sampled spectrum is not finite", i + 1);

    // Sort by wavelength; equal wavelengths keep their order, which makes them a step
    std::vector<size_t> order(lambda.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return lambda[a] < lambda[b]; });
    std::vector<double> l, v;
    for (const size_t i : order)
        l.push_back(lambda[i]), v.push_back(values[i]);

    // Break the axis at every whole nm and at every sample: in between, both factors are linear, the product
    // is quadratic, and Simpson's rule is exact. (pbrt-v3 sums 471 values at whole nm with weight 470/471:
    // 0.2% less for a constant. Here the constant 1 has Y = 1.)
    std::vector<double> breaks;
    for (int i = lambdaMin; i <= lambdaMax; ++i)
        breaks.push_back(i);
    for (const double x : l)
        if (x > lambdaMin && x < lambdaMax)
            breaks.push_back(x);
    std::sort(breaks.begin(), breaks.end());
    std::array<double, 3> xyz{};
    for (size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i], b = breaks[i + 1], middle = (a + b) / 2;
        if (!(b > a))
            continue;
        // The observer is linear between whole nm; both ends lie in the same such interval
        const double whole = std::min(std::floor(middle), double(lambdaMax - 1));
        const auto left = MatchingFunction(whole), right = MatchingFunction(whole + 1);
        // One-sided values at the ends of the interval, by the two inner points of a linear piece
        const double vm = InterpolateSamples(l, v, middle);
        const double vb = 2 * InterpolateSamples(l, v, (middle + b) / 2) - vm, va = 2 * vm - vb;
        for (size_t c = 0; c < 3; ++c) {
            const auto bar = [&](double x) { return Lerp(x - whole, left[c], right[c]); };
            xyz[c] += (b - a) / 6 * (va * bar(a) + 4 * vm * bar(middle) + vb * bar(b));
        }
    }
    for (double &x : xyz)
        x /= YIntegral();
    return xyz;
}

Spectrum SpectrumFromSamples(std::vector<double> lambda, std::vector<double> values) {
    return XYZToRGB(XYZFromSamples(std::move(lambda), std::move(values)));
}

Spectrum BlackbodyToRGB(double kelvin, double scale) {
    if (!(kelvin > 0) || !std::isfinite(kelvin))
        throw Error("a blackbody needs a temperature above 0 kelvin, not {:f}", kelvin);
    if (!std::isfinite(scale))
        throw Error("the scale of a blackbody is not finite");
    // Planck's law relative to its maximum, lambda^-5 / (exp(c2 / (lambda T)) - 1), from logarithms so that a
    // cold body underflows to 0 and not to 0/0. At the maximum (Wien) c2 / (lambda T) is the root of x = 5 (1
    // - exp(-x)).
    constexpr double c2 = 1.438776877e7; // h c / k in nm K
    constexpr double xMax = 4.965114231744276;
    const auto logPlanck = [](double x) { return 5 * std::log(x) - x - std::log(-std::expm1(-x)); };
    std::vector<double> lambda, values;
    for (int l = lambdaMin; l <= lambdaMax; ++l) {
        lambda.push_back(l);
        values.push_back(std::exp(logPlanck(c2 / (l * kelvin)) - logPlanck(xMax)));
    }
    return SpectrumFromSamples(std::move(lambda), std::move(values)) * static_cast<float>(scale);
}

// IEC 61966-2-1.
float LinearToSRGB(float v) { return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f; }

float SRGBToLinear(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

} // namespace cuticle
