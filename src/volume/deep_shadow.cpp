//> Define deep shadow maps
#include "volume/deep_shadow.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>

namespace cuticle {

//> Compress a visibility function
namespace {

// Joins the corners of a visibility function by straight lines as long as one passes all of them within the
// error, then begins a new one.
class StraightPieces {
  public:
    StraightPieces(float depth, float error) : error_(error), end_(depth), points_{{depth, 1}} {}
    // Corners come in the order of their depths; shares never grow.
    void Pass(const VisibilityPoint &corner) {
        if (Narrow(corner))
            return;
        Finish();
        if (!Narrow(corner))
            points_.push_back(corner); // a step, exactly
    }
    std::vector<VisibilityPoint> Take() {
        Finish();
        return std::move(points_);
    }

  private:
    // Leaves of the lines from the last point those that pass the corner; false, and all are left, if none
    // does.
    bool Narrow(const VisibilityPoint &corner) {
        const VisibilityPoint &from = points_.back();
        const float length = corner.depth - from.depth;
        if (!(length > 0))
            return std::abs(corner.share - from.share) <= error_;
        const float low = std::max(low_, (std::max(corner.share - error_, 0.f) - from.share) / length),
                    high = std::min(high_, (corner.share + error_ - from.share) / length);
        if (low > high)
            return false;
        low_ = low, high_ = high, end_ = corner.depth;
        return true;
    }
    // Ends the line at the last corner that it passed.
    void Finish() {
        const VisibilityPoint &from = points_.back();
        if (const float length = end_ - from.depth; length > 0)
            points_.push_back({end_, std::clamp(from.share + (low_ + high_) / 2 * length, 0.f, from.share)});
        low_ = -Infinity, high_ = 0, end_ = points_.back().depth;
    }
    const float error_;
    float low_ = -Infinity, high_ = 0; // slopes; light never grows
    float end_;
    std::vector<VisibilityPoint> points_;
};

} // namespace

std::vector<VisibilityPoint> CompressVisibility(std::span<const VisibilityPoint> steps, float error) {
    if (steps.empty())
        return {};
    StraightPieces pieces(steps[0].depth, error);
    float share = 1;
    for (const VisibilityPoint &step : steps) {
        pieces.Pass({step.depth, share}); // each step has two corners
        pieces.Pass(step);
        share = step.share;
    }
    return pieces.Take();
}
//<

//> Read a visibility function
float VisibilityAt(std::span<const VisibilityPoint> pieces, float depth) {
    const auto after = std::upper_bound(pieces.begin(), pieces.end(), depth,
                                        [](float d, const VisibilityPoint &p) { return d < p.depth; });
    if (after == pieces.begin())
        return 1;
    const VisibilityPoint &a = *(after - 1);
    if (after == pieces.end())
        return a.share;
    return Lerp((depth - a.depth) / (after->depth - a.depth), a.share, after->share);
}
//<

//> Map the directions around a point to a square, and back
namespace {

float SignOf(float v) { return v < 0 ? -1.f : 1.f; }

// An octahedron, unfolded: its upper half is a square that stands on a corner, the lower half the four
// corners of the square around it.
Vector3f DirectionAt(const Point2f &u) {
    const float x = 2 * u.x - 1, y = 2 * u.y - 1, z = 1 - std::abs(x) - std::abs(y);
    const float fold = std::max(-z, 0.f);
    return Normalize(Vector3f{x - SignOf(x) * fold, y - SignOf(y) * fold, z});
}
Point2f PlaceOfDirection(const Vector3f &d) {
    const Vector3f q = d / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    const float x = q.z < 0 ? (1 - std::abs(q.y)) * SignOf(q.x) : q.x,
                y = q.z < 0 ? (1 - std::abs(q.x)) * SignOf(q.y) : q.y;
    return {(x + 1) / 2, (y + 1) / 2};
}

} // namespace
//<

//> Place the map
LightRays LightRays::Parallel(const Vector3f &direction, const Bounds3f &bounds) {
    LightRays rays;
    rays.frame = Frame::FromZ(direction);
    const float radius = std::max(bounds.Diagonal().Length() / 2 * 1.001f, 1e-20f);
    rays.width = 2 * radius;
    rays.origin = bounds.Center() - (rays.frame.x + rays.frame.y + rays.frame.z) * radius;
    return rays;
}

LightRays LightRays::From(const Point3f &point) {
    LightRays rays;
    rays.parallel = false;
    rays.origin = point;
    return rays;
}

Ray LightRays::At(const Point2f &u) const {
    if (parallel)
        return {origin + frame.x * (u.x * width) + frame.y * (u.y * width), frame.z};
    return {origin, DirectionAt(u)};
}

Point2f LightRays::PlaceOf(const Point3f &p, float *depth) const {
    const Vector3f to = p - origin;
    if (parallel) {
        *depth = Dot(to, frame.z);
        return {Dot(to, frame.x) / width, Dot(to, frame.y) / width};
    }
    *depth = to.Length();
    return *depth > 0 ? PlaceOfDirection(to) : Point2f{0.5f, 0.5f};
}
//<

//> Gather the visibility of a pixel
namespace {

// A ray meets something at a depth: hair, or the end of its light.
struct RayEvent {
    float depth, loss; // loss: of the share of the whole pixel
};

std::vector<VisibilityPoint> PixelSteps(const LightRays &rays, const DeepShadowSettings &settings, size_t x,
                                        size_t y, const DeepShadowMap::TraceHair &trace) {
    std::vector<RayEvent> events;
    const auto n = static_cast<float>(settings.samples), side = static_cast<float>(settings.side);
    for (size_t i = 0; i < settings.samples * settings.samples; ++i) {
        const float a = (static_cast<float>(i % settings.samples) + 0.5f) / n,
                    b = (static_cast<float>(i / settings.samples) + 0.5f) / n;
        float left = 1 / (n * n); // of this ray
        const float end =
            trace(rays.At({(static_cast<float>(x) + a) / side, (static_cast<float>(y) + b) / side}),
                  [&](float depth) {
                      events.push_back({depth, left * settings.opacity});
                      left *= 1 - settings.opacity;
                  });
        if (end < Infinity)
            events.push_back({end, left});
    }
    std::stable_sort(events.begin(), events.end(),
                     [](const RayEvent &a, const RayEvent &b) { return a.depth < b.depth; });
    std::vector<VisibilityPoint> steps;
    double share = 1;
    for (const RayEvent &e : events) {
        share -= static_cast<double>(e.loss);
        const auto left = std::max(static_cast<float>(share), 0.f);
        if (!steps.empty() && steps.back().depth == e.depth)
            steps.back().share = left;
        else
            steps.push_back({e.depth, left});
    }
    return steps;
}

} // namespace
//<

//> Make the map, row by row
DeepShadowMap::DeepShadowMap(const LightRays &rays, const DeepShadowSettings &settings,
                             const TraceHair &trace)
    : rays_(rays), side_(settings.side) {
    CHECK(settings.side >= 1 && settings.samples >= 1);
    struct Row {
        std::vector<VisibilityPoint> points;
        std::vector<size_t> counts;
        size_t steps = 0;
    };
    std::vector<Row> rows(side_);
    ParallelFor(side_, [&](size_t y) {
        for (size_t x = 0; x < side_; ++x) {
            const auto steps = PixelSteps(rays, settings, x, y, trace);
            const auto pieces = CompressVisibility(steps, settings.error);
            rows[y].steps += steps.size();
            rows[y].counts.push_back(pieces.size());
            rows[y].points.insert(rows[y].points.end(), pieces.begin(), pieces.end());
        }
    });
    first_.push_back(0);
    for (const Row &row : rows) {
        steps_ += row.steps;
        points_.insert(points_.end(), row.points.begin(), row.points.end());
        for (const size_t count : row.counts)
            first_.push_back(first_.back() + count);
    }
}
//<

//> Look a point up
float DeepShadowMap::Share(const Point3f &p, float bias) const {
    float depth;
    const Point2f place = rays_.PlaceOf(p, &depth);
    const float last = static_cast<float>(side_ - 1);
    const float x = std::clamp(place.x * static_cast<float>(side_) - 0.5f, 0.f, last),
                y = std::clamp(place.y * static_cast<float>(side_) - 0.5f, 0.f, last);
    const auto x0 = static_cast<size_t>(x), y0 = static_cast<size_t>(y);
    const size_t x1 = std::min(x0 + 1, side_ - 1), y1 = std::min(y0 + 1, side_ - 1);
    const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0), at = depth - bias;
    return (VisibilityAt(Pixel(x0, y0), at) * (1 - a) + VisibilityAt(Pixel(x1, y0), at) * a) * (1 - b) +
           (VisibilityAt(Pixel(x0, y1), at) * (1 - a) + VisibilityAt(Pixel(x1, y1), at) * a) * b;
}
//<

} // namespace cuticle
//<
