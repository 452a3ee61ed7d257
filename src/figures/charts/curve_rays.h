// Rays through a ball of hair, and the errors of several intersectors, for the benchmark and the chart.
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
// A ball of radius 1: strands grow outward from a sphere of half of it, bending at random; their radius is
// 0.6 to 2 thousandths, times widthScale.
std::vector<CurveSegment> HairBall(size_t strands, float widthScale = 1);

// A ray to intersect. A bounce starts on a hair, at its origin, and is clear of it from the distance `clear`
// on.
struct CurveTask {
    Ray ray;
    bool bounce = false;
    CurveOrigin origin;
    float clear = 0;
};
// camera holds primary rays; bounce random walks from hair to hair, as a path tracer of light hair makes
// them.
struct CurveTasks {
    std::vector<CurveTask> camera, bounce;
};
// Makes side * side camera rays, and bounces from their hits. set holds the ball.
CurveTasks MakeCurveTasks(const CurveSet &set, int side = 400);

// Embree's curves over the same segments. Rays start where they are clear of the hair that they leave.
class EmbreeCurves {
  public:
    enum EmbreeShape { Flat, Round };
    // tessellation: Embree's rate for flat curves; 0: its default.
    EmbreeCurves(const std::vector<CurveSegment> &segments, EmbreeShape shape, float tessellation);
    ~EmbreeCurves();
    EmbreeCurves(const EmbreeCurves &) = delete;
    EmbreeCurves &operator=(const EmbreeCurves &) = delete;

    bool Intersect(const CurveTask &task, CurveHit *hit) const;
    bool Occluded(const CurveTask &task) const;
    double Bytes() const { return static_cast<double>(bytes_); }
    // CPU time of all threads, in seconds.
    double BuildSeconds() const { return seconds_; }

  private:
    RTCDeviceTy *device_;
    RTCSceneTy *scene_;
    int64_t bytes_ = 0;
    double seconds_ = 0;
};

// The true answer for a ray: the nearest of all roots, in extended precision.
struct CurveTruth {
    CurveTask task; // starts where it is clear, with no origin: the same ray for all
    std::optional<oracle::Candidate> nearest;
};
// Finds the truth for about `count` tasks, evenly chosen. Rays that a rounding error could turn from a hit to
// a miss are left out.
std::vector<CurveTruth> FindCurveTruths(const std::vector<CurveSegment> &segments,
                                        const std::vector<CurveTask> &tasks, size_t count);

// Counts of wrong answers, and errors of the right ones.
struct CurveAccuracy {
    size_t rays = 0, missed = 0, invented = 0, otherHair = 0;
    std::vector<double> vError, tError; // rising; t in radii of the hair

    double WrongShare() const {
        return static_cast<double>(missed + invented + otherHair) / static_cast<double>(rays);
    }
    // The value below which this share of the errors lies; 0 if nothing was hit.
    static double Percentile(const std::vector<double> &rising, double share);
};
// Compares an intersector with the truths. eitherSide: its v may count from the other side of the hair.
CurveAccuracy CompareWithTruth(const std::vector<CurveSegment> &segments,
                               const std::vector<CurveTruth> &truths, bool eitherSide,
                               const std::function<bool(const CurveTask &, CurveHit *)> &intersect);

} // namespace cuticle
