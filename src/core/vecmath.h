// Vectors, bounds, rays, transforms and frames. Points, vectors and normals share one type; the alias says
// which is meant.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <ostream>

namespace cuticle {

using Float = float;

template <typename T>
inline constexpr T kPi = std::numbers::pi_v<T>;
inline constexpr float Pi = std::numbers::pi_v<float>;
inline constexpr float Infinity = std::numeric_limits<float>::infinity();
// The largest binary32 below 1: random numbers stay in [0, OneMinusEpsilon].
inline constexpr float OneMinusEpsilon = 0x1.fffffep-1f;
// The smallest random number that is used. 0 stands for all numbers below 2^-32, the step of a 32-bit
// generator; this is their middle.
inline constexpr float kMinU = 0x1p-33f;

template <typename T>
constexpr T Sqr(T v) {
    return v * v;
}
template <typename T>
constexpr T Lerp(T t, T a, T b) {
    return (1 - t) * a + t * b;
}
inline constexpr float Radians(float deg) { return deg * (Pi / 180); }
inline constexpr float Degrees(float rad) { return rad * (180 / Pi); }

template <typename T>
struct Vector2 {
    T x{}, y{};
    constexpr Vector2() = default;
    constexpr Vector2(T xx, T yy) : x(xx), y(yy) {}
    constexpr T operator[](size_t i) const { return i == 0 ? x : y; }
    constexpr T &operator[](size_t i) { return i == 0 ? x : y; }
    constexpr Vector2 operator+(Vector2 b) const { return {x + b.x, y + b.y}; }
    constexpr Vector2 operator-(Vector2 b) const { return {x - b.x, y - b.y}; }
    constexpr Vector2 operator*(T s) const { return {x * s, y * s}; }
    constexpr bool operator==(const Vector2 &) const = default;
};

template <typename T>
struct Vector3 {
    T x{}, y{}, z{};
    constexpr Vector3() = default;
    constexpr Vector3(T xx, T yy, T zz) : x(xx), y(yy), z(zz) {}
    template <typename U>
    constexpr explicit Vector3(const Vector3<U> &o)
        : x(static_cast<T>(o.x)), y(static_cast<T>(o.y)), z(static_cast<T>(o.z)) {}
    constexpr T operator[](size_t i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr T &operator[](size_t i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr Vector3 operator+(const Vector3 &b) const { return {x + b.x, y + b.y, z + b.z}; }
    constexpr Vector3 operator-(const Vector3 &b) const { return {x - b.x, y - b.y, z - b.z}; }
    constexpr Vector3 operator*(T s) const { return {x * s, y * s, z * s}; }
    constexpr Vector3 operator/(T s) const { return {x / s, y / s, z / s}; }
    constexpr Vector3 operator-() const { return {-x, -y, -z}; }
    constexpr Vector3 &operator+=(const Vector3 &b) { return *this = *this + b; }
    constexpr Vector3 &operator-=(const Vector3 &b) { return *this = *this - b; }
    constexpr Vector3 &operator*=(T s) { return *this = *this * s; }
    constexpr bool operator==(const Vector3 &) const = default;
    constexpr T LengthSquared() const { return x * x + y * y + z * z; }
    T Length() const { return std::sqrt(LengthSquared()); }
};
template <typename T>
constexpr Vector3<T> operator*(T s, const Vector3<T> &v) {
    return v * s;
}
template <typename T>
std::ostream &operator<<(std::ostream &os, const Vector2<T> &v) {
    return os << "[ " << v.x << ", " << v.y << " ]";
}
template <typename T>
std::ostream &operator<<(std::ostream &os, const Vector3<T> &v) {
    return os << "[ " << v.x << ", " << v.y << ", " << v.z << " ]";
}

// The roles have pbrt-v3's names.
using Vector2f = Vector2<float>;
using Point2f = Vector2<float>;
using Point2i = Vector2<int>;
using Vector3f = Vector3<float>;
using Vector3d = Vector3<double>;
using Point3f = Vector3<float>;
using Normal3f = Vector3<float>;

template <typename T>
constexpr T Dot(const Vector3<T> &a, const Vector3<T> &b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
T AbsDot(const Vector3<T> &a, const Vector3<T> &b) {
    return std::abs(Dot(a, b));
}
template <typename T>
constexpr Vector3<T> Cross(const Vector3<T> &a, const Vector3<T> &b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Scales v to unit length; a zero vector gives NaNs, so callers that may hold one ask first.
template <typename T>
Vector3<T> Normalize(const Vector3<T> &v) {
    return v / v.Length();
}
template <typename T>
constexpr Vector3<T> Min(const Vector3<T> &a, const Vector3<T> &b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
template <typename T>
constexpr Vector3<T> Max(const Vector3<T> &a, const Vector3<T> &b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
inline bool IsFinite(const Vector3f &v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
// The largest coordinate or width that geometry may have: products of two and of sums of them are still
// finite.
inline constexpr float kMaxCoordinate = 1e18f;
// Whether no coordinate is beyond kMaxCoordinate; false for NaN.
inline bool IsWithinReach(const Point3f &p) {
    return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
           std::abs(p.z) <= kMaxCoordinate;
}
// Finds two unit vectors that make (v, *s, *t) an orthonormal right-handed frame; |v| = 1. Duff et al. 2017:
// no branch on the direction, exact at the poles.
template <typename T>
void CoordinateSystem(const Vector3<T> &v, Vector3<T> *s, Vector3<T> *t) {
    const T sign = std::copysign(T(1), v.z);
    const T a = -1 / (sign + v.z);
    const T b = v.x * v.y * a;
    *s = {1 + sign * v.x * v.x * a, sign * b, -sign * v.x};
    *t = {b, sign + v.y * v.y * a, -v.y};
}

struct Bounds3f {
    Point3f pMin{Infinity, Infinity, Infinity}, pMax{-Infinity, -Infinity, -Infinity};
    bool IsEmpty() const { return !(pMin.x <= pMax.x && pMin.y <= pMax.y && pMin.z <= pMax.z); }
    Vector3f Diagonal() const { return pMax - pMin; }
    Point3f Center() const { return (pMin + pMax) * 0.5f; }
    float SurfaceArea() const {
        const Vector3f d = Diagonal();
        return IsEmpty() ? 0 : 2 * (d.x * d.y + d.x * d.z + d.y * d.z);
    }
    void Extend(const Point3f &p) { pMin = Min(pMin, p), pMax = Max(pMax, p); }
    void Extend(const Bounds3f &b) { pMin = Min(pMin, b.pMin), pMax = Max(pMax, b.pMax); }
};

// The points o + t d for t in (tMin, tMax). d need not be of unit length; t is measured in multiples of d.
struct Ray {
    Point3f o;
    Vector3f d;
    float tMin = 0;
    float tMax = Infinity;
    Point3f operator()(float t) const { return o + d * t; }
};

// An orthonormal frame; local coordinates are (x . v, y . v, z . v).
struct Frame {
    Vector3f x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    static Frame FromZ(const Vector3f &n) {
        Frame f;
        f.z = n;
        CoordinateSystem(n, &f.x, &f.y);
        return f;
    }
    Vector3f ToLocal(const Vector3f &v) const { return {Dot(x, v), Dot(y, v), Dot(z, v)}; }
    Vector3f FromLocal(const Vector3f &v) const { return x * v.x + y * v.y + z * v.z; }
};

// A 4x4 matrix, row major, applied to column vectors, together with its inverse. Held in double: scenes chain
// many rotations, and the parser's inputs are few.
class Transform {
  public:
    using Matrix = std::array<std::array<double, 4>, 4>;
    Transform(); // identity
    explicit Transform(const Matrix &m);
    Transform(const Matrix &m, const Matrix &inverse) : m_(m), inv_(inverse) {}

    static Transform Translate(const Vector3d &d);
    static Transform Scale(double x, double y, double z);
    // Angle in degrees about any axis of non-zero length.
    static Transform Rotate(double degrees, const Vector3d &axis);
    // World to camera as pbrt's LookAt: +z looks from eye to look, left-handed. Degenerate input (eye = look,
    // up parallel to the view) gives a singular matrix: ask IsSingular().
    static Transform LookAt(const Vector3d &eye, const Vector3d &look, const Vector3d &up);
    static Transform Perspective(double fovDegrees, double nearPlane, double farPlane);

    Transform operator*(const Transform &b) const;
    Transform Inverse() const { return {inv_, m_}; }
    bool operator==(const Transform &) const = default;
    bool IsIdentity() const;
    bool IsSingular() const; // also true where an element is NaN or infinite
    bool SwapsHandedness() const;
    // Whether lengths grow by factors that differ by more than a thousandth from one direction to another.
    // False for what is singular or not affine.
    bool ScalesUnevenly() const;
    double Determinant() const; // of the upper left 3x3
    const Matrix &M() const { return m_; }

    Point3f Point(const Point3f &p) const;
    Vector3f Vector(const Vector3f &v) const;
    Normal3f Normal(const Normal3f &n) const; // by the inverse transpose; not normalised
    Ray operator()(const Ray &r) const;
    Bounds3f operator()(const Bounds3f &b) const;

  private:
    Matrix m_, inv_;
};

} // namespace cuticle
