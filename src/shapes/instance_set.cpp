#include "shapes/instance_set.h"

#include "core/error.h"
#include "shapes/embree.h"
#include "shapes/embree_device.h"

#include <algorithm>
#include <vector>

namespace cuticle {

namespace {

struct PlacedInstance {
    Transform objectToWorld;
    Bounds3f bound; // world
};

// A query on its way through Embree; base comes first, so that the callbacks find the rest.
struct InstanceContext {
    EmbreeContext base;
    InstanceSet::IntersectFn intersect;
    void *query;
};

Ray InObject(const PlacedInstance &instance, const RTCRay &r) {
    Ray ray = instance.objectToWorld.Inverse()(Ray{{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}});
    ray.tMin = r.tnear;
    ray.tMax = r.tfar;
    return ray;
}

void Bound(const RTCBoundsFunctionArguments *args) {
    const Bounds3f &b = static_cast<const PlacedInstance *>(args->geometryUserPtr)[args->primID].bound;
    *args->bounds_o = {b.pMin.x, b.pMin.y, b.pMin.z, 0, b.pMax.x, b.pMax.y, b.pMax.z, 0};
}

void IntersectOne(const RTCIntersectFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    auto *rayHit = reinterpret_cast<RTCRayHit *>(args->rayhit);
    const auto *context = reinterpret_cast<const InstanceContext *>(args->context);
    const PlacedInstance &instance = static_cast<const PlacedInstance *>(args->geometryUserPtr)[args->primID];
    const float t = context->intersect(context->query, args->primID, InObject(instance, rayHit->ray));
    if (!(t >= 0))
        return;
    rayHit->ray.tfar = t;
    rayHit->hit.geomID = args->geomID;
    rayHit->hit.primID = args->primID;
}

void OccludedOne(const RTCOccludedFunctionNArguments *args) {
    if (args->valid[0] == 0)
        return;
    auto *ray = reinterpret_cast<RTCRay *>(args->ray);
    const auto *context = reinterpret_cast<const InstanceContext *>(args->context);
    const PlacedInstance &instance = static_cast<const PlacedInstance *>(args->geometryUserPtr)[args->primID];
    if (context->intersect(context->query, args->primID, InObject(instance, *ray)) >= 0)
        ray->tfar = -Infinity;
}

RTCRay ToEmbree(const Ray &ray) {
    return {ray.o.x,     ray.o.y, ray.o.z, std::max(ray.tMin, 0.f), ray.d.x, ray.d.y, ray.d.z, 0, ray.tMax,
            0xffffffffu, 0,       0};
}

} // namespace

struct InstanceSet::Impl {
    std::shared_ptr<EmbreeDevice> device = EmbreeDevice::Shared();
    RTCScene scene = nullptr;
    ptrdiff_t embreeBytes = 0;
    std::vector<PlacedInstance> instances;
    Bounds3f bound;

    Impl() = default;
    ~Impl() {
        if (scene)
            rtcReleaseScene(scene);
    }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    // Whether a ray may meet anything at all.
    bool Accepts(const Ray &ray) const {
        return scene && IsWithinReach(ray.o) && IsWithinReach(Point3f() + ray.d) &&
               ray.d.LengthSquared() > 0 && ray.tMax > ray.tMin;
    }
};

InstanceSet::InstanceSet() = default;
InstanceSet::~InstanceSet() = default;
InstanceSet::InstanceSet(InstanceSet &&) noexcept = default;
InstanceSet &InstanceSet::operator=(InstanceSet &&) noexcept = default;

uint32_t InstanceSet::Add(const Transform &objectToWorld, const Bounds3f &objectBound) {
    if (objectToWorld.IsSingular())
        throw Error("the instance's transformation has no inverse");
    const auto &m = objectToWorld.M();
    if (m[3][0] != 0 || m[3][1] != 0 || m[3][2] != 0)
        throw Error("the instance's transformation is not affine (last row of the matrix)");
    // Directions of rays in the object are as long as the inverse makes them, and the accelerators bear them
    // up to kMaxCoordinate; shorter than its inverse, their squares are lost.
    float widest = 0;
    for (const Transform &t : {objectToWorld, objectToWorld.Inverse()})
        for (size_t row = 0; row < 3; ++row)
            for (size_t column = 0; column < 3; ++column)
                widest = std::max(widest, static_cast<float>(std::abs(t.M()[row][column])));
    if (!(widest <= kMaxCoordinate))
        throw Error("the instance's transformation is extreme: it scales by {:g} or by the inverse", widest)
            .WithRemedy("it may be up to 1e18: scale the object's shapes instead");
    Bounds3f bound;
    if (!objectBound.IsEmpty()) {
        bound = objectToWorld(objectBound);
        if (!IsWithinReach(bound.pMin) || !IsWithinReach(bound.pMax))
            throw Error("the instance's coordinates are not finite or beyond 1e18");
        //  Rounding on the way into the object must not lose what lies on the box.
        for (int c = 0; c < 3; ++c) {
            const float slack = 4e-7f * std::max(std::abs(bound.pMin[c]), std::abs(bound.pMax[c]));
            bound.pMin[c] -= slack, bound.pMax[c] += slack;
        }
    }
    if (!impl_)
        impl_ = std::make_unique<Impl>();
    impl_->instances.push_back({objectToWorld, bound});
    impl_->bound.Extend(bound);
    return static_cast<uint32_t>(impl_->instances.size() - 1);
}

void InstanceSet::Commit() {
    if (!impl_)
        return;
    Impl &i = *impl_;
    i.instances.shrink_to_fit();
    const EmbreeMemoryScope scope(*i.device, &i.embreeBytes);
    i.scene = rtcNewScene(*i.device);
    rtcSetSceneFlags(i.scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(i.scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(*i.device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(i.instances.size()));
    rtcSetGeometryUserData(geometry, i.instances.data());
    rtcSetGeometryBoundsFunction(geometry, Bound, nullptr);
    rtcSetGeometryIntersectFunction(geometry, IntersectOne);
    rtcSetGeometryOccludedFunction(geometry, OccludedOne);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(i.scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(i.scene);
    i.device->Check("cannot build over the instances");
}

bool InstanceSet::Intersect(const Ray &ray, IntersectFn intersect, void *query) const {
    if (!impl_ || !impl_->Accepts(ray))
        return false;
    InstanceContext context{{}, intersect, query};
    InitEmbreeContext(&context.base);
    RTCRayHit rayHit{};
    rayHit.ray = ToEmbree(ray);
    rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    EmbreeIntersect(impl_->scene, &context.base, &rayHit);
    return rayHit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool InstanceSet::Occluded(const Ray &ray, IntersectFn intersect, void *query) const {
    if (!impl_ || !impl_->Accepts(ray))
        return false;
    InstanceContext context{{}, intersect, query};
    InitEmbreeContext(&context.base);
    RTCRay embreeRay = ToEmbree(ray);
    EmbreeOccluded(impl_->scene, &context.base, &embreeRay);
    return embreeRay.tfar < 0;
}

const Transform &InstanceSet::ObjectToWorld(uint32_t instance) const {
    return impl_->instances[instance].objectToWorld;
}
Bounds3f InstanceSet::WorldBound() const { return impl_ ? impl_->bound : Bounds3f(); }
size_t InstanceSet::Size() const { return impl_ ? impl_->instances.size() : 0; }
size_t InstanceSet::MemoryBytes() const {
    return impl_ ? static_cast<size_t>(std::max<ptrdiff_t>(impl_->embreeBytes, 0)) +
                       impl_->instances.capacity() * sizeof(PlacedInstance)
                 : 0;
}

} // namespace cuticle
