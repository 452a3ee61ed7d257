//> Scatter along the fiber, in the ways of three papers
// How far light leaves the cone of mirror directions, for the far-field models. T is float or double.
#pragma once

#include "fibers/gaussian.h"
#include "fibers/hair_as_printed.h"
#include "fibers/hair_model.h"

namespace cuticle {

//> Choose a form of $M_p$
// width is the standard deviation of theta_i + theta_o and shift its mean; g the unit-area Gaussian.
//
//   HalfAngle  Marschner et al. 2003: g(width / 2; theta_h - shift / 2) / cos^2 theta_d. Returns about twice the light,
//              since dtheta_i = 2 dtheta_h.
//   FullAngle  Zinke and Weber 2007: g(width; theta_i + theta_o - shift) / cos^2 theta_d, half of the former.
//   Spherical  d'Eon et al. 2011: conserves energy. width^2 is its v.
//   Printed    the same, but computed as that paper prints it; sampled as Spherical. For comparison only.
enum class LongitudinalForm { HalfAngle, FullAngle, Spherical, Printed };
//<

//> Hold an inclination
template <typename T>
struct Inclination {
    T sin, cos;
    T Angle() const { return std::atan2(sin, cos); }
};
// cos^2 theta_d of the half difference (theta_o - theta_i) / 2: a quarter of the squared length of the sum of two unit
// vectors, which does not cancel.
template <typename T>
T SquaredCosOfHalfDifference(const Inclination<T> &o, const Inclination<T> &i) {
    return (Sqr(o.sin + i.sin) + Sqr(o.cos + i.cos)) / 4;
}
//<

//> Declare one lobe along the fiber
template <typename T>
class LongitudinalLobe {
  public:
    LongitudinalLobe() = default;
    // Radians. width is raised to 1e-4, what binary32 angles resolve.
    LongitudinalLobe(LongitudinalForm form, T width, T shift)
        : form_(form), width_(std::max(width, T(1e-4L))), shift_(shift), sinTilt_(-std::sin(shift)),
          cosTilt_(std::cos(shift)) {}

    // What the light N_p is multiplied with to give f |cos| of two directions.
    T Value(const Inclination<T> &o, const Inclination<T> &i) const;
    // The density of Sample, for cos theta_i d theta_i.
    T Density(const Inclination<T> &o, const Inclination<T> &i) const;
    // cos theta_d where most of the lobe is seen from theta_o: at theta_o, but from along the fiber half a width beside it.
    T UsualCosThetaD(T cosThetaO) const { return std::max(cosThetaO, std::min(width_ / 2, T(1))); }
    // Chooses theta_i from two numbers in (0, 1).
    Inclination<T> Sample(const Inclination<T> &o, T u, T v) const;

  private:
    bool IsSpherical() const {
        return form_ == LongitudinalForm::Spherical || form_ == LongitudinalForm::Printed;
    }
    SinCosine<T> TiltedBy(const Inclination<T> &o) const { return Tilted(o.sin, o.cos, sinTilt_, cosTilt_); }
    T SphericalValue(const Inclination<T> &o, const Inclination<T> &i) const {
        const SinCosine<T> tilted = TiltedBy(o);
        return Mp(i.cos, tilted.cos, i.sin, tilted.sin, width_ * width_);
    }
    TruncatedGaussian<T> Cut(const Inclination<T> &o) const;
    LongitudinalForm form_ = LongitudinalForm::Spherical;
    T width_ = 1, shift_ = 0, sinTilt_ = 0, cosTilt_ = 1;
};
//<

//> Evaluate the three forms
// S cos theta_i with S = M N / cos^2 theta_d, or d'Eon's M N, which holds these cosines already.
template <typename T>
T LongitudinalLobe<T>::Value(const Inclination<T> &o, const Inclination<T> &i) const {
    if (form_ == LongitudinalForm::Spherical)
        return SphericalValue(o, i);
    if (form_ == LongitudinalForm::Printed) {
        const SinCosine<T> tilted = TiltedBy(o);
        return as_printed::MpOf2011(i.cos, tilted.cos, i.sin, tilted.sin, width_ * width_);
    }
    const T cosines = i.cos / std::max(SquaredCosOfHalfDifference(o, i), T(1e-12L));
    const T full = Gaussian(width_, o.Angle() + i.Angle() - shift_) * cosines;
    return form_ == LongitudinalForm::HalfAngle ? 2 * full : full;
}
//<

//> Sample the three forms
// The spherical form is a density as it stands. The Gaussians are cut to [-pi/2, pi/2]; a centre that the shift has
// carried beyond the pole is put on it.
template <typename T>
TruncatedGaussian<T> LongitudinalLobe<T>::Cut(const Inclination<T> &o) const {
    const T pole = kPi<T> / 2;
    return {std::clamp(shift_ - o.Angle(), -pole, pole), width_, -pole, pole};
}
template <typename T>
T LongitudinalLobe<T>::Density(const Inclination<T> &o, const Inclination<T> &i) const {
    if (IsSpherical())
        return SphericalValue(o, i);
    return Cut(o).Density(i.Angle()) / std::max(i.cos, std::numeric_limits<T>::min());
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
    const T theta = Cut(o).Sample(u);
    return {std::sin(theta), std::cos(theta)};
}
//<

} // namespace cuticle
//<
