#include "grooms/groom.h"

#include "core/error.h"

#include <algorithm>

namespace cuticle {

float Groom::Width(size_t strand, size_t k) const {
    if (!pointWidths.empty())
        return pointWidths[strandOffsets[strand] + k];
    if (strandWidths.empty())
        return width;
    const size_t last = PointCount(strand) - 1;
    const float t = last == 0 ? 0.f : static_cast<float>(k) / static_cast<float>(last);
    return Lerp(t, strandWidths[strand][0], strandWidths[strand][1]);
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
    for (const Point3f &p : points)
        b.Extend(p);
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
    if (points.size() + other.points.size() > std::numeric_limits<uint32_t>::max())
        throw Error("a groom holds at most 4294967295 points");
    if (first) {
        width = other.width;
        color = other.color;
        hasColor = other.hasColor;
    }
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

// The pieces between the given points, without resampling.
void PiecesThrough(std::span<const Point3f> points, std::span<const float> widths, StrandSpline spline,
                   std::vector<BezierSegment> *out) {
    // Merge coincident neighbours: they have no tangent and carry no length.
    std::vector<Vector3d> p;
    std::vector<float> w;
    std::vector<Point3f> exact;
    for (size_t i = 0; i < points.size(); ++i) {
        const Vector3d q(points[i]);
        if (!p.empty() && !((q - p.back()).LengthSquared() > 0))
            continue;
        p.push_back(q);
        exact.push_back(points[i]);
        w.push_back(widths[i]);
    }
    const size_t n = p.size();
    if (n < 2)
        return;
    const size_t first = out->size();
    if (spline == StrandSpline::CatmullRom) {
        std::vector<double> step;
        std::vector<Vector3d> tangent;
        CentripetalTangents(p, &step, &tangent);
        for (size_t i = 0; i + 1 < n; ++i) {
            BezierSegment s;
            s.cp[0] = exact[i];
            s.cp[1] = Point3f(p[i] + tangent[i] * (step[i] / 3));
            s.cp[2] = Point3f(p[i + 1] - tangent[i + 1] * (step[i] / 3));
            s.cp[3] = exact[i + 1];
            s.width[0] = w[i];
            s.width[1] = w[i + 1];
            out->push_back(s);
        }
        return;
    }
    // Uniform B-spline by knot insertion; phantom points 2 p_0 - p_1 and 2 p_n - p_(n-1) clamp the ends.
    const auto at = [&](ptrdiff_t i) {
        if (i < 0)
            return p[0] * 2 - p[1];
        if (i >= static_cast<ptrdiff_t>(n))
            return p[n - 1] * 2 - p[n - 2];
        return p[static_cast<size_t>(i)];
    };
    const auto joint = [&](ptrdiff_t i) {
        if (i == 0)
            return exact[0];
        if (i == static_cast<ptrdiff_t>(n) - 1)
            return exact[n - 1];
        return Point3f((at(i - 1) + at(i) * 4 + at(i + 1)) / 6);
    };
    for (ptrdiff_t i = 0; i + 1 < static_cast<ptrdiff_t>(n); ++i) {
        BezierSegment s;
        s.cp[0] = joint(i);
        s.cp[1] = Point3f((at(i) * 2 + at(i + 1)) / 3);
        s.cp[2] = Point3f((at(i) + at(i + 1) * 2) / 3);
        s.cp[3] = joint(i + 1);
        s.width[0] = w[static_cast<size_t>(i)];
        s.width[1] = w[static_cast<size_t>(i) + 1];
        out->push_back(s);
    }
    // A B-spline's joints may coincide where its points zigzag; pieces of no extent carry nothing.
    out->erase(std::remove_if(out->begin() + static_cast<ptrdiff_t>(first), out->end(),
                              [](const BezierSegment &s) {
                                  return s.cp[0] == s.cp[1] && s.cp[1] == s.cp[2] && s.cp[2] == s.cp[3];
                              }),
               out->end());
}

Vector3d EvaluateBezier(const BezierSegment &s, double u) {
    const Vector3d a(s.cp[0]), b(s.cp[1]), c(s.cp[2]), d(s.cp[3]);
    const double v = 1 - u;
    return a * (v * v * v) + b * (3 * v * v * u) + c * (3 * v * u * u) + d * (u * u * u);
}

} // namespace

void ResampleStrand(std::span<const Point3f> points, std::span<const float> widths, StrandSpline spline,
                    int n, std::vector<Point3f> *outPoints, std::vector<float> *outWidths) {
    outPoints->clear();
    outWidths->clear();
    if (points.empty() || n < 1)
        return;
    std::vector<BezierSegment> pieces;
    PiecesThrough(points, widths, spline, &pieces);
    if (pieces.empty()) {
        outPoints->assign(static_cast<size_t>(n) + 1, points[0]);
        outWidths->assign(static_cast<size_t>(n) + 1, widths[0]);
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
    size_t at = 0;
    for (int i = 0; i <= n; ++i) {
        if (i == 0 || i == n) {
            const BezierSegment &s = i == 0 ? pieces.front() : pieces.back();
            outPoints->push_back(i == 0 ? s.cp[0] : s.cp[3]);
            outWidths->push_back(i == 0 ? s.width[0] : s.width[1]);
            continue;
        }
        const double goal = length.back() * i / n;
        while (at + 2 < length.size() && length[at + 1] < goal)
            ++at;
        const double span = length[at + 1] - length[at];
        const double f = span > 0 ? std::clamp((goal - length[at]) / span, 0., 1.) : 0.;
        const double u = (static_cast<double>(at % kSteps) + f) / kSteps;
        const BezierSegment &s = pieces[at / kSteps];
        outPoints->push_back(Point3f(EvaluateBezier(s, u)));
        outWidths->push_back(Lerp(static_cast<float>(u), s.width[0], s.width[1]));
    }
}

void AppendSegments(std::span<const Point3f> points, std::span<const float> widths,
                    const SegmentOptions &options, std::vector<BezierSegment> *out) {
    if (options.segmentsPerStrand <= 0) {
        PiecesThrough(points, widths, options.spline, out);
        return;
    }
    std::vector<Point3f> p;
    std::vector<float> w;
    ResampleStrand(points, widths, options.spline, options.segmentsPerStrand, &p, &w);
    // The resampled points lie on the wanted curve already, whichever spline made it.
    PiecesThrough(p, w, StrandSpline::CatmullRom, out);
}

void AppendSegments(const Groom &groom, size_t strand, const SegmentOptions &options,
                    std::vector<BezierSegment> *out) {
    const std::span<const Point3f> points = groom.Strand(strand);
    if (!groom.pointWidths.empty()) {
        AppendSegments(points, {groom.pointWidths.data() + groom.strandOffsets[strand], points.size()},
                       options, out);
        return;
    }
    std::vector<float> widths(points.size());
    for (size_t k = 0; k < widths.size(); ++k)
        widths[k] = groom.Width(strand, k);
    AppendSegments(points, widths, options, out);
}

void ForEachSegment(const Groom &groom, const SegmentOptions &options,
                    const std::function<void(const BezierSegment &, size_t strand)> &emit) {
    std::vector<BezierSegment> pieces;
    for (size_t strand = 0; strand < groom.StrandCount(); ++strand) {
        pieces.clear();
        AppendSegments(groom, strand, options, &pieces);
        for (const BezierSegment &s : pieces)
            emit(s, strand);
    }
}

} // namespace cuticle
