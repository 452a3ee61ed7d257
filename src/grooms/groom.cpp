#include "grooms/groom.h"

#include "core/error.h"
#include "core/parallel.h"

#include <algorithm>

namespace cuticle {

std::optional<StrandSpline> StrandSplineByName(std::string_view name) {
    constexpr std::array<StrandSpline, 3> splines{StrandSpline::CatmullRom, StrandSpline::BSpline,
                                                  StrandSpline::Linear};
    for (size_t i = 0; i < splines.size(); ++i)
        if (kStrandSplines[i] == name)
            return splines[i];
    return {};
}

float Groom::Width(size_t strand, size_t k) const {
    if (!pointWidths.empty())
        return pointWidths[strandOffsets[strand] + k];
    if (strandWidths.empty())
        return width;
    const size_t last = PointCount(strand) - 1;
    const float t = last == 0 ? 0.f : static_cast<float>(k) / static_cast<float>(last);
    return Lerp(t, strandWidths[strand][0], strandWidths[strand][1]);
}

Spectrum Groom::Color(size_t strand, float at) const {
    if (pointColors.empty() || PointCount(strand) == 0)
        return color;
    const size_t last = PointCount(strand) - 1;
    const float clamped = std::clamp(at, 0.f, static_cast<float>(last));
    const size_t k = std::min(static_cast<size_t>(clamped), last == 0 ? 0 : last - 1);
    const Spectrum *c = pointColors.data() + strandOffsets[strand] + k;
    const float t = clamped - static_cast<float>(k);
    return last == 0 ? c[0] : c[0] * (1 - t) + c[1] * t;
}

Spectrum Groom::StrandColor(size_t strand) const {
    if (pointColors.empty() || PointCount(strand) == 0)
        return color;
    std::array<double, 3> sum{};
    for (uint32_t i = strandOffsets[strand]; i < strandOffsets[strand + 1]; ++i)
        for (int c = 0; c < 3; ++c)
            sum[static_cast<size_t>(c)] += static_cast<double>(pointColors[i][c]);
    const double n = static_cast<double>(PointCount(strand));
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n), static_cast<float>(sum[2] / n)};
}

Bounds3f Groom::Bounds() const {
    Bounds3f b;
    ForEachPlacement(*this, [&](const StrandRange &strands, const Transform *toGroom) {
        for (uint32_t i = strandOffsets[strands.begin]; i < strandOffsets[strands.end]; ++i)
            b.Extend(toGroom ? toGroom->Point(points[i]) : points[i]);
    });
    return b;
}

void Groom::Append(const Groom &other) {
    if (other.StrandCount() == 0)
        return;
    const bool first = StrandCount() == 0;
    if (!first && (pointWidths.empty() != other.pointWidths.empty() ||
                   strandWidths.empty() != other.strandWidths.empty() ||
                   pointColors.empty() != other.pointColors.empty()))
        throw Error("grooms that keep widths or colours differently cannot be joined");
    if (!first && spline != other.spline)
        throw Error("grooms that join their points differently cannot be joined");
    if (points.size() + other.points.size() > std::numeric_limits<uint32_t>::max())
        throw Error("a groom holds at most 4294967295 points");
    if (first) {
        width = other.width;
        color = other.color;
        hasColor = other.hasColor;
        spline = other.spline;
    }
    for (const Placement &p : other.placements)
        placements.push_back({StrandCount() + p.begin, StrandCount() + p.end, p.toGroom});
    const auto base = static_cast<uint32_t>(points.size());
    for (size_t i = 1; i < other.strandOffsets.size(); ++i)
        strandOffsets.push_back(base + other.strandOffsets[i]);
    points.insert(points.end(), other.points.begin(), other.points.end());
    pointWidths.insert(pointWidths.end(), other.pointWidths.begin(), other.pointWidths.end());
    strandWidths.insert(strandWidths.end(), other.strandWidths.begin(), other.strandWidths.end());
    pointColors.insert(pointColors.end(), other.pointColors.begin(), other.pointColors.end());
}

