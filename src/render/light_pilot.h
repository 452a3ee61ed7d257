//> Declare what a pilot learns of the lights
#pragma once

#include "core/sampling.h"
#include "render/integrator.h"
#include "scene/light_sampler.h"

#include <span>
#include <string>
#include <vector>

namespace cuticle {

//> Keep an estimate of a light apart from its weight
// Light of one lamp, sampled from a point: what it scatters into the path over its density there.
struct LightEstimate {
    Spectrum value;             // f |cos| L / pdf
    float pdf = 0, bsdfPdf = 0; // per steradian, of light sampling and of BSDF sampling
    bool delta = false;         // nothing but light sampling finds it
    // The share in the picture, where this lamp gets `samples` samples at a hit in the mean.
    Spectrum Weighted(float samples) const {
        return value * ((delta ? 1 : PowerHeuristic(samples * pdf, bsdfPdf)) / samples);
    }
};
//<

// One path of a pilot, by kinds of light (LightKind): luminances with the path's throughput in them, before
// they are weighed.
struct LightPilotPath {
    // A sample of a kind of light at a surface. pdf: the kind's own density; bsdfPdf 0: no other way finds
    // it.
    struct Sampled {
        float value = 0, pdf = 1, bsdfPdf = 0;
    };
    using Vertex = std::array<Sampled, 3>;
    // Light that the path ran into. bsdfPdf < 0: light sampling had no chance of it.
    struct Found {
        float value, pdf, bsdfPdf;
        LightKind kind;
    };
    std::vector<Vertex> sampled;
    std::vector<Found> found;
};

// Finds the shares that give the least product of variance and cost. paths: pilot.samples for each of its
// cells, those of a cell side by side. Deterministic.
LightShares LearnLightShares(std::span<const LightPilotPath> paths, const Pilot &pilot,
                             const LightSampler &lights);

// The product that is made small, for tests and charts; the mean over the cells.
double LightShareCost(std::span<const LightPilotPath> paths, const Pilot &pilot, const LightShares &shares);

// The shares in words.
std::string DescribeShares(const LightShares &shares);

} // namespace cuticle
//<
