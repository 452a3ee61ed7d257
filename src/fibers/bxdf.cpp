//> Make pbrt-v3's methods of a fiber's two
#include "fibers/bxdf.h"

#include "core/sampling.h"

namespace cuticle {

//> Evaluate value and density
Spectrum FiberBxDF::f(const Vector3f &wo, const Vector3f &wi) const {
    Float pdf = 0;
    return FPdf(wo, wi, &pdf);
}
Float FiberBxDF::Pdf(const Vector3f &wo, const Vector3f &wi) const {
    Float pdf = 0;
    FPdf(wo, wi, &pdf);
    return pdf;
}
//<

//> Sample a direction with two random numbers
Spectrum FiberBxDF::Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                             BxDFType *sampledType) const {
    const Point2f first = DemuxFloat(u.x), second = DemuxFloat(u.y);
    if (sampledType)
        *sampledType = type;
    return Sample_f(wo, wi, std::array<Float, 4>{first.x, first.y, second.x, second.y}, pdf);
}
//<

//> Divide by the cosine that the renderer multiplies by
// A light in the plane of the ribbon has |wi.z| = 0: 1e-20 stands for it, there and in the sampled direction,
// so that value, direction and density agree for every direction.
constexpr Float kMinCosine = 1e-20f;

Spectrum FiberBxDF::WithoutCosine(const std::array<Float, 3> &fCos, const Vector3f &wi) {
    const Float inverse = 1 / std::max(std::abs(wi.z), kMinCosine);
    return Spectrum(fCos[0], fCos[1], fCos[2]) * inverse;
}
Spectrum FiberBxDF::WithoutCosineOfSample(const std::array<Float, 3> &fCos, Float pdf, Vector3f *wi) {
    if (std::abs(wi->z) < kMinCosine)
        wi->z = std::copysign(kMinCosine, wi->z);
    return pdf == 0 ? Spectrum() : WithoutCosine(fCos, *wi);
}
//<

} // namespace cuticle
//<
