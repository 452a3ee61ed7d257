//> Define sources of strands
#include "grooms/procedural.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "grooms/head_source.h"
#include "grooms/lock_source.h"

#include <algorithm>

namespace cuticle {

namespace {

Point3f UniformSphere(float u, float v) {
    const float z = 1 - 2 * u, r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(2 * Pi * v), r * std::sin(2 * Pi * v), z};
}

// --- a fur ball

//> Grow fur on a ball
class FurBallSource final : public LockSource {
  public:
    explicit FurBallSource(const GroomParams &params) : LockSource(params) {
        segments_ = params.segments > 0 ? params.segments : 10;
        area_ = 4 * Pi * Sqr(params.radius);
        guides_.resize(static_cast<size_t>(params.locks));
        ParallelFor(guides_.size(), [&](size_t i) { Grow(i, &guides_[i]); });
        MakeWisps();
    }

  private:
    Root RootAt(size_t strand, float u0, float v0) const override {
        const Point2f uv = R2(strand, u0, v0);
        Root root;
        root.n = UniformSphere(uv.x, uv.y);
        root.p = root.n * params_.radius;
        return root;
    }
    Point3f KeepOut(const Point3f &p, float fromRoot) const override {
        const float d = p.Length(), keep = params_.radius + kHeadClearance * std::min(1.f, fromRoot);
        return d < keep ? p * (keep / std::max(d, 1e-6f)) : p;
    }
    //> Grow a guide of fur
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
        g->gather = 0.45f * g->length;
    }
    //<
};
//<

// --- a hair cube

//> Line up a cube of hairs
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
//<

// --- a ball of random strands

//> Let strands wander through a ball
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
//<

} // namespace

StrandSource::StrandSource(const GroomParams &params)
    : width_{params.width * params.widthScale, params.width * params.widthScale * params.tip},
      colors_(params) {}

//> Colour a strand from root to tip
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
//<

//> Make any range of strands
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
        groom.strandWidths.resize(n);
    groom.hasColor = HasColors();
    if (HasColors())
        groom.pointColors.resize(n * run);
    ParallelFor(n, [&](size_t i) {
        Strand(begin + i, groom.points.data() + i * run);
        if (!groom.strandWidths.empty())
            groom.strandWidths[i] = Width(begin + i);
        if (HasColors())
            Colors(begin + i, groom.pointColors.data() + i * run);
    });
    return groom;
}
//<

//> Make the source that is asked for
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
        return MakeHeadSource(checked);
    if (checked.kind == "fur-ball")
        return std::make_unique<FurBallSource>(checked);
    if (checked.kind == "hair-cube")
        return std::make_unique<HairCubeSource>(checked);
    return std::make_unique<BallSource>(checked);
}
//<

//> Make all strands
Groom MakeGroom(const GroomParams &params) {
    const std::unique_ptr<StrandSource> source = MakeStrandSource(params);
    CheckSegmentCount(source->StrandCount() * (source->PointsPerStrand() - 1));
    ClaimMemory(fmt::format("the points of {} strands", source->StrandCount()),
                source->StrandCount() * source->PointsPerStrand() *
                    (sizeof(Point3f) + (source->HasColors() ? sizeof(Spectrum) : 0)));
    return source->Range(0, source->StrandCount());
}
//<

} // namespace cuticle
//<
