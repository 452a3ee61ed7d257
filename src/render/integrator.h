//> Declare what an integrator is
#pragma once

#include "render/sampler.h"
#include "scene/scene.h"

#include <memory>

namespace cuticle {

// Counts the rays traced, for the statistics: to find the next surface, and to find whether a light is seen.
struct RayCounts {
    uint64_t rays = 0, shadowRays = 0;
};

// Estimates the radiance that arrives along a ray from the camera. Const and without state of its own: any
// number of threads may call it. May return values that are not finite (the film counts and reports them).
class Integrator {
  public:
    virtual ~Integrator() = default;
    virtual Spectrum Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                        RayCounts &counts) const = 0;
};

// Makes the integrator of a scene; `type` overrides the scene's own name. Those of pbrt-v3 that are not
// rendered fall back to "path" with one warning; unknown names throw Error.
std::unique_ptr<Integrator> MakeIntegrator(const Entity &entity, const std::string &type);

} // namespace cuticle
//<
