#include "grooms/procedural.h"

#include "core/error.h"
#include "core/parallel.h"
#include "grooms/hash.h"
#include "grooms/head_shape.h"

#include <algorithm>

namespace cuticle {

namespace {

// The streams of random numbers, so that no two things share one.
enum Stream : uint64_t {
    kGuideStream = 1,
    kStrandStream,
    kNoiseStream,
    kBallStream,
    kOffsetStream,
    kColorStream
};

float SmoothStep(float a, float b, float v) {
    const float t = std::clamp((v - a) / (b - a), 0.f, 1.f);
    return t * t * (3 - 2 * t);
}

// Point `index` of Roberts' R2 sequence (the plastic number's powers): even cover of the square at any count.
Point2f R2(uint64_t index, float u0, float v0) {
    const double n = static_cast<double>(index) + 1;
    const double u = static_cast<double>(u0) + n * 0.7548776662466927,
                 v = static_cast<double>(v0) + n * 0.5698402909980532;
    return {std::min(static_cast<float>(u - std::floor(u)), OneMinusEpsilon),
            std::min(static_cast<float>(v - std::floor(v)), OneMinusEpsilon)};
}

Point3f UniformSphere(float u, float v) {
    const float z = 1 - 2 * u, r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(2 * Pi * v), r * std::sin(2 * Pi * v), z};
}

// Smooth vector noise in [-1, 1]^3 with features of unit size: random values at lattice points, cubic fade.
Vector3f Noise(const Point3f &p, uint64_t seed) {
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

Vector3f TangentTo(const Vector3f &n, const Vector3f &v) { return v - n * Dot(n, v); }

// A guide: the middle of a lock, with a frame carried along it without twist.
constexpr int kGuideSteps = 48;
struct Guide {
    Point3f root;
    int side = 0; // of the parting: -1, 1, or 0 where there is none
    float length = 0;
    Vector3f p[kGuideSteps + 1]; // relative to the root, at equal arc lengths
    Vector3f u[kGuideSteps + 1], v[kGuideSteps + 1];
    float phase = 0, turns = 0, handedness = 1, amplitude = 1;

    template <typename Member>
    Vector3f At(const Member &values, float s) const {
        const float x = std::clamp(s, 0.f, 1.f) * kGuideSteps;
        const int i = std::min(static_cast<int>(x), kGuideSteps - 1);
        return Lerp(x - static_cast<float>(i), 1.f, 0.f) * values[i] +
               (x - static_cast<float>(i)) * values[i + 1];
    }
};

// Turns a path into a guide: equal arc lengths, then frames by parallel transport.
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

// What heads and fur share: strands between guides, drawn into locks, curled, frizzed.
class LockSource : public StrandSource {
  public:
    explicit LockSource(const GroomParams &params) : StrandSource(params), params_(params) {}
    size_t StrandCount() const override { return static_cast<size_t>(params_.strands); }
    size_t PointsPerStrand() const override { return static_cast<size_t>(segments_) + 1; }

  protected:
    struct Root {
        Point3f p;
        Normal3f n;
        int side = 0;
        float shorter = 1; // factor on the length
    };
    virtual Root RootOf(size_t strand) const = 0;
    // p, moved off the skin; fromRoot: cm of hair behind it.
    virtual Point3f KeepOut(const Point3f &p, float fromRoot) const = 0;

    void Strand(size_t index, Point3f *out) const override;

    uint64_t Seed() const { return static_cast<uint64_t>(params_.seed); }

    GroomParams params_;
    int segments_ = 16;
    float lockSpacing_ = 1; // typical distance between the roots of neighbouring guides
    bool waves_ = false;    // waves in a plane and in step with their neighbours, instead of curls
    std::vector<Guide> guides_;
};

void LockSource::Strand(size_t index, Point3f *out) const {
    const HashStream r(Seed(), kStrandStream, index);
    const Root root = RootOf(index);

    // The three nearest guides on this side of the parting. The distance that chooses the lock is shaken a
    // little per strand, so that locks have ragged edges.
    constexpr int kNear = 3;
    const Guide *nearest[kNear] = {};
    float distance[kNear] = {Infinity, Infinity, Infinity};
    for (const Guide &g : guides_) {
        const float d = (g.root - root.p).LengthSquared() + (g.side * root.side < 0 ? 1e6f : 0.f);
        if (!(d < distance[kNear - 1]))
            continue;
        int k = kNear - 1;
        for (; k > 0 && d < distance[k - 1]; --k) {
            distance[k] = distance[k - 1];
            nearest[k] = nearest[k - 1];
        }
        distance[k] = d;
        nearest[k] = &g;
    }
    float weight[kNear], total = 0;
    const float soft = Sqr(0.25f * lockSpacing_);
    int lock = 0;
    float best = Infinity;
    for (int k = 0; k < kNear; ++k) {
        const bool usable = nearest[k] != nullptr && distance[k] < 1e5f;
        weight[k] = usable ? 1 / (distance[k] + soft) : 0;
        total += weight[k];
        const float shaken = std::sqrt(distance[k]) * (1 + 0.35f * r.Signed(static_cast<uint64_t>(k)));
        if (usable && shaken < best) {
            best = shaken;
            lock = k;
        }
    }
    // There is always a guide; only where all are absurdly far is none usable
    const Guide &middle = nearest[lock] ? *nearest[lock] : guides_.front();

    // This strand's own habits.
    const bool flyaway = r.Uniform(10) < params_.flyaways;
    const float shorter =
        root.shorter * (1 - params_.lengthVariation * Sqr(r.Uniform(11)) * (flyaway ? 1.6f : 1.f));
    const float stretch = std::max(shorter, 0.05f);
    const float clump = params_.clump * (flyaway ? 0.35f : 0.75f + 0.25f * r.Uniform(12));
    const float place = std::sqrt(r.Uniform(13)), turn = 2 * Pi * r.Uniform(14);
    const float lockRadius = 0.32f * lockSpacing_;
    const Vector3f rootOffset = root.p - middle.root;
    const float frizz = params_.frizz * (flyaway ? 5.f : 0.5f + r.Uniform(15));
    const float phase = middle.phase + (flyaway ? 2.5f : 0.4f) * r.Signed(16);
    const float amplitude = params_.curlRadius * middle.amplitude * (0.85f + 0.3f * r.Uniform(17));
    const float turns = middle.turns * (1 + (flyaway ? 0.2f : 0.03f) * r.Signed(18));
    const Vector3f stray{r.Signed(19), r.Signed(20), r.Signed(21)};
    const Point3f noiseAt = stray * 100.f;

    for (int i = 0; i <= segments_; ++i) {
        const float along = static_cast<float>(i) / static_cast<float>(segments_);
        const float s = along * stretch;
        const float fromRoot = s * middle.length; // cm of guide behind this point

        // Its own path between the guides around it ...
        Vector3f own;
        for (int k = 0; k < kNear; ++k)
            if (weight[k] > 0)
                own += nearest[k]->At(nearest[k]->p, s) * (weight[k] / total);
        own += root.p;
        // ... drawn toward a place in its lock.
        const Vector3f u = middle.At(middle.u, s), v = middle.At(middle.v, s);
        const float radius = lockRadius * place * (1 - 0.6f * along);
        const Vector3f inLock = middle.root + middle.At(middle.p, s) + u * (radius * std::cos(turn)) +
                                v * (radius * std::sin(turn));
        const float draw = clump * SmoothStep(0, 0.45f, s);
        Vector3f p = Lerp(draw, 1.f, 0.f) * own + draw * inLock;
        // Close to the skin keep the root's place whatever the lock does.
        const float settle = SmoothStep(0, 1.5f, fromRoot);
        p = Lerp(settle, 1.f, 0.f) * (middle.At(middle.p, s) + middle.root + rootOffset) + settle * p;

        // Curls: a helix in the lock's frame that opens from the root; waves stay in one plane.
        if (amplitude > 0) {
            const float open = amplitude * SmoothStep(0.2f, 6.f, fromRoot) * (1 - 0.25f * along);
            const float angle = phase + 2 * Pi * turns * s;
            if (waves_)
                p += (u * std::sin(angle) + v * (0.35f * std::cos(angle))) * open;
            else
                p += (u * std::cos(angle) + v * (middle.handedness * std::sin(angle))) * open;
        }
        // Frizz: slow strays over several centimetres, quick ones over one.
        const float loose = SmoothStep(0.3f, 5.f, fromRoot);
        if (frizz > 0) {
            const float x = fromRoot;
            p += Noise(noiseAt + Vector3f{0.22f * x, 0, 0}, Seed()) * (1.6f * frizz * loose);
            p += Noise(noiseAt + Vector3f{0, 0.9f * x, 7}, Seed()) * (0.45f * frizz * loose);
        }
        out[i] = p;
    }
    // Out of the skin. A point moved alone would leave a kink: spread what was needed over the neighbours first.
    std::vector<Vector3f> lack(static_cast<size_t>(segments_) + 1);
    const auto fromRootAt = [&](int i) {
        return static_cast<float>(i) / static_cast<float>(segments_) * stretch * middle.length;
    };
    bool any = false;
    for (int i = 0; i <= segments_; ++i) {
        Vector3f &v = lack[static_cast<size_t>(i)];
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
        for (int i = 0; i <= segments_; ++i)
            out[i] = KeepOut(out[i] + lack[static_cast<size_t>(i)], fromRootAt(i));
    // Two points outside may have the skin between them: move both out by what their middle lacks.
    for (int pass = 0; any && pass < 3; ++pass)
        for (int i = 1; i < segments_; ++i) {
            const Point3f between = (out[i] + out[i + 1]) * 0.5f;
            Vector3f more = KeepOut(between, 0.5f) - between;
            if (more.LengthSquared() == 0)
                continue;
            more *= std::min(1.f, 0.4f / more.Length());
            out[i] = KeepOut(out[i] + more, fromRootAt(i));
            out[i + 1] = KeepOut(out[i + 1] + more, fromRootAt(i + 1));
        }
    out[0] = root.p - root.n * (0.8f * kRootDepth);
}

// ---------------------------------------------------------------------------------------------------- a head

class HeadSource final : public LockSource {
  public:
    explicit HeadSource(const GroomParams &params) : LockSource(params) {
        waves_ = params.style == "wavy";
        const float turns = params.curlRadius > 0 ? params.length / params.curlLength : 0;
        // Seven points a turn keep the spline within 1% of a circle.
        segments_ =
            params.segments > 0
                ? params.segments
                : std::clamp(static_cast<int>(std::ceil(std::max(24.f, turns * (waves_ ? 6.f : 7.5f)))), 16,
                             400);
        lockSpacing_ = std::sqrt(scalp_.Area() / static_cast<float>(params.locks));
        guides_.resize(static_cast<size_t>(params.locks));
        ParallelFor(guides_.size(), [&](size_t i) { Grow(i, &guides_[i]); });
    }

  private:
    int Side(const Point3f &p) const {
        // The parting runs from the forehead to the crown and ends there.
        return p.z < -4.5f ? 0 : (p.x < params_.part ? -1 : 1);
    }
    Root RootOf(size_t strand) const override {
        const HashStream offset(Seed(), kOffsetStream, 0);
        const Point2f uv = R2(strand, offset.Uniform(0), offset.Uniform(1));
        const ScalpPoint s = scalp_.Sample(uv.x, uv.y);
        Root root;
        root.p = s.p;
        root.n = s.n;
        root.side = Side(s.p);
        root.shorter = 0.45f + 0.55f * s.density; // downy hair along the hairline
        return root;
    }
    Point3f KeepOut(const Point3f &p, float fromRoot) const override {
        return PushOutOfHead(p, kHeadClearance * std::min(1.f, fromRoot));
    }
    void Grow(size_t index, Guide *g) const;

    Scalp scalp_;
};

// Grows one guide from its root: combed away from the parting, bent down by its weight, resting on the head, the hair
// beneath it and the shoulders.
void HeadSource::Grow(size_t index, Guide *g) const {
    const HashStream r(Seed(), kGuideStream, index);
    const Point2f uv = R2(index, r.Uniform(100) * 0.02f, r.Uniform(101) * 0.02f);
    const ScalpPoint start = scalp_.Sample(uv.x, uv.y);
    g->root = start.p;
    g->side = Side(start.p);
    g->phase = 2 * Pi * r.Uniform(0);
    g->handedness = r.Uniform(1) < 0.5f ? -1.f : 1.f;
    g->amplitude = 0.65f + 0.7f * r.Uniform(2);

    // Which way it is combed at the root: sideways off the parting in front, away from the crown behind.
    const bool curly = params_.style == "curly";
    const Point3f crown{0.6f * params_.part, 10.5f, -5.f};
    Vector3f off = start.p - crown;
    off.y = std::min(off.y, 0.f);
    off = off / std::max(off.Length(), 1e-3f);
    const Vector3f sideways{start.p.x < params_.part ? -1.f : 1.f, 0, -0.6f};
    const float front = SmoothStep(-6.f, 0.5f, start.p.z);
    Vector3f comb = TangentTo(start.n, sideways * front + off * (1 - front));
    if (comb.LengthSquared() > 1e-8f)
        comb = Normalize(comb);
    const float height = SmoothStep(-5.f, 11.f, start.p.y);
    const float lift = (curly ? 0.85f : 0.45f) * (0.4f + 0.6f * height) + 0.15f * r.Signed(3);
    Vector3f d = Normalize(start.n * lift + comb + Vector3f{r.Signed(4), r.Signed(5), r.Signed(6)} * 0.22f);

    // Hair from higher up lies on that from below: its distance from the skin grows along it.
    const float layer = 0.1f + params_.volume * (0.12f + 0.88f * height * (0.6f + 0.4f * r.Uniform(7))) +
                        (curly ? 0.5f : 0.2f) * params_.curlRadius;
    // Cut: between "all as long" and "all end at one height".
    const float full = params_.length * (1 - 0.5f * params_.lengthVariation * r.Uniform(8));
    const float floorY = 10.f - params_.length + 5.f; // where the longest hairs from the top end
    constexpr float step = 0.3f;
    const float weight = curly ? 0.16f : 0.24f;
    std::vector<Point3f> path{start.p};
    Point3f p = start.p;
    float travelled = 0, budget = full;
    while (travelled < budget && path.size() < 4000) {
        Vector3f force = Vector3f{0, -1, 0} * weight;
        // Keep out of the face: hair in front of the ears goes outward and back.
        const float face =
            SmoothStep(1.f, 5.f, p.z) * (1 - SmoothStep(5.f, 10.f, p.y)) * SmoothStep(-16.f, -9.f, p.y);
        const float away =
            std::abs(p.x) < 3 && g->side != 0 ? static_cast<float>(g->side) : (p.x < 0 ? -1.f : 1.f);
        force += Vector3f{0.4f * away * (1 - SmoothStep(5.f, 9.f, std::abs(p.x))), 0, -0.3f} * face;
        // At the neck hair turns behind the shoulders, before they spread it.
        const float neck = (1 - SmoothStep(-9.f, -3.f, p.y)) * (1 - SmoothStep(-1.f, 4.f, p.z));
        force += Vector3f{p.x < 0 ? 0.08f : -0.08f, 0, -0.13f} * (neck * SmoothStep(3.f, 8.f, std::abs(p.x)));
        force += Noise(p * 0.16f, Seed() + 1) * 0.05f + Noise(g->root * 0.5f + p * 0.05f, Seed() + 2) * 0.06f;
        d = Normalize(d + force * step);
        p += d * step;
        travelled += step;
        const float offset = kHeadClearance + (layer - kHeadClearance) * SmoothStep(0, 7.f, travelled);
        const float inside = offset - HeadDistance(p);
        if (inside > 0) {
            const Normal3f n = HeadNormal(p);
            p += n * inside;
            const float into = Dot(d, n);
            if (into < 0) {
                const Vector3f along = TangentTo(n, d);
                d = along.LengthSquared() > 1e-4f ? Normalize(along)
                                                  : Normalize(along + Vector3f{0.1f, -0.1f, -0.3f});
            }
        }
        path.push_back(p);
        // Below the cut only the part of the length that the layers keep is left to grow.
        if (p.y < floorY + 1.2f * r.Signed(9))
            budget = std::min(budget, std::max(travelled, Lerp(params_.level, full, travelled)));
    }
    FinishGuide(path, start.n, g);
    g->turns = params_.curlRadius > 0 ? g->length / (params_.curlLength * (0.8f + 0.4f * r.Uniform(30))) : 0;
    if (waves_) {
        // Neighbouring locks swing together: the phase follows the place on the head.
        const Vector3f n = Noise(g->root * 0.12f, Seed() + 3);
        g->phase = 3.5f * n.x + 0.5f * r.Signed(31);
        g->turns = g->length / (params_.curlLength * (0.95f + 0.1f * r.Uniform(30)));
    }
}

// ------------------------------------------------------------------------------------------------- a fur ball

class FurBallSource final : public LockSource {
  public:
    explicit FurBallSource(const GroomParams &params) : LockSource(params) {
        segments_ = params.segments > 0 ? params.segments : 10;
        lockSpacing_ = params.radius * std::sqrt(4 * Pi / static_cast<float>(params.locks));
        guides_.resize(static_cast<size_t>(params.locks));
        ParallelFor(guides_.size(), [&](size_t i) { Grow(i, &guides_[i]); });
    }

  private:
    Root RootOf(size_t strand) const override {
        const HashStream offset(Seed(), kOffsetStream, 0);
        const Point2f uv = R2(strand, offset.Uniform(0), offset.Uniform(1));
        Root root;
        root.n = UniformSphere(uv.x, uv.y);
        root.p = root.n * params_.radius;
        return root;
    }
    Point3f KeepOut(const Point3f &p, float fromRoot) const override {
        const float d = p.Length(), keep = params_.radius + kHeadClearance * std::min(1.f, fromRoot);
        return d < keep ? p * (keep / std::max(d, 1e-6f)) : p;
    }
    void Grow(size_t index, Guide *g) const {
        const HashStream r(Seed(), kGuideStream, index);
        const Point2f uv = R2(index, r.Uniform(100) * 0.02f, r.Uniform(101) * 0.02f);
        const Normal3f n = UniformSphere(uv.x, uv.y);
        g->root = n * params_.radius;
        g->phase = 2 * Pi * r.Uniform(0);
        g->handedness = r.Uniform(1) < 0.5f ? -1.f : 1.f;
        g->amplitude = 0.7f + 0.6f * r.Uniform(2);
        // The nap: slow swirls over the ball, and its weight.
        const Vector3f nap = TangentTo(n, Noise(n * 1.7f, Seed() + 1) * 1.6f + Vector3f{0, -0.7f, 0});
        Vector3f d = Normalize(n + nap * 0.6f + Vector3f{r.Signed(3), r.Signed(4), r.Signed(5)} * 0.15f);
        const float length = params_.length * (1 - 0.5f * params_.lengthVariation * r.Uniform(6));
        const float step = length / 24;
        std::vector<Point3f> path{g->root};
        Point3f p = g->root;
        for (int i = 0; i < 24; ++i) {
            d = Normalize(d + (nap * 0.9f + Vector3f{0, -0.5f, 0}) * (1.f / 24));
            p += d * step;
            p = KeepOut(p, step * static_cast<float>(i + 1));
            path.push_back(p);
        }
        FinishGuide(path, TangentTo(d, Vector3f{0.3f, 0.9f, 0.1f}), g);
        g->turns = params_.curlRadius > 0 ? g->length / params_.curlLength : 0;
    }
};

// ----------------------------------------------------------------------------------------------- a hair cube

// n x n straight parallel hairs along y, evenly spaced, filling a cube around the origin (Pharr 2016, figure 1.20).
class HairCubeSource final : public StrandSource {
  public:
    explicit HairCubeSource(const GroomParams &params)
        : StrandSource(params), side_(params.side), segments_(std::max(1, params.segments)),
          n_(std::max<size_t>(
              1, static_cast<size_t>(std::lround(std::sqrt(static_cast<double>(params.strands)))))) {}
    size_t StrandCount() const override { return n_ * n_; }
    size_t PointsPerStrand() const override { return static_cast<size_t>(segments_) + 1; }
    void Strand(size_t index, Point3f *points) const override {
        const auto at = [&](size_t i) {
            return side_ * ((static_cast<float>(i) + 0.5f) / static_cast<float>(n_) - 0.5f);
        };
        for (int k = 0; k <= segments_; ++k)
            points[k] = {at(index % n_),
                         side_ * (static_cast<float>(k) / static_cast<float>(segments_) - 0.5f),
                         at(index / n_)};
    }

  private:
    float side_;
    int segments_;
    size_t n_;
};

// -------------------------------------------------------------------------------------- a ball of random strands

// Strands that wander through a ball: a random start, a direction that turns slowly, turned back at the surface.
class BallSource final : public StrandSource {
  public:
    explicit BallSource(const GroomParams &params)
        : StrandSource(params), params_(params), segments_(params.segments > 0 ? params.segments : 8) {}
    size_t StrandCount() const override { return static_cast<size_t>(params_.strands); }
    size_t PointsPerStrand() const override { return static_cast<size_t>(segments_) + 1; }
    void Strand(size_t index, Point3f *points) const override {
        const HashStream r(static_cast<uint64_t>(params_.seed), kBallStream, index);
        const float inner = params_.radius * 0.98f;
        Point3f p = UniformSphere(r.Uniform(0), r.Uniform(1)) * (inner * std::cbrt(r.Uniform(2)));
        Vector3f d = UniformSphere(r.Uniform(3), r.Uniform(4));
        const float step = params_.radius * (0.5f + 0.5f * r.Uniform(5)) / static_cast<float>(segments_);
        points[0] = p;
        for (int k = 1; k <= segments_; ++k) {
            const auto i = static_cast<uint64_t>(k);
            d = Normalize(d + UniformSphere(r.Uniform(16 + 2 * i), r.Uniform(17 + 2 * i)) * 0.35f);
            p += d * step;
            const float length = p.Length();
            if (length > inner) {
                const Vector3f n = p / length;
                p = n * inner;
                const Vector3f back = d - n * (1.2f * std::max(0.f, Dot(d, n)));
                d = back.LengthSquared() > 1e-6f ? Normalize(back) : -n;
            }
            points[k] = p;
        }
    }

  private:
    GroomParams params_;
    int segments_;
};

} // namespace

StrandSource::StrandSource(const GroomParams &params)
    : width_{params.width * params.widthScale, params.width * params.widthScale * params.tip},
      colors_(params) {}

void StrandSource::Colors(size_t index, Spectrum *colors) const {
    const HashStream r(static_cast<uint64_t>(colors_.seed), kColorStream, index);
    // Without pigment hair is not quite clear
    constexpr float kWhite[3] = {0.9f, 0.89f, 0.86f};
    const bool grey = r.Uniform(0) < colors_.grey;
    // The logarithm of a colour goes with the root of the absorption: a power of the colour is more or less of the pigment
    const float power = std::sqrt(std::max(0.f, 1 + colors_.colorVariation * r.Signed(1)));
    const float from = colors_.colorFrom + 0.12f * r.Signed(2);
    const size_t n = PointsPerStrand();
    for (size_t k = 0; k < n; ++k) {
        const float along = n > 1 ? static_cast<float>(k) / static_cast<float>(n - 1) : 0;
        const float dyed = colors_.tipColor ? SmoothStep(from - 0.12f, from + 0.12f, along) : 0;
        for (int c = 0; c < 3; ++c) {
            const float own = grey ? kWhite[c] : (*colors_.rootColor)[c];
            const float color = Lerp(dyed, own, dyed > 0 ? (*colors_.tipColor)[c] : own);
            colors[k][c] = std::pow(color, power);
        }
    }
}

Groom StrandSource::Range(size_t begin, size_t end) const {
    end = std::min(end, StrandCount());
    begin = std::min(begin, end);
    const size_t n = end - begin, run = PointsPerStrand();
    if (n * run > std::numeric_limits<uint32_t>::max())
        throw Error("a groom holds at most 4294967295 points at once");
    Groom groom;
    groom.strandOffsets.resize(n + 1);
    for (size_t i = 0; i <= n; ++i)
        groom.strandOffsets[i] = static_cast<uint32_t>(i * run);
    groom.points.resize(n * run);
    groom.width = width_[0];
    if (width_[0] != width_[1])
        groom.strandWidths.assign(n, width_);
    groom.hasColor = HasColors();
    if (HasColors())
        groom.pointColors.resize(n * run);
    ParallelFor(n, [&](size_t i) {
        Strand(begin + i, groom.points.data() + i * run);
        if (HasColors())
            Colors(begin + i, groom.pointColors.data() + i * run);
    });
    return groom;
}

std::unique_ptr<StrandSource> MakeStrandSource(const GroomParams &params) {
    // Through the table once more: a struct filled by hand gets the same checks as a scene file.
    GroomParams checked = MakeGroomParams(params.kind, params.kind == "head" ? params.style : std::string());
    for (const GroomParamInfo &info : GroomParamTable()) {
        const bool whole = std::holds_alternative<int GroomParams::*>(info.member);
        const double value = whole
                                 ? params.*(std::get<int GroomParams::*>(info.member))
                                 : static_cast<double>(params.*(std::get<float GroomParams::*>(info.member)));
        if (GroomReads(params.kind, info))
            SetGroomParam(&checked, info.name, value);
    }
    for (const GroomColorInfo &info : GroomColorTable())
        if (const std::optional<Spectrum> &color = params.*(info.member))
            SetGroomColor(&checked, info.name, *color);
    if (checked.tipColor && !checked.rootColor)
        throw Error("groom parameter \"tip_color\" dyes hair that has a \"root_color\"; give that as well");
    if (checked.grey > 0 && !checked.rootColor)
        Warning("grey hair without a colour",
                "groom parameter \"grey\" is for hair that has a \"root_color\"; without "
                "it the material alone gives the colour, of all hairs");
    if (checked.kind == "head")
        return std::make_unique<HeadSource>(checked);
    if (checked.kind == "fur-ball")
        return std::make_unique<FurBallSource>(checked);
    if (checked.kind == "hair-cube")
        return std::make_unique<HairCubeSource>(checked);
    return std::make_unique<BallSource>(checked);
}

Groom MakeGroom(const GroomParams &params) {
    const std::unique_ptr<StrandSource> source = MakeStrandSource(params);
    CheckSegmentCount(source->StrandCount() * (source->PointsPerStrand() - 1));
    return source->Range(0, source->StrandCount());
}

} // namespace cuticle
