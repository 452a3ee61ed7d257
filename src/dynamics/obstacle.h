//> Keep hair out of bodies
// Bodies that hair rests on and slides over, as signed distances; and the rigid motion that carries them.
#pragma once

#include "core/vecmath.h"

#include <functional>
#include <memory>
#include <vector>

namespace cuticle {

//> Place a rigid body
// Turns and moves points of a body (the head) from its own coordinates into the world's.
struct Pose {
    Vector3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}; // the body's axes in the world: orthonormal, right-handed
    Vector3d origin;
    Vector3d Direction(const Vector3d &v) const { return x * v.x + y * v.y + z * v.z; }
    Vector3d Point(const Vector3d &p) const { return origin + Direction(p); }
    Vector3d LocalDirection(const Vector3d &v) const { return {Dot(x, v), Dot(y, v), Dot(z, v)}; }
    Vector3d LocalPoint(const Vector3d &p) const { return LocalDirection(p - origin); }
};
// Turns about an axis through `pivot` by |turn| radians (any finite vector), then moves by `shift`.
Pose TurnAbout(const Vector3d &pivot, const Vector3d &turn, const Vector3d &shift);
//<

//> Declare what hair collides with
// A body in the coordinates of the head, which carries it.
class Obstacle {
  public:
    virtual ~Obstacle() = default;
    // The signed distance to its surface (cm), negative inside; exact near the surface, elsewhere its sign
    // counts, and that it is at most twice the distance.
    virtual double Distance(const Vector3d &p) const = 0;
    // The unit vector along which the distance grows fastest; by differences over a hundredth of a
    // millimetre where a class knows no better.
    virtual Vector3d Normal(const Vector3d &p) const;
};

// A ball; an ellipsoid of semi-axes along x, y and z; a capsule; all sizes > 0.
std::unique_ptr<Obstacle> MakeSphere(const Vector3d &center, double radius);
std::unique_ptr<Obstacle> MakeEllipsoid(const Vector3d &center, const Vector3d &radii);
std::unique_ptr<Obstacle> MakeCapsule(const Vector3d &a, const Vector3d &b, double radius);
// The half space below a plane through `p` with the unit normal n.
std::unique_ptr<Obstacle> MakeGround(const Vector3d &p, const Vector3d &n);
// The head and shoulders of our grooms (grooms/head_shape.h).
std::unique_ptr<Obstacle> MakeHead();
// Any signed distance.
std::unique_ptr<Obstacle> MakeObstacle(std::function<double(const Vector3d &)> distance);
// All of several bodies; none: the distance is infinite everywhere.
std::unique_ptr<Obstacle> MakeUnion(std::vector<std::unique_ptr<Obstacle>> bodies);
//<

} // namespace cuticle
//<
