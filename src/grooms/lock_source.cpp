#include "grooms/lock_source.h"

#include "grooms/head_shape.h"

#include <algorithm>

namespace cuticle {

Point2f R2(uint64_t index, float u0, float v0) {
    const double n = static_cast<double>(index) + 1;
    const double u = static_cast<double>(u0) + n * 0.7548776662466927,
                 v = static_cast<double>(v0) + n * 0.5698402909980532;
    return {std::min(static_cast<float>(u - std::floor(u)), OneMinusEpsilon),
            std::min(static_cast<float>(v - std::floor(v)), OneMinusEpsilon)};
}

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
}

LockSource::Nearby LockSource::FindGuides(const Root &root, const HashStream &r) const {
    Nearby near;
    float distance[Nearby::kGuides] = {Infinity, Infinity, Infinity};
    for (const Guide &g : guides_) {
        const float d = (g.root - root.p).LengthSquared() + (g.side * root.side < 0 ? 1e6f : 0.f);
        if (!(d < distance[Nearby::kGuides - 1]))
            continue;
        size_t k = Nearby::kGuides - 1;
        for (; k > 0 && d < distance[k - 1]; --k) {
            distance[k] = distance[k - 1];
            near.guide[k] = near.guide[k - 1];
        }
        distance[k] = d;
        near.guide[k] = &g;
    }
    // The distance that chooses the lock is shaken a little per strand, so that locks have ragged edges
    const float soft = Sqr(0.25f * lockSpacing_);
    size_t lock = 0;
    float best = Infinity;
    for (size_t k = 0; k < Nearby::kGuides; ++k) {
        const bool usable = near.guide[k] != nullptr && distance[k] < 1e5f;
        near.weight[k] = usable ? 1 / (distance[k] + soft) : 0;
        near.total += near.weight[k];
        const float shaken = std::sqrt(distance[k]) * (1 + 0.35f * r.Signed(k));
        if (usable && shaken < best) {
            best = shaken;
            lock = k;
        }
    }
    // There is always a guide; only where all are absurdly far is none usable
    near.middle = near.guide[lock] ? near.guide[lock] : &guides_.front();
    return near;
}

LockSource::Habits LockSource::HabitsOf(const Root &root, const Guide &middle, const HashStream &r) const {
    const bool flyaway = r.Uniform(10) < params_.flyaways;
    const float shorter =
        root.shorter * (1 - params_.lengthVariation * Sqr(r.Uniform(11)) * (flyaway ? 1.6f : 1.f));
    Habits h;
    h.rootOffset = root.p - middle.root;
    h.stretch = std::max(shorter, 0.05f);
    h.clump = params_.clump * (flyaway ? 0.35f : 0.75f + 0.25f * r.Uniform(12));
    h.place = std::sqrt(r.Uniform(13)), h.turn = 2 * Pi * r.Uniform(14);
    h.frizz = params_.frizz * (flyaway ? 5.f : 0.5f + r.Uniform(15));
    h.phase = middle.phase + (flyaway ? 2.5f : 0.4f) * r.Signed(16);
    h.amplitude = params_.curlRadius * middle.amplitude * (0.85f + 0.3f * r.Uniform(17));
    h.turns = middle.turns * (1 + (flyaway ? 0.2f : 0.03f) * r.Signed(18));
    h.noiseAt = Vector3f{r.Signed(19), r.Signed(20), r.Signed(21)} * 100.f;
    return h;
}

Point3f LockSource::PointAt(float along, const Root &root, const Nearby &near, const Habits &habits) const {
    const Guide &middle = *near.middle;
    const float s = along * habits.stretch;
    const float fromRoot = s * middle.length; // cm of guide behind this point

    // Its own path between the guides around it ...
    Vector3f own;
    for (size_t k = 0; k < Nearby::kGuides; ++k)
        if (near.weight[k] > 0)
            own += near.guide[k]->At(near.guide[k]->p, s) * (near.weight[k] / near.total);
    own += root.p;
    // ... drawn toward a place in its lock.
    const Vector3f u = middle.At(middle.u, s), v = middle.At(middle.v, s);
    const float lockRadius = 0.32f * lockSpacing_;
    const float radius = lockRadius * habits.place * (1 - 0.6f * along);
    const Vector3f inLock = middle.root + middle.At(middle.p, s) + u * (radius * std::cos(habits.turn)) +
                            v * (radius * std::sin(habits.turn));
    const float draw = habits.clump * SmoothStep(0, 0.45f, s);
    Vector3f p = Lerp(draw, 1.f, 0.f) * own + draw * inLock;
    // Close to the skin keep the root's place whatever the lock does.
    const float settle = SmoothStep(0, 1.5f, fromRoot);
    p = Lerp(settle, 1.f, 0.f) * (middle.At(middle.p, s) + middle.root + habits.rootOffset) + settle * p;

    // Curls: a helix in the lock's frame that opens from the root; waves stay in one plane.
    if (habits.amplitude > 0) {
        const float open = habits.amplitude * SmoothStep(0.2f, 6.f, fromRoot) * (1 - 0.25f * along);
        const float angle = habits.phase + 2 * Pi * habits.turns * s;
        if (waves_)
            p += (u * std::sin(angle) + v * (0.35f * std::cos(angle))) * open;
        else
            p += (u * std::cos(angle) + v * (middle.handedness * std::sin(angle))) * open;
    }
    // Frizz: slow strays over several centimetres, quick ones over one.
    const float loose = SmoothStep(0.3f, 5.f, fromRoot);
    if (habits.frizz > 0) {
        const float x = fromRoot;
        p += GroomNoise(habits.noiseAt + Vector3f{0.22f * x, 0, 0}, Seed()) * (1.6f * habits.frizz * loose);
        p += GroomNoise(habits.noiseAt + Vector3f{0, 0.9f * x, 7}, Seed()) * (0.45f * habits.frizz * loose);
    }
    return p;
}

void LockSource::Strand(size_t index, Point3f *out) const {
    const HashStream r(Seed(), kStrandStream, index);
    const Root root = RootOf(index);
    const Nearby near = FindGuides(root, r);
    const Habits habits = HabitsOf(root, *near.middle, r);
    for (size_t i = 0; i <= segments_; ++i)
        out[i] = PointAt(static_cast<float>(i) / static_cast<float>(segments_), root, near, habits);
    LiftOffSkin(habits.stretch, near.middle->length, out);
    out[0] = root.p - root.n * (0.8f * kRootDepth);
}

void LockSource::LiftOffSkin(float stretch, float guideLength, Point3f *out) const {
    // A point moved alone would leave a kink: spread what was needed over the neighbours first.
    std::vector<Vector3f> lack(segments_ + 1);
    const auto fromRootAt = [&](size_t i) {
        return static_cast<float>(i) / static_cast<float>(segments_) * stretch * guideLength;
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

} // namespace cuticle
