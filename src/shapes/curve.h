//> Declare one curve segment
#pragma once

#include "shapes/curve_list.h"

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

//> Search along one curve
// CurveSearch finds the nearest hit of a ray on a cubic Bezier segment with a width, by the recursion of
// pbrt-v3 (Pharr, Jakob, Humphreys, Physically Based Rendering, 3rd ed., section 3.7; Nakamaru and Ohno
// 2002): cut the curve in two, leave out what the ray cannot reach, and stop where the rest is easy. Curve,
// the plain sibling that CurveSet is compared with, stops where the ray is square to a part at one place at
// most, in double; BinaryCurveBvh stops where a part is straight, as pbrt-v3 does, in float.
template <typename T>
class CurveSearch {
  public:
    // flatness: how far a part may be from its chord to count as straight, in widths; 0: that does not count.
    // normals: null except for ribbons. maxDepth: how often the curve is halved at most.
    CurveSearch(const CurveSegment &segment, const RibbonNormals *normals, const Ray &ray, T flatness,
                int maxDepth);
    // Searches the part [u0, u1] of the segment. True: there is a hit nearer than those of earlier calls.
    bool Intersect(T u0, T u1);
    // Returns the nearest hit so far; valid once Intersect has returned true. The segment's index is 0.
    CurveHit Hit() const;

  private:
    bool Recurse(const Vector3<T> cp[4], T u0, T u1, int depth);
    bool IntersectLine(const Vector3<T> cp[4], T u0, T u1);
    bool IntersectAt(const Vector3<T> cp[4], T u0, T u1, T w);
    T WidthSeen(T u) const;

    const CurveSegment &segment_;
    const RibbonNormals *normals_;
    T flatness_;
    int maxDepth_;
    Vector3<T> o_, x_, y_, z_; // the ray's frame: origin, and axes of which z runs along the ray
    T length_;                 // of the ray's direction
    T zMin_, zMax_;            // hits count between these distances
    T still_ = 0;              // where c' is no longer than this, the curve stands still
    T hitZ_ = 0, hitU_ = 0, hitV_ = 0;
};
//<

//> Declare the curve as a shape
// Curve intersects one segment in double precision, slowly: the reference for CurveSet. Its hits are those of
// CurveSet's definition: every u with C.C' = 0, seen from any direction, nearly along the curve as well.
class Curve {
  public:
    // normals: of a ribbon, null for the other types (a ribbon without normals is treated as flat).
    Curve(const CurveSegment &segment, CurveType type, const RibbonNormals *normals = nullptr);

    // Finds the nearest hit with t in (ray.tMin, ray.tMax). surface may be null. hit->segment is left alone.
    // A segment with control points or widths that are not finite, or with no positive width, is never hit.
    bool Intersect(const Ray &ray, CurveHit *hit, CurveSurface *surface = nullptr) const;
    // Returns whether there is such a hit.
    bool IntersectP(const Ray &ray) const;
    // Returns a box that holds every point within half the largest width of the curve.
    Bounds3f WorldBound() const;

  private:
    const RibbonNormals *Normals() const { return type_ == CurveType::Ribbon ? &normals_ : nullptr; }

    CurveSegment segment_;
    CurveType type_;
    RibbonNormals normals_;
};
//<

//> Declare the surface at a hit
// Computes the surface where `ray` met the segment at `hit` (pbrt-v3's conventions: v grows along ray.d x
// dp/du). It is finite for every hit that Curve or CurveSet returns. normals: of a ribbon, else null.
CurveSurface MakeCurveSurface(const CurveSegment &segment, CurveType type, const RibbonNormals *normals,
                              const Ray &ray, const CurveHit &hit);
// Returns the unit normal of a ribbon at u, on the great arc between the normals of its two ends, at even
// speed.
Normal3f RibbonNormal(const RibbonNormals &normals, float u);
// Evaluates the cubic with these control points at u: the point and, where asked for, the first two
// derivatives.
Vector3d EvalBezier(const Vector3d cp[4], double u, Vector3d *derivative = nullptr,
                    Vector3d *second = nullptr);
// Returns whether an intersector keeps a segment: its control points are within reach and not all the same,
// its widths are finite, and the larger one is positive and at most kMaxCoordinate.
bool IsUsable(const CurveSegment &segment);
//<

//> Read the bases of a scene file
enum class CurveBasis { Bezier, BSpline };

// Counts the segments that `count` control points make in this basis and degree (2 or 3). 0: the numbers do
// not fit, and *error (may be null) says which would. Bezier: n * degree + 1 points, neighbours share an end
// point; B-spline: one segment for each point after the first `degree`.
size_t CurveSegmentCount(size_t count, CurveBasis basis, int degree, std::string *error = nullptr);

// Appends the cubic Bezier segments of one `Shape "curve"`, as pbrt-v3 cuts it: widths run linearly from
// width0 to width1 over all segments, u restarts in each; together they are a strand. points: in the space of
// the result. A negative width is taken as 0; a width that is not finite is refused, as is a wrong number of
// points: then nothing is appended, *error (may be null) says why, and false is returned.
bool AppendCurve(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                 float width1, uint32_t group, CurveList *segments, std::string *error = nullptr);

// Appends a ribbon in the same way. It needs a normal at each joint, ends included: CurveSegmentCount + 1 in
// all, of any length but zero.
bool AppendRibbon(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                  float width1, const Normal3f *normals, size_t normalCount, uint32_t group,
                  CurveList *segments, std::unordered_map<uint32_t, RibbonNormals> *ribbonNormals,
                  std::string *error = nullptr);
//<

} // namespace cuticle
//<
