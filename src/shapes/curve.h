//> One curve segment, plainly
#pragma once

#include "shapes/curve_types.h"

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

//> The curve as a shape
// A cubic Bezier segment with a width, met by rays one at a time: the recursive intersector of pbrt-v3 (Pharr, Jakob,
// Humphreys, Physically Based Rendering, 3rd ed., section 3.7; Nakamaru and Ohno 2002), in double precision and
// without any short cut. It is the text that the book explains, and the plain sibling that CurveSet is compared with.
class Curve {
  public:
    // normals: of a ribbon, null for the other types (a ribbon without normals is treated as flat).
    Curve(const CurveSegment &segment, CurveType type, const RibbonNormals *normals = nullptr);

    // The nearest hit with t in (ray.tMin, ray.tMax). surface may be null. hit->segment is left alone. A segment with
    // control points or widths that are not finite, or with no positive width, is never hit.
    bool Intersect(const Ray &ray, CurveHit *hit, CurveSurface *surface = nullptr) const;
    // True where there is such a hit.
    bool IntersectP(const Ray &ray) const { return Intersect(ray, nullptr); }
    // A box that holds every point within half the largest width of the curve.
    Bounds3f WorldBound() const;

  private:
    struct Search;
    bool RecursiveIntersect(Search *search, const Vector3d cp[4], double u0, double u1, int depth) const;
    bool IntersectLine(Search *search, const Vector3d cp[4], double u0, double u1) const;

    CurveSegment segment_;
    CurveType type_;
    RibbonNormals normals_;
    bool valid_;
};
//<

//> The surface at a hit
// The surface where `ray` met the segment at `hit` (pbrt-v3's conventions: v grows along ray.d x dp/du). Finite for
// every hit that Curve or CurveSet returns. normals: of a ribbon, else null.
CurveSurface MakeCurveSurface(const CurveSegment &segment, CurveType type, const RibbonNormals *normals,
                              const Ray &ray, const CurveHit &hit);
// The unit normal of a ribbon at u: the great arc between its two, at even speed.
Normal3f RibbonNormal(const RibbonNormals &normals, float u);
// The point and, where asked for, the derivatives at u of the cubic with these control points.
Vector3d EvalBezier(const Vector3d cp[4], double u, Vector3d *derivative = nullptr,
                    Vector3d *second = nullptr);
// True where all control points and widths are finite and some width is positive: what an intersector keeps.
bool IsUsable(const CurveSegment &segment);
//<

//> The bases of a scene file
enum class CurveBasis { Bezier, BSpline };

// How many segments `count` control points make in this basis and degree (2 or 3). 0: the numbers do not fit, and
// *error (may be null) says which would. Bezier: n * degree + 1 points, neighbours share an end point; B-spline:
// one segment for each point after the first `degree`.
size_t CurveSegmentCount(size_t count, CurveBasis basis, int degree, std::string *error = nullptr);

// Appends the cubic Bezier segments of one `Shape "curve"`, as pbrt-v3 cuts it: widths run linearly from width0 to
// width1 over all segments, u restarts in each. points: in the space of the result. A negative width is taken as 0; a
// width that is not finite is refused, as is a wrong number of points: then nothing is appended, *error (may be null)
// says why, and false is returned.
bool AppendCurve(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                 float width1, uint32_t group, std::vector<CurveSegment> *segments,
                 std::string *error = nullptr);

// The same for a ribbon: one normal for each end of a segment, CurveSegmentCount + 1 in all, of any length but zero.
bool AppendRibbon(const Point3f *points, size_t count, CurveBasis basis, int degree, float width0,
                  float width1, const Normal3f *normals, size_t normalCount, uint32_t group,
                  std::vector<CurveSegment> *segments,
                  std::unordered_map<uint32_t, RibbonNormals> *ribbonNormals, std::string *error = nullptr);
//<

} // namespace cuticle
//<
