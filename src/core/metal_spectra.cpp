#include "core/metal_spectra.h"

#include "core/error.h"

#include <span>

namespace cuticle {

namespace {

// The photon energies of Johnson and Christy (both papers), as wavelengths in nm.
constexpr double johnsonChristy[] = {354.2, 367.9, 381.5, 397.4, 413.3, 430.5, 450.9, 471.4, 495.9,
                                     520.9, 548.6, 582.1, 616.8, 659.5, 704.5, 756.0, 821.1, 892.0};
constexpr std::string_view johnsonChristy1972 = "Johnson and Christy 1972"; // Phys. Rev. B 6, 4370, table I
constexpr std::string_view johnsonChristy1974 = "Johnson and Christy 1974"; // Phys. Rev. B 9, 5056, table I

constexpr double agEta[] = {0.10, 0.07, 0.05, 0.05, 0.05, 0.04, 0.04, 0.05, 0.05,
                            0.05, 0.06, 0.05, 0.06, 0.05, 0.04, 0.03, 0.04, 0.04};
constexpr double agK[] = {1.419, 1.657, 1.864, 2.070, 2.275, 2.462, 2.657, 2.869, 3.093,
                          3.324, 3.586, 3.858, 4.152, 4.483, 4.838, 5.242, 5.727, 6.312};
constexpr double auEta[] = {1.50, 1.48, 1.46, 1.47, 1.46, 1.45, 1.38, 1.31, 1.04,
                            0.62, 0.43, 0.29, 0.21, 0.14, 0.13, 0.14, 0.16, 0.17};
constexpr double auK[] = {1.866, 1.895, 1.933, 1.952, 1.958, 1.948, 1.914, 1.849, 1.833,
                          2.081, 2.455, 2.863, 3.272, 3.697, 4.103, 4.542, 5.083, 5.663};
constexpr double coEta[] = {1.49, 1.50, 1.53, 1.57, 1.61, 1.67, 1.74, 1.81, 1.88,
                            1.97, 2.05, 2.13, 2.19, 2.25, 2.31, 2.40, 2.53, 2.65};
constexpr double coK[] = {2.61, 2.71, 2.82, 2.93, 3.05, 3.17, 3.28, 3.41, 3.55,
                          3.68, 3.82, 3.96, 4.11, 4.27, 4.45, 4.64, 4.88, 5.16};
// A film. The bulk metal of Palik's handbook has k near 4.4 throughout the visible, and reflects 0.1 more.
constexpr double crEta[] = {1.84, 1.87, 1.92, 2.00, 2.08, 2.19, 2.33, 2.51, 2.75,
                            2.94, 3.18, 3.22, 3.17, 3.09, 3.05, 3.08, 3.20, 3.30};
constexpr double crK[] = {2.64, 2.69, 2.74, 2.83, 2.93, 3.04, 3.14, 3.24, 3.30,
                          3.33, 3.33, 3.30, 3.30, 3.34, 3.39, 3.42, 3.48, 3.52};
constexpr double feEta[] = {1.93, 2.02, 2.12, 2.24, 2.35, 2.48, 2.59, 2.67, 2.74,
                            2.86, 2.95, 2.94, 2.88, 2.92, 2.86, 2.87, 2.94, 2.96};
constexpr double feK[] = {2.35, 2.43, 2.50, 2.58, 2.65, 2.71, 2.77, 2.82, 2.88,
                          2.91, 2.93, 2.99, 3.05, 3.10, 3.19, 3.28, 3.39, 3.56};
constexpr double niEta[] = {1.74, 1.70, 1.72, 1.72, 1.70, 1.71, 1.73, 1.78, 1.82,
                            1.85, 1.92, 1.96, 1.99, 1.99, 2.06, 2.13, 2.26, 2.40};
constexpr double niK[] = {2.32, 2.40, 2.48, 2.57, 2.69, 2.82, 2.95, 3.09, 3.25,
                          3.42, 3.61, 3.80, 4.02, 4.26, 4.50, 4.73, 4.97, 5.23};
constexpr double pdEta[] = {1.23, 1.24, 1.26, 1.30, 1.33, 1.37, 1.41, 1.46, 1.52,
                            1.57, 1.64, 1.68, 1.75, 1.80, 1.86, 1.95, 2.06, 2.23};
constexpr double pdK[] = {2.65, 2.74, 2.83, 2.93, 3.03, 3.14, 3.26, 3.39, 3.54,
                          3.68, 3.84, 4.02, 4.21, 4.42, 4.65, 4.89, 5.19, 5.50};
constexpr double tiEta[] = {1.82, 1.90, 1.99, 2.08, 2.14, 2.21, 2.27, 2.32, 2.36,
                            2.44, 2.54, 2.60, 2.67, 2.76, 2.86, 3.00, 3.21, 3.29};
constexpr double tiK[] = {2.87, 2.90, 2.93, 2.95, 2.98, 3.01, 3.04, 3.10, 3.19,
                          3.30, 3.43, 3.58, 3.72, 3.84, 3.96, 4.01, 4.01, 3.96};

// Rakić, Applied Optics 34, 4755: evaporated films, made consistent by Kramers and Kronig's relation.
constexpr double alLambda[] = {309.96, 326.28, 364.66, 413.28, 442.80, 476.87, 516.60, 563.57, 619.93,
                               652.25, 688.81, 729.32, 774.91, 794.78, 815.69, 837.74, 885.61};
constexpr double alEta[] = {0.28003, 0.31474, 0.39877, 0.52135, 0.60790, 0.72780, 0.87340, 1.0728, 1.3660,
                            1.5724,  1.8301,  2.1606,  2.6154,  2.7675,  2.7668,  2.6945,  2.2802};
constexpr double alK[] = {3.7081, 3.9165, 4.3957, 5.0008, 5.3676, 5.7781, 6.2418, 6.7839, 7.4052,
                          7.7354, 8.0601, 8.3565, 8.4914, 8.3866, 8.2573, 8.1878, 8.1134};

// pbrt-v3's default metal and the file that its scenes call Cu.eta.spd, as Luxpop's collection hands it down
// without the name of an author. Johnson and Christy 1972 find the same colour: see the test.
constexpr double cuLambda[] = {
    349.2512056, 354.2405086, 359.374429,  364.6593471, 370.1020239, 375.7096303, 381.4897785, 387.4505563,
    393.6005651, 399.9489613, 406.5055016, 413.2805933, 420.2853492, 427.5316483, 435.0322035, 442.8006357,
    450.8515564, 459.2006593, 467.8648226, 476.8622231, 486.2124627, 495.936712,  506.0578694, 516.6007417,
    527.5922468, 539.0616435, 551.0407911, 563.5644455, 576.6705953, 590.4008476, 604.8008683, 619.92089,
    635.8162974, 652.5483053, 670.1847459, 688.8009889, 708.4810171, 729.3186941, 751.4192606, 774.9011125,
    799.8979226, 826.5611867, 855.0632966, 885.6012714};
constexpr double cuEta[] = {
    1.300313, 1.29,  1.281563, 1.27,  1.249062, 1.225, 1.2,      1.18,  1.174375, 1.175, 1.1775,   1.18,
    1.178125, 1.175, 1.172812, 1.17,  1.165312, 1.16,  1.155312, 1.15,  1.142812, 1.135, 1.131562, 1.12,
    1.092437, 1.04,  0.950375, 0.826, 0.645875, 0.468, 0.35125,  0.272, 0.230813, 0.214, 0.20925,  0.213,
    0.21625,  0.223, 0.2365,   0.25,  0.254188, 0.26,  0.28,     0.3};
constexpr double cuK[] = {1.89425,  1.916, 1.931688, 1.95,  1.972438, 2.015, 2.121562, 2.21,  2.177188, 2.13,
                          2.160063, 2.21,  2.249938, 2.289, 2.326,    2.362, 2.397625, 2.433, 2.469187, 2.504,
                          2.535875, 2.564, 2.589625, 2.605, 2.595562, 2.583, 2.5765,   2.599, 2.678062, 2.809,
                          3.01075,  3.24,  3.458187, 3.67,  3.863125, 4.05,  4.239563, 4.43,  4.619563, 4.817,
                          5.034125, 5.26,  5.485625, 5.717};

// Brass of 70% copper and 30% zinc. Querry, report CRDC-CR-85034.
constexpr double cuZnLambda[] = {350, 360, 370, 380, 390, 400, 410, 420, 430, 440, 450, 460, 470, 480, 490,
                                 500, 510, 520, 530, 540, 550, 560, 570, 580, 590, 600, 610, 620, 630, 640,
                                 650, 660, 670, 680, 690, 700, 720, 740, 760, 780, 800, 820, 840};
constexpr double cuZnEta[] = {1.504, 1.503, 1.497, 1.487, 1.471, 1.445, 1.405, 1.350, 1.278, 1.191, 1.094,
                              0.994, 0.900, 0.816, 0.745, 0.686, 0.639, 0.602, 0.573, 0.549, 0.527, 0.505,
                              0.484, 0.468, 0.460, 0.450, 0.452, 0.449, 0.445, 0.444, 0.444, 0.445, 0.444,
                              0.444, 0.445, 0.446, 0.450, 0.455, 0.458, 0.464, 0.473, 0.481, 0.486};
constexpr double cuZnK[] = {1.815, 1.815, 1.818, 1.818, 1.813, 1.805, 1.794, 1.786, 1.784, 1.797, 1.829,
                            1.883, 1.957, 2.046, 2.145, 2.250, 2.358, 2.464, 2.568, 2.668, 2.765, 2.860,
                            2.958, 3.059, 3.159, 3.253, 3.345, 3.434, 3.522, 3.609, 3.695, 3.778, 3.860,
                            3.943, 4.025, 4.106, 4.266, 4.424, 4.579, 4.737, 4.890, 5.039, 5.192};

// Weaver, Olson and Lynch, Phys. Rev. B 12, 1293; read off the paper's figure.
constexpr double wLambda[] = {357.5, 366.2, 372.0, 379.0, 386.6, 393.0, 400.2, 411.5, 425.3, 442.6,
                              465.0, 492.1, 511.1, 529.8, 548.9, 570.5, 599.7, 626.0, 646.0, 671.2,
                              684.9, 706.1, 731.4, 752.8, 777.8, 795.8, 814.7, 832.7, 848.0};
constexpr double wEta[] = {3.270, 3.373, 3.431, 3.459, 3.458, 3.438, 3.406, 3.379, 3.346, 3.317,
                           3.325, 3.380, 3.433, 3.490, 3.522, 3.524, 3.557, 3.607, 3.657, 3.746,
                           3.818, 3.884, 3.891, 3.862, 3.789, 3.694, 3.596, 3.492, 3.405};
constexpr double wK[] = {2.705, 2.677, 2.621, 2.556, 2.490, 2.449, 2.415, 2.416, 2.439, 2.489,
                         2.574, 2.664, 2.700, 2.716, 2.739, 2.787, 2.860, 2.906, 2.925, 2.937,
                         2.904, 2.869, 2.828, 2.788, 2.737, 2.735, 2.757, 2.801, 2.853};

struct Metal {
    std::string_view symbol, source;
    std::span<const double> lambda, eta, k;
};
constexpr Metal kMetals[] = {
    {"Ag", johnsonChristy1972, johnsonChristy, agEta, agK},
    {"Al", "Rakic 1995", alLambda, alEta, alK},
    {"Au", johnsonChristy1972, johnsonChristy, auEta, auK},
    {"Co", johnsonChristy1974, johnsonChristy, coEta, coK},
    {"Cr", johnsonChristy1974, johnsonChristy, crEta, crK},
    {"Cu", "pbrt-v3's own copper", cuLambda, cuEta, cuK},
    {"CuZn", "Querry 1985", cuZnLambda, cuZnEta, cuZnK},
    {"Fe", johnsonChristy1974, johnsonChristy, feEta, feK},
    {"Ni", johnsonChristy1974, johnsonChristy, niEta, niK},
    {"Pd", johnsonChristy1974, johnsonChristy, pdEta, pdK},
    {"Ti", johnsonChristy1974, johnsonChristy, tiEta, tiK},
    {"W", "Weaver, Olson and Lynch 1975", wLambda, wEta, wK},
};
constexpr bool TablesAreWhole() {
    for (const Metal &m : kMetals)
        if (m.lambda.size() != m.eta.size() || m.lambda.size() != m.k.size())
            return false;
    return true;
}
static_assert(TablesAreWhole());

} // namespace

std::optional<MetalSpectrum> FindMetalSpectrum(std::string_view symbol, OpticalConstant which) {
    for (const Metal &m : kMetals) {
        if (m.symbol != symbol)
            continue;
        const std::span<const double> values = which == OpticalConstant::Eta ? m.eta : m.k;
        return MetalSpectrum{{m.lambda.begin(), m.lambda.end()}, {values.begin(), values.end()}, m.source};
    }
    return {};
}

std::optional<MetalSpectrum> FindMetalSpectrumByFilename(std::string_view filename) {
    filename = filename.substr(filename.find_last_of('/') + 1); // npos + 1 is 0
    const auto with = [&](std::string_view ending, OpticalConstant which) -> std::optional<MetalSpectrum> {
        if (!filename.ends_with(ending))
            return {};
        return FindMetalSpectrum(filename.substr(0, filename.size() - ending.size()), which);
    };
    if (auto eta = with(".eta.spd", OpticalConstant::Eta))
        return eta;
    return with(".k.spd", OpticalConstant::K);
}

Spectrum MetalRGB(std::string_view symbol, OpticalConstant which) {
    auto spectrum = FindMetalSpectrum(symbol, which);
    if (!spectrum)
        throw Error("no optical constants of \"{}\" are known here", symbol);
    return SpectrumFromSamples(std::move(spectrum->lambda), std::move(spectrum->values));
}

std::vector<std::string_view> MetalSymbols() {
    std::vector<std::string_view> symbols;
    for (const Metal &m : kMetals)
        symbols.push_back(m.symbol);
    return symbols;
}

} // namespace cuticle
