// Strands from files, whatever their format.
#pragma once

#include "grooms/groom.h"

#include <optional>
#include <string>

namespace cuticle {

// GroomFileOptions say of a file of strands what the file does not.
struct GroomFileOptions {
    float width = 0;                 // of all strands, instead of the file's; 0: the file's
    size_t pointsPerStrand = 0;      // of a .ply file; 0: 100
    std::optional<double> time = {}; // code of a .usda file's time samples; none: the first
};

// Reads a .hair file (Yuksel), a .tfx file (TressFX 4), a .usda file (USD's BasisCurves as text) or a .ply
// file of points only: by what the file begins with, and by its name's ending where that tells nothing. A
// file without widths gets 1/500 of the mean length of its strands, and a warning. Throws Error that names
// the file and, where it can, the byte or the line.
Groom ReadGroomFile(const std::string &filename, const GroomFileOptions &options = {});

} // namespace cuticle
