//> Follow the paths through a smooth fiber
#include "fibers/smooth_fiber.h"

#include "fibers/ap.h"
#include "fibers/np.h"

#include <limits>

namespace cuticle {

//> Differentiate $\Phi$
template <typename T>
T SmoothFiber<T>::Phi(int p, T gamma) const {
    return cuticle::Phi(p, gamma, GammaT(std::sin(gamma)));
}
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
// G(gamma) = Phi - p pi runs monotonically from G(low) to G(high); phi - p pi + 2 pi k meets it for some
// whole k. The end at high belongs to the next interval.
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
// R and TT in closed form: h = -sin(phi / 2); and from sin gamma = eta' sin(gamma + psi) with psi = (phi -
// pi) / 2, which has a root while cos psi > 1 / eta', so none for |phi| < 2 asin(1 / eta'). Beyond: dPhi /
// dgamma falls steadily with |gamma|, so that Phi is monotone outside and inside of the turning points, and
// each piece is solved by itself.
template <typename T>
PathRoots<T> SmoothFiber<T>::ExactRoots(int p, T phi) const {
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

//> Solve the paper's cubic
//> Solve it for one value
// The real gamma with Value(gamma) = y, by Vieta's cosines where there are three, else by Cardano's roots.
// cubic < 0.
template <typename T>
void SolveCubic(const PathCubic<T> &f, T y, PathRoots<T> *roots) {
    const T third = f.linear / (3 * f.cubic), half = -y / (2 * f.cubic); // of x^3 + 3 third x + 2 half = 0
    const T discriminant = half * half + third * third * third;
    const auto add = [&](T gamma) {
        if (std::abs(gamma) <= kPi<T> / 2)
            roots->Add(gamma);
    };
    if (discriminant < 0) {
        const T radius = std::sqrt(-third),
                angle = std::acos(std::clamp(-half / (radius * radius * radius), T(-1), T(1)));
        for (int k = 0; k < 3; ++k)
            add(2 * radius * std::cos((angle - 2 * kPi<T> * T(k)) / 3));
    } else {
        const T s = std::cbrt(-half - std::copysign(std::sqrt(discriminant), half));
        add(s == 0 ? T(0) : s - third / s);
    }
}
//<
// Roots beyond +-pi/2 are no rays of the fiber and are left out; the paper does not say so.
template <typename T>
PathRoots<T> SmoothFiber<T>::CubicRoots(int p, T phi) const {
    PathRoots<T> roots;
    if (p == 0) {
        roots.Add(-WrapAngle(phi) / 2);
        return roots;
    }
    const PathCubic<T> f(p, etaPrime);
    const T turn = 2 * kPi<T>, edge = kPi<T> / 2, target = WrapAngle(phi) - T(p) * kPi<T>;
    const T most = std::max(std::abs(f.Value(edge)), std::abs(f.Value(std::min(f.TurningPoint(), edge))));
    for (T y = target + turn * std::ceil((-most - target) / turn); y <= most; y += turn)
        SolveCubic(f, y, &roots);
    return roots;
}
//> Polish its roots
// Four steps of Newton's method on the exact Phi, each root kept on its own side of the turning points. What
// then does not solve the equation was no root: next to a turning point the cubic's may have no exact
// companion.
template <typename T>
PathRoots<T> SmoothFiber<T>::Polish(int p, T phi, const PathRoots<T> &cubic) const {
    if (p == 0)
        return cubic;
    PathRoots<T> roots;
    const T cubicTurn = PathCubic<T>(p, etaPrime).TurningPoint(), turn = TurningPoint(p), edge = kPi<T> / 2;
    for (size_t r = 0; r < cubic.count; ++r) {
        T gamma = cubic.gamma[r];
        const bool inside = p < 2 || std::abs(gamma) < cubicTurn;
        const T low = inside      ? -turn
                      : gamma < 0 ? -edge
                                  : turn,
                high = inside      ? turn
                       : gamma < 0 ? -turn
                                   : edge;
        for (int step = 0; step < 4; ++step) {
            gamma = std::clamp(gamma, low, high);
            const T miss = WrapAngle(Phi(p, gamma) - phi);
            const T slope = PhiSlope(p, gamma);
            if (slope != 0)
                gamma -= miss / slope;
        }
        gamma = std::clamp(gamma, low, high);
        if (std::abs(WrapAngle(Phi(p, gamma) - phi)) < 4 * std::sqrt(std::numeric_limits<T>::epsilon()))
            roots.Add(gamma);
    }
    return roots;
}
//<
//<

//> Find the roots, and what each of them weighs
template <typename T>
PathRoots<T> SmoothFiber<T>::Roots(int p, T phi, RootMethod method) const {
    if (method == RootMethod::Exact)
        return ExactRoots(p, phi);
    const PathRoots<T> cubic = CubicRoots(p, phi);
    return method == RootMethod::Cubic ? cubic : Polish(p, phi, cubic);
}
template <typename T>
T SmoothFiber<T>::Density(int p, T gamma, RootMethod method) const {
    const T slope = method == RootMethod::Cubic ? PathCubic<T>(p, etaPrime).Slope(gamma) : PhiSlope(p, gamma);
    // A gamma rounded beyond pi/2 has no negative cosine.
    return std::max(T(0), std::cos(gamma)) /
           (2 * std::max(std::abs(slope), std::sqrt(std::numeric_limits<T>::epsilon())));
}
//<

//> Attenuate one path of the smooth fiber
// Uses the root and the pair of reflectances of chapter 6, for one number of segments at a time.
// One ray: Fresnel's reflectance, and each colour's transmittance of a segment.
template <typename T>
struct SmoothFiber<T>::Passage {
    FresnelPair<T> fresnel;
    std::array<T, 3> depth; // -log of the transmittance
};
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

//> Attenuate a path whose polarisation is followed
// All bounces inside a circle have the same angles, so that a path's amplitudes are a product of 2 x 2
// matrices, T Q (D Q)^(p-1) T: D and T hold the amplitudes of the two polarisations at a bounce, Q turns one
// plane of incidence to the next, by 2 atan2(tan gamma_t, sin theta_t). Unpolarised light takes half of the
// sum of squares.
template <typename T>
T SmoothFiber<T>::PolarisedShare(int p, T gamma) const {
    const Refraction<T> inside =
        Refract(cosTheta_, std::sin(gamma), std::cos(gamma), eta_, (eta_ - 1) * (eta_ + 1));
    const T c = inside.cosIncident, ec = eta_ * eta_ * c, t = inside.t;
    const std::array<T, 2> reflected = {(c - t) / (c + t), (ec - t) / (ec + t)};
    if (p == 0)
        return (Sqr(reflected[0]) + Sqr(reflected[1])) / 2;
    const std::array<T, 2> refracted = {2 * std::sqrt(c * t) / (c + t), 2 * std::sqrt(ec * t) / (ec + t)};
    // tan gamma_t / sin theta_t = (a / t) / (sin theta / eta)
    const T sinTheta = std::sqrt(std::max(T(0), (1 - cosTheta_) * (1 + cosTheta_)));
    const T psi = 2 * std::atan2(eta_ * inside.a, sinTheta * t), cosPsi = std::cos(psi),
            sinPsi = std::sin(psi);
    std::array<std::array<T, 2>, 2> amplitude = {{{refracted[0], 0}, {0, refracted[1]}}};
    for (int k = 1; k <= p; ++k) {
        const std::array<T, 2> &bounce = k == p ? refracted : reflected;
        for (size_t i = 0; i < 2; ++i) {
            const T s = amplitude[0][i], q = amplitude[1][i];
            amplitude[0][i] = bounce[0] * (cosPsi * s - sinPsi * q);
            amplitude[1][i] = bounce[1] * (sinPsi * s + cosPsi * q);
        }
    }
    return (Sqr(amplitude[0][0]) + Sqr(amplitude[0][1]) + Sqr(amplitude[1][0]) + Sqr(amplitude[1][1])) / 2;
}
//<

template class SmoothFiber<float>;
template class SmoothFiber<double>;
template class SmoothFiber<long double>;

} // namespace cuticle
//<
