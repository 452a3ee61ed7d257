//> Trace the paths through a smooth fiber
// What the far-field models are made of: a clear or tinted circular cylinder without roughness, seen from one
// inclination, all offsets h at once. T is float, double or long double.
#pragma once

#include "fibers/hair_model.h"

#include <array>
#include <cmath>

namespace cuticle {

//> Tabulate a Gauss-Legendre rule
// Nodes in (-1, 1), rising; weights add up to 2. Computed once, by Newton's method on the Legendre polynomial.
template <size_t n>
struct GaussLegendreRule {
    std::array<double, n> x, w;
};
template <size_t n>
const GaussLegendreRule<n> &GaussLegendre() {
    static const GaussLegendreRule<n> rule = [] {
        GaussLegendreRule<n> r;
        for (size_t i = 0; i < n; ++i) {
            double x = -std::cos(kPi<double> * (static_cast<double>(i) + 0.75) / (n + 0.5)), slope = 0;
            for (int step = 0; step < 20; ++step) {
                double before = 1, p = x;
                for (size_t k = 2; k <= n; ++k) {
                    const double m = static_cast<double>(k),
                                 next = ((2 * m - 1) * x * p - (m - 1) * before) / m;
                    before = p, p = next;
                }
                slope = static_cast<double>(n) * (x * p - before) / (x * x - 1);
                x -= p / slope;
            }
            r.x[i] = x, r.w[i] = 2 / ((1 - x * x) * slope * slope);
        }
        return r;
    }();
    return rule;
}
//<

//> Choose the length of a segment
// Chord: 2 cos gamma_t radii over cos theta_t. Printed: 2 (1 + cos 2 gamma_t) over cos theta_t, as Marschner et al. 2003 and
// d'Eon et al. 2011 have it: the square of the chord, 4 radii where the fiber is 2 thick. For comparison only.
enum class SegmentLength { Chord, Printed };
//<

//> Collect the roots of $\Phi(p, h) = \phi$
// As angles of incidence gamma, h = sin gamma.
template <typename T>
struct PathRoots {
    static constexpr size_t kMost = 24;
    std::array<T, kMost> gamma;
    size_t count = 0;
    void Add(T g) {
        if (count < kMost)
            gamma[count++] = g;
    }
};
//<

//> Declare the smooth fiber
template <typename T>
class SmoothFiber {
  public:
    // cosTheta: cosine of the inclination, (0, 1]; below 1e-6 taken as that. eta > 1: relative index of refraction.
    SmoothFiber(T cosTheta, T eta)
        : cosTheta_(std::max(cosTheta, T(1e-6L))), eta_(eta),
          etaPrime(std::sqrt((eta - 1) * (eta + 1) + Sqr(cosTheta_)) / cosTheta_) {}

    // The net turn of path p that meets the fiber at gamma, not wrapped, and its derivative by gamma.
    T Phi(int p, T gamma) const { return cuticle::Phi(p, gamma, GammaT(std::sin(gamma))); }
    T PhiSlope(int p, T gamma) const;
    T GammaT(T h) const { return std::asin(h / etaPrime); }
    // The second derivative of Phi by h.
    T PhiCurvature(int p, T h) const;
    // The positive gamma at which path p turns back, where dPhi / dgamma = 0: the caustic. Pi/2 where it never does.
    T TurningPoint(int p) const;

    // All gamma in [-pi/2, pi/2] whose path p leaves at phi (any angle; modulo 2 pi).
    PathRoots<T> Roots(int p, T phi) const;

