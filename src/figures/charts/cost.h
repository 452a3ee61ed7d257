// The charts share these: times measured in turns, the Pareto front, and the diagram of error against cost.
#pragma once

#include "figures/plot.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace cuticle {

// Measures the CPU time of each job on this thread, in seconds: the smallest of `rounds` rounds (> 0) in
// which all jobs take turns, so that a busy moment of the machine hits all alike. Each job runs once before
// the first round; a short one is repeated until the clock resolves it. Parallel loops inside a job do not
// leave this thread.
std::vector<double> TimeInTurns(const std::vector<std::function<void()>> &jobs, int rounds);

// Keeps a result from being optimised away by the compiler.
template <typename T>
inline void Keep(const T &value) {
    asm volatile("" : : "m"(value) : "memory");
}

// A method on the chart. Its name is in the notation of labels (see plot.h); family groups methods by colour
// (0 to kPlotColors - 1). It fails if error is NaN or infinite.
struct CostPoint {
    std::string method;
    double cost, error;
    int family = 0;
};

// Indices of the points that no other beats in both cost and error, by rising cost. Points that fail, or
// whose cost is not a number, are never among them.
std::vector<size_t> ParetoFront(const std::vector<CostPoint> &points);

// The front as steps, to be drawn. Errors are clamped to [best, worst].
PlotSeries ParetoSteps(const std::vector<CostPoint> &points, double best, double worst);

// Draws points with letters, which the legend names, and their front as steps. Both axes are logarithmic.
// Errors above worst, and failures, stand at worst; errors below best at best.
PlotPanel CostPanel(const std::string &title, const std::string &costLabel, const std::string &errorLabel,
                    const std::vector<CostPoint> &points, double best, double worst);

} // namespace cuticle
