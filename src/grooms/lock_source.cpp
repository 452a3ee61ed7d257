//> Define strands in locks
#include "grooms/lock_source.h"

#include "core/parallel.h"

#include <algorithm>

namespace cuticle {

//> Cover a square evenly
Point2f R2(uint64_t index, float u0, float v0) {
    const double n = static_cast<double>(index) + 1;
    const double u = static_cast<double>(u0) + n * 0.7548776662466927,
                 v = static_cast<double>(v0) + n * 0.5698402909980532;
    return {std::min(static_cast<float>(u - std::floor(u)), OneMinusEpsilon),
            std::min(static_cast<float>(v - std::floor(v)), OneMinusEpsilon)};
}
//<

//> Make smooth noise in space
Vector3f GroomNoise(const Point3f &p, uint64_t seed) {
    const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto ix = static_cast<int64_t>(fx), iy = static_cast<int64_t>(fy), iz = static_cast<int64_t>(fz);
    const float t[3] = {SmoothStep(0, 1, p.x - fx), SmoothStep(0, 1, p.y - fy), SmoothStep(0, 1, p.z - fz)};
    Vector3f sum;
    for (int k = 0; k < 8; ++k) {
        const int dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
        const HashStream r(seed, kNoiseStream,
                           (static_cast<uint64_t>(ix + dx) * 0x9e3779b1u) ^
                               (static_cast<uint64_t>(iy + dy) * 0x85ebca77u << 20) ^
                               (static_cast<uint64_t>(iz + dz) * 0xc2b2ae3du << 40));
        const float w = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
        sum += Vector3f{r.Signed(0), r.Signed(1), r.Signed(2)} * w;
    }
    return sum;
}
//<

//> Turn a path into a guide
void FinishGuide(const std::vector<Point3f> &path, const Normal3f &start, Guide *g) {
    std::vector<Point3f> p;
    std::vector<float> w;
    ResampleStrand(path, std::vector<float>(path.size(), 1.f), StrandSpline::CatmullRom, kGuideSteps, &p, &w);
    g->length = 0;
    for (int i = 0; i <= kGuideSteps; ++i) {
        g->p[i] = p[static_cast<size_t>(i)] - path[0];
        if (i > 0)
            g->length += (g->p[i] - g->p[i - 1]).Length();
    }
    //> Carry a frame along without twist
    Vector3f u = start;
    for (int i = 0; i <= kGuideSteps; ++i) {
        const Vector3f t = g->p[std::min(i + 1, kGuideSteps)] - g->p[std::max(i - 1, 0)];
        const float length = t.Length();
        const Vector3f tangent = length > 0 ? t / length : Vector3f{0, -1, 0};
        Vector3f across = TangentTo(tangent, u);
        if (!(across.LengthSquared() > 1e-8f)) {
            Vector3f other;
            CoordinateSystem(tangent, &across, &other);
        }
        u = Normalize(across);
        g->u[i] = u;
        g->v[i] = Cross(tangent, u);
    }
    //<
}
//<

//> Wander smoothly along a hair
Vector3f Wander(const HashStream &r, uint64_t first, float x) {
    const float whole = std::floor(x), t = SmoothStep(0, 1, x - whole);
    const uint64_t at = first + 3 * static_cast<uint64_t>(whole);
    const Vector3f a{r.Signed(at), r.Signed(at + 1), r.Signed(at + 2)},
        b{r.Signed(at + 3), r.Signed(at + 4), r.Signed(at + 5)};
    return a * (1 - t) + b * t;
}
//<

//> Sort roots into cells
RootGrid::RootGrid(const std::vector<Guide> &guides, float spacing) {
    Bounds3f bounds;
    for (const Guide &g : guides)
        bounds.Extend(g.root);
    low_ = bounds.pMin;
    const Vector3f extent = bounds.Diagonal();
    // No more than 128 cells to a side, however close the roots
    cell_ = std::max({spacing, extent.x / 127, extent.y / 127, extent.z / 127});
    for (size_t axis = 0; axis < 3; ++axis)
        size_[axis] = static_cast<int>(extent[axis] / cell_) + 1;
    begin_.assign(static_cast<size_t>(size_[0] * size_[1] * size_[2]) + 1, 0);
    const auto cellOf = [&](const Guide &g) {
        const std::array<int, 3> at = CellOf(g.root);
        return static_cast<size_t>(at[0] + size_[0] * (at[1] + size_[1] * at[2]));
    };
    for (const Guide &g : guides)
        ++begin_[cellOf(g) + 1];
    for (size_t i = 1; i < begin_.size(); ++i)
        begin_[i] += begin_[i - 1];
    order_.resize(guides.size());
    std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (uint32_t i = 0; i < guides.size(); ++i)
        order_[next[cellOf(guides[i])]++] = i;
}
//<

std::array<int, 3> RootGrid::CellOf(const Point3f &p) const {
    std::array<int, 3> at{};
    for (size_t axis = 0; axis < 3; ++axis)
        at[axis] = static_cast<int>(
            std::clamp((p[axis] - low_[axis]) / cell_, 0.f, static_cast<float>(size_[axis] - 1)));
    return at;
}

//> Divide the locks into wisps
void LockSource::MakeWisps() {
    const auto count = static_cast<size_t>(std::min(params_.wisps, params_.strands));
    lockSpacing_ = std::sqrt(area_ / static_cast<float>(guides_.size()));
    wispSpacing_ = std::sqrt(area_ / static_cast<float>(count));
    locksByPlace_ = RootGrid(guides_, lockSpacing_);
    wisps_.resize(count);
    ParallelFor(count, [&](size_t i) { GrowWisp(i, &wisps_[i]); });
    wispsByPlace_ = RootGrid(wisps_, wispSpacing_);
}
//<

//> Grow a wisp between locks
// A wisp's path runs between the locks around it, drawn toward a place in its own.
void LockSource::GrowWisp(size_t index, Guide *wisp) const {
    const HashStream r(Seed(), kWispStream, index);
    const HashStream offset(Seed(), kWispStream, ~uint64_t(0));
    const Root root = RootAt(index, offset.Uniform(0), offset.Uniform(1));
    //> Find the three nearest locks
    constexpr size_t kLocks = 3;
    const Guide *near[kLocks] = {}; // nearest first
    float distance[kLocks] = {Infinity, Infinity, Infinity};
    const auto take = [&](uint32_t i) {
        const Guide &g = guides_[i];
        const float d = (g.root - root.p).LengthSquared() + (g.side * root.side < 0 ? 1e6f : 0.f);
        if (!(d < distance[kLocks - 1]))
            return;
        size_t k = kLocks - 1;
        for (; k > 0 && d < distance[k - 1]; --k) {
            distance[k] = distance[k - 1];
            near[k] = near[k - 1];
        }
        distance[k] = d;
        near[k] = &g;
    };
    for (int reach = 2; !(distance[kLocks - 1] < 1e5f); reach *= 4) {
        std::fill(std::begin(distance), std::end(distance), Infinity);
        locksByPlace_.ForEachNear(root.p, reach, take);
        if (reach > locksByPlace_.MaxReach())
            break;
    }
    //<
    //> Weigh the locks, and belong to one
    // The distance that chooses the lock is shaken a little, so that locks have ragged edges
    const float soft = Sqr(0.25f * lockSpacing_);
    float weight[kLocks], total = 0, best = Infinity;
    const Guide *lock = near[0];
    for (size_t k = 0; k < kLocks; ++k) {
        const bool usable = near[k] != nullptr && distance[k] < 1e5f;
        weight[k] = usable ? 1 / (distance[k] + soft) : 0;
        total += weight[k];
        const float shaken = std::sqrt(distance[k]) * (1 + 0.35f * r.Signed(k));
        if (usable && shaken < best) {
            best = shaken;
            lock = near[k];
        }
    }
    if (!(total > 0)) // where all are absurdly far, the nearest will do
        weight[0] = total = 1;
    //<

    *wisp = *lock;
    wisp->root = root.p;
    wisp->side = root.side;
    const float place = 0.4f * lockSpacing_ * std::sqrt(r.Uniform(3)), turn = 2 * Pi * r.Uniform(4);
    const float cosine = std::cos(turn), sine = std::sin(turn),
                clump = params_.clump * (0.7f + 0.3f * r.Uniform(5));
    wisp->length = wisp->gather = wisp->turns = 0;
    for (size_t k = 0; k < kLocks; ++k)
        if (weight[k] > 0) {
            wisp->length += near[k]->length * weight[k] / total;
            wisp->gather += near[k]->gather * weight[k] / total;
            wisp->turns += near[k]->turns * weight[k] / total;
        }
    wisp->lock = static_cast<uint32_t>(lock - guides_.data());
    wisp->phase += 0.4f * r.Signed(6);
    wisp->amplitude *= 0.85f + 0.3f * r.Uniform(7);
    wisp->turns *= 1 + 0.02f * r.Signed(8);
    //> Draw the wisp toward its place in the lock
    for (int i = 0; i <= kGuideSteps; ++i) {
        const float s = static_cast<float>(i) / kGuideSteps, fromRoot = s * wisp->length;
        Vector3f own;
        for (size_t k = 0; k < kLocks; ++k)
            if (weight[k] > 0)
                own += near[k]->p[i] * (weight[k] / total);
        const Vector3f inLock = (lock->root - root.p) + lock->p[i] +
                                (lock->u[i] * cosine + lock->v[i] * sine) * (place * (1 - 0.6f * s));
        // Close to the skin it keeps the root's place whatever the lock does
        const float draw = clump * SmoothStep(0, wisp->gather, fromRoot) * SmoothStep(0, 1.5f, fromRoot);
        wisp->p[i] = own * (1 - draw) + inLock * draw;
    }
    //<
}
//<

//> Find a strand's wisp
const Guide &LockSource::WispOf(const Root &root, const HashStream &r) const {
    const Guide *nearest = nullptr;
    float best = Infinity;
    for (int reach = 1; nearest == nullptr; reach *= 4) {
        const bool all = reach > wispsByPlace_.MaxReach();
        wispsByPlace_.ForEachNear(root.p, reach, [&](uint32_t i) {
            const Guide &g = wisps_[i];
            if (g.side * root.side < 0 && !all)
                return;
            const float d = (g.root - root.p).LengthSquared() * (1 + 0.5f * r.Signed(64 + i));
            if (d < best) {
                best = d;
                nearest = &g;
            }
        });
        if (all)
            break;
    }
    return nearest != nullptr ? *nearest : wisps_.front();
}
//<

//> Choose a strand's habits
LockSource::Habits LockSource::HabitsOf(const Root &root, const Guide &wisp, const HashStream &r) const {
    const bool flyaway = r.Uniform(10) < params_.flyaways;
    float shorter = root.shorter * (1 - params_.lengthVariation * Sqr(r.Uniform(11)));
    if (flyaway) // broken, or grown later than the others
        shorter *= 0.15f + 0.85f * r.Uniform(20);
    Habits h;
    h.rootOffset = root.p - wisp.root;
    h.stretch = std::max(shorter, 0.02f);
    h.clump = params_.wispClump * (flyaway ? 0.3f : 0.6f + 0.4f * r.Uniform(12));
    const float place = 0.4f * wispSpacing_ * std::sqrt(r.Uniform(13)), turn = 2 * Pi * r.Uniform(14);
    h.cosine = place * std::cos(turn), h.sine = place * std::sin(turn);
    h.frizz = flyaway ? 0.1f + 3 * params_.frizz : params_.frizz * (0.4f + 1.2f * Sqr(r.Uniform(15)));
    h.phase = wisp.phase + (flyaway ? 2.5f : 0.25f) * r.Signed(16);
    h.amplitude = params_.curlRadius * wisp.amplitude * (0.85f + 0.3f * r.Uniform(17));
    h.turns = wisp.turns * (1 + (flyaway ? 0.2f : 0.015f) * r.Signed(18));
    h.lift = flyaway ? 1.4f * Sqr(r.Uniform(19)) : 0;
    return h;
}
//<

//> Place a point of a strand
Point3f LockSource::PointAt(float along, const Guide &wisp, const Habits &habits, const HashStream &r) const {
    const float s = along * habits.stretch;
    const float fromRoot = s * wisp.length; // cm of the wisp behind this point
    const Guide::Place at = wisp.At(s);
    const float draw = habits.clump * SmoothStep(0, wisp.gather, fromRoot);
    Vector3f p = wisp.root + at.p + habits.rootOffset * (1 - draw) +
                 (at.u * habits.cosine + at.v * habits.sine) * (draw * (1 - 0.5f * along));
    const uint64_t kSlow = 1 << 20, kQuick = 1 << 21, kCurl = 1 << 22; // where their numbers begin
    //> Curl it
    // Curls: a helix in the wisp's frame that opens from the root; waves stay nearly in one plane. Radius and
    // phase drift along it
    if (habits.amplitude > 0) {
        const HashStream lock(Seed(), kGuideStream, wisp.lock);
        const Vector3f drift = Wander(lock, kCurl, 0.16f * fromRoot);
        const float open =
            habits.amplitude * SmoothStep(0.2f, 6.f, fromRoot) * (1 - 0.25f * along) * (1 + 0.3f * drift.x);
        const float angle = habits.phase + 2 * Pi * habits.turns * s + 0.9f * drift.y;
        if (waves_)
            p += (at.u * std::sin(angle) + at.v * (0.35f * std::cos(angle))) * open;
        else
            p += (at.u * std::cos(angle) + at.v * (wisp.handedness * std::sin(angle))) * open;
    }
    //<
    //> Let it stray
    // Frizz: slow strays over several centimetres, quick ones over one
    if (habits.frizz > 0) {
        const float loose = habits.frizz * SmoothStep(0.3f, 5.f, fromRoot);
        p += Wander(r, kSlow, 0.22f * fromRoot) * (1.6f * loose) +
             Wander(r, kQuick, 0.9f * fromRoot) * (0.35f * loose);
    }
    //<
    return p + at.u * (habits.lift * SmoothStep(0.3f, 6.f, fromRoot));
}
//<

//> Vary the width
float LockSource::WidthFactor(size_t index) const {
    const HashStream r(Seed(), kStrandStream, index);
    return 0.85f + 0.3f * r.Uniform(9);
}
//<

//> Make a strand
void LockSource::Strand(size_t index, Point3f *out) const {
    const HashStream r(Seed(), kStrandStream, index);
    const HashStream offset(Seed(), kOffsetStream, 0);
    const Root root = RootAt(index, offset.Uniform(0), offset.Uniform(1));
    const Guide &wisp = WispOf(root, r);
    const Habits habits = HabitsOf(root, wisp, r);
    for (size_t i = 0; i <= segments_; ++i)
        out[i] = PointAt(static_cast<float>(i) / static_cast<float>(segments_), wisp, habits, r);
    LiftOffSkin(habits.stretch * wisp.length, out);
    out[0] = root.p - root.n * (0.8f * kRootDepth);
}
//<

//> Lift a strand off the skin
void LockSource::LiftOffSkin(float length, Point3f *out) const {
    // A point moved alone would leave a kink: spread what was needed over the neighbours first.
    std::vector<Vector3f> lack(segments_ + 1);
    const auto fromRootAt = [&](size_t i) {
        return static_cast<float>(i) / static_cast<float>(segments_) * length;
    };
    bool any = false;
    for (size_t i = 0; i <= segments_; ++i) {
        Vector3f &v = lack[i];
        v = KeepOut(out[i], fromRootAt(i)) - out[i];
        any = any || v.LengthSquared() > 0;
    }
    for (int pass = 0; any && pass < 3; ++pass) {
        Vector3f before = lack[0];
        for (size_t i = 1; i + 1 < lack.size(); ++i) {
            const Vector3f smooth = (before + lack[i] * 2 + lack[i + 1]) * 0.25f;
            before = lack[i];
            lack[i] = smooth;
        }
    }
    if (any)
        for (size_t i = 0; i <= segments_; ++i)
            out[i] = KeepOut(out[i] + lack[i], fromRootAt(i));
    // Two points outside may have the skin between them: move both out by what their middle lacks.
    for (int pass = 0; any && pass < 3; ++pass)
        for (size_t i = 1; i < segments_; ++i) {
            const Point3f between = (out[i] + out[i + 1]) * 0.5f;
            Vector3f more = KeepOut(between, 0.5f) - between;
            if (more.LengthSquared() == 0)
                continue;
            more *= std::min(1.f, 0.4f / more.Length());
            out[i] = KeepOut(out[i] + more, fromRootAt(i));
            out[i + 1] = KeepOut(out[i + 1] + more, fromRootAt(i + 1));
        }
}
//<

} // namespace cuticle
//<
