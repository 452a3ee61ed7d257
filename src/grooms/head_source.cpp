//> Grow hair on the head
#include "grooms/head_source.h"

#include "core/parallel.h"
#include "grooms/head_shape.h"
#include "grooms/lock_source.h"
#include "grooms/scalp.h"

#include <algorithm>

namespace cuticle {

namespace {

//> Declare how a head of hair is grown
class HeadSource final : public LockSource {
  public:
    explicit HeadSource(const GroomParams &params) : LockSource(params), style_(FindHeadStyle(params.style)) {
        waves_ = style_.waves;
        //> Choose how many segments a strand needs
        const float turns = params.curlRadius > 0 ? params.length / params.curlLength : 0;
        if (params.segments > 0)
            segments_ = static_cast<size_t>(params.segments);
        else if (style_.segments > 0)
            segments_ = static_cast<size_t>(style_.segments);
        else // Seven and a half points a turn keep the spline within 1.1% of a circle
            segments_ = static_cast<size_t>(std::clamp(
                std::ceil(std::max(0.75f * params.length, turns * (waves_ ? 6.f : 7.5f))), 8.f, 400.f));
        //<
        area_ = scalp_.Area();
        guides_.resize(static_cast<size_t>(params.locks));
        ParallelFor(guides_.size(), [&](size_t i) { Grow(i, &guides_[i]); });
        MakeWisps();
    }

  private:
    //> Part the hair
    // The parting runs from the forehead to the crown, not quite straight, and ends there. stray: of a hair
    // that grows across it, cm.
    int Side(const Point3f &p, float stray) const {
        if (style_.comb != Comb::Part || p.z < -4.5f)
            return 0;
        const float line = params_.part + 0.12f * std::sin(1.7f * p.z) + 0.08f * std::sin(4.1f * p.z + 1);
        return p.x + stray < line ? -1 : 1;
    }
    //<
    //> Place a root
    Root RootAt(size_t index, float u0, float v0) const override {
        const HashStream r(Seed(), kRootStream, index);
        const Point2f uv = R2(index, u0, v0);
        const ScalpPoint s = scalp_.Sample(uv.x, uv.y);
        Root root;
        root.p = s.p;
        root.n = s.n;
        root.side = Side(s.p, 0.25f * r.Signed(0));
        // Along the hairline hair is downy: the nearer, the more of it is short
        if (r.Uniform(1) > SmoothStep(0.1f, 1.f, s.density))
            root.shorter = 0.03f + 0.22f * Sqr(r.Uniform(2));
        return root;
    }
    //<
    //> Keep hair out of head and ears
    Point3f KeepOut(const Point3f &p, float fromRoot) const override {
        // An ear's rim is thinner than a step along a hair: what passes by goes around the ear as a whole
        const Vector3f q{(std::abs(p.x) - 7.8f) / 1.2f, (p.y + 0.4f) / 3.4f, (p.z + 1.1f) / 2.2f};
        Point3f out = p;
        if (const float rest = 1 - Sqr(q.y) - Sqr(q.z); rest > Sqr(q.x)) {
            const float over = 7.8f + 1.2f * std::sqrt(rest) - std::abs(p.x);
            out.x += std::copysign(over * SmoothStep(0.5f, 2.5f, fromRoot), p.x);
        }
        return PushOutOfHead(out, kHeadClearance * std::min(1.f, fromRoot));
    }
    //<
    void Grow(size_t index, Guide *g) const;
    Vector3f CombAt(const ScalpPoint &root) const;
    // Where hair that is drawn together meets, on the head's midline.
    Point3f Knot() const {
        return style_.comb == Comb::Bun ? Point3f{0, 5.2f, -10.6f} : Point3f{0, -3.2f, -9.2f};
    }
    void DrawToKnot(Guide *g, std::vector<Point3f> *path) const;
    void WindBun(const HashStream &r, std::vector<Point3f> *path) const;
    void Plait(const HashStream &r, std::vector<Point3f> *path) const;
    Vector3f Force(const Point3f &p, const Guide &g) const;

