//> Declare the head
// A bust like a sculptor's study, lids closed, to grow hair on. Units are centimetres, y up, the face looks
// along +z, +x is the head's left; the origin lies between the ears.
#pragma once

#include "core/vecmath.h"

namespace cuticle {

inline constexpr float kHeadBottom = -27.f; // where the bust is cut off

// Distance to the surface of the bust, negative inside: smooth unions of ellipsoids and chains of round cones
// (after Quilez, "3D SDFs"). Its sign is exact by definition: the zero set IS the head. Near the surface the
// distance is right to about a tenth. An adult's sizes: 14.6 wide, 18.6 from brow to back, 22 from chin to
// crown; shoulders 38 wide.
float HeadDistance(const Point3f &p);
// Unit normal of the level set through p (central differences of HeadDistance).
Normal3f HeadNormal(const Point3f &p);
// The nearest point with HeadDistance(p) >= offset along the normals; p itself where it is that far already.
Point3f PushOutOfHead(Point3f p, float offset);

} // namespace cuticle
//<
