// The prims of a layer of USD, as text: what of them matters for strands of hair.
#pragma once

#include "core/vecmath.h"
#include "grooms/usd_text.h"

#include <map>
#include <memory>
#include <optional>
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
    std::string name;
    std::map<std::string, Transform, std::less<>> operations;
    std::vector<std::string> order;
    // The numbers of operations at each of their time samples, where they are kept.
    std::map<std::string, std::map<double, std::vector<double>>, std::less<>> samples;
    bool hidden = false;                // invisible, a class, an over, not active, or in a point instancer
    std::string purpose;                // as written; "": that of the prim above
    std::unique_ptr<CurvesPrim> curves; // of a BasisCurves prim
};

// A layer: what it says of itself, and its prims, parents before their children.
struct UsdLayer {
    std::vector<UsdPrim> prims;
    std::string upAxis = "Y";       // the schema's default
    double metersPerUnit = 0;       // 0: it does not say
    size_t upAxisAt = 0;            // byte of the text
    double timeCodesPerSecond = 24; // the schema's default
};

// Reads a layer; `name` stands in warnings. Of values with time samples it takes the last one no later than
// `time` (a time code), or the first. Throws Error at the place of what cannot be read.
// Kept: all samples of operations too.
enum class UsdSamples { Pass, Keep };
UsdLayer ReadUsdLayer(UsdText &text, const std::string &name, std::optional<double> time = {},
                      UsdSamples samples = UsdSamples::Pass);

// Sets the operations whose samples were kept to a time: linear between two samples, the nearest outside.
void SetUsdTime(std::vector<UsdPrim> *prims, double time);
// Returns a prim's path, /World/Head.
std::string UsdPrimPath(const std::vector<UsdPrim> &prims, size_t index);

// Returns the way from a prim's coordinates to the layer's.
Transform UsdPrimToLayer(const std::vector<UsdPrim> &prims, size_t index, const std::string &name);

// Whether a prim is nothing to be seen in a picture: it or one above it is invisible, a class, an over
// without a definition, not active or a prototype of a point instancer, or its purpose, which it may have
// from above, is "guide" or "proxy".
bool IsHiddenUsdPrim(const std::vector<UsdPrim> &prims, size_t index);

} // namespace cuticle
