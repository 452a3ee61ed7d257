// The layout of plots: how wide texts are, where captions break, how much room a legend needs, and where the
// letters beside points stand. Lengths are in pixels of the screen. Only the plots themselves include this.
#pragma once

#include "figures/plot.h"

#include <string>
#include <vector>

namespace cuticle {

// The width of a text in the font of labels, never too small by much; gnuplot's marks have none.
double TextWidth(const std::string &text);

// Breaks a text at its blanks into lines of at most maxLetters letters (longer words stay whole). Marks of
// the enhanced notation count as letters.
std::vector<std::string> BrokenLines(const std::string &text, size_t maxLetters);

// Makes room for the legends beside the axes: panels of one `right` keep it, or end together further left
// where one of their legends would not fit.
void FitLegends(Plot *plot);

// Chooses the sides of points on which the marks of a Cartesian panel or a diagram stand, so that they lie
// within the axes and on no point, line or other mark where there is a place for that. Panels without the
// ranges of both axes stay as they are.
void PlaceMarks(PlotPanel *panel, int width, int height);

} // namespace cuticle
