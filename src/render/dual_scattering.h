//> Declare dual scattering
#pragma once

#include "render/direct_light.h"
#include "render/fiber_albedo.h"
#include "volume/crossing_grid.h"

#include <map>
#include <optional>

namespace cuticle {

// Light in hair without paths (Zinke, Yuksel, Weber and Keyser 2008). On its way from a lamp, light is
// scattered forward by each hair that it meets: it loses what they absorb and send back, and spreads. Around
// the place where it arrives, neighbours send it back and forth. Works with every model of a fiber; surfaces
// that are no hair have direct light, weakened by the hair before them.
class DualScatteringIntegrator : public DirectLightIntegrator {
  public:
    // How the hairs between a place and a lamp are counted: one by one along a ray, or by a grid of how much
    // hair there is and how it lies.
    enum class Count { Traced, Grid };
    // How light that returns from the hair behind is spread: to the side that it came from, as energy asks;
    // or as printed, four times as much: all around the fiber, and twice.
    enum class Return { Half, Printed };
    struct Settings {
        Count count = Count::Traced;
        Return returned = Return::Half;
        float forwardDensity = 1;  // share of forward light that hair around a place sends there, 0 to 1
        float backwardDensity = 1; // the same of light that returns
        float cell = 0;            // side of the grid's cells; 0: 1/96 of the hair's longest side
        int maxDepth = 5;          // surfaces on the way from the camera
    };
    explicit DualScatteringIntegrator(const Settings &settings)
        : DirectLightIntegrator(settings.maxDepth), settings_(settings) {}
    // Tabulates what each material of hair scatters, and makes the grid.
    void Prepare(const Scene &scene, const Camera &camera) override;
    std::string Learned() const override;

    // Light on its way through hair: the share that meets none; the share that arrives
    // scattered forward, and the variance of its inclination (radians squared).
    struct Passage {
        float free = 1;
        Spectrum scattered;
        float variance = 0;
    };
    // Follows light to si from `distance` along wi (unit length). Nothing passes surfaces.
    Passage PassageOf(const SurfaceInteraction &si, const Vector3f &wi, float distance, const Scene &scene,
                      RayCounts &counts) const;

  private:
    Passage PassageByGrid(const SurfaceInteraction &si, const Vector3f &wi, float distance,
                          const Scene &scene, RayCounts &counts) const;
    Spectrum DirectLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                         PixelSampler &sampler, RayCounts &counts) const override;
    Spectrum HairLight(const SurfaceInteraction &si, const BSDF &bsdf, const Vector3f &wi,
                       const Passage &passage, const Point2f &u) const;
    FiberAlbedo AlbedoOf(const Material *material, float sinTheta) const;

    Settings settings_;
    std::map<const Material *, FiberAlbedoTable> tables_;
    std::optional<FiberAlbedoTable> any_; // of all hair, for materials that were not met
    std::optional<CrossingGrid> grid_;
};

} // namespace cuticle
//<
