// Directions across strands: the major axis of eccentric fibers.
#pragma once

#include "shapes/curve_list.h"

#include <vector>

namespace cuticle {

// Makes unit vectors at right angles to the strands, one for the start of every segment. At a strand's root
// its azimuth is random, by the strand's number; along the strand it is carried without twist (rotation
// minimising frames by double reflection, Wang, Juettler, Zheng and Liu 2008). Segments belong to one strand
// while each starts where the one before it ended, in the same group.
std::vector<Vector3f> MakeStrandNormals(const CurveList &segments);

// Returns the same direction further along a segment: start is its normal at u = 0, tangent the unit tangent
// at u.
Vector3f StrandNormal(const CurveSegment &segment, const Vector3f &start, float u, const Vector3f &tangent);

} // namespace cuticle
