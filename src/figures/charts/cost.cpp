#include "figures/charts/cost.h"

#include "core/clock.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cuticle {

namespace {

// The shortest time that is measured, in seconds: a reading of the thread's clock takes about 0.2 µs.
constexpr double kMinTimed = 1e-4;

// CPU seconds of one run of the job, which runs 1, 2, 4, ... times until that takes kMinTimed.
double TimeOf(const std::function<void()> &job) {
    for (int runs = 1;; runs *= 2) {
        const double start = ThreadCpuSeconds();
        for (int i = 0; i < runs; ++i)
            job();
        const double seconds = ThreadCpuSeconds() - start;
        if (seconds >= kMinTimed)
            return seconds / runs;
    }
}

} // namespace

std::vector<double> TimeInTurns(const std::vector<std::function<void()>> &jobs, int rounds) {
    std::vector<double> shortest(jobs.size(), std::numeric_limits<double>::infinity());
    OnOneThread([&] {
        for (const auto &job : jobs)
            job();
        for (int round = 0; round < rounds; ++round)
            for (size_t i = 0; i < jobs.size(); ++i)
                shortest[i] = std::min(shortest[i], TimeOf(jobs[i]));
    });
    return shortest;
}

std::vector<size_t> ParetoFront(const std::vector<CostPoint> &points) {
    std::vector<size_t> order;
    for (size_t i = 0; i < points.size(); ++i)
        if (std::isfinite(points[i].cost) && std::isfinite(points[i].error))
            order.push_back(i);
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return std::pair(points[a].cost, points[a].error) < std::pair(points[b].cost, points[b].error);
    });
    std::vector<size_t> front;
    for (const size_t i : order)
        if (front.empty() || points[i].error < points[front.back()].error)
            front.push_back(i);
    return front;
}

PlotSeries ParetoSteps(const std::vector<CostPoint> &points, double best, double worst) {
    PlotSeries steps;
    steps.label = "Pareto front";
    steps.color = 7, steps.width = 1.2, steps.dash = PlotDash::Dotted;
    for (const size_t i : ParetoFront(points)) {
        if (!steps.x.empty())
            steps.x.push_back(points[i].cost), steps.y.push_back(steps.y.back());
        steps.x.push_back(points[i].cost), steps.y.push_back(std::clamp(points[i].error, best, worst));
    }
    return steps;
}

PlotPanel CostPanel(const std::string &title, const std::string &costLabel, const std::string &errorLabel,
                    const std::vector<CostPoint> &points, double best, double worst) {
    PlotPanel panel;
    panel.title = title;
    panel.right = 0.55;
    panel.x = {.label = costLabel, .log = true};
    panel.y = {.label = errorLabel, .log = true, .min = best / 2, .max = worst * 2};
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        const CostPoint &p = points[i];
        PlotSeries s;
        s.mark = i < 26 ? std::string(1, static_cast<char>('a' + i)) : std::to_string(i + 1);
        s.label = s.mark + "  " + p.method;
        s.style = PlotStyle::Points;
        s.x = {p.cost}, s.y = {std::isfinite(p.error) ? std::clamp(p.error, best, worst) : worst};
        s.color = p.family, s.marker = p.family;
        panel.series.push_back(s);
        low = std::min(low, p.cost), high = std::max(high, p.cost);
    }
    const PlotSeries steps = ParetoSteps(points, best, worst);
    if (!steps.x.empty())
        panel.series.push_back(steps);
    panel.x.min = low / 1.4, panel.x.max = high * 1.6;
    return panel;
}

} // namespace cuticle
