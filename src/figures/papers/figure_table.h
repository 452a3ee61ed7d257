// The table of the figures of the four papers, and of the book's own.
#pragma once

#include "figures/figure.h"

#include <span>
#include <string>

namespace cuticle {

enum class FigureKind { Plot, Render, Diagram, Photo, Animation };
std::string ToString(FigureKind kind);

// A figure of one of the four papers, or of the book. make is null, and scenes empty, for one that is not
// made (yet); scenes names the files under scenes/ (without .pbrt) that render it, with blanks between. The
// caption is in the notation of plot.h.
struct Figure {
    const char *id;
    FigureKind kind;
    const char *caption;
    FigureFunction make;
    const char *scenes;
    bool Made() const { return make != nullptr || *scenes != '\0'; }
};
std::span<const Figure> Figures();
// Throws Error with the nearest ids, or, for a figure that `cuticle figure` does not draw, with what there is
// instead.
const Figure &FindFigure(const std::string &id);

} // namespace cuticle
