#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "shapes/curve.h"
#include "shapes/curve_capsule.h"
#include "shapes/curve_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>

namespace cuticle {
namespace {

struct Random {
    explicit Random(uint64_t seed) : engine(seed) {}
    float operator()(float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine); }
    Point3f Point() { return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)}; }
    Vector3f Direction() { return UniformSampleSphere({(*this)(0, 1), (*this)(0, 1)}); }
    std::mt19937_64 engine;
};

// A tuft of wavy strands of 8 segments each.
std::vector<CurveSegment> Tuft(size_t strands, uint64_t seed = 1, float width = 0.004f) {
    Random random(seed);
    CurveList segments;
    for (size_t i = 0; i < strands; ++i) {
        Point3f p = random.Point() * 0.3f;
        Vector3f d = random.Direction();
        std::vector<Point3f> points;
        for (int k = 0; k < 11; ++k) {
            points.push_back(p);
            p += d * 0.08f;
            d = Normalize(d + random.Direction() * 0.4f);
        }
        AppendCurve(points.data(), points.size(), CurveBasis::BSpline, 3, width, 0.5f * width, 0, &segments);
    }
    return {segments.begin(), segments.end()};
}
Ray Toward(Random *random) {
    Ray ray;
    ray.o = random->Direction() * 2;
    ray.d = random->Point() * 0.5f - ray.o;
    return ray;
}

TEST(CurveSet, NothingIsHitInAnEmptySet) {
    const CurveSet set;
    CurveHit hit;
    Ray ray;
    ray.d = {0, 0, 1};
    EXPECT_FALSE(set.Intersect(ray, nullptr, &hit));
    EXPECT_FALSE(set.Occluded(ray, nullptr));
    EXPECT_TRUE(set.WorldBound().IsEmpty());
    EXPECT_EQ(set.SegmentCount(), 0u);
}

TEST(CurveSet, BadInputIsDroppedAndCounted) {
    std::vector<CurveSegment> s = Tuft(2);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const size_t good = s.size();
    for (int i = 0; i < 5; ++i)
        s.push_back(s[0]);
    s[good].cp[2].y = nan;
    s[good + 1].cp[0].x = Infinity;
    s[good + 2].width[0] = nan;
    s[good + 3].width[0] = s[good + 3].width[1] = -1;
    s[good + 4].cp[0] = s[good + 4].cp[1] = s[good + 4].cp[2] = s[good + 4].cp[3];
    const CurveSet set(s, {CurveType::Flat});
    EXPECT_EQ(set.DroppedSegments(), 5u);
    EXPECT_EQ(set.SegmentCount(), good + 5);
    EXPECT_TRUE(IsFinite(set.WorldBound().pMin) && IsFinite(set.WorldBound().pMax));
    Random random(1);
    CurveHit hit;
    size_t hits = 0;
    for (int i = 0; i < 20000; ++i)
        if (set.Intersect(Toward(&random), nullptr, &hit)) {
            EXPECT_LT(hit.segment, good);
            ++hits;
        }
    EXPECT_GT(hits, 50u);

    for (const Vector3f &d : {Vector3f(0, 0, 0), Vector3f(nan, 0, 1), Vector3f(Infinity, 0, 0)}) {
        Ray ray;
        ray.d = d;
        EXPECT_FALSE(set.Intersect(ray, nullptr, &hit));
        EXPECT_FALSE(set.Occluded(ray, nullptr));
    }
    Ray ray;
    ray.o.x = nan;
    ray.d = {1, 0, 0};
    EXPECT_FALSE(set.Intersect(ray, nullptr, &hit));
}