    const HeadStyleInfo &style_;
    Scalp scalp_;
};
//<

//> Comb hair at its root
// The way that hair is combed at its root, along the skin.
Vector3f HeadSource::CombAt(const ScalpPoint &root) const {
    const Point3f crown{0.6f * params_.part, 10.5f, -5.f};
    Vector3f off = root.p - crown;
    if (style_.comb == Comb::Part)
        off.y = std::min(off.y, 0.f);
    off = off / std::max(off.Length(), 1e-3f);
    const float front = SmoothStep(-6.f, 0.5f, root.p.z);
    Vector3f comb;
    switch (style_.comb) {
    case Comb::Part: { // sideways off the parting in front, away from the crown behind
        const Vector3f sideways{root.p.x < params_.part ? -1.f : 1.f, 0, -0.6f};
        comb = sideways * front + off * (1 - front);
        break;
    }
    case Comb::Whorl: // away from the crown, turning around it, and to one side in front
        comb =
            off + Cross(root.n, off) * 0.5f + Vector3f{-0.7f, 0, 0.1f} * front * SmoothStep(3, 8, root.p.y);
        break;
    case Comb::Back:
        comb = {0, -0.35f * (1 - SmoothStep(-2.f, 6.f, root.p.y)), -1};
        break;
    case Comb::Out:
        return {};
    case Comb::Bun:
    case Comb::Braid:
        comb = Knot() - root.p;
        break;
    }
    comb = TangentTo(root.n, comb);
    return comb.LengthSquared() > 1e-8f ? Normalize(comb) : Vector3f();
}
//<

//> Bend a hair as it grows
// This bends a hair at p, per cm of its length.
Vector3f HeadSource::Force(const Point3f &p, const Guide &g) const {
    Vector3f force = Vector3f{0, -1, 0} * style_.weight;
    if (style_.comb == Comb::Out || style_.comb == Comb::Whorl)
        return force + GroomNoise(p * 0.3f, Seed() + 1) * 0.08f;
    if (style_.comb == Comb::Back) // the comb's way holds until the hair hangs
        force += Vector3f{0, 0, -0.16f} * (SmoothStep(-8.f, -3.f, p.z) * SmoothStep(-4.f, 4.f, p.y));
    // Ends turn in, toward the neck
    force += Vector3f{p.x < 0 ? style_.turnIn : -style_.turnIn, 0, -0.3f * style_.turnIn} *
             (1 - SmoothStep(-9.f, -5.f, p.y));
    // Keep out of the face: hair in front of the ears goes outward and back.
    const float face =
        SmoothStep(1.f, 5.f, p.z) * (1 - SmoothStep(5.f, 10.f, p.y)) * SmoothStep(-16.f, -9.f, p.y);
    const float away = std::abs(p.x) < 3 && g.side != 0 ? static_cast<float>(g.side) : (p.x < 0 ? -1.f : 1.f);
    force += Vector3f{0.4f * away * (1 - SmoothStep(5.f, 9.f, std::abs(p.x))), 0, -0.3f} * face;
    // At the neck hair turns behind the shoulders, before they spread it.
    const float neck = (1 - SmoothStep(-9.f, -3.f, p.y)) * (1 - SmoothStep(-1.f, 4.f, p.z));
    force += Vector3f{p.x < 0 ? 0.08f : -0.08f, 0, -0.13f} * (neck * SmoothStep(3.f, 8.f, std::abs(p.x)));
    return force + GroomNoise(p * 0.16f, Seed() + 1) * 0.05f +
           GroomNoise(g.root * 0.5f + p * 0.05f, Seed() + 2) * 0.06f;
}
//<

constexpr float kKnotStep = 0.3f; // cm

//> Draw hair to the knot
// Draws hair along the head to the knot: what comes from farther off lies on what grows nearer.
void HeadSource::DrawToKnot(Guide *g, std::vector<Point3f> *path) const {
    const float far = (Knot() - g->root).Length();
    const float layer = 0.08f + params_.volume * (0.15f + 0.05f * far);
    Point3f p = g->root;
    for (int i = 0; i < 200 && (Knot() - p).Length() > 1.2f; ++i) {
        const Normal3f n = HeadNormal(p);
        // In front of an ear the way leads over it
        const float front = SmoothStep(-4.f, -1.f, p.z) * (1 - SmoothStep(2.5f, 5.f, p.y));
        const Point3f overEar{std::copysign(7.5f, p.x), 6, -4};
        const Vector3f along = TangentTo(n, Knot() * (1 - front) + overEar * front - p);
        const float off = 0.3f * SmoothStep(2.5f, 1, (Knot() - p).Length()); // leaves the skin near the knot
        p += Normalize(along / std::max(along.Length(), 1e-3f) + n * off) * kKnotStep;
        const float keep = kHeadClearance + layer * SmoothStep(0, 4, kKnotStep * static_cast<float>(i)) *
                                                SmoothStep(-0.2f * far, 0.5f * far, (Knot() - p).Length());
        p += HeadNormal(p) * (std::max(keep, std::min(HeadDistance(p), layer + off)) - HeadDistance(p));
        path->push_back(p);
    }
}
//<

//> Wind a bun
// Winds a hair around the knot: along a torus whose axis leaves the head, each at a depth of its own.
void HeadSource::WindBun(const HashStream &r, std::vector<Point3f> *path) const {
    const Vector3f axis = Normalize(Vector3f{0, 0.25f, -1}), e1{1, 0, 0}, e2 = Cross(axis, e1);
    const Point3f center = Knot() + axis * 1.35f;
    const Point3f start = path->back();
    const Vector3f into = start - center;
    constexpr float ring = 1.75f;
    const float depth = 1.6f * std::sqrt(0.15f + 0.85f * r.Uniform(40));
    float theta = std::atan2(Dot(into, e2), Dot(into, e1)), phi = -1.2f + 0.5f * r.Signed(41);
    const float length = params_.length * (0.8f + 0.4f * r.Uniform(42));
    for (float s = kKnotStep; s < length; s += kKnotStep) {
        const float out = ring + depth * std::cos(phi);
        theta += kKnotStep / std::max(out, 0.8f);
        phi += kKnotStep * 0.14f;
        const Point3f wound =
            center + (e1 * std::cos(theta) + e2 * std::sin(theta)) * out + axis * (depth * std::sin(phi));
        const float t = SmoothStep(0, 4, s);
        path->push_back(PushOutOfHead(start * (1 - t) + wound * t, 0.15f));
    }
}
//<

//> Plait a braid
// Plaits three tresses, which swing from side to side once while they go in and out twice.
void HeadSource::Plait(const HashStream &r, std::vector<Point3f> *path) const {
    const Point3f start = path->back(), root = path->front();
    const int tress = root.x < -2.2f ? 0 : root.x > 2.2f ? 2 : 1;
    const float place = 0.6f * std::sqrt(r.Uniform(40)), turn = 2 * Pi * r.Uniform(41);
    Point3f middle = Knot() + Vector3f{0, 0, -1.f};
    const float length = params_.length * (0.93f + 0.1f * r.Uniform(42));
    constexpr float pitch = 7.5f;
    for (float s = kKnotStep; s < length; s += kKnotStep) {
        middle.y -= kKnotStep;
        if (const float near = 1.7f - HeadDistance(middle); near > 0) // it lies on neck and back
            middle.z -= near;
        else
            middle.z += 0.25f * kKnotStep * SmoothStep(0, 1.5f, -near);
        const float end = 1 - 0.45f * s / params_.length;
        const float angle = 2 * Pi * (s / pitch + static_cast<float>(tress) / 3);
        const float twist = turn + 0.25f * s;
        const Vector3f swing{1.05f * std::sin(angle) + place * std::cos(twist), 0,
                             0.55f * std::sin(2 * angle) + place * std::sin(twist)};
        const float t = SmoothStep(0, 3.5f, s);
        path->push_back(start * (1 - t) + Vector3f{0, -s, 0} * (1 - t) + (middle + swing * end) * t);
    }
}
//<

//> Grow a guide from its root
// Grows one guide from its root: combed as its style says, bent down by its weight, resting on the head, the
// hair beneath it and the shoulders.
void HeadSource::Grow(size_t index, Guide *g) const {
    const HashStream r(Seed(), kGuideStream, index);
    const Point2f uv = R2(index, r.Uniform(100) * 0.02f, r.Uniform(101) * 0.02f);
    //> Choose where a lock begins, how thick it lies and how long it gets
    const ScalpPoint start = scalp_.Sample(uv.x, uv.y);
    g->root = start.p;
    g->side = Side(start.p, 0);
    g->phase = 2 * Pi * r.Uniform(0);
    g->handedness = r.Uniform(1) < 0.5f ? -1.f : 1.f;
    g->amplitude = 0.65f + 0.7f * r.Uniform(2);

    const float height = SmoothStep(-5.f, 11.f, start.p.y);
    const float lift = style_.lift * (0.4f + 0.6f * height) + 0.15f * r.Signed(3);
    Vector3f d =
        Normalize(start.n * lift + CombAt(start) + Vector3f{r.Signed(4), r.Signed(5), r.Signed(6)} * 0.22f);

    // Hair from higher up lies on that from below: its distance from the skin grows along it.
    const float layer = 0.1f + params_.volume * (0.12f + 0.88f * height * (0.6f + 0.4f * r.Uniform(7))) +
                        (waves_ ? 0.2f : 0.5f) * params_.curlRadius;
    // Cut: between "all as long" and "all end at one height".
    const float full = params_.length * (1 - 0.5f * params_.lengthVariation * r.Uniform(8)) *
                       Lerp(SmoothStep(-2.f, 8.f, start.p.y), style_.sides, 1.f);
    const float floorY = 10.f - params_.length + 5.f; // where the longest hairs from the top end
    //<
    constexpr float step = 0.3f;
    std::vector<Point3f> path{start.p};
    if (style_.comb == Comb::Bun || style_.comb == Comb::Braid) {
        DrawToKnot(g, &path);
        const size_t drawn = path.size() - 1;
        if (style_.comb == Comb::Bun)
            WindBun(r, &path);
        else
            Plait(r, &path);
        FinishGuide(path, start.n, g);
        g->gather = 0.9f * g->length * static_cast<float>(drawn) / static_cast<float>(path.size() - 1);
        return;
    }
    //> Let it fall, and lie on what is beneath
    Point3f p = start.p;
    float travelled = 0, budget = full;
    while (travelled < budget && path.size() < 4000) {
        d = Normalize(d + Force(p, *g) * step);
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
    //<
    FinishGuide(path, start.n, g);
    g->gather = 0.45f * g->length;
    //> Choose how a lock curls
    g->turns = params_.curlRadius > 0 ? g->length / (params_.curlLength * (0.8f + 0.4f * r.Uniform(30))) : 0;
    if (waves_) {
        // Neighbouring locks swing together: the phase follows the place on the head.
        const Vector3f n = GroomNoise(g->root * 0.12f, Seed() + 3);
        g->phase = 3.5f * n.x + 0.5f * r.Signed(31);
        g->turns = g->length / (params_.curlLength * (0.95f + 0.1f * r.Uniform(30)));
    }
    //<
}
//<

} // namespace

std::unique_ptr<StrandSource> MakeHeadSource(const GroomParams &params) {
    return std::make_unique<HeadSource>(params);
}

} // namespace cuticle
//<
