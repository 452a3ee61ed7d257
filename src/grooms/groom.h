// Strands of hair as runs of points, and the way from points to smooth cubic Bezier segments.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// Says how the points of a strand are joined.
enum class StrandSpline {
    CatmullRom, // through all points; tangents by the centripetal parametrisation, which does not overshoot
    BSpline, // uniform cubic B-spline, clamped to the first and last point: smoother, inside the points' hull
    Linear,  // straight from point to point
    Bezier   // points are cubic Bezier control points: 3 n + 1 of them make n pieces
};

// The splines that may be asked for by name, "catmull-rom", "bspline", "linear"; nothing for any other name.
inline constexpr std::array<std::string_view, 3> kStrandSplines{"catmull-rom", "bspline", "linear"};
std::optional<StrandSpline> StrandSplineByName(std::string_view name);

// A set of strands. Every strand is a run of points from root to tip; strand i holds the points
// [strandOffsets[i], strandOffsets[i + 1]). Lengths are in the units of whoever made it: the procedural
// grooms are in centimetres, a .hair file in its own.
struct Groom {
    std::vector<uint32_t> strandOffsets{0};
    std::vector<Point3f> points;
    StrandSpline spline = StrandSpline::CatmullRom; // what the points are meant for

    // Full widths (diameters). pointWidths: one per point, or empty. strandWidths: root and tip of each
    // strand, linear between, or empty. When both are empty all points are `width` wide. At most one of them
    // is filled.
    std::vector<float> pointWidths;
    std::vector<std::array<float, 2>> strandWidths;
    float width = 0.008f;

    // Strands that stand under a transformation which scales unevenly, [begin, end): their points and widths
    // are those before it, since no width survives it. In order, apart from one another; all other strands
    // need none.
    struct Placement {
        size_t begin, end;
        Transform toGroom;
    };
    std::vector<Placement> placements;

    // Linear RGB: one per point, or empty. hasColor: `color` holds for all (pointColors empty).
    std::vector<Spectrum> pointColors;
    Spectrum color{0.5f};
    bool hasColor = false;

    size_t StrandCount() const { return strandOffsets.size() - 1; }
    size_t PointCount(size_t strand) const { return strandOffsets[strand + 1] - strandOffsets[strand]; }
    std::span<const Point3f> Strand(size_t strand) const {
        return {points.data() + strandOffsets[strand], PointCount(strand)};
    }
    // Width of point k of a strand.
    float Width(size_t strand, size_t k) const;
    // Colour at a place of a strand that BezierSegment::at gives: linear between the points.
    Spectrum Color(size_t strand, float at) const;
    // Mean colour over the points of a strand; `color` where there are no colours per point.
    Spectrum StrandColor(size_t strand) const;
    // Bounds the points, without their widths.
    Bounds3f Bounds() const;
    // Adds the strands of another groom that keeps widths and colours in the same arrays and joins its points
    // likewise (throws Error otherwise, and where the points would outgrow 32-bit offsets).
    void Append(const Groom &other);
};

struct SegmentOptions {
    // Instead of the groom's own; control points of Bezier curves cannot be joined otherwise, nor others as
    // such (Error).
    std::optional<StrandSpline> spline;
    // 0: one segment between neighbouring points; else every strand is first resampled to this many segments
    // of equal arc length.
    int segmentsPerStrand = 0;
};

// One cubic Bezier piece of a strand. width: full widths at u = 0 and u = 1, linear between. at: where on the
// strand its ends lie, counted in points from the root (1.5: midway between the second and the third). It is
// number `index` of the `count` pieces of its strand.
struct BezierSegment {
    Point3f cp[4];
    float width[2];
    float at[2];
    uint32_t index = 0, count = 1;
};

// Appends the Bezier pieces of one run of points to *out, root to tip. widths: one per point. Pieces join
// with a common point (bit for bit) and a common tangent direction. Coincident neighbours are merged; fewer
// than two distinct points give no piece.
void AppendSegments(std::span<const Point3f> points, std::span<const float> widths,
                    const SegmentOptions &options, std::vector<BezierSegment> *out);

// The same for strand number `strand` of a groom.
void AppendSegments(const Groom &groom, size_t strand, const SegmentOptions &options,
                    std::vector<BezierSegment> *out);

// The most curve segments that a scene holds: the accelerator counts them in 27 bits.
inline constexpr size_t kMaxSegments = (size_t(1) << 27) - 1;

// Throws Error where `segments` are more than kMaxSegments.
void CheckSegmentCount(size_t segments);

// A run of strands, [begin, end).
struct StrandRange {
    size_t begin = 0, end = 0;
};

// Returns how many pieces come from strands that all have points and no coincident ones: what to reserve.
size_t ExpectedSegments(const Groom &groom, const StrandRange &strands, const SegmentOptions &options);
size_t ExpectedSegments(const Groom &groom, const SegmentOptions &options); // of all strands

// Calls emit(segment, strand) for all pieces of these strands in order, from this thread; the pieces are made
// in parallel. Placements are left to the caller.
using EmitSegment = std::function<void(const BezierSegment &, size_t strand)>;
void ForEachSegment(const Groom &groom, const StrandRange &strands, const SegmentOptions &options,
                    const EmitSegment &emit);
void ForEachSegment(const Groom &groom, const SegmentOptions &options, const EmitSegment &emit);

// Calls use(strands, toGroom) for runs that together are all strands, in order; toGroom is null but for those
// of a placement.
void ForEachPlacement(const Groom &groom,
                      const std::function<void(const StrandRange &, const Transform *toGroom)> &use);

// Returns the groom without placements, for formats that know none: points are transformed, and widths by the
// mean factor, with a Warning in which `name` stands.
Groom WithoutPlacements(Groom groom, const std::string &name);

// Finds n + 1 points at equal arc lengths along the spline through `points`, with widths interpolated along
// it; n >= 1. The first and the last point stay. A strand of no length gives n + 1 equal points. outAt: where
// on the strand they lie, as BezierSegment::at; may be null.
void ResampleStrand(std::span<const Point3f> points, std::span<const float> widths, StrandSpline spline,
                    int n, std::vector<Point3f> *outPoints, std::vector<float> *outWidths,
                    std::vector<float> *outAt = nullptr);

// Returns the groom for readers that join points by themselves: Bezier control points become two points a
// piece that lie on the curve; any other groom stays as it is.
Groom PointsOnCurves(Groom groom);

} // namespace cuticle
