//> Declare what an integrator is
#pragma once

#include "render/sampler.h"
#include "scene/camera.h"
#include "scene/scene.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace cuticle {

// Counts the rays traced, for the statistics: to find the next surface, and to find whether a light is seen.
struct RayCounts {
    uint64_t rays = 0, shadowRays = 0;
};

// A few samples of the whole picture, for an integrator that learns from them before the first one is taken.
// They are the same for any number of threads, crop window and range of samples, and are no part of the
// picture.
struct Pilot {
    Point2i cells;   // columns and rows of pixels, spread evenly over the picture
    int samples = 0; // of each of these
    // Starts the sampler for a sample of a cell, and returns its ray.
    std::function<Ray(Point2i cell, int sample, PixelSampler *sampler)> ray;
};

//> Average over a fiber's width where more than its width is seen
// Tells over how many offsets across a fiber to average at a hit. A fiber is met at one place across its
// width, always (near); or at all of them, where a pixel or what arrives is wider than the fiber (auto).
enum class HairField { Auto, Near };
class WidthSeen {
  public:
    void Look(const Camera &camera) { camera_ = camera; } // until then, what the camera meets is near
    // distance: along the path from the camera. scattered: rough surfaces have scattered the light before.
    size_t Offsets(const SurfaceInteraction &si, float distance, bool scattered, HairField field) const {
        constexpr size_t seen = 8, later = 4;
        if (!si.isCurve || field == HairField::Near)
            return 1;
        if (scattered)
            return later;
        return camera_ && camera_->PixelWidthAt(distance) >= si.width ? seen : 1;
    }

  private:
    std::optional<Camera> camera_;
};
//<

// Divides a sample's light for whoever treats its parts apart (render/denoise.h).
struct LightParts {
    Spectrum direct; // that rough surfaces scattered once at most; mirrors and glass do not count
};

// Estimates the radiance that arrives along a ray from the camera. Const and without state of its own: any
// number of threads may call it. May return values that are not finite (the film counts and reports them).
class Integrator {
  public:
    virtual ~Integrator() = default;
    virtual Spectrum Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                        RayCounts &counts) const = 0;
    // Gives the same radiance and tells its parts; where an integrator knows of none, all of it is direct.
    virtual Spectrum LiInParts(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                               RayCounts &counts, LightParts *parts) const {
        return parts->direct = Li(cameraRay, scene, sampler, counts);
    }
    // Makes what the picture needs of the scene. Once, before all else, however small the render.
    virtual void Prepare(const Scene & /*scene*/, const Camera &camera) { width_.Look(camera); }
    // Learns from a pilot how to spend the samples best; the expected picture stays. Once, before any Li.
    virtual void Learn(const Pilot & /*pilot*/, const Scene & /*scene*/) {}
    // Says what was learned, in words for the statistics; empty where nothing was.
    virtual std::string Learned() const { return {}; }

  protected:
    WidthSeen width_;
};

// Makes the integrator of a scene; `type` overrides the scene's own name. Those of pbrt-v3 that are not
// rendered fall back to "path" with one warning; unknown names throw Error.
std::unique_ptr<Integrator> MakeIntegrator(const Entity &entity, const std::string &type);

} // namespace cuticle
//<
