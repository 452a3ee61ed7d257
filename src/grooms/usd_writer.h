// Strands that move, as USD's text form (.usda) with time samples.
#pragma once

#include "files/file.h"
#include "grooms/groom.h"

#include <string>
#include <vector>

namespace cuticle {

// Writes one BasisCurves prim whose points change from frame to frame: USD's Catmull-Rom splines for strands
// that pass through their points (linear ends: "pinned"), else B-splines, Bezier or linear ones as the groom
// joins them; widths and colours of the first frame hold for all. In centimetres, y up.
class UsdWriter {
  public:
    // Throws Error where the file cannot be written.
    UsdWriter(const std::string &filename, double framesPerSecond);
    // Adds a frame, later than those before. Throws Error for a groom of other strands than the first one's,
    // of none, or with placements.
    void AddFrame(size_t frame, const Groom &groom);
    // Puts the file in place, with the frames that there are (one or more). Without it nothing is left.
    void Finish();

  private:
    void Begin(size_t frame, const Groom &groom);
    OutputFile file_;
    double framesPerSecond_;
    std::vector<uint32_t> offsets_;
    std::string text_; // a buffer
    bool begun_ = false;
};

} // namespace cuticle
