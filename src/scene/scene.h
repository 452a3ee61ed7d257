// The scene as rays meet it: curves, solids, materials and lights made from a description.
#pragma once

#include "materials/interaction.h"
#include "materials/material.h"
#include "parser/scene_description.h"
#include "scene/light.h"
#include "shapes/curve_set.h"
#include "shapes/instance_set.h"
#include "shapes/solid_set.h"

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

namespace cuticle {

struct SceneOptions {
    MaterialOptions materials;
    // Curves in the plain binary tree, met by recursion, as pbrt-v3 does it: the benchmark's opponent.
    bool binaryCurves = false;
};

// A ray with what it starts on.
struct SceneRay {
    Ray ray;
    CurveOrigin origin;
    bool fromCurve = false;
    int instance = -1; // that the curve belongs to; -1: none
};

class Scene {
  public:
    // Takes the description's curves and object definitions (their lists are empty afterwards); the rest of it stays
    // for the film, camera and integrator. Throws Error with the directive's place where an object cannot be
    // made; what is known and not rendered gives one warning a kind.
    Scene(SceneDescription *description, const SceneOptions &options);
    Scene(const Scene &) = delete;
    Scene &operator=(const Scene &) = delete;

    // The nearest surface in (tMin, tMax); the ray's direction must be of unit length.
    bool Intersect(const SceneRay &ray, SurfaceInteraction *si) const;
    bool Occluded(const SceneRay &ray) const;
    // A ray that leaves si along w (unit length) and does not meet the place that it starts from: curves decide that
    // by geometry, solids by the bound of the hit point's rounding error.
    SceneRay SpawnRay(const SurfaceInteraction &si, const Vector3f &w) const;

    // Lights are numbered; area lights have numbers like the others.
    int LightCount() const { return static_cast<int>(lights_.size()); }
    const Light &LightAt(int i) const { return *lights_[static_cast<size_t>(i)]; }
    const std::vector<int> &InfiniteLights() const { return infiniteLights_; }
    const LightSampler &Lights() const { return lightSampler_; }
    const DiffuseAreaLight &AreaLightAt(int i) const {
        return static_cast<const DiffuseAreaLight &>(*lights_[static_cast<size_t>(i)]);
    }
    // The density per steradian with which the area light at si samples it from ref.
    float AreaLightPdf(const Point3f &ref, const SurfaceInteraction &si) const;

    Bounds3f WorldBound() const;
    size_t Curves() const; // segments that are stored: of an object that is instanced, once
    size_t Instances() const;
    size_t MemoryBytes() const; // shapes and accelerators
    const char *Isa() const;    // what the curve kernels run on

  private:
    struct SolidInfo { // by shape id
        const Material *material = nullptr;
        int light = -1;
    };
    // Colours of a groom's strands, for its run of curve segments; a single one holds for all of them.
    struct GroupColors {
        uint32_t firstSegment = 0;
        std::vector<StrandColors> colors;
    };
    // What is stored once: the world's own shapes, or those of an object definition in its own coordinates.
    struct Part {
        SolidSet solids;
        std::vector<SolidInfo> solidInfos;
        CurveSet curves;
        std::optional<BinaryCurveBvh> binaryCurves;
        std::vector<Vector3f> strandNormals; // by segment; empty where no material asks for them
        bool haveSolids = false, haveCurves = false;

        struct Hit {
            bool isCurve = false;
            CurveHit curve;
            SolidPoint solid;
            float T() const { return isCurve ? curve.t : solid.t; }
        };
        bool Intersect(Ray ray, const CurveOrigin *origin, Hit *hit) const;
        bool Occluded(const Ray &ray, const CurveOrigin *origin) const;
        const CurveSegment &Segment(uint32_t i) const {
            return binaryCurves ? binaryCurves->Segment(i) : curves.Segment(i);
        }
        Bounds3f Bound() const;
        size_t Curves() const;
        size_t MemoryBytes() const;
    };
    struct InstanceQuery;
    class Builder;

    static float IntersectInstance(void *query, uint32_t instance, const Ray &ray);
    static float OccludedInstance(void *query, uint32_t instance, const Ray &ray);
    void Describe(const Part &part, const Ray &ray, const Part::Hit &hit, SurfaceInteraction *si) const;
    const StrandColors *StrandColorsOf(uint32_t group, uint32_t segment) const;

    std::vector<std::unique_ptr<Material>> materials_;
    std::vector<const Material *> curveMaterials_;           // by curve group
    std::unordered_map<uint32_t, GroupColors> strandColors_; // by curve group, of those that have any
    Part world_;
    std::vector<std::unique_ptr<Part>> objects_; // those that are used
    InstanceSet instances_;
    std::vector<const Part *> objectOf_; // by instance
    std::vector<std::unique_ptr<Light>> lights_;
    std::vector<int> infiniteLights_;
    LightSampler lightSampler_;
};

} // namespace cuticle