TEST(CurveSet, ManyIdenticalCurvesBuild) {
    const std::vector<CurveSegment> one = Tuft(1);
    const CurveSet set(std::vector<CurveSegment>(20000, one[3]), {});
    const CurveSet single({one[3]}, {});
    Random random(4);
    size_t hits = 0;
    for (int i = 0; i < 100; ++i) {
        Ray ray;
        ray.o = random.Direction() * 2;
        ray.d = Point3f(one[3].cp[1] + one[3].cp[2]) * 0.5f - ray.o;
        CurveHit a, b;
        ASSERT_EQ(set.Intersect(ray, nullptr, &a), single.Intersect(ray, nullptr, &b));
        if (single.Intersect(ray, nullptr, &b)) {
            ++hits;
            EXPECT_EQ(a.t, b.t);
            EXPECT_EQ(a.v, b.v);
        }
    }
    EXPECT_GT(hits, 20u);
}

// Splits by place part few curves from the rest here, again and again; the depth must stay bounded. Each
// curve stands alone in its direction from the origin, at a distance that may be any.
TEST(CurveSet, CurvesOfEveryScaleAreMet) {
    Random random(6);
    std::vector<CurveSegment> segments;
    for (int i = 0; i < 8000; ++i) {
        const float scale = std::pow(10.f, random(-12, 17));
        const Point3f middle = Point3f() + random.Direction() * scale;
        const Vector3f along = random.Direction() * (0.01f * scale);
        CurveSegment s;
        for (size_t k = 0; k < 4; ++k)
            s.cp[k] = middle + along * (static_cast<float>(k) - 1.5f);
        s.width[0] = s.width[1] = 0.001f * scale;
        segments.push_back(s);
    }
    const CurveSet set(segments, {});
    for (size_t i = 0; i < segments.size(); i += 41) { // each meets the capsules of all that are much smaller
        const Point3f &a = segments[i].cp[1], &b = segments[i].cp[2];
        Ray ray;
        ray.d = Vector3f((a + b) * 0.5f);
        ray.tMin = 0.5f; // curves much nearer may stand before it
        CurveHit hit;
        ASSERT_TRUE(set.Intersect(ray, nullptr, &hit)) << i;
        EXPECT_LT(hit.t, 1.001f);
        EXPECT_TRUE(set.Occluded(ray, nullptr));
    }
}

// The plain recursion over all segments, one after another, says the same.
TEST(CurveSet, AgreesWithEverySegmentAlone) {
    const std::vector<CurveSegment> s = Tuft(120);
    const CurveSet set(s, {CurveType::Flat});
    const BinaryCurveBvh binary(s, {CurveType::Flat});
    Random random(2);
    size_t hits = 0, different = 0, binaryDifferent = 0;
    constexpr int n = 5000;
    for (int i = 0; i < n; ++i) {
        Ray ray = Toward(&random);
        CurveHit plain, hit;
        bool found = false;
        Ray left = ray;
        for (uint32_t k = 0; k < s.size(); ++k) {
            CurveHit h;
            if (Curve(s[k], CurveType::Flat).Intersect(left, &h)) {
                plain = h, plain.segment = k, left.tMax = h.t;
                found = true;
            }
        }
        const auto same = [&](bool other) {
            return found == other && (!found || std::abs(plain.t - hit.t) < 1e-4f * plain.t);
        };
        hits += found;
        different += !same(set.Intersect(ray, nullptr, &hit));
        binaryDifferent += !same(binary.Intersect(ray, nullptr, &hit));
        EXPECT_EQ(set.Occluded(ray, nullptr), set.Intersect(ray, nullptr, &hit));
    }
    EXPECT_GT(hits, 500u);
    EXPECT_LE(different, 1u); // a grazing ray may go either way
    EXPECT_LE(binaryDifferent, n / 200u);
}

