//> Declare the fiber simulator
#pragma once

#include "fibers/fiber_histogram.h"
#include "fibers/microfacets.h"

#include <optional>

namespace cuticle {

//> Describe a fiber
// x runs along the fiber from root to tip; theta is measured from the normal plane, phi from y toward z.
// Lengths are in radii: for an ellipse, the radius of the circle of its area.
struct FiberDescription {
    double eta = 1.55;    // index of refraction against the surroundings, [0.1, 10]
    double axisRatio = 1; // second semi-axis of the section over the first, [0.05, 20]
    double rotation = 0;  // azimuth of the first semi-axis, radians
    double alpha = 0;     // tilt of the scales toward the root, radians, |alpha| <= 45 degrees
    double roughnessU =
        0; // along the fiber and across it, as Microfacets has it, [0, 1]; both 0: smooth; else 0 is 1e-4
    double roughnessV = 0;
    MicrofacetDistribution distribution = MicrofacetDistribution::Beckmann;
    std::vector<double> sigmaA = {0}; // absorption per radius, one number for each channel, >= 0
    // A core of the same shape and index, its radius over the fiber's in [0, 1); 0: none. It absorbs
    // medullaSigmaA (for each channel, or empty: sigmaA) and scatters medullaSigmaS (both per radius) after
    // Henyey and Greenstein.
    double medullaRatio = 0;
    std::vector<double> medullaSigmaA;
    double medullaSigmaS = 0;
    double medullaG = 0; // mean cosine, (-1, 1)
    // Light is polarised by every reflection and refraction, and a path remembers it (unpolarised light comes
    // in, all of what leaves is counted); a medulla that scatters it depolarises it. False: light is averaged
    // over polarisations at every bounce, as in all published models.
    bool polarised = false;

    bool operator==(const FiberDescription &) const = default;
};
//<

//> Say where the light comes from
// A parallel beam from (theta, phi), radians, |theta| < 90 degrees. Without h it covers the width evenly (far
// field); with h in [-1, 1] it is one ray at this part of the half width (near field), counted as in Phi(p,
// h): h > 0 on the side of azimuth phi - 90 degrees.
struct FiberLight {
    double theta = 0, phi = 0;
    std::optional<double> h;
};
//<

//> Say how well to measure
struct FiberMeasurement {
    uint64_t samples = 1'000'000;
    uint64_t seed = 1;
    int orders = 4; // classes of their own: p = 0 to orders - 1, [1, 16]
    // The one p to measure, below orders: paths are given up where they have more. Nothing else is in the
    // sum.
    std::optional<size_t> only;
    // Paths whose weight falls below this, [0, 1], play Russian roulette. 0: none does, what is below 1e-15
    // is given up, and one smooth ray has no noise at all.
    double faint = 0.05;
    SphereCells cells;
};
//<

//> Measure
// Traces rays of geometric optics through the fiber. The result depends on the seed, not on the number of
// threads. Throws Error for what is outside the stated ranges.
FiberHistogram SimulateFiber(const FiberDescription &fiber, const FiberLight &light,
                             const FiberMeasurement &measurement);

// The width that the fiber shows to light from azimuth phi, in radii: 2 for a circle.
double FiberWidth(const FiberDescription &fiber, double phi);
//<

} // namespace cuticle
//<
