// Random places and the quadrics as parametrised surfaces, for the tests of solids.
#pragma once

#include "core/sampling.h"
#include "shapes/solid_set.h"

#include <functional>
#include <string>
#include <vector>

namespace cuticle {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

inline Point3f RandomPoint(RNG &rng, float size = 1) {
    const auto u = [&] { return (2 * rng.UniformFloat() - 1) * size; };
    const float x = u(), y = u(), z = u();
    return {x, y, z};
}
inline Vector3f RandomDirection(RNG &rng) {
    const float x = rng.UniformFloat(), y = rng.UniformFloat();
    return UniformSampleSphere({x, y});
}
inline Transform RandomTransform(RNG &rng, bool mirror = false) {
    const float angle = 360 * rng.UniformFloat();
    const auto s = [&] { return 0.3f + 2 * rng.UniformFloat(); };
    const double sx = s(), sy = s(), sz = s();
    const Vector3d axis(RandomDirection(rng)), shift(RandomPoint(rng, 5));
    return Transform::Translate(shift) * Transform::Rotate(angle, axis) *
           Transform::Scale(mirror ? -sx : sx, sy, sz);
}

inline Vector3d Turned(const Vector3d &p, double phi) {
    return {p.x * std::cos(phi) - p.y * std::sin(phi), p.x * std::sin(phi) + p.y * std::cos(phi), p.z};
}

// A quadric as its parametrisation: (u, v) to a point of object space, in double.
struct ParametrisedShape {
    std::string name;
    std::function<uint32_t(SolidSet &, const Transform &, bool)> add;
    std::function<Vector3d(double, double)> at;
};
// A sphere, a disk and a cylinder, each whole and in part.
inline std::vector<ParametrisedShape> RoundQuadrics() {
    const double deg = kPi<double> / 180;
    const auto sphere = [=](double r, double z0, double z1, double phiMax) {
        return [=](double u, double v) {
            const double t0 = std::acos(z0 / r), t1 = std::acos(z1 / r), theta = t0 + v * (t1 - t0);
            return Vector3d(r * std::sin(theta) * std::cos(u * phiMax),
                            r * std::sin(theta) * std::sin(u * phiMax), r * std::cos(theta));
        };
    };
    return {
        {"sphere",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddSphere(t, 1.5f, -2, 2, 360, 7, r); },
         sphere(1.5, -1.5, 1.5, 2 * kPi<double>)},
        {"partial sphere",
         [](SolidSet &s, const Transform &t, bool r) {
             return s.AddSphere(t, 1.5f, -0.75f, 0.5f, 250, 7, r);
         },
         sphere(1.5, -0.75, 0.5, 250 * deg)},
        {"disk", [](SolidSet &s, const Transform &t, bool r) { return s.AddDisk(t, 0.25f, 2, 0, 360, 7, r); },
         [](double u, double v) {
             const double rr = 2 * (1 - v), phi = u * 2 * kPi<double>;
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), 0.25);
         }},
        {"partial annulus",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddDisk(t, -0.5f, 2, 0.75f, 100, 7, r); },
         [=](double u, double v) {
             const double rr = 0.75 + (1 - v) * 1.25, phi = u * 100 * deg;
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), -0.5);
         }},
        {"cylinder",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddCylinder(t, 0.5f, -1, 2, 360, 7, r); },
         [](double u, double v) {
             const double phi = u * 2 * kPi<double>;
             return Vector3d(0.5 * std::cos(phi), 0.5 * std::sin(phi), -1 + 3 * v);
         }},
        {"partial cylinder",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddCylinder(t, 1.25f, -1, 0.5f, 200, 7, r); },
         [=](double u, double v) {
             const double phi = u * 200 * deg;
             return Vector3d(1.25 * std::cos(phi), 1.25 * std::sin(phi), -1 + 1.5 * v);
         }},
    };
}
// A cone, a paraboloid and a hyperboloid, each whole and in part.
inline std::vector<ParametrisedShape> SlopingQuadrics() {
    const double deg = kPi<double> / 180;
    return {
        {"cone", [](SolidSet &s, const Transform &t, bool r) { return s.AddCone(t, 0.75f, 1.5f, 360, 7, r); },
         [](double u, double v) {
             const double phi = u * 2 * kPi<double>, rr = 0.75 * (1 - v);
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), 1.5 * v);
         }},
        {"partial cone",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddCone(t, 1.25f, 0.5f, 220, 7, r); },
         [=](double u, double v) {
             const double phi = u * 220 * deg, rr = 1.25 * (1 - v);
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), 0.5 * v);
         }},
        {"paraboloid",
         [](SolidSet &s, const Transform &t, bool r) {
             return s.AddParaboloid(t, 1.25f, 0.15f, 1.5f, 360, 7, r);
         },
         [](double u, double v) {
             const double phi = u * 2 * kPi<double>, z = 0.15f * (1 - v) + 1.5 * v;
             const double rr = 1.25 * std::sqrt(z / 1.5);
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), z);
         }},
        {"partial paraboloid",
         [](SolidSet &s, const Transform &t, bool r) { return s.AddParaboloid(t, 1, 0.25f, 2, 200, 7, r); },
         [=](double u, double v) {
             const double phi = u * 200 * deg, z = 0.25 + 1.75 * v, rr = std::sqrt(z / 2);
             return Vector3d(rr * std::cos(phi), rr * std::sin(phi), z);
         }},
        {"hyperboloid",
         [](SolidSet &s, const Transform &t, bool r) {
             return s.AddHyperboloid(t, {1, -1, -1}, {1, 1, 1}, 360, 7, r);
         },
         [=](double u, double v) {
             return Turned({1, 2 * v - 1, 2 * v - 1}, u * 2 * kPi<double>);
         }},
        {"partial hyperboloid", // downward: the normal turns round
         [](SolidSet &s, const Transform &t, bool r) {
             return s.AddHyperboloid(t, {0.5f, 1, 0.75f}, {0.5f, -0.5f, -0.375f}, 250, 7, r);
         },
         [=](double u, double v) {
             return Turned({0.5, 1 - 1.5 * v, 0.75 - 1.125 * v}, u * 250 * deg);
         }},
    };
}

inline std::vector<ParametrisedShape> ParametrisedQuadrics() {
    std::vector<ParametrisedShape> shapes = RoundQuadrics();
    for (ParametrisedShape &shape : SlopingQuadrics())
        shapes.push_back(std::move(shape));
    return shapes;
}

inline Vector3d Apply(const Transform &t, const Vector3d &p) {
    const auto &m = t.M();
    const auto row = [&](size_t i) { return m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z + m[i][3]; };
    return {row(0), row(1), row(2)};
}

} // namespace cuticle
