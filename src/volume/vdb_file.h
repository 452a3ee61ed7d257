//> Declare how volumes are written for other programs
#pragma once

#include "volume/grid.h"

#include <string>
#include <variant>
#include <vector>

namespace cuticle {

// A field by its name: numbers, or vectors.
struct VdbField {
    std::string name;
    // Tells readers what it is: a density of fog, a distance to a surface, or neither.
    enum class Kind { Fog, Distance, Plain } kind = Kind::Plain;
    std::variant<const DenseGrid<float> *, const DenseGrid<Vector3f> *> grid;
};

// Writes the fields as sparse grids of one .vdb file (OpenVDB's, version 224), whole or not at all. Blocks of
// 8 x 8 x 8 vertices that are 0 are left out, of a distance none. At most 4,096 vertices to a side. Throws
// Error where the file cannot be written.
void WriteVdb(const std::string &filename, const std::vector<VdbField> &fields);

} // namespace cuticle
//<
