//> Declare the mean scattering of a fiber
#pragma once

#include "materials/material.h"

#include <span>
#include <vector>

namespace cuticle {

// Light that meets a fiber at random offsets, halved by azimuth: forward is what goes on to the far side,
// backward what returns (Zinke, Yuksel, Weber and Keyser 2008, section 4). albedo: shares of
// the light. shift and spread: mean and standard deviation of theta_i + theta_o, radians, weighted by
// luminance.
struct FiberHalf {
    Spectrum albedo;
    float shift = 0, spread = 0;
};
struct FiberAlbedo {
    FiberHalf forward, backward;
};

// The mean scattering of the hair of one material by inclination.
class FiberAlbedoTable {
  public:
    // Averages over places where the material was met (one or more) and over offsets. Deterministic.
    FiberAlbedoTable(const Material &material, std::span<const SurfaceInteraction> places);
    // Interpolates at an inclination, given by the sine of the light's angle to the normal plane.
    FiberAlbedo At(float sinTheta) const;

  private:
    std::vector<FiberAlbedo> nodes_; // by theta, evenly from -90 to 90 degrees
};

// Sums up the light that went into the hair behind a fiber, met others and leaves past it again, sent
// backward once or three times by fibers of like inclination (the same, section 4.2).
FiberHalf MultipleBackscatter(const FiberAlbedo &albedo);

} // namespace cuticle
//<
