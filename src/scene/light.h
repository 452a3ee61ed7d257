// The lights of a scene.
#pragma once

#include "core/check.h"
#include "core/color.h"
#include "parser/scene_description.h"
#include "shapes/solid_set.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace cuticle {

// Light that arrives at a point. The estimator is f(wi) |cos| L / pdf if nothing stands in (0, distance)
// along wi.
struct LightSample {
    Vector3f wi;   // of unit length, from the reference point toward the light
    float pdf = 0; // per steradian; 1 for delta lights (L then carries the falloff)
    // The length of the way that must be free; ends just short of an emitter's own surface. Infinity for far
    // lights.
    float distance = 0;
    Spectrum L;         // radiance, or intensity / distance^2, or irradiance on a plane across wi
    bool delta = false; // no other strategy can find this direction: no MIS
};

// Says where a light stands and whither it shines, which bounds the light that it can send to a point.
struct EmissionBound {
    Bounds3f box; // holds all points that emit
    // Every point emits within `spread` of a direction that is within `normals` of axis, in radians; its
    // intensity falls at least as the cosine of the angle to that direction. twoSided: toward -axis as well.
    Vector3f axis{0, 0, 1};
    float normals = Pi, spread = Pi / 2;
    bool twoSided = false;
};

// Tells lights apart for the choice of one: paths run into Infinite ones by themselves, Distant ones are as
// bright everywhere, and of Local ones the near are brighter.
enum class LightKind : uint8_t { Infinite, Distant, Local };

class Light {
  public:
    virtual ~Light() = default;
    // Samples a direction toward the light. u in [0,1)^2. False if the light sends nothing to ref (then
    // *sample is not to be used).
    virtual bool Sample_Li(const Point3f &ref, const Point2f &u, LightSample *sample) const = 0;
    // The density per steradian of Sample_Li from ref at wi (unit length), for rays that leave the scene:
    // infinite lights only, 0 for the others. For emitters that rays hit see DiffuseAreaLight::Pdf_Li.
    virtual float Pdf_Li(const Point3f & /*ref*/, const Vector3f & /*wi*/) const { return 0; }
    // Radiance along a ray that leaves the scene; its direction need not be of unit length.
    virtual Spectrum Le(const Ray & /*ray*/) const { return Spectrum(0.f); }
    // The power in watts; of far lights the part that passes the bounding sphere of the scene.
    virtual Spectrum Power() const = 0;
    virtual bool IsDelta() const { return false; }
    virtual LightKind Kind() const { return LightKind::Local; }
    bool IsInfinite() const { return Kind() == LightKind::Infinite; } // Le may be other than 0
    // The bound of a Local light; others have none.
    virtual EmissionBound Bound() const { return {}; }
    // How many samples Integrator "directlighting" takes of this light at each hit: the scene's "samples",
    // at least 1.
    int Samples() const { return samples_; }
    void SetSamples(int samples) { samples_ = std::max(1, samples); }

  private:
    int samples_ = 1;
};

// Emits L from the side its normal points to, or from both (twoSided), over one geometry of a SolidSet,
// which must outlive it.
class DiffuseAreaLight : public Light {
  public:
    DiffuseAreaLight(const Spectrum &L, bool twoSided, const SolidSet *solids, uint32_t geometryId);
    bool Sample_Li(const Point3f &ref, const Point2f &u, LightSample *sample) const override;
    Spectrum Power() const override;
    EmissionBound Bound() const override;
    // Radiance that leaves a point of normal n (SolidHit::n) toward w.
    Spectrum L(const Normal3f &n, const Vector3f &w) const {
        return twoSided_ || Dot(n, w) > 0 ? L_ : Spectrum(0.f);
    }
    using Light::Pdf_Li;
    // The density of Sample_Li(ref) at the direction of a ray from ref that met this light at hit.
    float Pdf_Li(const Point3f &ref, const SolidHit &hit) const { return solids_->Pdf(ref, hit); }

  private:
    Spectrum L_;
    bool twoSided_;
    const SolidSet *solids_;
    uint32_t geometryId_;
};

// Makes the light of a LightSource directive. worldBound: of all shapes and curves. An unknown name and a
// map that cannot be used are an Error. Values below 0 or NaN are set to 0 with a Warning that says where.
std::unique_ptr<Light> MakeLight(const LightEntity &entity, const Bounds3f &worldBound);
// Makes the light of an AreaLightSource directive over one geometry of solids, which must outlive it.
std::unique_ptr<DiffuseAreaLight> MakeAreaLight(const Entity &entity, const SolidSet *solids,
                                                uint32_t geometryId);

} // namespace cuticle
