// Strands from files, whatever their format.
#pragma once

#include "grooms/groom.h"

#include <string>

namespace cuticle {

// Reads a .hair file (Yuksel), a .tfx file (TressFX 4) or a .usda file (USD's BasisCurves as text): by what
// the file begins with, and by its name's ending where that tells nothing. width: of all strands, instead of
// the file's; 0: the file's. A file without widths gets 1/500 of the mean length of its strands, and a
// warning. Throws Error that names the file and, where it can, the byte or the line.
Groom ReadGroomFile(const std::string &filename, float width = 0);

} // namespace cuticle
