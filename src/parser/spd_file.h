// Sampled spectra from files, as pbrt-v3's scenes name them.
#pragma once

#include "core/color.h"

#include <string>

namespace cuticle {

// Reads a .spd text file of pairs "wavelength value" (nm, no unit) with # comments; returns the colour of
// SpectrumFromSamples(). Throws Error that names file, line and column: a word that is no finite number, an
// odd count, a colour beyond binary32.
Spectrum ReadSPD(const std::string &filename);
// Reads the same from text in memory; `name` stands in messages.
Spectrum ParseSPD(const std::string &text, const std::string &name);

} // namespace cuticle
