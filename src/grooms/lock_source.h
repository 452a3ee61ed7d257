// Strands in locks: what the recipes of heads and of fur have in common.
#pragma once

#include "grooms/hash.h"
#include "grooms/procedural.h"

namespace cuticle {

// Each thing that is random draws from a stream of its own.
enum GroomStream : uint64_t {
    kGuideStream = 1,
    kStrandStream,
    kNoiseStream,
    kBallStream,
    kOffsetStream,
    kColorStream
};

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

inline constexpr int kGuideSteps = 48;
// A guide is the middle of a lock, with a frame that is carried along it without twist.
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

// Turns a path into a guide: equal arc lengths, then frames by parallel transport from `start`.
void FinishGuide(const std::vector<Point3f> &path, const Normal3f &start, Guide *g);

// A source of strands that run between guides, are drawn into locks, curled and frizzed. A recipe grows the
// guides and says where strands have their roots and where the skin is.
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
    virtual Root RootOf(size_t strand) const = 0;
    // Moves p off the skin; fromRoot: cm of hair behind it.
    virtual Point3f KeepOut(const Point3f &p, float fromRoot) const = 0;

    void Strand(size_t index, Point3f *out) const override;

    uint64_t Seed() const { return static_cast<uint64_t>(params_.seed); }

    GroomParams params_;
    size_t segments_ = 16;
    float lockSpacing_ = 1; // typical distance between the roots of neighbouring guides
    bool waves_ = false;    // waves in a plane and in step with their neighbours, instead of curls
    std::vector<Guide> guides_;

  private:
    // The guides around a strand's root, on its side of the parting.
    struct Nearby {
        static constexpr size_t kGuides = 3;
        const Guide *guide[kGuides] = {}; // nearest first; null where there are fewer
        float weight[kGuides] = {};       // by which the strand's own path follows them
        float total = 0;                  // of the weights
        const Guide *middle = nullptr;    // the guide of the lock that the strand belongs to
    };

    // How a strand departs from its lock, constant along it.
    struct Habits {
        Vector3f rootOffset; // from the lock's root
        float stretch;       // share of the guide's length
        float clump;         // 0 follows its own path, 1 its lock
        float place, turn;   // polar coordinates in the lock, in units of its radius and radians
        float frizz, phase, amplitude, turns;
        Point3f noiseAt; // where in the noise it begins
    };

    Nearby FindGuides(const Root &root, const HashStream &r) const;
    Habits HabitsOf(const Root &root, const Guide &middle, const HashStream &r) const;
    // The place of a strand's point at `along` in [0, 1], before it is kept off the skin.
    Point3f PointAt(float along, const Root &root, const Nearby &near, const Habits &habits) const;
    // Moves a strand's points off the skin; stretch: its share of a guide of this length.
    void LiftOffSkin(float stretch, float guideLength, Point3f *out) const;
};

} // namespace cuticle
