//> Blur with Gaussians, on a line and on a circle
// The models that came before a spherical lobe blur with these. T is float or double.
#pragma once

#include "core/special.h"
#include "core/vecmath.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace cuticle {

//> Evaluate the unit-area Gaussian $g(\beta; x)$
template <typename T>
T Gaussian(T beta, T x) {
    const T z = x / beta;
    return std::exp(-z * z / 2) / (beta * std::sqrt(2 * kPi<T>));
}
//<

//> Wrap the Gaussian around a circle
// d'Eon et al. 2011, equation 11: sum over k of g(beta; x - 2 pi k), any x, any beta > 0. Narrow: the nearest
// image and its two neighbours. Wide: Poisson's sum of the same, whose terms are the cosines damped by
// exp(-n^2 beta^2 / 2). Either is exact to 1e-16 on its side of beta = 1.1. The sum has at most 8 terms, and
// none where the circle is lit evenly to the last digit; each follows from those before it.
template <typename T>
T GaussianDetector(T beta, T x) {
    const T turn = 2 * kPi<T>, d = x - turn * std::nearbyint(x / turn);
    if (beta < T(0.35L)) // the neighbours are below exp(-40), and so is what lies beyond 9 widths
        return std::abs(d) < 9 * beta ? Gaussian(beta, d) : T(0);
    if (beta < T(1.1L))
        return Gaussian(beta, d) + Gaussian(beta, d - turn) + Gaussian(beta, d + turn);
    const T q = std::exp(-beta * beta / 2);
    T sum = T(0.5L), damping = q; // q^(n^2), where the next has a factor q^(2 n + 1)
    if (damping > std::numeric_limits<T>::epsilon() / 16) {
        T factor = q * q * q, before = 1, cosine = std::cos(d); // of n d; Chebyshev's recurrence
        const T twice = 2 * cosine;
        do {
            sum += damping * cosine;
            before = std::exchange(cosine, twice * cosine - before);
            damping *= factor, factor *= q * q;
        } while (damping > std::numeric_limits<T>::epsilon() / 16);
    }
    return sum / kPi<T>;
}
//<

//> Invert the error function
// x in (-1, 1), clamped to the nearest numbers inside: a start that is good to 2e-3 (Winitzki 2008), then two
// steps of Halley's method.
template <typename T>
T InverseErf(T x) {
    const T edge = 1 - std::numeric_limits<T>::epsilon() / 2;
    x = std::clamp(x, -edge, edge);
    const T log = std::log1p(-x * x), a = T(0.147L), b = 2 / (kPi<T> * a) + log / 2;
    T y = std::copysign(std::sqrt(std::max(T(0), std::sqrt(b * b - log / a) - b)), x);
    for (int step = 0; step < 2; ++step) {
        const T miss = (std::erf(y) - x) * std::sqrt(kPi<T>) / 2 * std::exp(y * y);
        y -= miss / (1 + y * miss);
    }
    return y;
}
//<

//> Cut a Gaussian to an interval, and draw from it
// The Gaussian has the given mean and standard deviation and is normalised on [low, high]. mass: how much of
// the whole Gaussian lies inside. Below 1e-6 the interval counts as missed: Density is 0, Sample gives the
// end nearer to the mean.
template <typename T>
class TruncatedGaussian {
  public:
    TruncatedGaussian(T mean, T sigma, T low, T high)
        : mean_(mean), sigma_(sigma), low_(low), high_(high),
          erfLow_(std::erf((low - mean) / (sigma * std::sqrt(T(2))))),
          erfHigh_(std::erf((high - mean) / (sigma * std::sqrt(T(2))))), mass((erfHigh_ - erfLow_) / 2) {}
    T Density(T x) const {
        return mass < T(1e-6L) || x < low_ || x > high_ ? T(0) : Gaussian(sigma_, x - mean_) / mass;
    }
    T Sample(T u) const {
        const T x = mean_ + sigma_ * std::sqrt(T(2)) * InverseErf(erfLow_ + u * (erfHigh_ - erfLow_));
        return std::clamp(x, low_, high_);
    }

  private:
    T mean_, sigma_, low_, high_, erfLow_, erfHigh_;

  public:
    const T mass;
};
//<

//> Stop an inclination at the poles
// A float nearest to pi/2 lies beyond it, with a negative cosine. kPole is the largest number that does not,
// of float and of double. The cosine of an inclination, from -kPole to kPole, is above 0; near the poles a
// density per steradian grows as 1 / cos, and is held where cos is kPoleCosine: less than 1e-9 of any lobe.
template <typename T>
inline constexpr T kPole = std::is_same_v<T, float> ? T(0x1.921fb4p+0) : T(0x1.921fb54442d18p+0);
template <typename T>
inline constexpr T kPoleCosine = T(1e-12L);
template <typename T>
SinCosine<T> SinCosOfInclination(T theta) {
    theta = std::clamp(theta, -kPole<T>, kPole<T>);
    return {std::sin(theta), std::max(std::cos(theta), T(0))};
}
//<

//> Draw $\theta$ with a density proportional to $\cos^2 \theta \, d\theta$
// A diffuse fiber sends this out: sin theta is a coordinate of a point that is uniform in the unit disk.
template <typename T>
SinCosine<T> SampleCosineSquared(T u, T v) {
    const T r = std::sqrt(u), a = 2 * kPi<T> * v, x = r * std::cos(a), y = r * std::sin(a);
    return {x, std::sqrt((1 - u) + y * y)};
}
//<

} // namespace cuticle
//<
