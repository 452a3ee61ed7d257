//> Interpolate all hairs from key hairs
// A groom of many strands, of which some are simulated; the others follow them. Lengths in cm, in the head's
// coordinates.
#pragma once

#include "core/vecmath.h"
#include "dynamics/obstacle.h"
#include "dynamics/strand.h"
#include "grooms/groom.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cuticle {

//> Choose key hairs spread over the roots
// Picks `count` strands (all, if there are fewer) of at least two distinct points: each time the one whose
// root is farthest from those of the picked. Returns their numbers, in the order of the groom.
std::vector<uint32_t> ChooseKeyHairs(const Groom &groom, size_t count);

// The points of these strands at equal arc lengths, `points` (2 or more) each, strand by strand.
std::vector<Vector3d> ResampleKeyHairs(const Groom &groom, std::span<const uint32_t> strands, size_t points);
//<

//> Declare what carries the other hairs
// Every hair hangs on one or more key hairs, by weights that are found once, at rest: the nearest by roots
// and of these the likest by shape. A point of a hair goes with the place of its key hair that is as far from
// the root (where the key hair is shorter: at the same share of the length), and keeps its offset from it in
// that place's frame of directors. Where key hairs part, a hair goes with the one that weighs most.
class HairInterpolation {
  public:
    // set: at rest, made from the resampled key hairs of `groom` in that order. The groom must outlive it.
    HairInterpolation(const Groom &groom, std::span<const uint32_t> keys, const KeyStrands &set);
    // The groom where the key hairs are now. Points are kept out of the obstacle as far as they were at rest,
    // at most `clearance`.
    Groom Deform(const KeyStrands &set, const Pose &pose, const Obstacle &obstacle, double clearance) const;

    static constexpr size_t kKeys = 3; // that carry a hair, at most

  private:
    struct Carrier {
        std::array<uint32_t, kKeys> key{};
        std::array<float, kKeys> weight{}; // falling; 0: none
        std::array<float, kKeys> reach{};  // share of the key hair's length that the hair has, at most 1
    };
    // A place of a strand, with the frame of its directors there.
    struct PlaceFrame {
        Vector3d p, t, d1, d2;
    };
    static PlaceFrame PlaceAt(const Vector3d *points, const Vector3d *directors, size_t count, double u);
    Vector3d Carry(const Carrier &carrier, size_t i, std::span<const Vector3d> points,
                   std::span<const Vector3d> directors) const;
    const Groom &groom_;
    std::vector<Carrier> carriers_;
    std::vector<Vector3d> restPoints_, restDirectors_; // of the key hairs
    std::vector<float> share_;                         // of its strand's length, of every point
    size_t keyPoints_;
};
//<

} // namespace cuticle
//<
