//> Compute the forms of $M_p$
#pragma once

#include "fibers/hair_as_printed.h"
#include "fibers/longitudinal.h"
#include "fibers/mp.h"

namespace cuticle {

//> Evaluate the three forms
// S cos theta_i with S = M N / cos^2 theta_d, or d'Eon's M N, which holds these cosines already.
template <typename T>
SinCosine<T> LongitudinalLobe<T>::TiltedBy(const Inclination<T> &o) const {
    return Tilted(o.sin, o.cos, sinTilt_, cosTilt_);
}
template <typename T>
T LongitudinalLobe<T>::SphericalValue(const Inclination<T> &o, const Inclination<T> &i) const {
    const SinCosine<T> tilted = TiltedBy(o);
    return Mp(i.cos, tilted.cos, i.sin, tilted.sin, width_ * width_);
}
template <typename T>
T LongitudinalLobe<T>::Value(const Inclination<T> &o, const Inclination<T> &i) const {
    if (form_ == LongitudinalForm::Spherical)
        return SphericalValue(o, i);
    if (form_ == LongitudinalForm::Printed) {
        const SinCosine<T> tilted = TiltedBy(o);
        return as_printed::MpOf2011InRange(i.cos, tilted.cos, i.sin, tilted.sin, width_ * width_);
    }
    const T cosines = i.cos / std::max(SquaredCosOfHalfDifference(o, i), T(1e-12L));
    const T full = Gaussian(width_, o.Angle() + i.Angle() - shift_) * cosines;
    return form_ == LongitudinalForm::HalfAngle ? 2 * full : full;
}
//<

//> Sample the three forms
// The spherical form is a density as it stands. The Gaussians are cut at the poles; a centre that the shift
// has carried beyond a pole is put on it, and so is an angle that rounding has.
template <typename T>
TruncatedGaussian<T> LongitudinalLobe<T>::Cut(const Inclination<T> &o) const {
    const T pole = kPole<T>;
    return {std::clamp(shift_ - o.Angle(), -pole, pole), width_, -pole, pole};
}
template <typename T>
T LongitudinalLobe<T>::Density(const Inclination<T> &o, const Inclination<T> &i) const {
    if (IsSpherical())
        return SphericalValue(o, i);
    return Cut(o).Density(std::clamp(i.Angle(), -kPole<T>, kPole<T>)) / std::max(i.cos, kPoleCosine<T>);
}
template <typename T>
Inclination<T> LongitudinalLobe<T>::Sample(const Inclination<T> &o, T u, T v) const {
    if (IsSpherical()) {
        const SinCosine<T> axis = TiltedBy(o);
        const T psi = 2 * kPi<T> * v;
        const SinCosine<T> theta = TurnFromAxis(SampleMpCosine(u, width_ * width_), std::sin(psi),
                                                std::cos(psi), axis.sin, axis.cos);
        return {theta.sin, theta.cos};
    }
    const SinCosine<T> theta = SinCosOfInclination(Cut(o).Sample(u));
    return {theta.sin, theta.cos};
}
//<

} // namespace cuticle
//<
