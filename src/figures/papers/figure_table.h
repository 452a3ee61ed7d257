// The table of the figures of the four papers, and of the book's own.
#pragma once

#include "figures/figure.h"

#include <span>
#include <string>
#include <vector>

namespace cuticle {

enum class FigureKind { Plot, Render, Diagram, Photo, Animation };
std::string ToString(FigureKind kind);

// Takes the pictures of a figure's scenes, in the order of its row, and returns panels, numbers and laws.
using MeasureFunction = FigureData (*)(const FigureOptions &, std::span<const FigurePicture>);

// A figure of one of the four papers, or of the book. The caption is in the notation of plot.h. make computes
// a plot or a diagram. A rendered figure has instead the names of its scenes (under scenes/, without .pbrt,
// with blanks between) and measure. One that is not made has none of these.
struct Figure {
    const char *id;
    FigureKind kind;
    const char *caption;
    FigureFunction make;
    const char *scenes = "";
    MeasureFunction measure = nullptr;
    bool Made() const { return make != nullptr || measure != nullptr; }
    std::vector<std::string> Scenes() const;
};
std::span<const Figure> Figures();
// Throws Error with the nearest ids, or, for a figure that is not made, with the reason.
const Figure &FindFigure(const std::string &id);
// Computes a figure that is made, rendering its scenes first; their pictures, and what they took, are in what
// is returned.
FigureData MakeFigure(const Figure &figure, const FigureOptions &options);

} // namespace cuticle
