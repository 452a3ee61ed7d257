// The .hair format of Cem Yuksel's HAIR model files: a 128-byte header and up to five arrays.
#pragma once

#include "grooms/groom.h"

#include <string>

namespace cuticle {

// Reads the bytes of a .hair file; `name` stands in messages: points, thickness (taken as full widths, per
// point or the header's default) and colours per point (the header's default is no colour); transparency is
// checked and not rendered (one warning where there is any). Little-endian, as the format is. Throws Error
// "FILE: error: byte N: ..." for what is not a .hair file, for counts that the file's size cannot hold, for
// strands that do not add up to the points, and for NaN, infinite or negative values. Memory stays within
// about three times the file's size.
Groom ParseHairFile(std::string_view bytes, const std::string &name);

// Writes a groom as .hair: atomically, points, one strand length for all or an array of them, thickness where
// the groom has it per point or strand, otherwise as the header's default, colours per point where it has
// any. Throws Error for strands of more than 65535 segments, of no points, and for what the system reports.
void WriteHairFile(const std::string &filename, const Groom &groom);

} // namespace cuticle
