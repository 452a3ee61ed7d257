//> Bodies by their distances
#include "dynamics/obstacle.h"

#include "grooms/head_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cuticle {

//> Turn a rigid body about an axis
Pose TurnAbout(const Vector3d &pivot, const Vector3d &turn, const Vector3d &shift) {
    const double angle = turn.Length();
    Pose pose;
    if (angle > 0) {
        const Vector3d axis = turn / angle;
        const double c = std::cos(angle), s = std::sin(angle);
        const auto turned = [&](const Vector3d &v) { // Rodrigues' formula
            return v * c + Cross(axis, v) * s + axis * (Dot(axis, v) * (1 - c));
        };
        pose.x = turned(pose.x), pose.y = turned(pose.y), pose.z = turned(pose.z);
    }
    pose.origin = pivot + shift - pose.Direction(pivot);
    return pose;
}
//<

//> Find a normal by differences
Vector3d Obstacle::Normal(const Vector3d &p) const {
    constexpr double h = 1e-3;
    Vector3d g;
    for (size_t c = 0; c < 3; ++c) {
        Vector3d step;
        step[c] = h;
        g[c] = Distance(p + step) - Distance(p - step);
    }
    const double length = g.Length();
    return length > 0 ? g / length : Vector3d{0, 1, 0}; // at a centre any direction leads out
}
//<

namespace {

//> Measure the distance to simple bodies
// The distance to a body of a formula.
class FormulaObstacle : public Obstacle {
  public:
    explicit FormulaObstacle(std::function<double(const Vector3d &)> distance)
        : distance_(std::move(distance)) {}
    double Distance(const Vector3d &p) const override { return distance_(p); }

  private:
    std::function<double(const Vector3d &)> distance_;
};

// The first-order distance to an ellipsoid: the implicit function over its gradient's length.
double EllipsoidDistance(const Vector3d &q, const Vector3d &r) {
    const Vector3d a{q.x / r.x, q.y / r.y, q.z / r.z};
    const Vector3d b{a.x / r.x, a.y / r.y, a.z / r.z};
    const double k = a.Length(), g = b.Length();
    return g > 0 ? k * (k - 1) / g : -std::min({r.x, r.y, r.z});
}

double SegmentDistance(const Vector3d &p, const Vector3d &a, const Vector3d &b) {
    const Vector3d ab = b - a, ap = p - a;
    const double length2 = ab.LengthSquared();
    const double t = length2 > 0 ? std::clamp(Dot(ap, ab) / length2, 0., 1.) : 0;
    return (ap - ab * t).Length();
}
//<

//> Wrap the head of our grooms
class HeadObstacle : public Obstacle {
  public:
    double Distance(const Vector3d &p) const override {
        return static_cast<double>(HeadDistance(Point3f(p)));
    }
    Vector3d Normal(const Vector3d &p) const override { return Vector3d(HeadNormal(Point3f(p))); }
};
//<

//> Join bodies
class ObstacleUnion : public Obstacle {
  public:
    explicit ObstacleUnion(std::vector<std::unique_ptr<Obstacle>> bodies) : bodies_(std::move(bodies)) {}
    double Distance(const Vector3d &p) const override {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto &body : bodies_)
            nearest = std::min(nearest, body->Distance(p));
        return nearest;
    }
    Vector3d Normal(const Vector3d &p) const override {
        const Obstacle *nearest = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (const auto &body : bodies_)
            if (const double d = body->Distance(p); nearest == nullptr || d < least)
                nearest = body.get(), least = d;
        return nearest != nullptr ? nearest->Normal(p) : Vector3d{0, 1, 0};
    }

  private:
    std::vector<std::unique_ptr<Obstacle>> bodies_;
};
//<

} // namespace

//> Make bodies
std::unique_ptr<Obstacle> MakeObstacle(std::function<double(const Vector3d &)> distance) {
    return std::make_unique<FormulaObstacle>(std::move(distance));
}
std::unique_ptr<Obstacle> MakeSphere(const Vector3d &center, double radius) {
    return MakeObstacle([=](const Vector3d &p) { return (p - center).Length() - radius; });
}
std::unique_ptr<Obstacle> MakeEllipsoid(const Vector3d &center, const Vector3d &radii) {
    return MakeObstacle([=](const Vector3d &p) { return EllipsoidDistance(p - center, radii); });
}
std::unique_ptr<Obstacle> MakeCapsule(const Vector3d &a, const Vector3d &b, double radius) {
    return MakeObstacle([=](const Vector3d &p) { return SegmentDistance(p, a, b) - radius; });
}
std::unique_ptr<Obstacle> MakeGround(const Vector3d &p, const Vector3d &n) {
    return MakeObstacle([=](const Vector3d &q) { return Dot(q - p, n); });
}
std::unique_ptr<Obstacle> MakeHead() { return std::make_unique<HeadObstacle>(); }
std::unique_ptr<Obstacle> MakeUnion(std::vector<std::unique_ptr<Obstacle>> bodies) {
    return std::make_unique<ObstacleUnion>(std::move(bodies));
}
//<

} // namespace cuticle
//<
