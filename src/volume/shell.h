//> Declare the shell of hair and the distance to it
#pragma once

#include "grooms/head_mesh.h"
#include "volume/grid.h"

namespace cuticle {

// The shell of hair: the surface on which a density is `iso` (> 0), as triangles whose normals point out of
// the hair, and the distance to these triangles at every vertex of the lattice, negative inside.
struct HairShell {
    float iso = 0;
    SurfaceMesh mesh;
    DenseGrid<float> distance;
    // Volume inside of the triangles.
    double Volume() const;
};

// Makes the shell. Where hair reaches the wall of the box the surface is open there. Throws Error where no
// vertex of the lattice has a density of iso or more, or iso is not positive.
HairShell MakeShell(const DenseGrid<float> &density, float iso);

// The density that half of the hair's mass is denser than: half of the median is a good iso.
float MedianDensity(const DenseGrid<float> &density);

// Distance from a point to a triangle.
float DistanceToTriangle(const Point3f &p, const Point3f &a, const Point3f &b, const Point3f &c);

} // namespace cuticle
//<
