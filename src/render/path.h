//> Declare the path integrator
#pragma once

#include "render/integrator.h"
#include "render/light_pilot.h"

#include <optional>

namespace cuticle {

// Unidirectional path tracing with light sampling, multiple importance sampling and Russian roulette
// (pbrt-v3's "path"). The ray that continues the path is also the one that looks for lights by BSDF sampling:
// one ray does both, where pbrt-v3 traces two; separateLightRay takes pbrt-v3's way, with the same expected
// picture, for comparison.
class PathIntegrator : public Integrator {
  public:
    // At each hit, one light is chosen at random, or all of them are sampled, each as often as it says.
    enum class LightStrategy { One, All };
    struct Settings {
        int maxDepth = 5;        // scattering events after the camera ray; 0: only lights seen directly
        float rrThreshold = 1;   // paths whose throughput falls below it may end by roulette
        bool directOnly = false; // "directlighting": follow only mirrors and glass past the first surface
        LightStrategy lights = LightStrategy::One; // which lights are sampled at each hit
        bool separateLightRay = false; // look for lights by BSDF sampling with a ray that ends there
        HairField field = HairField::Auto;
    };
    explicit PathIntegrator(const Settings &settings) : settings_(settings) {}
    Spectrum Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                RayCounts &counts) const override;
    Spectrum LiInParts(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler, RayCounts &counts,
                       LightParts *parts) const override;
    // Learns how often to sample which kind of light.
    void Learn(const Pilot &pilot, const Scene &scene) override;
    std::string Learned() const override;

  private:
    using Receiver = LightSampler::Receiver;
    template <class Recorder>
    Spectrum Trace(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler, RayCounts &counts,
                   Recorder &recorder) const;
    Spectrum SampleLights(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                          PixelSampler &sampler, RayCounts &counts) const;
    static bool SampleLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                            const Light &lamp, const Point2f &u, RayCounts &counts, LightEstimate *estimate);
    Spectrum SampleBSDFForLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                PixelSampler &sampler, RayCounts &counts) const;
    Spectrum LightFound(const Scene &scene, const Ray &ray, const SurfaceInteraction *surface,
                        const Receiver &from, const float *bsdfPdf) const;
    float SamplesOf(const Scene &scene, int light, const Receiver &at) const;
    const LightShares &Shares(const Scene &scene) const {
        return shares_ ? *shares_ : scene.Lights().SharesByPower();
    }
    Settings settings_;
    std::optional<Camera> camera_;      // none before Prepare: its hits are then near
    std::optional<LightShares> shares_; // that a pilot has found
};

} // namespace cuticle
//<
