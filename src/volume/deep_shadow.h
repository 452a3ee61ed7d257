//> Declare deep shadow maps
#pragma once

#include "core/vecmath.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cuticle {

//> Keep how much light is left along a ray
// A corner of a visibility function: what share of the light is left at a depth.
struct VisibilityPoint {
    float depth, share;
};

// Brings a visibility function that is constant between steps (share[i] holds from steps[i].depth on, 1
// before the first; depths in order) to few straight pieces that are nowhere off by more than `error` (>= 0),
// but for rounding (Lokovic and Veach 2000). Two points at one depth are a step; after the last point the
// last share holds.
std::vector<VisibilityPoint> CompressVisibility(std::span<const VisibilityPoint> steps, float error);

// The share that straight pieces have at a depth; 1 before the first.
float VisibilityAt(std::span<const VisibilityPoint> pieces, float depth);
//<

//> Place a map before a light
// The rays of a light that does not shine from an area: parallel ones, or from a point into all directions.
struct LightRays {
    bool parallel = true;
    Frame frame;     // parallel: z is the direction of the light, x and y span the map
    Point3f origin;  // a corner of the map of parallel rays; else the point
    float width = 1; // parallel: side of the map
    // Parallel light of this direction (unit length) through a sphere around the bounds.
    static LightRays Parallel(const Vector3f &direction, const Bounds3f &bounds);
    static LightRays From(const Point3f &point);
    // The ray at a place of the map, u in [0, 1)^2, its direction of unit length; depth is along it.
    Ray At(const Point2f &u) const;
    // The place of the map whose ray passes through p, and p's depth.
    Point2f PlaceOf(const Point3f &p, float *depth) const;
    // How far apart neighbouring rays of a map of so many to a side are at that depth, about.
    float Spacing(size_t side, float depth) const {
        return (parallel ? width : 3 * depth) / static_cast<float>(side);
    }
};
//<

//> Declare a map of visibility functions
struct DeepShadowSettings {
    size_t side = 512;    // pixels
    size_t samples = 3;   // rays of a pixel, to a side: so many squared
    float error = 0.01f;  // of the compression
    float opacity = 0.5f; // share of the light that a crossing takes away, 0 to 1
};

// A square of visibility functions, one for each pixel.
class DeepShadowMap {
  public:
    // Calls crossing(depth) at each crossing of a ray with hair, in order; returns the depth from which on
    // nothing is lit (infinite: there is none). Safe from any thread.
    using TraceHair = std::function<float(const Ray &ray, const std::function<void(float depth)> &crossing)>;
    DeepShadowMap(const LightRays &rays, const DeepShadowSettings &settings, const TraceHair &trace);

    // The share of the light that reaches p: the functions of the four pixels around its place, weighted by
    // the tent, at p's depth less `bias`.
    float Share(const Point3f &p, float bias) const;
    const LightRays &Rays() const { return rays_; }
    size_t Points() const { return points_.size(); } // of all functions
    size_t Steps() const { return steps_; }          // of all functions before they were compressed
    size_t Bytes() const { return points_.size() * sizeof(VisibilityPoint) + first_.size() * sizeof(size_t); }

  private:
    std::span<const VisibilityPoint> Pixel(size_t x, size_t y) const {
        const size_t i = y * side_ + x;
        return {points_.data() + first_[i], first_[i + 1] - first_[i]};
    }
    LightRays rays_;
    size_t side_;
    size_t steps_ = 0;
    std::vector<VisibilityPoint> points_;
    std::vector<size_t> first_; // of each pixel's points
};
//<

} // namespace cuticle
//<
