//> Declare hair on the head
// A head of hair: guides grown from the scalp as its style combs them.
#pragma once

#include "grooms/procedural.h"

namespace cuticle {

// The strands of a groom of kind "head"; MakeStrandSource (procedural.h) checks the parameters.
std::unique_ptr<StrandSource> MakeHeadSource(const GroomParams &params);

} // namespace cuticle
//<