namespace {

// Derivatives at each point with respect to the knots t_i, whose steps are the square roots of the chords
// (centripetal). Inside: the parabola through three points; at the ends: the parabola's end slope, so that a
// strand of three points is that parabola. Works in double: chords of far-away strands cancel.
void CentripetalTangents(const std::vector<Vector3d> &p, std::vector<double> *step,
                         std::vector<Vector3d> *tangent) {
    const size_t n = p.size();
    step->resize(n - 1);
    tangent->resize(n);
    for (size_t i = 0; i + 1 < n; ++i)
        (*step)[i] = std::sqrt((p[i + 1] - p[i]).Length());
    if (n == 2) {
        (*tangent)[0] = (*tangent)[1] = (p[1] - p[0]) / (*step)[0];
        return;
    }
    for (size_t i = 1; i + 1 < n; ++i) {
        const double a = (*step)[i - 1], b = (*step)[i];
        const Vector3d left = (p[i] - p[i - 1]) / a, right = (p[i + 1] - p[i]) / b;
        (*tangent)[i] = (left * b + right * a) / (a + b);
    }
    (*tangent)[0] = (p[1] - p[0]) * (2 / (*step)[0]) - (*tangent)[1];
    (*tangent)[n - 1] = (p[n - 1] - p[n - 2]) * (2 / (*step)[n - 2]) - (*tangent)[n - 2];
}

// Bezier control points, three to a piece and one more, as they stand; pieces of no extent are left out.
void PiecesOfControlPoints(std::span<const Point3f> points, std::span<const float> widths,
                           std::vector<BezierSegment> *out) {
    for (size_t i = 0; i + 3 < points.size(); i += 3) {
        const BezierSegment s{{points[i], points[i + 1], points[i + 2], points[i + 3]},
                              {widths[i], widths[i + 3]},
                              {static_cast<float>(i), static_cast<float>(i + 3)}};
        if (!(s.cp[0] == s.cp[1] && s.cp[1] == s.cp[2] && s.cp[2] == s.cp[3]))
            out->push_back(s);
    }
}

// The points of a strand without those that equal their predecessor, which have no tangent and carry no
// length.
struct DistinctPoints {
    std::vector<Vector3d> p;
    std::vector<Point3f> exact;
    std::vector<float> width, at;

