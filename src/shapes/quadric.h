// Quadrics (spheres, disks, cylinders, cones, paraboloids, hyperboloids), intersected in object space and in
// double.
#pragma once

#include "core/vecmath.h"

namespace cuticle {

struct ShapeSample;
struct SolidHit;

// The upper three rows of an affine matrix, in double.
struct AffineMatrix {
    double m[3][4];
    explicit AffineMatrix(const Transform &t);
    Vector3d Point(const Vector3d &p) const { return Vector(p) + Vector3d(m[0][3], m[1][3], m[2][3]); }
    Vector3d Vector(const Vector3d &v) const {
        return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
    }
    // n times the transpose: the normal transformation of the inverse.
    Vector3d Transposed(const Vector3d &n) const {
        return {m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z, m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
                m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z};
    }
};

// To add one: give it a name here and in QuadricName, a maker below, its case in the switches of quadric.cpp,
// and an Add function in SolidSet.
enum class QuadricKind { Sphere, Disk, Cylinder, Cone, Paraboloid, Hyperboloid };
// pbrt-v3's name of the shape, "sphere" ...
const char *QuadricName(QuadricKind kind);

// A quadric with its place in the world. Every quadric but the disk is a surface of revolution about z,
// x^2 + y^2 = rho(z) with rho(z) = c0 + c1 z + c2 z^2, cut off at zMin, zMax and phiMax.
struct Quadric {
    // pbrt-v3's parameters, phiMax in degrees, clamped as there. A singular transformation or parameters that
    // are not finite: Error. Parameters that leave no surface: empty is set.
    static Quadric MakeSphere(const Transform &objectToWorld, float radius, float zMin, float zMax,
                              float phiMax, bool reverseOrientation);
    static Quadric MakeDisk(const Transform &objectToWorld, float height, float radius, float innerRadius,
                            float phiMax, bool reverseOrientation);
    static Quadric MakeCylinder(const Transform &objectToWorld, float radius, float zMin, float zMax,
                                float phiMax, bool reverseOrientation);
    static Quadric MakeCone(const Transform &objectToWorld, float radius, float height, float phiMax,
                            bool reverseOrientation);
    static Quadric MakeParaboloid(const Transform &objectToWorld, float radius, float zMin, float zMax,
                                  float phiMax, bool reverseOrientation);
    // The surface is pbrt-v3's, x^2 + y^2 = c0 + c2 z^2; a Warning says so where the segment from p1 to p2
    // sweeps another one.
    static Quadric MakeHyperboloid(const Transform &objectToWorld, const Point3f &p1, const Point3f &p2,
                                   float phiMax, bool reverseOrientation);

    // Finds the nearest hit with t in (tMin, tMax); *pObject is in object space.
    bool Intersect(const Ray &ray, double tMin, double tMax, double *t, Vector3d *pObject) const;
    // Computes all of a hit but t and the ids from the point in object space.
    void FillHit(const Vector3d &p, SolidHit *hit) const;
    Bounds3f WorldBounds() const;

    // Area in world space.
    double WorldArea() const;
    // Samples a point for u in [0, 1)^2, with a density per world area: uniform in object space; of a
    // hyperboloid uniform in z and phi. False where there is none.
    bool Sample(const Point2f &u, ShapeSample *sample) const;
    // Samples a point as seen from ref: a full sphere from outside uniformly in solid angle, all else by
    // area. False where it is seen edge-on, as a disk from its own plane.
    bool Sample(const Point3f &ref, const Point2f &u, ShapeSample *sample) const;
    // The density of Sample per steradian from ref at a point of the surface in world space.
    float Pdf(const Point3f &ref, const Point3f &world) const;

    QuadricKind kind;
    bool empty = false; // no surface: no ray meets it

  private:
    Quadric(QuadricKind k, const Transform &t, float phiMaxDegrees, bool reverse);
    void MarkEmpty();

    double Rho(double z) const { return c0_ + z * (c1_ + z * c2_); }
    double RhoPrime(double z) const { return c1_ + 2 * z * c2_; }
    double V(double z) const { return (z - v0_) / (v1_ - v0_); }
    // Returns where the sweep begins at height z, as a vector across the axis.
    Vector3d SweepStart(double z) const { return twist0_ + (twist1_ - twist0_) * V(z); }
    double Phi(const Vector3d &p) const; // in [0, 2 pi)
    bool Clipped(const Vector3d &p) const;
    Vector3d Refined(const Vector3d &p) const;
    int Roots(const Vector3d &o, const Vector3d &d, double roots[2]) const;
    Vector3d ObjectNormal(const Vector3d &p) const;
    Vector3d WorldNormal(const Vector3d &pObject) const;
    Vector3f TransformError(const Vector3d &p) const;
    double ObjectDensity(const Vector3d &p) const;
    double AreaDensity(const Vector3d &p) const { return ObjectDensity(p) / Stretch(p); }
    struct Viewer;
    Viewer ViewerAt(const Point3f &ref) const;
    bool SampleCone(const Viewer &viewer, const Point2f &u, ShapeSample *sample) const;
    float SeenDensity(const Viewer &viewer, const Vector3d &p, ShapeSample *sample) const;
    double Slant(double z) const;
    bool SampleObject(double u0, double u1, Vector3d *p) const;
    bool SamplePlace(const Point2f &u, Vector3d *p, ShapeSample *sample) const;
    double Stretch(const Vector3d &p) const;
    double MaxRadius() const;

    AffineMatrix objectToWorld_, worldToObject_;
    double radius_ = 1, innerRadius_ = 0, height_ = 0; // of the sphere, the cylinder and the disk
    double c0_ = 0, c1_ = 0, c2_ = 0;
    double zMin_ = -1, zMax_ = 1, phiMax_;         // phiMax in radians
    double thetaMin_ = kPi<double>, thetaMax_ = 0; // of the sphere, at zMin and zMax
    double v0_ = 0, v1_ = 1;                       // of the others: z where v is 0 and 1
    // The hyperboloid has phi = 0 where the mean of these two, by V, points.
    Vector3d twist0_{1, 0, 0}, twist1_{1, 0, 0};
    bool reverseOrientation_ = false;
    double worldRadius_ = 0; // of a full sphere that is still a sphere in world space, else 0
    Vector3d center_;        // in world space
};

} // namespace cuticle