TEST(CurveSet, EveryThreadCountBuildsTheSameTree) {
    const std::vector<CurveSegment> s = Tuft(6000);
    std::vector<CurveHit> first;
    for (const size_t threads : {1, 2, 5}) {
        const ThreadLimit control(threads);
        const CurveSet set(s, {CurveType::Flat});
        static size_t bytes = set.MemoryBytes();
        EXPECT_EQ(set.MemoryBytes(), bytes);
        Random random(3);
        for (size_t i = 0; i < 3000; ++i) {
            CurveHit hit;
            set.Intersect(Toward(&random), nullptr, &hit);
            if (first.size() <= i)
                first.push_back(hit);
            EXPECT_EQ(first[i].t, hit.t);
            EXPECT_EQ(first[i].segment, hit.segment);
            EXPECT_EQ(first[i].v, hit.v);
        }
    }
}

// Whatever the control points, and at any part of the segment.
TEST(CurveSet, CapsulesHoldTheirPieces) {
    Random random(11);
    for (int i = 0; i < 4000; ++i) {
        CurveSegment s;
        for (Point3f &p : s.cp)
            p = random.Point();
        if (i % 5 == 1)
            s.cp[1] = s.cp[0]; // uneven pace
        if (i % 5 == 2)
            s.cp[2] = s.cp[0] + (s.cp[0] - s.cp[3]) * 0.5f; // beyond its chord
        if (i % 5 == 3)
            s.cp[3] = s.cp[0]; // a loop
        s.width[0] = random(0, 0.2f), s.width[1] = random(0, 0.2f);
        const int pieces = 1 << (i % 4);
        for (int k = 0; k < pieces; ++k) {
            const double u0 = double(k) / pieces, u1 = double(k + 1) / pieces;
            const CurveCapsule capsule = CapsuleOf(s, u0, u1);
            const double e2 = capsule.e.LengthSquared();
            Vector3d cp[4];
            for (size_t c = 0; c < 4; ++c)
                cp[c] = Vector3d(s.cp[c]);
            for (int j = 0; j <= 16; ++j) {
                const double u = u0 + (u1 - u0) * j / 16;
                const Vector3d p = EvalBezier(cp, u) - capsule.p;
                const double along = e2 > 0 ? std::clamp(Dot(p, capsule.e) / e2, 0., 1.) : 0;
                const double half = 0.5 * Lerp<double>(u, s.width[0], s.width[1]);
                EXPECT_LE((p - capsule.e * along).Length() + half, capsule.radius * (1 + 1e-12))
                    << i << " piece " << k << " u " << u;
            }
        }
    }
}

// A shallow bow needs half the room around the middle of the bow that it needs around its chord.
TEST(CurveSet, CapsulesLieAlongTheMiddleOfTheBow) {
    CurveSegment s;
    s.cp[0] = {0, 0, 0}, s.cp[1] = {1, 0.1f, 0}, s.cp[2] = {2, 0.1f, 0}, s.cp[3] = {3, 0, 0};
    s.width[0] = s.width[1] = 0.02f;
    const double bow = 0.75 * 0.1; // of the summit over the chord
    const CurveCapsule capsule = CapsuleOf(s, 0, 1);
    EXPECT_NEAR(capsule.p.y, bow / 2, 1e-8);
    EXPECT_GE(capsule.radius, 0.01 + bow / 2 - 1e-8);
    EXPECT_LE(capsule.radius, 0.01 + 0.55 * bow);
}

TEST(CurveSet, ASegmentOfAStrandTakesAtMost110Bytes) {
    // A small set may spend more: it is the millions that fill a memory.
    const auto bytes = [](size_t strands) {
        const std::vector<CurveSegment> tuft = Tuft(strands);
        const CurveSet set(tuft, {CurveType::Flat});
        return static_cast<double>(set.MemoryBytes()) / static_cast<double>(tuft.size());
    };
    EXPECT_LE(bytes(60000), 110);
    EXPECT_LE(bytes(10000), 130);
}

bool SameBits(const CurveSegment &a, const CurveSegment &b) {
    return std::memcmp(a.cp, b.cp, sizeof a.cp) == 0 && std::memcmp(a.width, b.width, sizeof a.width) == 0 &&
           a.group == b.group && a.part.index == b.part.index && a.part.count == b.part.count;
}