    DistinctPoints(std::span<const Point3f> points, std::span<const float> widths) {
        for (size_t i = 0; i < points.size(); ++i) {
            const Vector3d q(points[i]);
            if (!p.empty() && !((q - p.back()).LengthSquared() > 0))
                continue;
            p.push_back(q);
            exact.push_back(points[i]);
            width.push_back(widths[i]);
            at.push_back(static_cast<float>(i));
        }
    }
    // The piece from point i to the next, whose inner control points are b and c.
    BezierSegment Piece(size_t i, const Vector3d &b, const Vector3d &c) const {
        return {
            {exact[i], Point3f(b), Point3f(c), exact[i + 1]}, {width[i], width[i + 1]}, {at[i], at[i + 1]}};
    }
};

void PiecesOfBSpline(const DistinctPoints &d, std::vector<BezierSegment> *out) {
    const std::vector<Vector3d> &p = d.p;
    const size_t n = p.size(), first = out->size();
    // Uniform B-spline by knot insertion; phantom points 2 p_0 - p_1 and 2 p_n - p_(n-1) clamp the ends.
    const auto joint = [&](size_t i) {
        return i == 0 || i == n - 1 ? d.exact[i] : Point3f((p[i - 1] + p[i] * 4 + p[i + 1]) / 6);
    };
    for (size_t i = 0; i + 1 < n; ++i) {
        BezierSegment s = d.Piece(i, (p[i] * 2 + p[i + 1]) / 3, (p[i] + p[i + 1] * 2) / 3);
        s.cp[0] = joint(i);
        s.cp[3] = joint(i + 1);
        out->push_back(s);
    }
    // A B-spline's joints may coincide where its points zigzag; pieces of no extent carry nothing.
    out->erase(std::remove_if(out->begin() + static_cast<ptrdiff_t>(first), out->end(),
                              [](const BezierSegment &s) {
                                  return s.cp[0] == s.cp[1] && s.cp[1] == s.cp[2] && s.cp[2] == s.cp[3];
                              }),
               out->end());
}

// The pieces between the given points, without resampling.
void PiecesThrough(std::span<const Point3f> points, std::span<const float> widths, StrandSpline spline,
                   std::vector<BezierSegment> *out) {
    if (spline == StrandSpline::Bezier)
        return PiecesOfControlPoints(points, widths, out);
    const DistinctPoints d(points, widths);
    const std::vector<Vector3d> &p = d.p;
    const size_t n = p.size();
    if (n < 2)
        return;
    if (spline == StrandSpline::BSpline)
        return PiecesOfBSpline(d, out);
    if (spline == StrandSpline::Linear) {
        for (size_t i = 0; i + 1 < n; ++i)
            out->push_back(d.Piece(i, (p[i] * 2 + p[i + 1]) / 3, (p[i] + p[i + 1] * 2) / 3));
        return;
    }
    std::vector<double> step;
    std::vector<Vector3d> tangent;
    CentripetalTangents(p, &step, &tangent);
    for (size_t i = 0; i + 1 < n; ++i)
        out->push_back(
            d.Piece(i, p[i] + tangent[i] * (step[i] / 3), p[i + 1] - tangent[i + 1] * (step[i] / 3)));
}

Vector3d EvaluateBezier(const BezierSegment &s, double u) {
    const Vector3d a(s.cp[0]), b(s.cp[1]), c(s.cp[2]), d(s.cp[3]);
    const double v = 1 - u;
    return a * (v * v * v) + b * (3 * v * v * u) + c * (3 * v * u * u) + d * (u * u * u);
}

} // namespace

void ResampleStrand(std::span<const Point3f> points, std::span<const float> widths, StrandSpline spline,
                    int n, std::vector<Point3f> *outPoints, std::vector<float> *outWidths,
                    std::vector<float> *outAt) {
    outPoints->clear();
    outWidths->clear();
    std::vector<float> unasked;
    std::vector<float> &at = outAt != nullptr ? *outAt : unasked;
    at.clear();
    if (points.empty() || n < 1)
        return;
    std::vector<BezierSegment> pieces;
    PiecesThrough(points, widths, spline, &pieces);
    if (pieces.empty()) {
        outPoints->assign(static_cast<size_t>(n) + 1, points[0]);
        outWidths->assign(static_cast<size_t>(n) + 1, widths[0]);
        at.assign(static_cast<size_t>(n) + 1, 0.f);
        return;
    }
    // Arc length by chords of a sixteenth of a piece; its relative error falls with the square of that step.
    constexpr int kSteps = 16;
    std::vector<double> length{0};
    length.reserve(pieces.size() * kSteps + 1);
    Vector3d previous = EvaluateBezier(pieces[0], 0);
    for (const BezierSegment &s : pieces)
        for (int k = 1; k <= kSteps; ++k) {
            const Vector3d q = EvaluateBezier(s, static_cast<double>(k) / kSteps);
            length.push_back(length.back() + (q - previous).Length());
            previous = q;
        }
    size_t chord = 0;
    for (int i = 0; i <= n; ++i) {
        if (i == 0 || i == n) {
            const BezierSegment &s = i == 0 ? pieces.front() : pieces.back();
            outPoints->push_back(i == 0 ? s.cp[0] : s.cp[3]);
            outWidths->push_back(i == 0 ? s.width[0] : s.width[1]);
            at.push_back(i == 0 ? s.at[0] : s.at[1]);
            continue;
        }
        const double goal = length.back() * i / n;
        while (chord + 2 < length.size() && length[chord + 1] < goal)
            ++chord;
        const double span = length[chord + 1] - length[chord];
        const double f = span > 0 ? std::clamp((goal - length[chord]) / span, 0., 1.) : 0.;
        const double u = (static_cast<double>(chord % kSteps) + f) / kSteps;
        const BezierSegment &s = pieces[chord / kSteps];
        outPoints->push_back(Point3f(EvaluateBezier(s, u)));
        outWidths->push_back(Lerp(static_cast<float>(u), s.width[0], s.width[1]));
        at.push_back(Lerp(static_cast<float>(u), s.at[0], s.at[1]));
    }
}

