#include "materials/bsdf.h"

namespace cuticle {

bool BSDF::HasNonSpecular() const {
    if (const auto *s = std::get_if<SurfaceLobes>(&model_))
        return s->HasNonSpecular();
    return IsHair();
}

Spectrum BSDF::FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const {
    const Vector3f wo = frame_.ToLocal(woW), wi = frame_.ToLocal(wiW);
    *pdf = 0;
    if (const FiberBxDF *fiber = Fiber()) {
        const Spectrum f = fiber->FPdf(wo, wi, pdf);
        Check(f, *pdf);
        return scale_ * f * std::abs(wi.z);
    }
    if (const auto *s = std::get_if<SurfaceLobes>(&model_)) {
        const bool reflect = Dot(woW, n_) * Dot(wiW, n_) > 0;
        return scale_ * s->f(wo, wi, reflect, pdf) * std::abs(wi.z);
    }
    return {};
}

bool BSDF::Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                    Spectrum *weight) const {
    const Vector3f wo = frame_.ToLocal(woW);
    Vector3f wi; // local
    if (const FiberBxDF *fiber = Fiber()) {
        sample->f = fiber->Sample_f(wo, &wi, u, &sample->pdf);
        Check(sample->f, sample->pdf);
        sample->wi = IsFinite(wi) ? Normalize(frame_.FromLocal(wi)) : woW;
        sample->specular = false;
        sample->transmission = wi.z * wo.z < 0;
        sample->eta = 1;
    } else if (const auto *s = std::get_if<SurfaceLobes>(&model_)) {
        if (!s->Sample_f(wo, u[0], {u[1], u[2]}, sample))
            return false;
        wi = sample->wi;
        sample->wi = Normalize(frame_.FromLocal(wi));
        if (!sample->specular) {
            // Evaluate at the rounded direction of the world, as FCos will: near grazing angles the half
            // vector of a sharp lobe moves by several percent of the lobe's width with a direction's last
            // bit.
            wi = frame_.ToLocal(sample->wi);
            const bool reflect = Dot(sample->wi, n_) * Dot(woW, n_) > 0;
            sample->f = s->f(wo, wi, reflect, &sample->pdf);
        }
    } else {
        return false;
    }
    sample->f *= scale_;
    if (sample->pdf <= 0 || sample->f.IsBlack()) // not so for NaN: that is to be seen
        return false;
    *weight = sample->f * (std::abs(wi.z) / sample->pdf);
    return true;
}

void BSDF::TellNotFinite(const Spectrum &f, float pdf) const {
    const std::string what = fmt::format(
        "the fiber model \"{}\" gave the value {} {} {} with the density {}; samples that meet such "
        "a number are left out of the picture",
        origin_ ? origin_->model : "of no name", f[0], f[1], f[2], pdf);
    Warning(origin_ ? origin_->loc : FileLoc(), "fiber model that is not finite", what);
}

} // namespace cuticle
