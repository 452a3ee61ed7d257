// Everything that is not a curve: triangle meshes and quadrics (spheres, disks, cylinders, cones,
// paraboloids, hyperboloids), traced by Embree. Quadrics are Embree's user geometry, intersected here in
// object space and in double.
#pragma once

#include "core/vecmath.h"
#include "shapes/triangle_mesh.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace cuticle {

// A hit on a solid. n is the geometric normal, of unit length and not turned toward the ray: the cross
// product that pbrt-v3 takes, flipped for flipNormals, and for a mesh with vertex normals turned to their
// side. ns is the shading normal (n where there is none better). uv and dpdu, dpdv are pbrt-v3's
// parameterisation; where it is degenerate, dpdu and dpdv are any frame across n. |true p - p| <= pError in
// each coordinate.
struct SolidHit {
    float t = 0;
    Point3f p;
    Vector3f pError;
    Normal3f n, ns;
    Point2f uv;
    Vector3f dpdu, dpdv;
    uint32_t shapeId = 0;    // as given to Add...
    uint32_t geometryId = 0; // as returned by Add...
    uint32_t primId = 0;     // triangle of the mesh, counted as in its indices; 0 for quadrics
};

// Minimal hit record during traversal; SolidSet::Describe computes the rest.
struct SolidPoint {
    float t = 0;
    uint32_t geometryId = 0;
    uint32_t triangle = 0; // of the mesh as it is stored
    Vector3d p;            // of a quadric: in object space. Of a triangle: barycentric coordinates
};

// A point on a surface. pdf is per unit area, or per unit solid angle where a reference point was given.
struct ShapeSample {
    Point3f p;
    Vector3f pError;
    Normal3f n; // oriented as SolidHit::n
    float pdf = 0;
    // The next three tell the way from a reference point to p, where one was given. All are computed in
    // double, before p is rounded: near the surface, and at grazing angles, p and n would say nothing of the
    // side any more.
    Vector3f wi; // of unit length
    float distance = 0;
    float cosine = 0; // between n and the way back: above 0 where the side is seen that n points to
};

// Returns the density per solid angle, from the start of `way` to a point of normal n (unit length) on a
// surface, of points that have the density pdfArea per area. Or, by the height of the start above the plane
// of that point, where it is known better than as Dot(-way, n). Fills in wi, distance and cosine of *sample
// (which may be null). 0 where the surface is seen edge-on or the density is beyond what a float holds.
float SolidAngleDensity(double pdfArea, const Vector3d &way, const Vector3d &n, ShapeSample *sample);
float SolidAngleDensity(double pdfArea, const Vector3d &way, double height, ShapeSample *sample);

// Returns the origin for a ray that leaves p toward w without meeting the surface again: p moved along n by
// as much as pError allows p to be off, on the side of w, and each coordinate rounded away from p (pbrt-v3,
// section 3.9.5).
Point3f OffsetRayOrigin(const Point3f &p, const Vector3f &pError, const Normal3f &n, const Vector3f &w);

// SolidSet holds the solids of a scene or of one object. Add shapes, Commit() once, then ask from any number
// of threads. Every Add returns a geometry id, counted from 0. flipNormals is pbrt-v3's reverseOrientation ^
// transformSwapsHandedness; quadrics take reverseOrientation alone, as their transformation is known.
class SolidSet {
  public:
    SolidSet();
    ~SolidSet();
    SolidSet(SolidSet &&) noexcept;
    SolidSet &operator=(SolidSet &&) noexcept;

    using MeshAlpha = cuticle::MeshAlpha;
    // Triangles with an index out of range, a vertex that is not finite, or no area are dropped; one Warning
    // counts them. Normals or uv whose number differs from the vertices', or an index count that is no
    // multiple of 3: Error.
    uint32_t AddMesh(TriangleMesh mesh, uint32_t shapeId, bool flipNormals, MeshAlpha alpha = {});
    // pbrt-v3's parameters, phiMax in degrees, clamped as there. A singular transformation or parameters that
    // are not finite: Error. A radius of 0 or an empty sweep: a Warning, and a shape that no ray meets.
    uint32_t AddSphere(const Transform &objectToWorld, float radius, float zMin, float zMax, float phiMax,
                       uint32_t shapeId, bool reverseOrientation);
    uint32_t AddDisk(const Transform &objectToWorld, float height, float radius, float innerRadius,
                     float phiMax, uint32_t shapeId, bool reverseOrientation);
    uint32_t AddCylinder(const Transform &objectToWorld, float radius, float zMin, float zMax, float phiMax,
                         uint32_t shapeId, bool reverseOrientation);
    uint32_t AddCone(const Transform &objectToWorld, float radius, float height, float phiMax,
                     uint32_t shapeId, bool reverseOrientation);
    uint32_t AddParaboloid(const Transform &objectToWorld, float radius, float zMin, float zMax, float phiMax,
                           uint32_t shapeId, bool reverseOrientation);
    // pbrt-v3's surface, x^2 + y^2 = c0 + c2 z^2: it is the one that the segment from p1 to p2 sweeps only if
    // that is symmetric in z; otherwise a Warning says so.
    uint32_t AddHyperboloid(const Transform &objectToWorld, const Point3f &p1, const Point3f &p2,
                            float phiMax, uint32_t shapeId, bool reverseOrientation);
    void Commit();

    // Finds the nearest hit with t in (ray.tMin, ray.tMax). A ray with a NaN or without a direction meets
    // nothing.
    bool Intersect(const Ray &ray, SolidPoint *point) const;
    SolidHit Describe(const SolidPoint &point) const;
    bool Intersect(const Ray &ray, SolidHit *hit) const; // Intersect and Describe
    bool Occluded(const Ray &ray) const;
    Bounds3f WorldBound() const; // empty without shapes
    size_t Geometries() const;
    size_t MemoryBytes() const; // Embree's and ours

    // --- for area lights ---
    // Returns the area in world space.
    float Area(uint32_t geometryId) const;
    Bounds3f Bound(uint32_t geometryId) const; // empty where the geometry has no surface
    // Finds a direction and an angle around it, in radians, that holds every normal (SolidHit::n).
    void Normals(uint32_t geometryId, Vector3f *axis, float *angle) const;
    // Samples a point uniformly over the area (for a quadric under a transformation that is no similarity:
    // uniform in object space, with the density that makes; for a hyperboloid uniform in z and phi). u in
    // [0,1)^2. False for a shape of no area, and where a hyperboloid of two sheets has none.
    bool Sample(uint32_t geometryId, const Point2f &u, ShapeSample *sample) const;
    // Samples a point as seen from ref: on a full sphere that ref is outside of by solid angle, on all else
    // by area; pdf is per steradian. A ref that is on a quadric as far as its rounded coordinates tell is
    // taken to be on it exactly. False where pdf would be 0 or infinite, and for a triangle or a disk whose
    // plane holds ref: what is seen of it there is rounding, and is left to rays that meet it by chance.
    bool Sample(uint32_t geometryId, const Point3f &ref, const Point2f &u, ShapeSample *sample) const;
    // Returns the density per steradian with which Sample(geometryId, ref, ...) picks the direction that led
    // to hit.
    float Pdf(const Point3f &ref, const SolidHit &hit) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cuticle
