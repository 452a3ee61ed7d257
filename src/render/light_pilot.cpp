//> Learn the shares of the lights
#include "render/light_pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

//> Compute a path's mean and variance over the choices of lights
// A path's light under given shares, if its directions and the points on its lights stay as they are: the
// mean over which kind is sampled at each vertex, and the variance.
struct Moments {
    double mean = 0, variance = 0;
};
Moments MomentsOf(const LightPilotPath &path, const LightShares &shares) {
    Moments m;
    for (const LightPilotPath::Found &found : path.found) {
        const float share = shares[static_cast<size_t>(found.kind)];
        const float weight = found.bsdfPdf < 0 ? 1 : PowerHeuristic(found.bsdfPdf, share * found.pdf);
        m.mean += double{found.value * weight};
    }
    for (const LightPilotPath::Vertex &vertex : path.sampled) {
        double first = 0, second = 0;
        for (size_t kind = 0; kind < shares.size(); ++kind) {
            const double share{shares[kind]};
            const LightPilotPath::Sampled &s = vertex[kind];
            if (!(share > 0) || s.value == 0)
                continue;
            const float weight = s.bsdfPdf > 0 ? PowerHeuristic(shares[kind] * s.pdf, s.bsdfPdf) : 1;
            const double x = double{s.value * weight} / share; // what is added where this kind is chosen
            first += share * x;
            second += share * x * x;
        }
        m.mean += first;
        m.variance += second - first * first;
    }
    return m;
}
//<

//> Estimate how bright the picture is around each cell
// The picture's errors count by how bright it is: means over 5 x 5 cells, of paths that take every light.
std::vector<double> WeightsOf(std::span<const LightPilotPath> paths, const Pilot &pilot) {
    const LightShares all{1, 1, 1};
    const auto n = static_cast<size_t>(pilot.samples);
    const int columns = pilot.cells.x, rows = pilot.cells.y;
    std::vector<double> mean(paths.size() / n);
    double whole = 0;
    for (size_t i = 0; i < paths.size(); ++i) {
        const double light = MomentsOf(paths[i], all).mean / static_cast<double>(n);
        if (std::isfinite(light))
            mean[i / n] += light, whole += light / static_cast<double>(mean.size());
    }
    std::vector<double> weights(mean.size());
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            double sum = 0, count = 0;
            for (int v = std::max(0, y - 2); v <= std::min(rows - 1, y + 2); ++v)
                for (int u = std::max(0, x - 2); u <= std::min(columns - 1, x + 2); ++u)
                    sum += mean[static_cast<size_t>(v * columns + u)], ++count;
            const double floor = 0.25 * whole * whole; // black corners do not decide
            const double bright = sum / count;
            weights[static_cast<size_t>(y * columns + x)] = 1 / (bright * bright + floor + 1e-30);
        }
    return weights;
}
//<

//> Put variance and cost together
// A sample of a light costs about half of what a ray to the next surface costs with its BSDF: 0.54 by a ball
// of 16,000 curve segments under a sky, with and without light samples.
constexpr double kLightCost = 0.5;

double CostOf(std::span<const LightPilotPath> paths, const std::vector<double> &weights, size_t samples,
              const LightShares &shares) {
    double variance = 0;
    for (size_t cell = 0; cell < weights.size(); ++cell) {
        double sum = 0, squares = 0, chosen = 0;
        for (size_t s = 0; s < samples; ++s) {
            const Moments m = MomentsOf(paths[cell * samples + s], shares);
            sum += m.mean, squares += m.mean * m.mean, chosen += m.variance;
        }
        const auto n = static_cast<double>(samples);
        const double ofPaths = (squares - sum * sum / n) / (n - 1);
        const double v = std::max(0., ofPaths + chosen / n); // rounding may leave less than nothing
        if (std::isfinite(v))                                // a path through a broken BSDF says nothing
            variance += weights[cell] * v;
    }
    const double lightSamples = double{shares[0]} + double{shares[1]} + double{shares[2]};
    return variance / static_cast<double>(weights.size()) * (1 + kLightCost * lightSamples);
}
//<

} // namespace

double LightShareCost(std::span<const LightPilotPath> paths, const Pilot &pilot, const LightShares &shares) {
    return CostOf(paths, WeightsOf(paths, pilot), static_cast<size_t>(pilot.samples), shares);
}

//> Search for the best shares
LightShares LearnLightShares(std::span<const LightPilotPath> paths, const Pilot &pilot,
                             const LightSampler &lights) {
    // A few paths do not know of light that is rare: every kind keeps a share.
    constexpr float kMinShare = 0.1f;
    const std::vector<double> weights = WeightsOf(paths, pilot);
    const auto samples = static_cast<size_t>(pilot.samples);
    LightShares best = lights.SharesByPower();
    double least = CostOf(paths, weights, samples, best);
    const auto attempt = [&](LightShares shares) {
        float sum = 0, floors = 0;
        for (size_t kind = 0; kind < shares.size(); ++kind) {
            const float floor = lights.Has(static_cast<LightKind>(kind)) ? kMinShare : 0;
            shares[kind] = floor > 0 ? std::max(shares[kind] - floor, 0.f) : 0; // above the floor
            sum += shares[kind], floors += floor;
        }
        const float scale = sum > 1 - floors ? (1 - floors) / sum : 1;
        for (size_t kind = 0; kind < shares.size(); ++kind)
            if (lights.Has(static_cast<LightKind>(kind)))
                shares[kind] = shares[kind] * scale + kMinShare;
        const double cost = CostOf(paths, weights, samples, shares);
        if (!(cost < 0.9999 * least)) // less is not worth a step, and the search ends
            return false;
        best = shares, least = cost;
        return true;
    };
    // Steps shrink until none helps, or soon.
    constexpr int kMaxRounds = 16;
    for (const float step : {4.f, 2.f, 1.3f, 1.1f}) {
        bool improved = true;
        for (int round = 0; improved && round < kMaxRounds; ++round) {
            improved = false;
            for (size_t kind = 0; kind < best.size(); ++kind)
                for (const float factor : {step, 1 / step}) {
                    LightShares shares = best;
                    shares[kind] *= factor;
                    improved |= attempt(shares);
                }
            LightShares fewer = best, more = best;
            for (size_t kind = 0; kind < best.size(); ++kind)
                fewer[kind] /= step, more[kind] *= step;
            improved |= attempt(fewer);
            improved |= attempt(more);
        }
    }
    return best;
}
//<

std::string DescribeShares(const LightShares &shares) {
    const float none = std::max(0.f, 1 - shares[0] - shares[1] - shares[2]);
    return fmt::format("lights sampled: infinite {:.3g}, distant {:.3g}, local {:.3g}, none {:.3g}",
                       shares[0], shares[1], shares[2], none);
}

} // namespace cuticle
//<
