// The .tfx format of AMD's TressFX, version 4: a header of 160 bytes and arrays at offsets that it names.
#pragma once

#include "grooms/groom.h"

#include <string>
#include <string_view>

namespace cuticle {

// Whether a file that begins so may be a .tfx file of version 4.
bool IsTfxFile(std::string_view bytes);

// Reads guide strands, all of one number of points: positions (their fourth number, which pins points in
// simulations, is checked and left out), thickness of each strand where given (taken as full widths), colours
// of each point where given (their alpha is not rendered: one warning). Follow hairs are made by programs
// that use the format and are not in it. Without thickness the groom's width is 0. `name` stands in messages.
// Throws Error "FILE: error: byte N: ..." for another version, for counts and offsets that do not lie within
// the file, and for values that are no numbers.
Groom ParseTfxFile(std::string_view bytes, const std::string &name);

} // namespace cuticle
