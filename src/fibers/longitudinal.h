//> Scatter along the fiber, in the ways of three papers
// How far light leaves the cone of mirror directions, for the far-field models. T is float or double. The
// members of LongitudinalLobe are in longitudinal_forms.h, which whoever compiles a model includes.
#pragma once

#include "fibers/gaussian.h"

namespace cuticle {

//> Choose a form of $M_p$
// width is the standard deviation of theta_i + theta_o and shift its mean; g the unit-area Gaussian.
//
//   HalfAngle  Marschner et al. 2003: g(width / 2; theta_h - shift / 2) / cos^2 theta_d. Returns about twice
//              the light, since dtheta_i = 2 dtheta_h.
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
// cos^2 theta_d of the half difference (theta_o - theta_i) / 2: a quarter of the squared length of the sum of
// two unit vectors, which does not cancel.
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

    // The factor that the light N_p is multiplied with to give f |cos| of two directions.
    T Value(const Inclination<T> &o, const Inclination<T> &i) const;
    // The density of Sample, for cos theta_i d theta_i.
    T Density(const Inclination<T> &o, const Inclination<T> &i) const;
    // cos theta_d where most of the lobe is seen from theta_o: at theta_o, but from along the fiber half a
    // width beside it.
    T UsualCosThetaD(T cosThetaO) const { return std::max(cosThetaO, std::min(width_ / 2, T(1))); }
    // Chooses theta_i from two numbers in (0, 1).
    Inclination<T> Sample(const Inclination<T> &o, T u, T v) const;

  private:
    bool IsSpherical() const {
        return form_ == LongitudinalForm::Spherical || form_ == LongitudinalForm::Printed;
    }
    SinCosine<T> TiltedBy(const Inclination<T> &o) const;
    T SphericalValue(const Inclination<T> &o, const Inclination<T> &i) const;
    TruncatedGaussian<T> Cut(const Inclination<T> &o) const;
    LongitudinalForm form_ = LongitudinalForm::Spherical;
    T width_ = 1, shift_ = 0, sinTilt_ = 0, cosTilt_ = 1;
};
//<

} // namespace cuticle
//<
