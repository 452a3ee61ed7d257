// The prims of a layer of USD, as text: what of them matters for strands of hair.
#pragma once

#include "core/vecmath.h"
#include "grooms/usd_text.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace cuticle {

// An attribute holds its numbers as written, where they stand, and how they spread over the curves.
struct UsdAttribute {
    std::vector<float> values;
    size_t at = 0;
    std::string interpolation;
    bool given = false, byTime = false;
};

// The properties of a BasisCurves prim; the defaults are the schema's.
struct CurvesPrim {
    size_t at = 0;
    std::string type = "cubic", basis = "bezier", wrap = "nonperiodic";
    UsdAttribute counts, points, widths, primvarWidths, color, colorIndices;
};

// A prim of a layer, with what matters for the curves in it and below it.
struct UsdPrim {
    ptrdiff_t parent = -1;
    std::map<std::string, Transform, std::less<>> operations;
    std::vector<std::string> order;
    bool hidden = false;                // invisible, a guide, a class, or not active
    std::unique_ptr<CurvesPrim> curves; // of a BasisCurves prim
};

// Reads the prims of a layer, parents before their children; `name` stands in warnings. Throws Error at the
// place of what cannot be read.
std::vector<UsdPrim> ReadUsdLayer(UsdText &text, const std::string &name);

// Returns the way from a prim's coordinates to the layer's.
Transform UsdPrimToLayer(const std::vector<UsdPrim> &prims, size_t index, const std::string &name);

// Whether a prim or one above it is invisible, a guide, a class, or not active.
bool IsHiddenUsdPrim(const std::vector<UsdPrim> &prims, size_t index);

} // namespace cuticle