Groom PointsOnCurves(Groom groom) {
    if (groom.spline != StrandSpline::Bezier)
        return groom;
    Groom out;
    out.width = groom.width;
    out.color = groom.color;
    out.hasColor = groom.hasColor;
    std::vector<BezierSegment> pieces;
    const auto add = [&](size_t strand, const BezierSegment &s, float u) {
        out.points.push_back(Point3f(EvaluateBezier(s, static_cast<double>(u))));
        if (!groom.pointWidths.empty() || !groom.strandWidths.empty())
            out.pointWidths.push_back(Lerp(u, s.width[0], s.width[1]));
        if (!groom.pointColors.empty())
            out.pointColors.push_back(groom.Color(strand, Lerp(u, s.at[0], s.at[1])));
    };
    for (size_t strand = 0; strand < groom.StrandCount(); ++strand) {
        pieces.clear();
        AppendSegments(groom, strand, {}, &pieces);
        for (const BezierSegment &s : pieces) {
            add(strand, s, 0);
            add(strand, s, 0.5f);
        }
        if (pieces.empty())
            continue;
        add(strand, pieces.back(), 1);
        out.strandOffsets.push_back(static_cast<uint32_t>(out.points.size()));
    }
    return out;
}

void AppendSegments(std::span<const Point3f> points, std::span<const float> widths,
                    const SegmentOptions &options, std::vector<BezierSegment> *out) {
    const StrandSpline spline = options.spline.value_or(StrandSpline::CatmullRom);
    const size_t first = out->size();
    if (options.segmentsPerStrand <= 0) {
        PiecesThrough(points, widths, spline, out);
    } else {
        std::vector<Point3f> p;
        std::vector<float> w, at;
        ResampleStrand(points, widths, spline, options.segmentsPerStrand, &p, &w, &at);
        // The resampled points lie on the wanted curve already, whichever spline made it.
        PiecesThrough(p, w, spline == StrandSpline::Linear ? spline : StrandSpline::CatmullRom, out);
        for (size_t i = first; i < out->size(); ++i)
            for (float &a : (*out)[i].at)
                a = at[static_cast<size_t>(a)];
    }
    const size_t count = out->size() - first;
    for (size_t i = 0; i < count; ++i) {
        (*out)[first + i].index = static_cast<uint32_t>(i);
        (*out)[first + i].count = static_cast<uint32_t>(count);
    }
}

void AppendSegments(const Groom &groom, size_t strand, const SegmentOptions &options,
                    std::vector<BezierSegment> *out) {
    SegmentOptions joined = options;
    joined.spline = options.spline.value_or(groom.spline);
    if (joined.spline != groom.spline &&
        (joined.spline == StrandSpline::Bezier || groom.spline == StrandSpline::Bezier))
        throw Error(
            groom.spline == StrandSpline::Bezier
                ? "these strands are Bezier curves: their control points cannot be joined by another spline"
                : "the points of these strands are no Bezier control points");
    const std::span<const Point3f> points = groom.Strand(strand);
    if (!groom.pointWidths.empty()) {
        AppendSegments(points, {groom.pointWidths.data() + groom.strandOffsets[strand], points.size()},
                       joined, out);
        return;
    }
    std::vector<float> widths(points.size());
    for (size_t k = 0; k < widths.size(); ++k)
        widths[k] = groom.Width(strand, k);
    AppendSegments(points, widths, joined, out);
}

