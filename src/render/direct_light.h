//> Declare direct light past mirrors
#pragma once

#include "render/integrator.h"

namespace cuticle {

// The light that arrives straight from lamps at the first surface that is neither mirror nor glass. How it is
// weakened or spread on its way is up to the derived class.
class DirectLightIntegrator : public Integrator {
  public:
    // maxDepth: surfaces on the way from the camera.
    explicit DirectLightIntegrator(int maxDepth) : maxDepth_(maxDepth) {}
    Spectrum Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                RayCounts &counts) const override;

  protected:
    // Adds up what the surface at si scatters toward si.wo of the light of all lamps.
    virtual Spectrum DirectLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                 PixelSampler &sampler, RayCounts &counts) const = 0;

  private:
    int maxDepth_;
};

//> Walk along a ray through all hair
// Calls crossing(t, si) for each hair, t along the ray as a whole; returns where something else ends it, else
// infinity. crossing returns false to stop.
template <class Crossing>
float WalkThroughHair(const Scene &scene, SceneRay ray, RayCounts *counts, const Crossing &crossing) {
    constexpr int kMaxCrossings = 10000; // a ray that walks on the spot comes to an end
    float walked = 0;
    const float end = ray.ray.tMax;
    SurfaceInteraction si;
    for (int n = 0; n < kMaxCrossings; ++n) {
        ++counts->shadowRays;
        if (!scene.Intersect(ray, &si))
            return Infinity;
        walked += si.t;
        if (!si.isCurve)
            return walked;
        if (!crossing(walked, si))
            return Infinity;
        ray = scene.SpawnRayTo(si, ray.ray.d, end - walked);
    }
    return Infinity;
}
//<

} // namespace cuticle
//<
