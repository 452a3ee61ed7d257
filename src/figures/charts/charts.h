// The charts, one function each: error against cost, measured in the run that draws them.
#pragma once

#include "figures/figure.h"

namespace cuticle {

FigureData BesselChart(const FigureOptions &options);
FigureData CurvesChart(const FigureOptions &options);
FigureData EfficiencyChart(const FigureOptions &options);
FigureData GrowthChart(const FigureOptions &options);
FigureData KeyHairsChart(const FigureOptions &options);
FigureData NormalsChart(const FigureOptions &options);
FigureData ModelsChart(const FigureOptions &options);
FigureData QuadratureChart(const FigureOptions &options);
FigureData RenderChart(const FigureOptions &options);
FigureData RootsChart(const FigureOptions &options);
FigureData ScatteringChart(const FigureOptions &options);

} // namespace cuticle
