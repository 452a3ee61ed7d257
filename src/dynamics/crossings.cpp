//> Find who passes through whom
#include "dynamics/crossings.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

//> Find when four moving points lie in a plane
// An edge from p to q that moves straight from one place to another.
struct MovingEdge {
    Vector3d p, q;   // at time 0
    Vector3d dp, dq; // to time 1
};

// The box around all that an edge sweeps.
struct SweptBox {
    Vector3d low, high;
    explicit SweptBox(const MovingEdge &e)
        : low(Min(Min(e.p, e.q), Min(e.p + e.dp, e.q + e.dq))),
          high(Max(Max(e.p, e.q), Max(e.p + e.dp, e.q + e.dq))) {}
    bool Meets(const SweptBox &o) const {
        return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y &&
               low.z <= o.high.z && o.low.z <= high.z;
    }
};

double Determinant(const Vector3d &a, const Vector3d &b, const Vector3d &c) { return Dot(Cross(a, b), c); }

// Six times the volume of the tetrahedron of two edges, as a polynomial of time; it changes its sign where
// the lines through them meet.
struct EdgeVolume {
    std::array<double, 4> c;
    EdgeVolume(const MovingEdge &a, const MovingEdge &b) {
        const Vector3d u = a.q - a.p, v = b.q - b.p, w = b.p - a.p;
        const Vector3d du = a.dq - a.dp, dv = b.dq - b.dp, dw = b.dp - a.dp;
        c[0] = Determinant(u, v, w);
        c[1] = Determinant(du, v, w) + Determinant(u, dv, w) + Determinant(u, v, dw);
        c[2] = Determinant(du, dv, w) + Determinant(du, v, dw) + Determinant(u, dv, dw);
        c[3] = Determinant(du, dv, dw);
    }
    double At(double t) const { return ((c[3] * t + c[2]) * t + c[1]) * t + c[0]; }
    // The times in (0, 1) at which it turns, growing, between 0 and 1.
    std::array<double, 4> Turns() const {
        std::array<double, 4> turns{0, 0, 0, 1};
        const double a = 3 * c[3], b = c[2], d = b * b - a * c[1];
        if (!(d > 0))
            return turns;
        const double q = -(b + std::copysign(std::sqrt(d), b)); // of both signs the one that cancels nothing
        const double first = a != 0 ? q / a : 0, second = q != 0 ? c[1] / q : 0;
        turns[1] = std::clamp(std::min(first, second), 0., 1.);
        turns[2] = std::clamp(std::max(first, second), 0., 1.);
        return turns;
    }
    // The time between low and high, of different signs, at which it is zero.
    double Zero(double low, double high) const {
        const bool sign = At(low) < 0;
        for (int i = 0; i < 52; ++i) {
            const double middle = 0.5 * (low + high);
            ((At(middle) < 0) == sign ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }
};
//<

//> Find whether edges meet where their lines do
bool MeetAt(const MovingEdge &a, const MovingEdge &b, double t) {
    const Vector3d p = a.p + a.dp * t, u = a.q + a.dq * t - p;
    const Vector3d r = b.p + b.dp * t, v = b.q + b.dq * t - r;
    const Vector3d n = Cross(u, v), w = r - p;
    const double n2 = n.LengthSquared();
    if (!(n2 > 0))
        return false; // parallel: their neighbours tell
    const double s = Determinant(w, v, n) / n2, k = Determinant(w, u, n) / n2;
    // Each end belongs to one of the two edges that share it
    return s >= 0 && s < 1 && k >= 0 && k < 1;
}

// The sum of the signs of the passes of two edges.
template <typename Note>
void ForEachPass(const MovingEdge &a, const MovingEdge &b, const Note &note) {
    const EdgeVolume volume(a, b);
    const std::array<double, 4> turns = volume.Turns();
    for (size_t i = 0; i < 3; ++i) {
        const double low = turns[i], high = turns[i + 1];
        const bool before = volume.At(low) < 0, after = volume.At(high) < 0;
        if (low < high && before != after && MeetAt(a, b, volume.Zero(low, high)))
            note(before ? 1 : -1);
    }
}
//<

//> Gather edges by the cells that they sweep
using Cell = std::array<int32_t, 3>;
struct CellEntry {
    Cell cell;
    uint32_t edge;
    bool operator<(const CellEntry &o) const { return cell != o.cell ? cell < o.cell : edge < o.edge; }
};

// The side of cells for which an edge sweeps few: their mean size, or a part of the largest.
double CellSide(std::span<const SweptBox> boxes) {
    double mean = 0, most = 0;
    for (const SweptBox &box : boxes) {
        const Vector3d d = box.high - box.low;
        const double size = std::max({d.x, d.y, d.z});
        mean += size / static_cast<double>(boxes.size());
        most = std::max(most, size);
    }
    return std::max({mean, most / 16, 1e-9});
}
Cell CellOf(const Vector3d &p, double side) {
    const auto in = [&](double x) {
        return static_cast<int32_t>(std::clamp(std::floor(x / side), -1e9, 1e9));
    };
    return {in(p.x), in(p.y), in(p.z)};
}
std::vector<CellEntry> EntriesOf(std::span<const SweptBox> boxes, double side) {
    std::vector<CellEntry> entries;
    for (size_t i = 0; i < boxes.size(); ++i) {
        const Cell low = CellOf(boxes[i].low, side), high = CellOf(boxes[i].high, side);
        for (int32_t x = low[0]; x <= high[0]; ++x)
            for (int32_t y = low[1]; y <= high[1]; ++y)
                for (int32_t z = low[2]; z <= high[2]; ++z)
                    entries.push_back({{x, y, z}, static_cast<uint32_t>(i)});
    }
    std::sort(entries.begin(), entries.end());
    return entries;
}
//<

} // namespace

//> Begin to follow strands
StrandCrossings::StrandCrossings(std::span<const Vector3d> points, size_t count)
    : points_(points.begin(), points.end()), count_(count) {
    CHECK(count >= 2 && points.size() % count == 0);
}
//<

//> Find the passes of a move
std::vector<StrandCrossings::Pass> StrandCrossings::PassesOnTheWayTo(std::span<const Vector3d> points) const {
    const size_t strands = points.size() / count_, edgesEach = count_ - 1;
    std::vector<MovingEdge> edges;
    std::vector<SweptBox> boxes;
    for (size_t s = 0; s < strands; ++s)
        for (size_t i = s * count_; i + 1 < (s + 1) * count_; ++i) {
            edges.push_back(
                {points_[i], points_[i + 1], points[i] - points_[i], points[i + 1] - points_[i + 1]});
            boxes.emplace_back(edges.back());
        }
    const double side = CellSide(boxes);
    const std::vector<CellEntry> entries = EntriesOf(boxes, side);
    const auto inCell = [&](size_t first, size_t last, std::vector<Pass> *found) {
        for (size_t i = first; i < last; ++i)
            for (size_t j = i + 1; j < last; ++j) {
                const uint32_t a = entries[i].edge, b = entries[j].edge;
                if (a / edgesEach == b / edgesEach || !boxes[a].Meets(boxes[b]))
                    continue;
                // Two edges may share several cells: they meet in the first of those
                if (CellOf(Max(boxes[a].low, boxes[b].low), side) != entries[i].cell)
                    continue;
                ForEachPass(edges[a], edges[b], [&](int sign) {
                    found->push_back({uint64_t{a / edgesEach} << 32 | b / edgesEach, sign});
                });
            }
    };
    return ParallelReduce<std::vector<Pass>>(
        entries.size(), 4096, {},
        [&](size_t first, size_t last) {
            std::vector<Pass> found;
            // A piece takes the cells that begin in it
            for (size_t i = first; i < last;) {
                size_t end = i + 1;
                while (end < entries.size() && entries[end].cell == entries[i].cell)
                    ++end;
                if (i == 0 || entries[i - 1].cell != entries[i].cell)
                    inCell(i, end, &found);
                i = end;
            }
            return found;
        },
        [](std::vector<Pass> *all, const std::vector<Pass> &more) {
            all->insert(all->end(), more.begin(), more.end());
        });
}
//<

//> Keep account of who has passed through whom
void StrandCrossings::MoveTo(std::span<const Vector3d> points) {
    CHECK_EQ(points.size(), points_.size());
    for (const Pass &pass : PassesOnTheWayTo(points)) {
        sides_[pass.pair] += pass.sign;
        ++passes_;
    }
    points_.assign(points.begin(), points.end());
}
size_t StrandCrossings::Pairs() const {
    return static_cast<size_t>(
        std::count_if(sides_.begin(), sides_.end(), [](const auto &side) { return side.second != 0; }));
}
int StrandCrossings::Side(size_t strand, size_t other) const {
    const auto found = sides_.find(uint64_t{std::min(strand, other)} << 32 | std::max(strand, other));
    return found == sides_.end() ? 0 : found->second;
}
//<

} // namespace cuticle
//<
