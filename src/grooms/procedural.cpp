#include "grooms/procedural.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "grooms/head_shape.h"
#include "grooms/lock_source.h"

#include <algorithm>

namespace cuticle {

namespace {

Point3f UniformSphere(float u, float v) {
    const float z = 1 - 2 * u, r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(2 * Pi * v), r * std::sin(2 * Pi * v), z};
}

// --- a head

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

// Grows one guide from its root: combed away from the parting, bent down by its weight, resting on the head,
// the hair beneath it and the shoulders.
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
        force += GroomNoise(p * 0.16f, Seed() + 1) * 0.05f +
                 GroomNoise(g->root * 0.5f + p * 0.05f, Seed() + 2) * 0.06f;
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
        const Vector3f n = GroomNoise(g->root * 0.12f, Seed() + 3);
        g->phase = 3.5f * n.x + 0.5f * r.Signed(31);
        g->turns = g->length / (params_.curlLength * (0.95f + 0.1f * r.Uniform(30)));
    }
}

// --- a fur ball

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
        const Vector3f nap = TangentTo(n, GroomNoise(n * 1.7f, Seed() + 1) * 1.6f + Vector3f{0, -0.7f, 0});
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

// --- a hair cube

// n x n straight parallel hairs along y, evenly spaced, filling a cube around the origin (Pharr 2016, figure
// 1.20).
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

// --- a ball of random strands

// Strands that wander through a ball: a random start, a direction that turns slowly, turned back at the
// surface.
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
    // The logarithm of a colour goes with the root of the absorption: a power of the colour is more or less
    // of the pigment
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
    ClaimMemory(fmt::format("the points of {} strands", source->StrandCount()),
                source->StrandCount() * source->PointsPerStrand() *
                    (sizeof(Point3f) + (source->HasColors() ? sizeof(Spectrum) : 0)));
    return source->Range(0, source->StrandCount());
}

} // namespace cuticle
