// Rays through a ball of hair, and how far several intersectors are from the truth: for the benchmark and the chart.
#pragma once

#include "shapes/curve_oracle.h"
#include "shapes/curve_set.h"

#include <functional>
#include <optional>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace cuticle {

inline constexpr size_t kSegmentsPerStrand = 8;
// Strands grow outward from a sphere of half the ball's radius 1, bending at random; radius 0.6 to 2 thousandths.
std::vector<CurveSegment> HairBall(size_t strands);

struct CurveTask {
    Ray ray;
    bool bounce = false;
    CurveOrigin origin; // of a bounce
    float clear = 0;    // where the ray is clear of the hair it leaves
};
// "camera": primary rays; "bounce": random walks from hair to hair, as a path tracer of light hair makes them.
struct CurveTasks {
    std::vector<CurveTask> camera, bounce;
};
// set holds the ball; side * side camera rays.
CurveTasks MakeCurveTasks(const CurveSet &set, int side = 400);

// Embree's curves over the same segments. A ray starts where it is clear of the hair that it leaves.
class EmbreeCurves {
  public:
    enum Kind { Flat, Round };
    // tessellation: Embree's rate for flat curves; 0: its default.
    EmbreeCurves(const std::vector<CurveSegment> &segments, Kind kind, float tessellation);
    ~EmbreeCurves();
    EmbreeCurves(const EmbreeCurves &) = delete;
    EmbreeCurves &operator=(const EmbreeCurves &) = delete;

    bool Intersect(const CurveTask &task, CurveHit *hit) const;
    bool Occluded(const CurveTask &task) const;
    double Bytes() const { return static_cast<double>(bytes_); }
    double BuildSeconds() const { return seconds_; }

  private:
    RTCDeviceTy *device_;
    RTCSceneTy *scene_;
    int64_t bytes_ = 0;
    double seconds_ = 0;
};

// What a ray truly meets: the nearest of all roots, in extended precision.
struct CurveTruth {
    CurveTask task; // starts where it is clear, with no origin: the same ray for all
    std::optional<oracle::Candidate> nearest;
};
// Of about `count` tasks, evenly chosen. Rays that a rounding error could turn from a hit to a miss are left out.
std::vector<CurveTruth> FindCurveTruths(const std::vector<CurveSegment> &segments,
                                        const std::vector<CurveTask> &tasks, size_t count);

struct CurveAccuracy {
    size_t rays = 0, missed = 0, invented = 0, otherHair = 0;
    std::vector<double> vError, tError; // rising; t in radii of the hair

    double WrongShare() const {
        return static_cast<double>(missed + invented + otherHair) / static_cast<double>(rays);
    }
    // 0 if nothing was hit.
    static double Percentile(const std::vector<double> &rising, double share);
};
// eitherSide: v may count from the other side of the hair.
CurveAccuracy CompareWithTruth(const std::vector<CurveSegment> &segments,
                               const std::vector<CurveTruth> &truths, bool eitherSide,
                               const std::function<bool(const CurveTask &, CurveHit *)> &intersect);

} // namespace cuticle
