#include "core/error.h"
#include "grooms/groom.h"
#include "grooms/hash.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// Strands with uneven spacing, the hard case for a spline: steps between 1 and 20.
std::vector<Point3f> Wander(uint64_t index, size_t n) {
    const HashStream r(7, 99, index);
    std::vector<Point3f> p{{r.Signed(0) * 50, r.Signed(1) * 50, r.Signed(2) * 50}};
    for (size_t i = 1; i < n; ++i) {
        const float step = 1 + 19 * r.Uniform(4 * i + 3);
        p.push_back(p.back() + Vector3f{r.Signed(4 * i), r.Signed(4 * i + 1), r.Signed(4 * i + 2)} * step +
                    Vector3f{0, 0, -1});
    }
    return p;
}

float Turn(const Vector3f &a, const Vector3f &b) { return Cross(a, b).Length() / (a.Length() * b.Length()); }

TEST(Groom, PiecesJoinWithCommonTangents) {
    for (const StrandSpline spline : {StrandSpline::CatmullRom, StrandSpline::BSpline})
        for (uint64_t i = 0; i < 200; ++i) {
            const std::vector<Point3f> p = Wander(i, 3 + i % 20);
            std::vector<BezierSegment> s;
            AppendSegments(p, std::vector<float>(p.size(), 0.1f), {spline, 0}, &s);
            ASSERT_EQ(s.size(), p.size() - 1);
            EXPECT_EQ(s.front().cp[0], p.front());
            EXPECT_EQ(s.back().cp[3], p.back());
            for (size_t k = 0; k + 1 < s.size(); ++k) {
                EXPECT_EQ(s[k].cp[3], s[k + 1].cp[0]);
                const Vector3f out = s[k].cp[3] - s[k].cp[2], in = s[k + 1].cp[1] - s[k + 1].cp[0];
                EXPECT_LT(Turn(out, in), 1e-4f) << "strand " << i << ", joint " << k;
                EXPECT_GT(Dot(out, in), 0) << "strand " << i << ", joint " << k;
                // C1 in the spline's own parameter: derivatives agree when divided by the knot steps.
                const float a = spline == StrandSpline::BSpline ? 1 : std::sqrt((p[k + 1] - p[k]).Length());
                const float b =
                    spline == StrandSpline::BSpline ? 1 : std::sqrt((p[k + 2] - p[k + 1]).Length());
                EXPECT_LT((out / a - in / b).Length(), 1e-4f * (out / a).Length() + 2e-5f);
            }
        }
}

TEST(Groom, CatmullRomPassesThroughItsPointsAndStraightStaysStraight) {
    const std::vector<Point3f> wander = Wander(3, 12);
    std::vector<BezierSegment> s;
    AppendSegments(wander, std::vector<float>(wander.size(), 1.f), {}, &s);
    for (size_t k = 0; k < s.size(); ++k) {
        EXPECT_EQ(s[k].cp[0], wander[k]);
        EXPECT_EQ(s[k].cp[3], wander[k + 1]);
    }
    // Collinear points, unevenly spaced: all control points on the line, in order.
    const std::vector<Point3f> line{{0, 0, 0}, {0, 1, 0}, {0, 1.5f, 0}, {0, 9, 0}, {0, 9.25f, 0}};
    s.clear();
    AppendSegments(line, std::vector<float>(line.size(), 1.f), {}, &s);
    for (const BezierSegment &piece : s)
        for (int k = 0; k < 4; ++k) {
            EXPECT_EQ(piece.cp[k].x, 0);
            EXPECT_EQ(piece.cp[k].z, 0);
            if (k > 0) {
                EXPECT_GE(piece.cp[k].y, piece.cp[k - 1].y);
            }
        }
}

TEST(Groom, BSplineLiesWithinItsPoints) {
    const std::vector<Point3f> p = Wander(5, 20);
    Bounds3f b;
    for (const Point3f &q : p)
        b.Extend(q);
    std::vector<BezierSegment> s;
    AppendSegments(p, std::vector<float>(p.size(), 1.f), {StrandSpline::BSpline, 0}, &s);
    for (const BezierSegment &piece : s)
        for (const Point3f &q : piece.cp)
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(q[c], b.pMin[c] - 1e-4f);
                EXPECT_LE(q[c], b.pMax[c] + 1e-4f);
            }
}

TEST(Groom, DegenerateStrands) {
    std::vector<BezierSegment> s;
    AppendSegments(std::vector<Point3f>{}, std::vector<float>{}, {}, &s);
    AppendSegments(std::vector<Point3f>{{1, 2, 3}}, std::vector<float>{1}, {}, &s);
    AppendSegments(std::vector<Point3f>(5, {1, 2, 3}), std::vector<float>(5, 1.f), {}, &s);
    AppendSegments(std::vector<Point3f>(5, {1, 2, 3}), std::vector<float>(5, 1.f), {StrandSpline::BSpline, 7},
                   &s);
    EXPECT_TRUE(s.empty());
    // Doubled points vanish, all else stays finite, back-and-forth included.
    const std::vector<Point3f> p{{0, 0, 0}, {0, 0, 0}, {1, 0, 0},      {0, 0, 0},
                                 {1, 0, 0}, {1, 0, 0}, {1e-30f, 0, 0}, {1e15f, 0, 0}};
    for (const StrandSpline spline : {StrandSpline::CatmullRom, StrandSpline::BSpline, StrandSpline::Linear})
        for (const int n : {0, 1, 9}) {
            s.clear();
            AppendSegments(p, std::vector<float>(p.size(), 1.f), {spline, n}, &s);
            EXPECT_FALSE(s.empty());
            for (const BezierSegment &piece : s)
                for (const Point3f &q : piece.cp)
                    EXPECT_TRUE(IsFinite(q)) << q << " with " << n << " segments";
        }
}

