// Triangle meshes from PLY files.
#pragma once

#include "shapes/triangle_mesh.h"

#include <string>
#include <string_view>

namespace cuticle {

// Reads a .ply file: ascii, binary of either byte order, each also compressed with gzip (decided by content).
// Vertex properties x y z, nx ny nz, and u v, s t, texture_u texture_v or texture_s texture_t; faces in a
// list vertex_indices or vertex_index, polygons cut into a fan as pbrt-v3 does with quads. Other elements and
// properties are skipped. Indices are checked against the number of vertices. Faces of fewer than three
// corners are dropped with a Warning. Anything else that is wrong (missing, truncated, absurd) throws Error
// with the file's name and the fault; memory grows with the data that is there, not with the counts a header
// claims.
TriangleMesh ReadPly(const std::string &filename);
// Reads the same from memory (not compressed); `name` stands in messages.
TriangleMesh ReadPlyBytes(std::string_view bytes, const std::string &name);

} // namespace cuticle
