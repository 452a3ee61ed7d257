//> Follow key hairs
#include "dynamics/key_hairs.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cuticle {

namespace {

double StrandLength(std::span<const Point3f> points) {
    double length = 0;
    for (size_t i = 0; i + 1 < points.size(); ++i)
        length += Vector3d(points[i + 1] - points[i]).Length();
    return length;
}

} // namespace

//> Pick the farthest root each time
std::vector<uint32_t> ChooseKeyHairs(const Groom &groom, size_t count) {
    std::vector<uint32_t> usable;
    for (size_t s = 0; s < groom.StrandCount(); ++s)
        if (groom.PointCount(s) >= 2 && StrandLength(groom.Strand(s)) > 1e-4)
            usable.push_back(static_cast<uint32_t>(s));
    if (usable.size() <= count)
        return usable;
    std::vector<uint32_t> chosen;
    std::vector<float> apart(usable.size(), std::numeric_limits<float>::infinity());
    for (size_t next = 0; chosen.size() < count;) {
        chosen.push_back(usable[next]);
        const Point3f root = groom.Strand(usable[next])[0];
        apart[next] = -1;
        for (size_t i = 0; i < usable.size(); ++i)
            if (apart[i] >= 0)
                apart[i] = std::min(apart[i], (groom.Strand(usable[i])[0] - root).LengthSquared());
        next = static_cast<size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}
//<

//> Resample key hairs by arc length
std::vector<Vector3d> ResampleKeyHairs(const Groom &groom, std::span<const uint32_t> strands, size_t points) {
    std::vector<Vector3d> all(strands.size() * points);
    ParallelFor(strands.size(), [&](size_t k) {
        const std::span<const Point3f> from = groom.Strand(strands[k]);
        const std::vector<float> widths(from.size(), 1.f);
        std::vector<Point3f> p;
        std::vector<float> w;
        ResampleStrand(from, widths, groom.spline, static_cast<int>(points - 1), &p, &w);
        for (size_t i = 0; i < points; ++i)
            all[k * points + i] = Vector3d(p[i]);
    });
    return all;
}
//<

//> Find a place of a key hair and its frame
// u: share of its points' range, 0 to 1. Points are joined by a Catmull-Rom spline, directors by straight
// lines between the edges' middles.
HairInterpolation::PlaceFrame HairInterpolation::PlaceAt(const Vector3d *points, const Vector3d *directors,
                                                         size_t count, double u) {
    const double at = std::clamp(u, 0., 1.) * static_cast<double>(count - 1);
    const size_t i = std::min(static_cast<size_t>(at), count - 2);
    const double f = at - static_cast<double>(i), f2 = f * f, f3 = f2 * f;
    const Vector3d &b = points[i], &c = points[i + 1];
    const Vector3d mB = i > 0 ? (c - points[i - 1]) * 0.5 : c - b;
    const Vector3d mC = i + 2 < count ? (points[i + 2] - b) * 0.5 : c - b;
    PlaceFrame place;
    place.p = b * (2 * f3 - 3 * f2 + 1) + mB * (f3 - 2 * f2 + f) + c * (3 * f2 - 2 * f3) + mC * (f3 - f2);
    const Vector3d along =
        b * (6 * f2 - 6 * f) + mB * (3 * f2 - 4 * f + 1) + c * (6 * f - 6 * f2) + mC * (3 * f2 - 2 * f);
    place.t = along.LengthSquared() > 1e-20 ? Normalize(along) : Normalize(c - b);
    const double middle = std::clamp(at - 0.5, 0., static_cast<double>(count - 2));
    const size_t j = std::min(static_cast<size_t>(middle), count - 2), k = std::min(j + 1, count - 2);
    const double g = middle - static_cast<double>(j);
    place.d1 = rods::AcrossUnit(directors[j] * (1 - g) + directors[k] * g, place.t);
    place.d2 = Cross(place.t, place.d1);
    return place;
}
//<

//> Find what carries each hair
HairInterpolation::HairInterpolation(const Groom &groom, std::span<const uint32_t> keys,
                                     const KeyStrands &set)
    : groom_(groom), carriers_(groom.StrandCount()), share_(groom.points.size()),
      keyPoints_(set.PointCount()) {
    CHECK_EQ(keys.size(), set.StrandCount());
    for (size_t k = 0; k < keys.size(); ++k)
        for (size_t i = 0; i < keyPoints_; ++i) {
            restPoints_.push_back(set.RestPosition(k, i));
            restDirectors_.push_back(i + 1 < keyPoints_ ? set.Director(k, i) : Vector3d{});
        }
    std::vector<double> lengths(keys.size());
    for (size_t k = 0; k < keys.size(); ++k)
        for (size_t i = 0; i + 1 < keyPoints_; ++i)
            lengths[k] += set.EdgeLength(k, i);
    ParallelFor(groom.StrandCount(), [&](size_t s) {
        const std::span<const Point3f> hair = groom.Strand(s);
        const double length = StrandLength(hair);
        const auto reach = [&](uint32_t k) { return std::min(1., 2 * length / lengths[k]); };
        double at = 0;
        for (size_t i = 0; i < hair.size(); ++i) {
            if (i > 0)
                at += Vector3d(hair[i] - hair[i - 1]).Length();
            share_[groom.strandOffsets[s] + i] = static_cast<float>(length > 0 ? at / length : 0);
        }
        //> Ask the nearest key hairs how alike they are
        constexpr size_t kNear = 8;
        std::array<std::pair<double, uint32_t>, kNear> near;
        near.fill({std::numeric_limits<double>::infinity(), 0});
        for (uint32_t k = 0; k < keys.size() && !hair.empty(); ++k) {
            const double d2 = (restPoints_[k * keyPoints_] - Vector3d(hair[0])).LengthSquared();
            if (d2 < near.back().first) {
                near.back() = {d2, k};
                std::sort(near.begin(), near.end());
            }
        }
        for (auto &[d2, k] : near)
            for (size_t i = 0; std::isfinite(d2) && i < hair.size(); ++i) {
                const double u = static_cast<double>(share_[groom.strandOffsets[s] + i]) * reach(k);
                const PlaceFrame place =
                    PlaceAt(&restPoints_[k * keyPoints_], &restDirectors_[k * keyPoints_], keyPoints_, u);
                d2 += (place.p - Vector3d(hair[i])).LengthSquared() / static_cast<double>(hair.size());
            }
        std::sort(near.begin(), near.end());
        //<
        double sum = 0;
        for (size_t n = 0; n < kKeys; ++n)
            if (std::isfinite(near[n].first)) {
                const double weight = near[0].first < 1e-6 ? (n == 0 ? 1 : 0) : 1 / Sqr(near[n].first);
                carriers_[s].key[n] = near[n].second;
                carriers_[s].reach[n] = static_cast<float>(reach(near[n].second));
                carriers_[s].weight[n] =
                    static_cast<float>(weight * Sqr(near[0].first < 1e-6 ? 1 : near[0].first));
                sum += static_cast<double>(carriers_[s].weight[n]);
            }
        for (float &w : carriers_[s].weight)
            w = sum > 0 ? w / static_cast<float>(sum) : 0;
    });
}
//<

//> Go with those that agree
// At rest all key hairs that carry a point put it at the same place. Where they disagree by more than a
// lock's width, their mean is where no hair is.
Vector3d HairInterpolation::Carry(const Carrier &carrier, size_t i, std::span<const Vector3d> points,
                                  std::span<const Vector3d> directors) const {
    constexpr double kLock = 2; // cm
    const Vector3d rest(groom_.points[i]);
    Vector3d sum, first;
    double weights = 0;
    for (size_t n = 0; n < kKeys && carrier.weight[n] > 0; ++n) {
        const size_t at = carrier.key[n] * keyPoints_;
        const auto u = static_cast<double>(share_[i] * carrier.reach[n]);
        const PlaceFrame from = PlaceAt(&restPoints_[at], &restDirectors_[at], keyPoints_, u);
        const PlaceFrame to = PlaceAt(&points[at], &directors[at], keyPoints_, u);
        const Vector3d offset = rest - from.p;
        const Vector3d p =
            to.p + to.t * Dot(from.t, offset) + to.d1 * Dot(from.d1, offset) + to.d2 * Dot(from.d2, offset);
        if (n == 0)
            first = p;
        const double apart2 = (p - first).LengthSquared() / Sqr(kLock);
        const double weight = static_cast<double>(carrier.weight[n]) / (1 + Sqr(apart2));
        sum += p * weight, weights += weight;
    }
    return weights > 0 ? sum / weights : rest;
}
//<

//> Carry all hairs along
Groom HairInterpolation::Deform(const KeyStrands &set, const Pose &pose, const Obstacle &obstacle,
                                double clearance) const {
    Groom moved = groom_;
    std::vector<Vector3d> points(restPoints_.size()), directors(restPoints_.size());
    for (size_t k = 0; k < set.StrandCount(); ++k)
        for (size_t i = 0; i < keyPoints_; ++i) {
            points[k * keyPoints_ + i] = set.Position(k, i);
            if (i + 1 < keyPoints_)
                directors[k * keyPoints_ + i] = set.Director(k, i);
        }
    ParallelFor(groom_.StrandCount(), [&](size_t s) {
        const size_t first = groom_.strandOffsets[s];
        // In the head's coordinates: the point before, and where its key hairs would have it
        Vector3d before, wantedBefore;
        for (size_t i = first; i < groom_.strandOffsets[s + 1]; ++i) {
            const Vector3d rest(groom_.points[i]);
            const Vector3d wanted = pose.LocalPoint(Carry(carriers_[s], i, points, directors));
            const double keep = std::min(clearance, obstacle.Distance(rest));
            const double length = i > first ? (rest - Vector3d(groom_.points[i - 1])).Length() : 0;
            //> Keep a hair's length and stay outside, the latter last
            // Edges go where the wanted ones go, and somewhat back to where they ought to be
            const Vector3d drift = wantedBefore - before;
            const double back = std::min(0.2, 0.5 * length / (drift.Length() + 1e-20));
            Vector3d local = i > first ? before + (wanted - wantedBefore) + drift * back : wanted;
            bool isOutside = false;
            for (int k = 0; k < 4 && !isOutside; ++k) {
                const Vector3d edge = local - before;
                if (i > first && edge.LengthSquared() > 1e-20)
                    local = before + Normalize(edge) * length;
                isOutside = obstacle.Distance(local) >= keep;
                for (int n = 0; n < 20 && obstacle.Distance(local) < keep; ++n)
                    local += obstacle.Normal(local) * (keep - obstacle.Distance(local) + 1e-6);
            }
            //<
            moved.points[i] = Point3f(pose.Point(local));
            before = local, wantedBefore = wanted;
        }
    });
    return moved;
}
//<

} // namespace cuticle
//<