TEST(Groom, ResamplingSpacesEvenlyAndKeepsTheLength) {
    // A quarter of a circle from unevenly spaced points: resampled points stay on it and are evenly apart.
    std::vector<Point3f> p;
    std::vector<float> w;
    for (int i = 0; i <= 24; ++i) {
        const double t = static_cast<double>(i) / 24, angle = kPi<double> / 2 * t * t;
        p.push_back(Point3f(Vector3d{10 * std::cos(angle), 10 * std::sin(angle), 0}));
        w.push_back(static_cast<float>(1 - t * t)); // linear in arc length
    }
    std::vector<Point3f> q;
    std::vector<float> v;
    ResampleStrand(p, w, StrandSpline::CatmullRom, 10, &q, &v);
    ASSERT_EQ(q.size(), 11u);
    EXPECT_EQ(q.front(), p.front());
    EXPECT_EQ(q.back(), p.back());
    for (size_t i = 0; i < q.size(); ++i) {
        const double angle = std::atan2(static_cast<double>(q[i].y), static_cast<double>(q[i].x));
        EXPECT_NEAR(angle, kPi<double> / 2 * static_cast<double>(i) / 10, 1e-3);
        EXPECT_NEAR(q[i].Length(), 10, 2e-3);
        EXPECT_NEAR(v[i], 1 - static_cast<float>(i) / 10, 5e-3f);
    }
}

// A piece says where on the strand it lies: points that were passed over are counted, and colours follow.
TEST(Groom, PiecesKnowTheirPlaceOnTheStrand) {
    Groom g;
    g.points = {{0, 0, 0}, {0, 1, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}};
    g.strandOffsets = {0, 5};
    for (int i = 0; i < 5; ++i)
        g.pointColors.push_back(Spectrum(static_cast<float>(i)));
    for (const StrandSpline spline :
         {StrandSpline::CatmullRom, StrandSpline::BSpline, StrandSpline::Linear}) {
        std::vector<BezierSegment> s;
        AppendSegments(g, 0, {spline, 0}, &s);
        ASSERT_EQ(s.size(), 3u);
        EXPECT_EQ(s[0].at[0], 0);
        EXPECT_EQ(s[1].at[0], 1);
        EXPECT_EQ(s[1].at[1], 3);
        EXPECT_EQ(s[2].at[1], 4);
    }
    std::vector<BezierSegment> s;
    AppendSegments(g, 0, {StrandSpline::Linear, 6}, &s);
    ASSERT_EQ(s.size(), 6u);
    EXPECT_NEAR(s[0].at[1], 0.5f, 1e-3f);
    EXPECT_NEAR(g.Color(0, s[5].at[0])[0], 3.5f, 1e-3f);
    EXPECT_EQ(g.Color(0, 4)[1], 4);
    EXPECT_EQ(g.Color(0, 99)[1], 4) << "beyond the tip is the tip";
    g.pointColors.clear();
    EXPECT_EQ(g.Color(0, 2.5f), g.color);
}

// The pieces of thousands of strands, made in parallel, come in the order of the strands.
TEST(Groom, SegmentsComeInOrder) {
    Groom g;
    for (uint32_t i = 0; i < 40000; ++i) {
        const auto x = static_cast<float>(i);
        for (uint32_t k = 0; k < i % 4; ++k) // strands of no piece among them
            g.points.push_back({x, static_cast<float>(k), 0});
        g.strandOffsets.push_back(static_cast<uint32_t>(g.points.size()));
    }
    size_t last = 0, count = 0;
    ForEachSegment(g, {}, [&](const BezierSegment &s, size_t strand) {
        ASSERT_GE(strand, last);
        ASSERT_EQ(s.cp[0].x, static_cast<float>(strand));
        last = strand;
        ++count;
    });
    EXPECT_EQ(count, 10000u * (1 + 2));
    EXPECT_GE(ExpectedSegments(g, {}), count - 10000);
    EXPECT_EQ(ExpectedSegments(g, {{}, 7}), 7 * 40000u);
}

TEST(Groom, WidthsAndColours) {
    Groom g;
    g.strandOffsets = {0, 3, 5};
    g.points.resize(5);
    g.width = 2;
    EXPECT_EQ(g.Width(1, 1), 2);
    g.strandWidths = {{4, 2}, {1, 1}};
    EXPECT_EQ(g.Width(0, 1), 3);
    g.strandWidths.clear();
    g.pointWidths = {1, 2, 3, 4, 5};
    EXPECT_EQ(g.Width(1, 0), 4);
    g.pointColors.assign(5, Spectrum(0.25f));
    g.pointColors[4] = Spectrum(0.75f);
    EXPECT_EQ(g.StrandColor(1), Spectrum(0.5f));
    Groom twice = g;
    twice.Append(g);
    EXPECT_EQ(twice.StrandCount(), 4u);
    EXPECT_EQ(twice.Width(3, 1), 5);
    EXPECT_EQ(twice.StrandColor(3), Spectrum(0.5f));
    Groom other;
    other.strandOffsets = {0, 1};
    other.points.resize(1);
    EXPECT_THROW(twice.Append(other), Error);
}

} // namespace
} // namespace cuticle
