//> Declare direct light on hair
#pragma once

#include "render/direct_light.h"
#include "volume/deep_shadow.h"
#include "volume/shell.h"

#include <optional>
#include <vector>

namespace cuticle {

// Direct light only, as Petrovic, Henne and Anderson light hair: light passes hair and is weakened at every
// crossing, and may be held against the normal of the hair's shell.
class HairLightIntegrator : public DirectLightIntegrator {
  public:
    // How hair stands in the light: as any other surface; as a filter, crossing by crossing along a ray; or
    // by a map made beforehand for each light without area (others are traced).
    enum class Shadow { Opaque, Traced, DeepMap };
    struct Settings {
        Shadow shadow = Shadow::Opaque;
        DeepShadowSettings map; // its opacity holds for traced shadows too
        bool shellNormals = false;
        float shellCell = 0; // side of a cell of the shell's lattice; 0: 1/96 of the hair's longest side
        float wrap = 0;      // by how much light reaches around the shell, 0 to 1
        int maxDepth = 5;    // surfaces on the way from the camera: mirrors and glass are followed
    };
    explicit HairLightIntegrator(const Settings &settings)
        : DirectLightIntegrator(settings.maxDepth), settings_(settings) {}
    // Makes the shell and the maps.
    void Prepare(const Scene &scene, const Camera &camera) override;
    std::string Learned() const override;

    // Says what the shell's normal makes of light from wi at p (in the world), 0 to 1; 1 without a shell.
    float ShellFactor(const Point3f &p, const Vector3f &wi) const;
    // The share of light that arrives at si from wi, from so far, past hair and surfaces.
    float Traced(const SurfaceInteraction &si, const Vector3f &wi, float distance, const Scene &scene,
                 RayCounts &counts) const;
    // The same of the light with that number, by its map if there is one.
    float Arrives(const SurfaceInteraction &si, const LightSample &light, int number, const Scene &scene,
                  RayCounts &counts) const;

  private:
    Spectrum DirectLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                         PixelSampler &sampler, RayCounts &counts) const override;
    Settings settings_;
    std::optional<HairShell> shell_;
    std::vector<std::optional<DeepShadowMap>> maps_; // by light
};

} // namespace cuticle
//<