// Neighbours that differ in anything that they would share: width, group, the sign of a zero, a NaN.
TEST(CurveList, WhatComesOutIsWhatWasPutIn) {
    Random random(12);
    std::vector<CurveSegment> s;
    for (int i = 0; i < 5000; ++i) {
        CurveSegment segment{{random.Point(), random.Point(), random.Point(), random.Point()},
                             {random(0.f, 1.f), random(0.f, 1.f)},
                             static_cast<uint32_t>(random(0.f, 1.f) < 0.1f ? i : 7),
                             {static_cast<uint16_t>(i), static_cast<uint16_t>(random(1.f, 60000.f))}};
        const float kind = random(0.f, 1.f);
        if (kind < 0.1f)
            segment.cp[3].y = std::nanf("");
        else if (kind < 0.2f)
            segment.cp[3].y = 0;
        if (i > 0 && random(0.f, 1.f) < 0.8f) {
            segment.cp[0] = s.back().cp[3];
            segment.width[0] = s.back().width[1];
            if (random(0.f, 1.f) < 0.1f)
                segment.cp[0].y = -segment.cp[0].y;
            if (random(0.f, 1.f) < 0.1f)
                segment.width[0] = random(0.f, 1.f);
        }
        s.push_back(segment);
    }
    CurveList list;
    for (size_t i = 0; i < s.size(); ++i) {
        list.push_back(s[i]);
        ASSERT_TRUE(SameBits(list.back(), s[i])) << i;
    }
    const CurveList copy(list);
    const CurveSet set(list, {});
    ASSERT_EQ(copy.size(), s.size());
    EXPECT_LT(copy.PointCount(), 4 * s.size() - s.size() / 4) << "no strand keeps its points once";
    size_t i = 0;
    for (const CurveSegment &segment : copy) {
        EXPECT_TRUE(SameBits(segment, s[i]) && SameBits(copy[i], s[i])) << i;
        EXPECT_TRUE(SameBits(set.Segment(static_cast<uint32_t>(i)), s[i])) << i;
        ++i;
    }
    EXPECT_EQ(i, s.size());
    EXPECT_THROW(copy.at(s.size()), std::out_of_range);
}

// A strand of n segments has 3 n + 1 different points, and no more are kept.
TEST(CurveList, KeepsThePointsOfAStrandOnce) {
    EXPECT_EQ(CurveList(Tuft(1)).PointCount(), 25u);
    EXPECT_EQ(CurveList(Tuft(1000)).PointCount(), 25000u);
}

TEST(CurveSet, AnUnknownInstructionSetIsAnError) {
    CurveSetOptions options;
    options.isa = "mmx";
    EXPECT_THROW(CurveSet(Tuft(1), {}, {}, options), Error);
}

// A ray that crosses a strand at a joint of two segments with a common tangent meets one or the other.
TEST(CurveSet, JointsLoseNoHits) {
    const std::vector<CurveSegment> s = Tuft(500);
    Random random(6);
    for (const int split : {0, 1, 2, 3}) {
        CurveSetOptions options;
        options.split = split;
        const CurveSet set(s, {CurveType::Flat}, {}, options);
        size_t rays = 0, missed = 0;
        for (size_t i = 0; i + 1 < s.size(); ++i) {
            if (!(s[i].cp[3] == s[i + 1].cp[0]))
                continue;
            // At the joint of two segments, and at those of the pieces within the first.
            for (const double u : {0.125, 0.25, 0.5, 0.75, 1.})
                for (int k = 0; k < 4; ++k) {
                    const Vector3d cp[4] = {Vector3d(s[i].cp[0]), Vector3d(s[i].cp[1]), Vector3d(s[i].cp[2]),
                                            Vector3d(s[i].cp[3])};
                    Ray ray;
                    ray.o = random.Direction() * 2;
                    const Vector3d p = EvalBezier(cp, u);
                    ray.d = Vector3f(p - Vector3d(ray.o));
                    CurveHit hit;
                    ++rays;
                    missed += !set.Intersect(ray, nullptr, &hit) || hit.t > 1.001f;
                }
        }
        EXPECT_EQ(missed, 0u) << "of " << rays << ", split " << split;
    }
}

