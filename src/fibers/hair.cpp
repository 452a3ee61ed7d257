//> Offer the hair model behind pbrt-v3's interface
#include "fibers/hair.h"

#include "core/error.h"
#include "core/special.h"

#include <sstream>

namespace cuticle {

namespace {
//> Refuse what has no meaning, clamp what is out of range
// The message is made aside, so that the constructor stays short.
[[noreturn, gnu::cold, gnu::noinline]] void Refuse(const char *name, float value) {
    throw Error("HairBSDF: {} is {:f}", name, value).WithRemedy("it must be a number, eta and alpha finite");
}
inline float Clamped(const char *name, float value, float low, float high) {
    if (std::isnan(value)) [[unlikely]]
        Refuse(name, value);
    return std::min(std::max(value, low), high);
}
inline float Finite(const char *name, float value) {
    if (!(std::abs(value) < Infinity)) [[unlikely]]
        Refuse(name, value);
    return value;
}
//<
} // namespace

//> Construct the BSDF
HairBSDF::HairBSDF(Float h, Float eta, const Spectrum &sigma_a, Float beta_m, Float beta_n, Float alpha,
                   ScaleTilt tilt)
    : parameters_{Clamped("h", h, -1, 1),
                  Clamped("eta", Finite("eta", eta), 1e-3f, 1e3f),
                  {Clamped("sigma_a", sigma_a[0], 0, 1e18f), Clamped("sigma_a", sigma_a[1], 0, 1e18f),
                   Clamped("sigma_a", sigma_a[2], 0, 1e18f)},
                  Clamped("beta_m", beta_m, 0, 1),
                  Clamped("beta_n", beta_n, 0, 1),
                  Finite("alpha", alpha),
                  tilt},
      kernels_(&CurrentHairKernels()) {
    kernels_->setUp(parameters_, setup_);
}
HairBSDF::HairBSDF(const HairBSDF &fiber, Float h)
    : parameters_(fiber.parameters_), setup_(fiber.setup_), kernels_(fiber.kernels_) {
    parameters_.h = setup_.h = Clamped("h", h, -1, 1);
    setup_.cosGammaO = std::sqrt((1 - setup_.h) * (1 + setup_.h));
}
//<

//> Forward evaluation and sampling to the kernels
Spectrum HairBSDF::FPdf(const Vector3f &wo, const Vector3f &wi, Float *pdf) const {
    const HairValue value = kernels_->evaluate(setup_, wo, wi);
    *pdf = value.pdf;
    return WithoutCosine(value.fCos, wi);
}
Spectrum HairBSDF::Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u,
                            Float *pdf) const {
    const HairValue value = kernels_->sample(setup_, wo, u, wi);
    *pdf = value.pdf;
    return WithoutCosineOfSample(value.fCos, value.pdf, wi);
}
//<

//> Describe the BSDF in a line
std::string HairBSDF::ToString() const {
    std::ostringstream out;
    out << "[ HairBSDF h: " << parameters_.h << " eta: " << parameters_.eta << " sigma_a: [ "
        << parameters_.sigmaA[0] << ", " << parameters_.sigmaA[1] << ", " << parameters_.sigmaA[2]
        << " ] beta_m: " << parameters_.betaM << " beta_n: " << parameters_.betaN
        << " alpha: " << parameters_.alpha
        << " tilt: " << (parameters_.tilt == ScaleTilt::RootToTip ? "root to tip" : "pbrt-v3")
        << " kernels: " << kernels_->name << " ]";
    return out.str();
}
//<

//> Mix pigments into an absorption coefficient
Spectrum HairBSDF::SigmaAFromConcentration(Float ce, Float cp) {
    const Spectrum eumelanin(0.419f, 0.697f, 1.37f), pheomelanin(0.187f, 0.4f, 1.05f);
    return std::max(ce, 0.f) * eumelanin + std::max(cp, 0.f) * pheomelanin;
}
//<

//> Find the absorption that makes a mass of hair look like a colour
Spectrum HairBSDF::SigmaAFromReflectance(const Spectrum &c, Float beta_n) {
    const Float b = std::clamp(beta_n, 0.f, 1.f);
    const Float scale = Polynomial(b, 5.969f, -0.215f, 2.532f, -10.73f, 5.574f, 0.245f);
    Spectrum sigma;
    for (int i = 0; i < 3; ++i)
        sigma[i] = Sqr(std::log(std::clamp(c[i], 1e-4f, 1.f)) / scale);
    return sigma;
}
//<

} // namespace cuticle
//<
