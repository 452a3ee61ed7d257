//> Declare strands in locks
// Strands in wisps, and wisps in locks: what the recipes of heads and of fur have in common.
#pragma once

#include "grooms/hash.h"
#include "grooms/procedural.h"

#include <algorithm>
#include <array>
#include <vector>

namespace cuticle {

//> Give each random thing a stream
// Each thing that is random draws from a stream of its own.
enum GroomStream : uint64_t {
    kGuideStream = 1,
    kStrandStream,
    kNoiseStream,
    kBallStream,
    kOffsetStream,
    kColorStream,
    kWispStream,
    kRootStream
};
//<

// 0 up to v = a, 1 from v = b on, a smooth cubic in between.
inline float SmoothStep(float a, float b, float v) {
    const float t = std::clamp((v - a) / (b - a), 0.f, 1.f);
    return t * t * (3 - 2 * t);
}

// Returns point `index` of Roberts' R2 sequence (the plastic number's powers), shifted by (u0, v0): it covers
// the square evenly at any count.
Point2f R2(uint64_t index, float u0, float v0);

// Evaluates smooth vector noise in [-1, 1]^3 with features of unit size: random values at lattice points,
// cubic fade.
Vector3f GroomNoise(const Point3f &p, uint64_t seed);

// Returns the part of v that lies across n.
inline Vector3f TangentTo(const Vector3f &n, const Vector3f &v) { return v - n * Dot(n, v); }

// Wanders through [-1, 1]^3 smoothly, with features of unit length: random vectors at whole x, cubic between.
// first: where in the stream its numbers begin; x is no less than 0.
Vector3f Wander(const HashStream &r, uint64_t first, float x);

//> Declare a guide
inline constexpr int kGuideSteps = 48;
// A guide is the middle of a lock or of a wisp, with a frame that is carried along it without twist. u points
// away from the skin at the root.
struct Guide {
    Point3f root;
    int side = 0; // of the parting: -1, 1, or 0 where there is none
    float length = 0;
    float gather = 0;            // cm from the root over which hair draws together
    Vector3f p[kGuideSteps + 1]; // relative to the root, at equal arc lengths
    Vector3f u[kGuideSteps + 1], v[kGuideSteps + 1];
    float phase = 0, turns = 0, handedness = 1, amplitude = 1;
    uint32_t lock = 0; // its number; hairs of one lock curl alike

    struct Place {
        Vector3f p, u, v;
    };
    // s: share of the length, 0 to 1.
    Place At(float s) const {
        const float x = std::clamp(s, 0.f, 1.f) * kGuideSteps;
        const int i = std::min(static_cast<int>(x), kGuideSteps - 1);
        const float t = x - static_cast<float>(i), t0 = 1 - t;
        return {p[i] * t0 + p[i + 1] * t, u[i] * t0 + u[i + 1] * t, v[i] * t0 + v[i + 1] * t};
    }
};
//<

// Turns a path into a guide: equal arc lengths, then frames by parallel transport from `start`.
void FinishGuide(const std::vector<Point3f> &path, const Normal3f &start, Guide *g);

//> Declare a grid of roots
// Finds the nearest of many roots on one side of the parting: a grid of cells, each with its roots.
class RootGrid {
  public:
    RootGrid() = default;
    // spacing: a typical distance between neighbours, positive.
    RootGrid(const std::vector<Guide> &guides, float spacing);
    // Calls use(index) for all guides in the cells within `reach` cells of p.
    template <class Use>
    void ForEachNear(const Point3f &p, int reach, const Use &use) const {
        const std::array<int, 3> at = CellOf(p);
        for (int z = std::max(at[2] - reach, 0); z <= std::min(at[2] + reach, size_[2] - 1); ++z)
            for (int y = std::max(at[1] - reach, 0); y <= std::min(at[1] + reach, size_[1] - 1); ++y)
                for (int x = std::max(at[0] - reach, 0); x <= std::min(at[0] + reach, size_[0] - 1); ++x) {
                    const auto cell = static_cast<size_t>(x + size_[0] * (y + size_[1] * z));
                    for (uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i)
                        use(order_[i]);
                }
    }
    int MaxReach() const { return std::max({size_[0], size_[1], size_[2]}); }

  private:
    std::array<int, 3> CellOf(const Point3f &p) const;
    Point3f low_;
    float cell_ = 1;
    std::array<int, 3> size_{};
    std::vector<uint32_t> begin_, order_; // of each cell; guides by cell
};
//<

//> Declare hair that is drawn into locks
// A source of strands that are drawn into wisps, which are drawn into locks, curled and frizzed. A recipe
// grows the guides, one a lock, calls MakeWisps, and says where strands have their roots and where the skin
// is.
class LockSource : public StrandSource {
  public:
    explicit LockSource(const GroomParams &params) : StrandSource(params), params_(params) {}
    size_t StrandCount() const override { return static_cast<size_t>(params_.strands); }
    size_t PointsPerStrand() const override { return segments_ + 1; }

  protected:
    struct Root {
        Point3f p;
        Normal3f n;
        int side = 0;
        float shorter = 1; // factor on the length
    };
    // Root number `index` of a sequence that covers the skin evenly; u0, v0 in [0, 1) choose which sequence.
    virtual Root RootAt(size_t index, float u0, float v0) const = 0;
    // Moves p off the skin; fromRoot: cm of hair behind it.
    virtual Point3f KeepOut(const Point3f &p, float fromRoot) const = 0;

    // Divides the locks of guides_ into wisps.
    void MakeWisps();
    void Strand(size_t index, Point3f *out) const override;
    float WidthFactor(size_t index) const override;

    uint64_t Seed() const { return static_cast<uint64_t>(params_.seed); }

    GroomParams params_;
    size_t segments_ = 16;
    float area_ = 1;     // of the skin where hair grows
    bool waves_ = false; // waves in a plane and in step with their neighbours, instead of curls
    std::vector<Guide> guides_;

  private:
    //> Keep a strand's habits
    // How a strand departs from its wisp, constant along it.
    struct Habits {
        Vector3f rootOffset; // from the wisp's root
        float stretch;       // share of the wisp's length
        float clump;         // 0 keeps its distance from the wisp's middle, 1 comes to its place there
        float cosine, sine;  // of that place: its direction times its distance in radii of the wisp
        float frizz, phase, amplitude, turns;
        float lift; // cm away from the head, of a flyaway
    };
    //<

    void GrowWisp(size_t index, Guide *wisp) const;
    const Guide &WispOf(const Root &root, const HashStream &r) const;
    Habits HabitsOf(const Root &root, const Guide &wisp, const HashStream &r) const;
    // The place of a strand's point at `along` in [0, 1], before it is kept off the skin.
    Point3f PointAt(float along, const Guide &wisp, const Habits &habits, const HashStream &r) const;
    // Moves a strand's points off the skin; length: of the strand.
    void LiftOffSkin(float length, Point3f *out) const;

    float lockSpacing_ = 1, wispSpacing_ = 1; // typical distances between neighbours' roots
    std::vector<Guide> wisps_;
    RootGrid locksByPlace_, wispsByPlace_;
};
//<

} // namespace cuticle
//<
