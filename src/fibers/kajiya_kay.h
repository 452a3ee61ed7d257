//> Declare the model of Kajiya and Kay
#pragma once

#include "fibers/bxdf.h"
#include "fibers/gaussian.h"

#include <array>

namespace cuticle {

//> Write the two terms for any kind of number
// T is float or double. Directions are unit vectors in the local frame of the fiber, x along it.
template <typename T>
class KajiyaKay {
  public:
    KajiyaKay(const std::array<T, 3> &diffuse, const std::array<T, 3> &specular, T n);

    FiberValue<T> Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in (0, 1).
    FiberValue<T> Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const;

    std::array<T, 3> kd, ks;
    T exponent;

  private:
    // Samples the highlight from thetaO = -mean.
    TruncatedGaussian<T> ConeAbout(T mean) const { return {mean, sigma_, -kPole<T>, kPole<T>}; }
    T peak_;                 // the highlight's value on the cone, per unit of Ks
    T sigma_;                // width of the Gaussian that samples it
    T probabilityOfDiffuse_; // by luminance; negative: both terms are black
};
//<

//> Say what the class takes
// Kajiya and Kay 1989. Kd: energy of the diffuse term. Ks: energy of the highlight for a view square to the
// fiber. exponent: of the cosine, in [0, 1e6], clamped; the lobe's standard deviation is about 1 /
// sqrt(exponent) radians. Colours below 0 are taken as 0. NaN anywhere, or an infinite colour, throws Error.
// The model conserves no energy and is not mended: see chapter 11.
class KajiyaKayBSDF final : public BxDFOf<KajiyaKay<Float>> {
  public:
    KajiyaKayBSDF(const Spectrum &kd, const Spectrum &ks, Float exponent);
    std::string ToString() const override;
};
//<

} // namespace cuticle
//<
