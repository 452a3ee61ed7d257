//> Declare normals of hair and how hair carries them
#pragma once

#include "volume/grid.h"

#include <span>
#include <vector>

namespace cuticle {

// The normal of hair at a point of the rest pose: the direction in which the distance to the shell grows, of
// unit length; zero where it grows in none.
Normal3f ShellNormal(const DenseGrid<float> &distance, const Point3f &p);

// Turns v by the smallest rotation that takes a to b (both of unit length). Where they are opposite, that is
// half a turn about `about` (of unit length, perpendicular to a).
Vector3f TurnBySmallest(const Vector3f &a, const Vector3f &b, const Vector3f &about, const Vector3f &v);

// Frames along a strand by parallel transport (Bishop 1975): x is the direction of the segment behind a point
// (at the last one, before it), y and z turn with it by the smallest rotations. The first frame is `root`
// turned so that its x has the direction of the first segment. A segment of no length has the direction of
// the one before it.
std::vector<Frame> TransportFrames(std::span<const Point3f> points, const Frame &root);

// Carries normals along with a strand that has moved (Petrovic, Henne and Anderson 2005, section 4.1): each
// keeps its coordinates in the frame of its point. The frame at the root is rigid with the head, whose motion
// from rest to pose is `head`. All spans have one element for each point.
std::vector<Normal3f> CarryNormals(std::span<const Point3f> rest, std::span<const Normal3f> normals,
                                   std::span<const Point3f> posed, const Transform &head);

} // namespace cuticle
//<
