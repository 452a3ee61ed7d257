// Scene: curves, solids, materials and lights made from a description, and the queries of rays.
#pragma once

#include "core/check.h"
#include "materials/interaction.h"
#include "materials/material.h"
#include "parser/scene_description.h"
#include "scene/light.h"
#include "scene/light_sampler.h"
#include "scene/shape_group.h"
#include "shapes/instance_set.h"

#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

namespace cuticle {

struct SceneOptions {
    MaterialOptions materials;
    // Keeps curves in a plain binary tree and intersects them by recursion as pbrt-v3 does: the benchmark's
    // baseline.
    bool binaryCurves = false;
};

// A ray and the curve or instance that it starts on.
struct SceneRay {
    Ray ray;
    CurveOrigin origin; // where fromCurve
    bool fromCurve = false;
    int instance = -1; // the instance that the curve belongs to; -1: none
};

// Queries are safe from any number of threads.
class Scene {
  public:
    // Takes the description's curves and object definitions (their lists are empty afterwards); the rest of
    // it stays for the film, camera and integrator. Throws Error with the directive's place where an object
    // cannot be made; what is known and not rendered gives one warning a kind.
    Scene(SceneDescription *description, const SceneOptions &options);
    Scene(const Scene &) = delete;
    Scene &operator=(const Scene &) = delete;

    // The nearest surface in (tMin, tMax); the ray's direction must be of unit length.
    bool Intersect(const SceneRay &ray, SurfaceInteraction *si) const;
    // Whether any surface lies in (tMin, tMax).
    bool Occluded(const SceneRay &ray) const;
    // The same of surfaces that are no hair.
    bool OccludedBySolids(const SceneRay &ray) const;
    // A ray that leaves si along w (unit length) and does not hit the place that it starts from: curves
    // decide that by geometry, solids by the bound of the hit point's rounding error. Where the scene's
    // options ask for pbrt-v3's way, a ray leaves a curve as there: two widths, as an error bound of each
    // coordinate, away from it along the normal, on the side of w; what it meets from there on is met, be it
    // its own hair.
    SceneRay SpawnRay(const SurfaceInteraction &si, const Vector3f &w) const;
    // The same as far as the point at `distance` along w from si; infinite: without end.
    SceneRay SpawnRayTo(const SurfaceInteraction &si, const Vector3f &w, float distance) const;

    // The lights by number, area lights among them.
    int LightCount() const { return static_cast<int>(lights_.size()); }
    const Light &LightAt(size_t i) const {
        DCHECK_LT(i, lights_.size());
        return *lights_[i];
    }
    const std::vector<int> &InfiniteLights() const { return infiniteLights_; }
    const LightSampler &Lights() const { return lightSampler_; }
    // The area light of that number: SurfaceInteraction::light where that is not -1.
    const DiffuseAreaLight &AreaLightAt(size_t i) const {
        return static_cast<const DiffuseAreaLight &>(LightAt(i));
    }
    // The density per steradian with which the area light at si samples it from ref.
    float AreaLightPdf(const Point3f &ref, const SurfaceInteraction &si) const;

    Bounds3f WorldBound() const;
    // Calls use(segment, toWorld) for all curve segments, once for each instance; toWorld is null where the
    // segment is in the world's coordinates.
    void ForEachCurve(const std::function<void(const CurveSegment &, const Transform *toWorld)> &use) const;
    size_t Curves() const;      // segments that are stored: of an object that is instanced, once
    size_t Instances() const;   // curves under a transformation that scales unevenly are instances too
    size_t MemoryBytes() const; // shapes and accelerators
    const char *Isa() const;    // the instruction set that the curve kernels use

  private:
    friend class SceneBuilder;
    struct InstanceQuery;

    // The colours of a groom's strands, for its run of curve segments; a single one holds for all of them.
    struct StrandColorRun {
        uint32_t firstSegment = 0;
        std::vector<StrandColors> colors;
    };

    static float IntersectInstance(void *query, uint32_t instance, const Ray &ray);
    static float OccludedInstance(void *query, uint32_t instance, const Ray &ray);
    static float OccludedBySolidsOf(void *query, uint32_t instance, const Ray &ray);
    void Describe(const ShapeGroup &shapes, const Ray &ray, const ShapeGroupHit &hit,
                  SurfaceInteraction *si) const;
    const StrandColors *StrandColorsOf(uint32_t group, uint32_t segment) const;

    std::vector<std::unique_ptr<Material>> materials_;
    std::vector<const Material *> curveMaterials_;              // by curve group
    std::vector<bool> curveFlipped_;                            // the same
    std::unordered_map<uint32_t, StrandColorRun> strandColors_; // by curve group, of those that have any
    ShapeGroup world_;
    std::vector<std::unique_ptr<ShapeGroup>> objects_; // those that are used
    InstanceSet instances_;
    std::vector<const ShapeGroup *> objectOf_; // by instance
    std::vector<std::unique_ptr<Light>> lights_;
    std::vector<int> infiniteLights_;
    LightSampler lightSampler_;
    bool strandRoots_ = false; // a texture asks for the roots of strands
    bool pbrtV3Offset_ = false;
};

} // namespace cuticle
