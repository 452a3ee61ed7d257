// The table of charts.
#pragma once

#include "figures/figure.h"

#include <span>
#include <string>

namespace cuticle {

// A measurement of error against cost. The caption is in the notation of plot.h.
struct Chart {
    const char *name;
    const char *caption;
    FigureFunction make;
};
std::span<const Chart> Charts();
// Throws Error with the nearest name.
const Chart &FindChart(const std::string &name);

} // namespace cuticle
