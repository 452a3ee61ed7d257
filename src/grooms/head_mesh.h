//> Declare the head as triangles
// The head and shoulders as triangles, and triangles as a file.
#pragma once

#include "core/vecmath.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cuticle {

// A triangle mesh with a unit normal at every vertex.
struct SurfaceMesh {
    std::vector<Point3f> points;
    std::vector<Normal3f> normals;
    std::vector<uint32_t> indices; // three per triangle, counter-clockwise seen from outside
};

// The bust as triangles of edges near `spacing` cm (0.05 to 5, else Error), cut off flat below the chest.
// Every vertex above the cut lies on the zero set to 1e-3 cm.
SurfaceMesh MakeHeadMesh(float spacing = 0.3f);

// Writes binary PLY with normals, whole or not at all. Throws Error naming the path.
void WritePly(const std::string &filename, const SurfaceMesh &mesh);

} // namespace cuticle
//<
