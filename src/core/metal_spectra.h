// Measured optical constants of metals, for scenes that name them and have lost their .spd files.
#pragma once

#include "core/color.h"

#include <optional>
#include <string_view>

namespace cuticle {

// The complex index eta + i k of a metal in air, a function of the wavelength.
enum class OpticalConstant { Eta, K };

struct MetalSpectrum {
    std::vector<double> lambda, values; // nm, ascending and past both ends of the visible range; no unit
    std::string_view source;            // who measured, when
};

// Finds a spectrum by chemical symbol (Ag Al Au Co Cr Cu Fe Ni Pd Ti W), or CuZn for brass; nothing for any
// other name. Upper and lower case count.
std::optional<MetalSpectrum> FindMetalSpectrum(std::string_view symbol, OpticalConstant which);
// Finds one by the name of a file as pbrt-v3's scenes have it, "spds/Au.eta.spd" or "Au.k.spd"; folders do
// not count.
std::optional<MetalSpectrum> FindMetalSpectrumByFilename(std::string_view filename);
// Returns the colour in linear RGB, by the rule of SpectrumFromSamples(). The symbol must be known (Error
// otherwise).
Spectrum MetalRGB(std::string_view symbol, OpticalConstant which);
// All symbols, in the order of the alphabet.
std::vector<std::string_view> MetalSymbols();

} // namespace cuticle
