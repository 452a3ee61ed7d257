// Many placed copies of objects that are stored once: the upper level of a scene of two levels.
#pragma once

#include "core/vecmath.h"

#include <cstddef>
#include <memory>

namespace cuticle {

// InstanceSet knows the boxes and transformations of instances; its owner knows what is inside an object. Add
// instances, Commit() once, then ask from any number of threads.
class InstanceSet {
  public:
    InstanceSet();
    ~InstanceSet();
    InstanceSet(InstanceSet &&) noexcept;
    InstanceSet &operator=(InstanceSet &&) noexcept;

    // Returns the instance's number, counted from 0. objectBound: of what is placed, in its own coordinates;
    // an empty one makes an instance that no ray meets. Error if the transformation has no inverse or is not
    // affine, or its box is not finite.
    uint32_t Add(const Transform &objectToWorld, const Bounds3f &objectBound);
    void Commit();

    // Asks about one instance: objectRay is the ray in the object's coordinates, its direction of whatever
    // length that gives, so that t is the same in both. Returns t of the nearest hit in (objectRay.tMin,
    // objectRay.tMax), or a negative number; for Occluded any number >= 0 means a hit.
    using IntersectFn = float (*)(void *query, uint32_t instance, const Ray &objectRay);
    // Calls intersect(query, ...) for instances whose box the ray meets, in no order, with tMax the nearest t
    // so far. Returns whether any hit was reported.
    bool Intersect(const Ray &ray, IntersectFn intersect, void *query) const;
    // Does the same until the first hit.
    bool Occluded(const Ray &ray, IntersectFn intersect, void *query) const;

    const Transform &ObjectToWorld(uint32_t instance) const;
    Bounds3f WorldBound() const;
    size_t Size() const;
    size_t MemoryBytes() const; // Embree's and ours

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cuticle
