//> Declare sources of strands
// Procedural grooms: heads of hair, a fur ball, a hair cube, a ball of random strands.
#pragma once

#include "grooms/groom.h"
#include "grooms/groom_params.h"

#include <memory>

namespace cuticle {

//> Declare what makes strands
// Makes strands on demand: every strand depends on the parameters and its number alone, so that any range, in
// any order, on any number of threads gives the same bits; a writer can stream 10^7 of them through little
// memory.
class StrandSource {
  public:
    virtual ~StrandSource() = default;
    virtual size_t StrandCount() const = 0;
    virtual size_t PointsPerStrand() const = 0;
    // Writes the PointsPerStrand() points of one strand, root to tip. Safe from any thread.
    virtual void Strand(size_t index, Point3f *points) const = 0;
    // Full widths of a strand at root and tip.
    std::array<float, 2> Width(size_t index) const {
        const float factor = WidthFactor(index);
        return {width_[0] * factor, width_[1] * factor};
    }
    // The strands [begin, end), made in parallel.
    Groom Range(size_t begin, size_t end) const;
    // Linear RGB of the points of one strand; only where HasColors().
    void Colors(size_t index, Spectrum *colors) const;
    bool HasColors() const { return colors_.rootColor.has_value(); }

  protected:
    // Takes widths and colours.
    explicit StrandSource(const GroomParams &params);
    // How wide a strand is beside the others.
    virtual float WidthFactor(size_t) const { return 1; }

  private:
    std::array<float, 2> width_{};
    GroomParams colors_;
};
//<

// Throws Error for parameters out of the table's ranges or a kind or style that does not exist.
std::unique_ptr<StrandSource> MakeStrandSource(const GroomParams &params);

// All strands at once. Throws Error where they have more segments than a scene can hold, kMaxSegments
// (groom.h).
Groom MakeGroom(const GroomParams &params);

// On a head the points of a strand keep this far outside (cm) from a centimetre after the root on; the root
// itself lies under the skin, no deeper than kRootDepth; so no point is deeper than that. The curve between
// two points may dip a little more where it bends over an edge (measured in the tests).
inline constexpr float kHeadClearance = 0.03f;
inline constexpr float kRootDepth = 0.05f;

} // namespace cuticle
//<
