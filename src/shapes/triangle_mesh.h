// Triangle meshes: what a scene gives, and what the set traces.
#pragma once

#include "core/vecmath.h"

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace cuticle {

struct ShapeSample;
struct SolidHit;

// Vertices in world space. n and uv are empty or hold one entry a vertex; indices: three a triangle. Without
// uv a triangle's corners have pbrt-v3's (0,0), (1,0), (1,1).
struct TriangleMesh {
    std::vector<Point3f> p;
    std::vector<Normal3f> n;
    std::vector<Point2f> uv;
    std::vector<uint32_t> indices;
};

// Says whether a mesh is there at a point (in its own coordinates); shadow: for a ray that asks for any hit.
// Called from any thread.
using MeshAlpha = std::function<bool(const Point3f &p, const Point2f &uv, bool shadow)>;

// A mesh made ready to be traced, with its geometry in double. Does not change once made; triangles are
// counted as they are kept, which is not as they were given where some were dropped.
class TracedMesh {
  public:
    // Triangles with an index out of range, a vertex that is not finite, or no area are dropped; one Warning
    // counts them. Normals or uv whose number differs from the vertices', or an index count that is no
    // multiple of 3: Error. flipNormals: pbrt-v3's reverseOrientation ^ transformSwapsHandedness. alpha: null
    // where the mesh is everywhere.
    TracedMesh(TriangleMesh mesh, bool flipNormals, MeshAlpha alpha);
    ~TracedMesh();
    TracedMesh(const TracedMesh &) = delete;
    TracedMesh &operator=(const TracedMesh &) = delete;

    // Vertices and indices as Embree shares them: of 16 bytes read at each vertex of 12, the last 4 are ours
    // as well.
    const TriangleMesh &Shared() const { return mesh_; }
    size_t Triangles() const { return mesh_.indices.size() / 3; }
    const Bounds3f &WorldBound() const { return bound_; }
    size_t MemoryBytes() const;

    // The place where a ray meets the plane of a triangle; b: the barycentric coordinates there, kept inside
    // the triangle.
    struct PlaneHit {
        double t;
        Vector3d b;
    };
    PlaneHit IntersectPlane(size_t triangle, const Ray &ray) const;
    // False in a hole of the mesh. shadow: see MeshAlpha.
    bool IsThere(size_t triangle, const Vector3d &b, bool shadow) const;
    // Computes all of a hit but t and the ids of its shape.
    void FillHit(size_t triangle, const Vector3d &b, SolidHit *hit) const;

    // Finds a direction and an angle around it, in radians, that holds every normal (SolidHit::n): pi where
    // vertex normals may turn them from point to point.
    void Normals(Vector3f *axis, float *angle) const;
    // In world space.
    double Area() const;
    // Samples a point uniformly over the area; pdf is per area. u in [0, 1)^2. False where there is none.
    bool Sample(const Point2f &u, ShapeSample *sample) const;
    // The same as seen from ref; pdf is per steradian. False also where ref lies in the triangle's plane.
    bool Sample(const Point3f &ref, const Point2f &u, ShapeSample *sample) const;
    // The density of that per steradian at a point of a triangle, counted as it was given; 0 where it was
    // dropped.
    float Pdf(const Point3f &ref, uint32_t given, const Point3f &p) const;

  private:
    struct Sampling; // what area lights need, made when first asked for

    void DropUselessTriangles();
    const Sampling &GetSampling() const;
    bool Sample(const Point2f &u, ShapeSample *sample, size_t *triangle, Vector3d *p) const;
    double HeightAbove(size_t triangle, const Point3f &ref) const;
    const uint32_t *Corners(size_t triangle) const { return &mesh_.indices[3 * triangle]; }
    Vector3d P(uint32_t vertex) const { return Vector3d(mesh_.p[vertex]); }
    Vector3d Point(size_t triangle, const Vector3d &b) const {
        const uint32_t *v = Corners(triangle);
        return P(v[0]) * b[0] + P(v[1]) * b[1] + P(v[2]) * b[2];
    }
    Vector3d AreaNormal(size_t triangle) const;
    float TriangleArea(size_t triangle) const {
        return static_cast<float>(AreaNormal(triangle).Length() / 2);
    }
    Vector3d ShadingNormal(size_t triangle, const Vector3d &b) const;
    Vector3d OrientedNormal(const Vector3d &areaNormal, const Vector3d &ns) const;
    void CornerUVs(size_t triangle, Vector2<double> uv[3]) const;

    TriangleMesh mesh_;
    std::vector<uint32_t> given_; // each triangle's number as it was given; empty if none was dropped
    bool flipNormals_;
    MeshAlpha alpha_;
    Bounds3f bound_;
    mutable std::once_flag samplingOnce_;
    mutable std::unique_ptr<const Sampling> sampling_;
};

} // namespace cuticle
