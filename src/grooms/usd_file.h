// Strands from USD's text form (.usda): the BasisCurves of a layer.
#pragma once

#include "grooms/groom.h"

#include <optional>
#include <string>
#include <string_view>

namespace cuticle {

// Reads every BasisCurves prim: linear and cubic; bases bezier, bspline, catmullRom; wraps nonperiodic and
// pinned; widths and primvars:displayColor of constant, uniform, varying and vertex interpolation,
// displayColor also with indices; transformed by the xformOps of the prim and its parents (where these scale
// unevenly the strands keep their own coordinates, and Groom::placements says so). Points, widths and colours
// at USD's default time, or the first of their time samples. A layer of linear curves keeps its points; any
// cubic curve makes the whole groom Bezier control points. Where no curve has widths the groom's width is 0.
//
// One warning a kind for what is not rendered: periodic curves and curves of too few points (left out), other
// kinds of curves, point instancers, operations that are not known, references and variants, opacity; and for
// a layer whose z axis is up, which is turned so that y is, and whose units are given. Prims that are
// invisible, of purpose guide or proxy, classes, or overs are no strands; a purpose is inherited. `name`
// stands in messages. Throws Error "FILE:LINE:COLUMN: error: ..." for text that is not USD's, for counts that
// do not add up, and for values that are not finite. Memory stays within a few times the text's size.
Groom ParseUsdFile(std::string_view text, const std::string &name);
// The same at a time code: of values with time samples the last one no later than that, or the first.
Groom ParseUsdFileAt(std::string_view text, const std::string &name, std::optional<double> time);

} // namespace cuticle
