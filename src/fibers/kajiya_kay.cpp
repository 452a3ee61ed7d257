//> Define the model of Kajiya and Kay
#include "fibers/kajiya_kay.h"

#include "core/error.h"
#include "fibers/ap.h"
#include "fibers/fiber_angles.h"
#include "fibers/gaussian.h"
#include "fibers/mp.h"

#include <sstream>

namespace cuticle {

namespace {
//> Divide gamma functions half a step apart
// Gamma(x + 1/2) / Gamma(x), x > 0: moved up to x >= 10 by the recurrence, then the asymptotic series about
// the middle, w = x - 1/4, where odd powers vanish. What is left out is 0.14 / w^16, below 3e-17.
template <typename T>
T HalfStepGammaRatio(T x) {
    T factor = 1;
    for (; x < 10; x += 1)
        factor *= x / (x + T(0.5L));
    const T w = x - T(0.25L);
    return factor * std::sqrt(w) *
           Polynomial(1 / (w * w), T(1), T(1) / 64, T(-19) / 8192, T(631) / 524288, T(-174317) / 134217728,
                      T(20491783) / T(8589934592), T(-7334801895) / T(1099511627776),
                      T(1858590154455) / T(70368744177664));
}
//<

//> Check a colour
Spectrum CheckedColor(const char *name, const Spectrum &c) {
    if (!std::isfinite(c[0] + c[1] + c[2]))
        throw Error(std::string("KajiyaKayBSDF: ") + name + " must be finite numbers");
    return c.Clamp();
}
Float CheckedExponent(Float exponent) {
    if (std::isnan(exponent))
        throw Error("KajiyaKayBSDF: the exponent must be a number");
    return std::clamp(exponent, 0.f, 1e6f);
}
//<
} // namespace

//> Normalise the highlight for a view square to the fiber
// 2 pi times the integral of cos^(n+1) is 2 pi^(3/2) Gamma(n/2 + 1) / Gamma(n/2 + 3/2).
template <typename T>
KajiyaKay<T>::KajiyaKay(const std::array<T, 3> &diffuse, const std::array<T, 3> &specular, T n)
    : kd(diffuse), ks(specular), exponent(n),
      peak_(HalfStepGammaRatio(n / 2 + 1) / (2 * kPi<T> * std::sqrt(kPi<T>))),
      sigma_(1 / std::sqrt(std::max(n, T(0.1L)))) {
    const T d = Luminance(kd), s = Luminance(ks);
    probabilityOfDiffuse_ = d + s > 0 ? d / (d + s) : T(-1);
}
//<

//> Evaluate the diffuse term and the cone of the highlight
template <typename T>
FiberValue<T> KajiyaKay<T>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z), i = AnglesOf(wi.x, wi.y, wi.z);
    const T diffuse = i.cosTheta / Sqr(kPi<T>);
    //> Raise $\cos(\theta_i + \theta_o)$ to its power
    // Starts from 1 - cos, which keeps its digits where the power is large.
    const T x = OneMinusCosSum(i.sinTheta, i.cosTheta, o.sinTheta, o.cosTheta);
    const T power = x < 1 ? std::exp(exponent * std::log1p(-x)) : T(0);
    //<
    const T highlight = peak_ * power;
    FiberValue<T> value{{0, 0, 0}, 0};
    for (size_t c = 0; c < 3; ++c)
        value.fCos[c] = kd[c] * diffuse + ks[c] * highlight;
    //> Weigh the two ways to sample
    if (probabilityOfDiffuse_ >= 0) {
        const T thetaO = std::atan2(o.sinTheta, o.cosTheta), thetaI = std::atan2(i.sinTheta, i.cosTheta);
        const T coneDensity = ConeAbout(-thetaO).Density(std::clamp(thetaI, -kPole<T>, kPole<T>)) /
                              (2 * kPi<T> * std::max(i.cosTheta, kPoleCosine<T>));
        value.pdf = probabilityOfDiffuse_ * diffuse + (1 - probabilityOfDiffuse_) * coneDensity;
    }
    //<
    return value;
}
//<

//> Sample the diffuse term by a disk, the highlight by a Gaussian
template <typename T>
FiberValue<T> KajiyaKay<T>::Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const {
    const T thetaO = std::atan2(wo.x, std::hypot(wo.y, wo.z)), phi = 2 * kPi<T> * u[1];
    if (u[0] < probabilityOfDiffuse_) {
        const SinCosine<T> theta = SampleCosineSquared(u[2], u[3]);
        *wi = {theta.sin, theta.cos * std::cos(phi), theta.cos * std::sin(phi)};
    } else {
        const SinCosine<T> theta = SinCosOfInclination(ConeAbout(-thetaO).Sample(u[2]));
        *wi = {theta.sin, theta.cos * std::cos(phi), theta.cos * std::sin(phi)};
    }
    return Evaluate(wo, *wi);
}
template class KajiyaKay<float>;
template class KajiyaKay<double>;
//<

//> Offer the model as a BSDF
KajiyaKayBSDF::KajiyaKayBSDF(const Spectrum &kd, const Spectrum &ks, Float exponent)
    : BxDFOf(
          KajiyaKay<Float>(CheckedColor("Kd", kd).c, CheckedColor("Ks", ks).c, CheckedExponent(exponent))) {}

std::string KajiyaKayBSDF::ToString() const {
    std::ostringstream out;
    out << "[ KajiyaKayBSDF Kd: [ " << model_.kd[0] << ", " << model_.kd[1] << ", " << model_.kd[2]
        << " ] Ks: [ " << model_.ks[0] << ", " << model_.ks[1] << ", " << model_.ks[2]
        << " ] exponent: " << model_.exponent << " ]";
    return out.str();
}
//<

} // namespace cuticle
//<
