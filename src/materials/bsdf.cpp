#include "materials/bsdf.h"

namespace cuticle {

bool BSDF::HasNonSpecular() const {
    if (const auto *s = std::get_if<SurfaceLobes>(&model_))
        return s->HasNonSpecular();
    return IsHair();
}

Spectrum BSDF::FiberFPdf(const FiberBxDF &fiber, const Vector3f &wo, const Vector3f &wi, float *pdf) const {
    Spectrum f = fiber.FPdf(wo, wi, pdf);
    if (others_.empty())
        return f;
    for (const FiberStorage &other : others_) {
        float density = 0;
        f += other.Get()->FPdf(wo, wi, &density);
        *pdf += density;
    }
    const float share = 1 / static_cast<float>(others_.size() + 1);
    *pdf *= share;
    return f * share;
}

// One of the offsets is chosen, and a direction by its fiber; value and density are those of the mean.
Spectrum BSDF::SampleFiber(const FiberBxDF &fiber, const Vector3f &wo, const std::array<float, 4> &u,
                           Vector3f *wi, float *pdf) const {
    if (others_.empty())
        return fiber.Sample_f(wo, wi, u, pdf);
    const size_t count = others_.size() + 1;
    const float place = u[0] * static_cast<float>(count);
    const size_t chosen =
        place >= 0 ? std::min(static_cast<size_t>(place), count - 1) : 0; // NaN goes on in u
    const std::array<float, 4> rest = {std::min(place - static_cast<float>(chosen), OneMinusEpsilon), u[1],
                                       u[2], u[3]};
    Spectrum f;
    *pdf = 0;
    for (size_t k = 0; k <= count; ++k) { // the chosen one first, for its direction
        if (k > 0 && k - 1 == chosen)
            continue;
        const size_t which = k == 0 ? chosen : k - 1;
        const FiberBxDF &one = which == 0 ? fiber : *others_[which - 1].Get();
        float density = 0;
        f += k == 0 ? one.Sample_f(wo, wi, rest, &density) : one.FPdf(wo, *wi, &density);
        *pdf += density;
        if (k == 0 && !(density > 0)) // no direction; NaN is to be seen
            return f * (1 / static_cast<float>(count));
    }
    const float share = 1 / static_cast<float>(count);
    *pdf *= share;
    return f * share;
}

Spectrum BSDF::FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const {
    const Vector3f wo = frame_.ToLocal(woW), wi = frame_.ToLocal(wiW);
    *pdf = 0;
    if (const FiberBxDF *fiber = Fiber()) {
        const Spectrum f = FiberFPdf(*fiber, wo, wi, pdf);
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
        sample->f = SampleFiber(*fiber, wo, u, &wi, &sample->pdf);
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
