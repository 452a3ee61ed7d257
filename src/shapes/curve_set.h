//> Declare many curves at once
#pragma once

#include "shapes/curve_list.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

//> List what may be chosen about a curve set
struct CurveSetOptions {
    // The instruction set of the kernels, "sse2", "avx2" or "avx512", as ChooseIsa (core/isa.h) takes it:
    // empty means the program's own choice. An unknown name, or one that the processor lacks, throws Error.
    std::string isa;
    // The set holds each segment as 2^split pieces, 0 to 4; negative: the best that was measured, 1.
    int split = -1;
    // A ray that starts on a hair ignores that hair up to this many of its radii, measured across the hair.
    float selfReach = 1.5f;
};
//<

//> Declare the curve set
// CurveSet holds all curves of a scene (or of one object definition) in one bounding volume hierarchy of
// width 8. Leaves hold up to 16 pieces of curve as capsules; what a capsule lets through is solved on the
// true cubic, in double precision. It is thread-safe once built, and tree and hits are the same for any
// number of threads.
//
// A hit is defined so: the ray sees a curve as the ribbon that faces it, all points within half the width of
// the curve, measured at right angles to it. So with C(u) the curve relative to the ray, projected along it:
// C(u).C'(u) = 0 and |C(u)| <= width(u) / 2; of all such u in [0, 1] the one with the smallest t in
// (ray.tMin, ray.tMax) is the hit. A ribbon's width is first narrowed by the angle between its normal and the
// ray.
class CurveSet {
  public:
    CurveSet(); // holds nothing
    // groupTypes: the type of each CurveSegment::group (a group beyond its end is Flat). ribbons: the normals
    // of those segments that are ribbons, by index into segments. Segments with values that are not finite,
    // or without any width, stay in the list but are never hit: DroppedSegments() counts them. Built with all
    // threads of the current task arena.
    CurveSet(CurveList segments, std::vector<CurveType> groupTypes,
             const std::unordered_map<uint32_t, RibbonNormals> &ribbons = {},
             const CurveSetOptions &options = {});
    ~CurveSet();
    CurveSet(CurveSet &&) noexcept;
    CurveSet &operator=(CurveSet &&) noexcept;

    // Finds the nearest hit with t in (ray.tMin, ray.tMax), or returns false. origin: where on a curve of
    // this set the ray starts, or null. With it, the ray does not meet the strand that it leaves (the segment
    // and its neighbours joined end to end) before it is clear of it: t |d| <= selfReach * radius / sin(angle
    // between ray and strand), and no farther along the strand than the ray itself has gone. Other hairs are
    // met however near. A ray whose direction is zero or not finite, or whose origin is not finite, meets
    // nothing.
    bool Intersect(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const;
    // Returns whether there is any such hit.
    bool Occluded(const Ray &ray, const CurveOrigin *origin) const;

    // Computes the surface at a hit of `ray` that Intersect returned.
    CurveSurface Surface(const Ray &ray, const CurveHit &hit) const;

    Bounds3f WorldBound() const; // empty for a set that holds nothing
    size_t SegmentCount() const;
    size_t DroppedSegments() const;
    size_t MemoryBytes() const; // segments and accelerator
    CurveSegment Segment(uint32_t i) const;
    CurveType Type(uint32_t i) const;
    const RibbonNormals *Ribbon(uint32_t i) const; // null where it has none
    const char *Isa() const;                       // "sse2", "avx2" or "avx512"

  private:
    struct Data;
    std::unique_ptr<Data> data_;
};
//<

//> Declare the plain baseline
// BinaryCurveBvh does as pbrt-v3 does, for comparison: a binary tree over curves that were cut in
// 2^splitDepth pieces, each intersected by the recursion of Curve in single precision, at most maxDepth deep,
// one at a time. A ray that starts on a curve skips two widths, as pbrt-v3's error bound makes it do. The
// interface is CurveSet's.
class BinaryCurveBvh {
  public:
    BinaryCurveBvh(const CurveList &segments, std::vector<CurveType> groupTypes,
                   std::unordered_map<uint32_t, RibbonNormals> ribbons = {}, int splitDepth = 3,
                   int maxDepth = 10);
    ~BinaryCurveBvh();
    BinaryCurveBvh(BinaryCurveBvh &&) noexcept;
    BinaryCurveBvh &operator=(BinaryCurveBvh &&) noexcept;

    bool Intersect(const Ray &ray, const CurveOrigin *origin, CurveHit *hit) const;
    bool Occluded(const Ray &ray, const CurveOrigin *origin) const;
    CurveSurface Surface(const Ray &ray, const CurveHit &hit) const;
    Bounds3f WorldBound() const;
    size_t SegmentCount() const;
    size_t MemoryBytes() const;
    const CurveSegment &Segment(uint32_t i) const;

  private:
    struct Data;
    std::unique_ptr<Data> data_;
};
//<

} // namespace cuticle
//<
