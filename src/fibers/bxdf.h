//> Declare what a scattering function offers
// pbrt-v3's names and signatures.
#pragma once

#include "core/color.h"

namespace cuticle {

//> Sort scattering into kinds
enum BxDFType {
    BSDF_REFLECTION = 1 << 0,
    BSDF_TRANSMISSION = 1 << 1,
    BSDF_DIFFUSE = 1 << 2,
    BSDF_GLOSSY = 1 << 3,
    BSDF_SPECULAR = 1 << 4,
    BSDF_ALL = BSDF_DIFFUSE | BSDF_GLOSSY | BSDF_SPECULAR | BSDF_REFLECTION | BSDF_TRANSMISSION,
};
//<

//> Evaluate, sample and weigh a pair of directions
// Directions are unit vectors in the local frame of the surface point and point away from it: z the normal; for a fiber
// x the tangent from root to tip and y across the width.
class BxDF {
  public:
    explicit BxDF(BxDFType t) : type(t) {}
    virtual ~BxDF() = default;
    // The value of the BSDF, 1/sr, without the cosine.
    virtual Spectrum f(const Vector3f &wo, const Vector3f &wi) const = 0;
    // Chooses wi from u in [0,1)^2; returns f and the density *pdf in 1/sr. *pdf = 0: no direction.
    virtual Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                              BxDFType *sampledType = nullptr) const = 0;
    // The density with which Sample_f chooses wi, 1/sr.
    virtual Float Pdf(const Vector3f &wo, const Vector3f &wi) const = 0;
    virtual std::string ToString() const = 0;

    const BxDFType type;
};
//<

} // namespace cuticle
//<