    // The share of light on path p, per colour, at offset sin gamma: A_p. And on all paths from p on.
    std::array<T, 3> Attenuation(int p, T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;
    std::array<T, 3> Tail(int p, T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;

  private:
    struct Passage { // of one ray: Fresnel's reflectance, and each colour's transmittance of a segment
        FresnelPair<T> fresnel;
        std::array<T, 3> depth; // -log of the transmittance
    };
    Passage Pass(T gamma, const std::array<T, 3> &sigmaA, SegmentLength length) const;
    T cosTheta_, eta_;

  public:
    const T etaPrime;
};
//<

//> Differentiate $\Phi$
template <typename T>
T SmoothFiber<T>::PhiSlope(int p, T gamma) const {
    const T h = std::sin(gamma), cosGammaT = std::sqrt(std::max(T(0), 1 - Sqr(h / etaPrime)));
    return 2 * T(p) * std::cos(gamma) / (etaPrime * cosGammaT) - 2;
}
template <typename T>
T SmoothFiber<T>::PhiCurvature(int p, T h) const {
    const T cos2GammaT = 1 - Sqr(h / etaPrime), cos2GammaO = 1 - h * h;
    return 2 * T(p) * h / (etaPrime * etaPrime * etaPrime * cos2GammaT * std::sqrt(cos2GammaT)) -
           2 * h / (cos2GammaO * std::sqrt(cos2GammaO));
}
//<

//> Find where a path turns back
// Descartes' rainbow, for any number p of segments: h^2 = (p^2 - eta'^2) / (p^2 - 1).
template <typename T>
T SmoothFiber<T>::TurningPoint(int p) const {
    const T square = T(p) * T(p);
    if (p < 2)
        return kPi<T> / 2;
    if (etaPrime >= T(p))
        return 0;
    return std::asin(std::sqrt((square - Sqr(etaPrime)) / (square - 1)));
}
//<

//> Solve $\Phi(p, h) = \phi$ exactly
//> Solve for one root where $\Phi$ is monotone
// target between the values at low and high. Newton's method, which a bracket keeps from going astray.
template <typename T, typename F, typename Slope>
T SolveMonotone(F f, Slope slope, T low, T high, bool rising, T target) {
    T x = (low + high) / 2;
    for (int step = 0; step < 100; ++step) {
        const T miss = f(x) - target;
        ((miss < 0) == rising ? low : high) = x;
        T next = x - miss / slope(x);
        if (!(next > low && next < high))
            next = (low + high) / 2;
        if (std::abs(next - x) <= 4 * std::numeric_limits<T>::epsilon() * (T(0.1L) + std::abs(x)))
            return next;
        x = next;
    }
    return x;
}
//<
//> Solve on an interval, for every turn of the circle
// G(gamma) = Phi - p pi runs monotonically from G(low) to G(high); phi - p pi + 2 pi k meets it for some whole k. The
// end at high belongs to the next interval.
template <typename T, typename F, typename Slope>
void SolveOnInterval(F g, Slope slope, T low, T high, T target, PathRoots<T> *roots) {
    if (!(high > low))
        return;
    const T gLow = g(low), gHigh = g(high), turn = 2 * kPi<T>;
    const bool rising = gHigh > gLow;
    const T least = std::min(gLow, gHigh), most = std::max(gLow, gHigh);
    for (T y = target + turn * std::ceil((least - target) / turn); y <= most; y += turn)
        if (y == gLow)
            roots->Add(low);
        else if (y != gHigh)
            roots->Add(SolveMonotone(g, slope, low, high, rising, y));
}
//<
// R and TT in closed form: h = -sin(phi / 2); and from sin gamma = eta' sin(gamma + psi) with psi = (phi - pi) / 2,
// which has a root while cos psi > 1 / eta', so none for |phi| < 2 asin(1 / eta'). Beyond: dPhi / dgamma falls
// steadily with |gamma|, so that Phi is monotone outside and inside of the turning points, and each piece is solved by
// itself.
template <typename T>
PathRoots<T> SmoothFiber<T>::Roots(int p, T phi) const {
    PathRoots<T> roots;
    phi = WrapAngle(phi);
    if (p == 0) {
        roots.Add(-phi / 2);
    } else if (p == 1) {
        const T psi = (phi - std::copysign(kPi<T>, phi)) / 2, a = 1 / etaPrime;
        if (std::cos(psi) > a)
            roots.Add(std::atan2(-std::sin(psi), std::cos(psi) - a));
    } else {
        const auto g = [&](T gamma) { return Phi(p, gamma) - T(p) * kPi<T>; };
        const auto slope = [&](T gamma) { return PhiSlope(p, gamma); };
        const T turn = TurningPoint(p), edge = kPi<T> / 2, target = phi - T(p) * kPi<T>;
        SolveOnInterval(g, slope, -edge, -turn, target, &roots);
        SolveOnInterval(g, slope, -turn, turn, target, &roots);
        SolveOnInterval(g, slope, turn, edge, target, &roots);
    }
    return roots;
}
//<

//> Attenuate one path of the smooth fiber
// By the root and the pair of reflectances of chapter 6, for one number of segments at a time.
template <typename T>
typename SmoothFiber<T>::Passage SmoothFiber<T>::Pass(T gamma, const std::array<T, 3> &sigmaA,
                                                      SegmentLength length) const {
    const Refraction<T> inside =
        Refract(cosTheta_, std::sin(gamma), std::cos(gamma), eta_, (eta_ - 1) * (eta_ + 1));
    T way = inside.length;
    if (length == SegmentLength::Printed)
        way *= 2 * inside.t / std::sqrt(Sqr(inside.t) + Sqr(inside.a));
    return {Fresnel(inside.cosIncident, inside.t, eta_), {sigmaA[0] * way, sigmaA[1] * way, sigmaA[2] * way}};
}
template <typename T>
std::array<T, 3> SmoothFiber<T>::Attenuation(int p, T gamma, const std::array<T, 3> &sigmaA,
                                             SegmentLength length) const {
    const Passage passage = Pass(gamma, sigmaA, length);
    if (p == 0)
        return {passage.fresnel.f, passage.fresnel.f, passage.fresnel.f};
    T share = Sqr(passage.fresnel.oneMinusF);
    for (int k = 1; k < p; ++k)
        share *= passage.fresnel.f;
    std::array<T, 3> a;
    for (size_t c = 0; c < 3; ++c)
        a[c] = share * std::exp(-T(p) * passage.depth[c]);
    return a;
}
// A_p / (1 - F T), the quotient in the form that has a limit at the rim of a clear fiber. p >= 1.
template <typename T>
std::array<T, 3> SmoothFiber<T>::Tail(int p, T gamma, const std::array<T, 3> &sigmaA,
                                      SegmentLength length) const {
    const Passage passage = Pass(gamma, sigmaA, length);
    T share = passage.fresnel.oneMinusF;
    for (int k = 1; k < p; ++k)
        share *= passage.fresnel.f;
    std::array<T, 3> a;
    for (size_t c = 0; c < 3; ++c) {
        const T rest = passage.fresnel.oneMinusF - passage.fresnel.f * std::expm1(-passage.depth[c]);
        a[c] = share * std::exp(-T(p) * passage.depth[c]) * passage.fresnel.oneMinusF /
               std::max(rest, T(1e-30L));
    }
    return a;
}
//<

//> Average over the width of the fiber
// The mean over h in [-1, 1] of an even function of gamma, by n nodes: dh = cos gamma dgamma.
template <size_t n, typename T, typename F>
std::array<T, 3> MeanOverWidth(F f) {
    std::array<T, 3> sum = {0, 0, 0};
    const GaussLegendreRule<n> &rule = GaussLegendre<n>();
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
