//> Count strands that pass through one another
// Which hairs of a simulation pass through which: to judge how well it keeps them apart.
#pragma once

#include "core/vecmath.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace cuticle {

//> Declare who has passed through whom
// Follows strands of straight edges through a motion. A pass of one edge through another has a sign: that of
// the side from which it comes. A pair of strands whose passes do not add up to nothing stands on the wrong
// side of one another.
class StrandCrossings {
  public:
    // points: where all strands are, `count` (2 or more) points each, strand by strand; finite.
    StrandCrossings(std::span<const Vector3d> points, size_t count);
    // Moves every point straight to a new place, and notes who passes through whom on the way.
    void MoveTo(std::span<const Vector3d> points);

    size_t Pairs() const;                        // of strands on the wrong side of one another
    int Side(size_t strand, size_t other) const; // the sum of the passes of a pair; 0 at the start
    size_t Passes() const { return passes_; }    // of edges, all that were, back and forth

  private:
    struct Pass {
        uint64_t pair;
        int sign;
    };
    std::vector<Pass> PassesOnTheWayTo(std::span<const Vector3d> points) const;
    std::vector<Vector3d> points_;
    size_t count_;
    size_t passes_ = 0;
    std::unordered_map<uint64_t, int> sides_; // of pairs that have passed, smaller number first
};
//<

} // namespace cuticle
//<