// A ray that leaves a hair does not meet it where it stands, but meets a neighbour at less than a radius.
TEST(CurveSet, LeavesItsHairAndMeetsCloseNeighbours) {
    const float r = 0.01f;
    CurveList s;
    const auto straight = [&](float y, float z) {
        std::vector<Point3f> p;
        for (int i = 0; i < 13; ++i)
            p.push_back({0.1f * static_cast<float>(i), y, z});
        AppendCurve(p.data(), p.size(), CurveBasis::Bezier, 3, 2 * r, 2 * r, 0, &s);
    };
    straight(0, 0);
    straight(0, 0.4f * r); // so near that both overlap
    const CurveSet set(s, {CurveType::Flat});
    Random random(8);
    size_t own = 0, neighbour = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
        // Onto the first hair from below, at a random place across it; then away in a random direction.
        Ray ray;
        ray.o = {random(0.1f, 1.1f), random(-r, r) * 0.99f, -1};
        ray.d = {0, 0, 1};
        CurveHit hit;
        ASSERT_TRUE(set.Intersect(ray, nullptr, &hit));
        ASSERT_LT(hit.segment, 4u);
        Ray next;
        next.o = set.Surface(ray, hit).p;
        next.d = random.Direction();
        const CurveOrigin origin{hit.segment, hit.u};
        if (set.Intersect(next, &origin, &hit)) {
            own += hit.segment < 4;
            neighbour += hit.segment >= 4;
            EXPECT_TRUE(set.Occluded(next, &origin));
        }
    }
    EXPECT_EQ(own, 0u); // a straight hair is never met again
    EXPECT_GT(neighbour, n / 3u);
}

// Segments keep points of their own where width or group change along a strand. It is one hair still: no
// ray that leaves it meets it, on whichever side of a joint, and one that leaves its copy meets it at once.
TEST(CurveSet, AStrandStaysOneWhereItsWidthOrGroupChanges) {
    const float r = 0.01f;
    std::vector<CurveSegment> s;
    for (int i = 0; i < 40; ++i) {
        const float x = 0.1f * static_cast<float>(i % 20), step = 0.1f / 3;
        const float width = 2 * r * (i % 3 == 0 ? 1.001f : 1);
        s.push_back({{{x, 0, 0}, {x + step, 0, 0}, {x + 2 * step, 0, 0}, {0.1f * float(i % 20 + 1), 0, 0}},
                     {width, width},
                     static_cast<uint32_t>(i % 5 == 0),
                     {}});
    }
    const CurveSet one(std::vector<CurveSegment>(s.begin(), s.begin() + 20), {}), two(s, {});
    EXPECT_GT(CurveList(s).PointCount(), 3 * s.size() + 20) << "the test wants points that are stored twice";
    Random random(8);
    size_t near = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
        Ray ray; // near a joint, from below
        ray.o = {0.1f * std::round(random(1.f, 19.f)) + random(-r, r), random(-r, r) * 0.99f, -1};
        ray.d = {0, 0, 1};
        CurveHit hit;
        ASSERT_TRUE(one.Intersect(ray, nullptr, &hit));
        Ray next;
        next.o = one.Surface(ray, hit).p;
        next.d = random.Direction();
        const CurveOrigin origin{hit.segment, hit.u};
        EXPECT_FALSE(one.Intersect(next, &origin, &hit)) << "segment " << origin.segment;
        near += two.Intersect(next, &origin, &hit);
    }
    EXPECT_GT(near, n / 3u);
}

} // namespace
} // namespace cuticle