void CheckSegmentCount(size_t segments) {
    if (segments > kMaxSegments)
        throw Error("there would be {} curve segments", segments)
            .WithRemedy("a scene holds at most {}: use fewer strands or segments", kMaxSegments);
}

size_t ExpectedSegments(const Groom &groom, const StrandRange &range, const SegmentOptions &options) {
    const size_t strands = range.end - range.begin;
    if (options.segmentsPerStrand > 0)
        return strands * static_cast<size_t>(options.segmentsPerStrand);
    const size_t points = groom.strandOffsets[range.end] - groom.strandOffsets[range.begin];
    return points <= strands ? 0 : (points - strands) / (groom.spline == StrandSpline::Bezier ? 3 : 1);
}

size_t ExpectedSegments(const Groom &groom, const SegmentOptions &options) {
    return ExpectedSegments(groom, {0, groom.StrandCount()}, options);
}

void ForEachSegment(const Groom &groom, const SegmentOptions &options, const EmitSegment &emit) {
    ForEachSegment(groom, {0, groom.StrandCount()}, options, emit);
}

void ForEachSegment(const Groom &groom, const StrandRange &strands, const SegmentOptions &options,
                    const EmitSegment &emit) {
    // Batches made in parallel and handed on in order, so that memory stays small
    constexpr size_t kChunk = 256, kChunks = 64;
    struct Pieces {
        std::vector<BezierSegment> all;
        std::vector<size_t> ends; // by strand of the chunk
    };
    std::vector<Pieces> chunks(kChunks);
    for (size_t begin = strands.begin; begin < strands.end; begin += kChunk * kChunks) {
        ParallelFor(kChunks, [&](size_t c) {
            Pieces &pieces = chunks[c];
            pieces.all.clear();
            pieces.ends.clear();
            const size_t last = std::min(strands.end, begin + (c + 1) * kChunk);
            for (size_t strand = begin + c * kChunk; strand < last; ++strand) {
                AppendSegments(groom, strand, options, &pieces.all);
                pieces.ends.push_back(pieces.all.size());
            }
        });
        for (size_t c = 0; c < kChunks; ++c)
            for (size_t i = 0, k = 0; k < chunks[c].ends.size(); ++k)
                for (; i < chunks[c].ends[k]; ++i)
                    emit(chunks[c].all[i], begin + c * kChunk + k);
    }
}

void ForEachPlacement(const Groom &groom,
                      const std::function<void(const StrandRange &, const Transform *)> &use) {
    size_t next = 0;
    for (const Groom::Placement &p : groom.placements) {
        if (next < p.begin)
            use({next, p.begin}, nullptr);
        use({p.begin, p.end}, &p.toGroom);
        next = p.end;
    }
    if (next < groom.StrandCount())
        use({next, groom.StrandCount()}, nullptr);
}

Groom WithoutPlacements(Groom groom, const std::string &name) {
    if (groom.placements.empty())
        return groom;
    Warning("strands scaled unevenly",
            name + ": strands stand under a transformation that scales differently along different axes; "
                   "their widths are scaled by its mean factor");
    if (groom.pointWidths.empty()) { // a width for each point, since placements differ
        std::vector<float> widths;
        for (size_t i = 0; i < groom.StrandCount(); ++i)
            for (size_t k = 0; k < groom.PointCount(i); ++k)
                widths.push_back(groom.Width(i, k));
        groom.pointWidths = std::move(widths);
        std::vector<std::array<float, 2>>().swap(groom.strandWidths); // `= {}` would keep its memory
    }
    for (const Groom::Placement &p : groom.placements) {
        const auto scale = static_cast<float>(std::cbrt(std::abs(p.toGroom.Determinant())));
        for (uint32_t i = groom.strandOffsets[p.begin]; i < groom.strandOffsets[p.end]; ++i) {
            groom.points[i] = p.toGroom.Point(groom.points[i]);
            groom.pointWidths[i] *= scale;
        }
    }
    groom.placements.clear();
    return groom;
}

} // namespace cuticle
