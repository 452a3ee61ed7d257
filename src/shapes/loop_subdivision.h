// Charles Loop's subdivision surfaces (Loop 1987; boundary rules of Hoppe et al. 1994), with pbrt-v3's
// weights. Only at the boundary are points moved to the limit with 1/6, 2/3, 1/6, which is the limit of the
// rules (a cubic B-spline's); pbrt-v3's 1/5, 3/5, 1/5 belong to other rules.
#pragma once

#include "shapes/triangle_mesh.h"

namespace cuticle {

// Returns the control mesh (p and indices; n and uv are not read) subdivided `levels` times, with its
// vertices moved to their places on the limit surface and the limit's normals at them. Faces keep their
// orientation; normals are on pbrt-v3's side, which is the inner one of a closed mesh whose faces turn
// anticlockwise seen from outside; at a boundary vertex with other than three faces they are approximate, as
// in pbrt-v3. A vertex without faces is dropped. Error: an index out of range, a face that names a vertex
// twice, an edge with more than two faces or with two that run along it the same way, a vertex where separate
// fans of faces touch, levels below 0 or so many that there would be more than 2^27 triangles.
TriangleMesh LoopSubdivide(const TriangleMesh &control, int levels);

} // namespace cuticle
