#include "core/error.h"
#include "scene/light.h"
#include "scene/light_makers.h"
#include "scene/plugins.h"

#include <algorithm>

namespace cuticle {

DiffuseAreaLight::DiffuseAreaLight(const Spectrum &L, bool twoSided, const SolidSet *solids,
                                   uint32_t geometryId)
    : L_(L), twoSided_(twoSided), solids_(solids), geometryId_(geometryId) {}

bool DiffuseAreaLight::Sample_Li(const Point3f &ref, const Point2f &u, LightSample *sample) const {
    ShapeSample point;
    if (L_.IsBlack() || !solids_->Sample(geometryId_, ref, u, &point))
        return false;
    const float distance = point.distance;
    if (!(distance > 0 && distance < Infinity) || !(twoSided_ || point.cosine > 0))
        return false;
    // Stop short of the emitter by what rounding may have moved its point, the start and the direction's far
    // end across its plane, seen along the ray.
    const Vector3f n(std::abs(point.n.x), std::abs(point.n.y), std::abs(point.n.z));
    const Vector3f from(std::abs(ref.x), std::abs(ref.y), std::abs(ref.z));
    const float across = Dot(n, point.pError + from * 0x1p-22f) + distance * 0x1p-21f;
    const float slack = across / std::max(std::abs(point.cosine), 1e-4f);
    *sample = {point.wi, point.pdf, std::max(0.f, distance - slack), L_, false};
    return true;
}

Spectrum DiffuseAreaLight::Power() const {
    return L_ * (solids_->Area(geometryId_) * Pi * (twoSided_ ? 2.f : 1.f));
}

EmissionBound DiffuseAreaLight::Bound() const {
    EmissionBound bound{.box = solids_->Bound(geometryId_), .twoSided = twoSided_};
    solids_->Normals(geometryId_, &bound.axis, &bound.normals);
    return bound;
}

std::unique_ptr<DiffuseAreaLight> MakeAreaLight(const Entity &entity, const SolidSet *solids,
                                                uint32_t geometryId) {
    const ParamSet &params = entity.params;
    if (!AreaLightPlugins().Find(entity.type)) {
        const std::vector<std::string_view> names = AreaLightPlugins().Names();
        throw Error(params.loc, "unknown area light \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
    }
    const Spectrum L = ScaledLightValue(params, "L", "area");
    const bool twoSided = params.FindBool("twosided", false);
    auto light = std::make_unique<DiffuseAreaLight>(L, twoSided, solids, geometryId);
    light->SetSamples(params.FindInt("samples", params.FindInt("nsamples", 1)));
    return light;
}

} // namespace cuticle
