// Strands from PLY files of points only, as reconstructions of hair are written.
#pragma once

#include "grooms/groom.h"

#include <string>
#include <string_view>

namespace cuticle {

// How many points of a .ply file make a strand where nobody says.
inline constexpr size_t kPlyPointsPerStrand = 100;

// Reads the vertices of a .ply file, ascii or binary, as strands of pointsPerStrand points in a row, root
// first; 0: kPlyPointsPerStrand. The groom's width is 0: the file has none. Throws Error with the file's name
// for a file with faces, for points that do not divide, and for whatever else is wrong; memory follows the
// points that are there.
Groom ParsePlyStrands(std::string_view bytes, const std::string &name, size_t pointsPerStrand);

} // namespace cuticle
