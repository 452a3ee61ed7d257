//> Trace the paths through a smooth fiber
// The far-field models are made of this: a clear or tinted circular cylinder without roughness, seen from one
// inclination, all offsets h at once. T is float, double or long double (smooth_fiber.cpp compiles these).
#pragma once

#include "core/quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

//> Choose the length of a segment
// Chord: 2 cos gamma_t radii over cos theta_t. Printed: 2 (1 + cos 2 gamma_t) over cos theta_t, as Marschner
// et al. 2003 and d'Eon et al. 2011 have it: the square of the chord, 4 radii where the fiber is 2 thick. For
// comparison only.
enum class SegmentLength { Chord, Printed };
//<

//> Collect the roots of $\Phi(p, h) = \phi$
// As angles of incidence gamma, h = sin gamma.
template <typename T>
struct PathRoots {
    static constexpr size_t kMaxCount = 24;
    std::array<T, kMaxCount> gamma;
    size_t count = 0;
    void Add(T g) {
        if (count < kMaxCount)
            gamma[count++] = g;
    }
};
//<

//> Choose how roots are found
// Exact: all of them. Cubic: Marschner et al. 2003, section 5.2.1, a cubic in place of Snell's law, which is
// off by up to 0.7 degrees of gamma_t at eta' = 1.5 and 1.7 at 1.3. PolishedCubic: the cubic's roots, moved
// onto the exact Phi.
enum class RootMethod { Exact, Cubic, PolishedCubic };
//<

//> Declare the smooth fiber
template <typename T>
class SmoothFiber {
  public:
    // cosTheta: cosine of the inclination, (0, 1]; below 1e-6 taken as that. eta > 1: relative index of
    // refraction.
    SmoothFiber(T cosTheta, T eta)
        : cosTheta_(std::max(cosTheta, T(1e-6L))), eta_(eta),
          etaPrime(std::sqrt((eta - 1) * (eta + 1) + Sqr(cosTheta_)) / cosTheta_) {}

    // The net turn of path p that meets the fiber at gamma, not wrapped, and its derivative by gamma.
    T Phi(int p, T gamma) const;
    T PhiSlope(int p, T gamma) const;
    T GammaT(T h) const { return std::asin(h / etaPrime); }
    // The second derivative of Phi by h.
    T PhiCurvature(int p, T h) const;
    // The positive gamma at which path p turns back, where dPhi / dgamma = 0: the caustic. Pi/2 where it
    // never does.
    T TurningPoint(int p) const;

    // All gamma in [-pi/2, pi/2] whose path p leaves at phi (any angle; modulo 2 pi).
    PathRoots<T> Roots(int p, T phi, RootMethod method = RootMethod::Exact) const;
    // Half of |dh / dPhi| at a root: the density of phi where h is uniform over the width. At a turning
    // point, where it is infinite, 1 / (2 sqrt(epsilon)).
    T Density(int p, T gamma, RootMethod method = RootMethod::Exact) const;

    // The share of light on path p, per colour, at offset sin gamma: A_p. And on all paths from p on.
    std::array<T, 3> Attenuation(int p, T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;
    std::array<T, 3> Tail(int p, T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;
    // A_p of a clear fiber for unpolarised light whose polarisation is followed, not averaged at each bounce.
    T PolarisedShare(int p, T gamma) const;

  private:
    struct Passage; // of one ray: what is reflected, and what a segment absorbs
    Passage Pass(T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;
    PathRoots<T> ExactRoots(int p, T phi) const;
    PathRoots<T> CubicRoots(int p, T phi) const;
    PathRoots<T> Polish(int p, T phi, const PathRoots<T> &cubic) const;
    T cosTheta_, eta_;

  public:
    const T etaPrime;
};
//<

//> Write the cubic
// gamma_t ~ (3 c / pi) gamma - (4 c / pi^3) gamma^3 with c = asin(1 / eta'), exact in value and slope at
// +-pi/2. So Phi - p pi ~ linear gamma + cubic gamma^3.
template <typename T>
struct PathCubic {
    PathCubic(int p, T etaPrime) {
        const T c = std::asin(1 / etaPrime);
        linear = 6 * T(p) * c / kPi<T> - 2;
        cubic = -8 * T(p) * c / (kPi<T> * kPi<T> * kPi<T>);
    }
    T Value(T gamma) const { return gamma * (linear + cubic * gamma * gamma); }
    T Slope(T gamma) const { return linear + 3 * cubic * gamma * gamma; }
    // The positive gamma where it turns back; 0 where it falls throughout.
    T TurningPoint() const { return linear > 0 ? std::sqrt(linear / (-3 * cubic)) : T(0); }
    T linear, cubic;
};
//<

//> Average over the width of the fiber
// The mean over h in [-1, 1] of an even function of gamma, by n nodes: dh = cos gamma dgamma.
template <size_t n, typename T, typename F>
std::array<T, 3> MeanOverWidth(F f) {
    std::array<T, 3> sum = {0, 0, 0};
    const GaussLegendreRule &rule = GaussLegendre(n);
    for (size_t i = 0; i < n; ++i) {
        const T gamma = kPi<T> / 4 * (1 + T(rule.x[i])), weight = kPi<T> / 4 * T(rule.w[i]) * std::cos(gamma);
        const std::array<T, 3> value = f(gamma);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += weight * value[c];
    }
    return sum;
}
//<

} // namespace cuticle
//<
