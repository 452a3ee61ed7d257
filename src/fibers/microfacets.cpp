//> Define a rough surface of microfacets
#include "fibers/microfacets.h"

namespace cuticle {

Microfacets::Microfacets(MicrofacetDistribution distribution, double alphaX, double alphaY)
    : distribution_(distribution), alphaX_(std::max(alphaX, 1e-4)), alphaY_(std::max(alphaY, 1e-4)) {}

//> Compute Smith's $\Lambda$
// a is the slope of w in units of the roughness that it sees, with the sign of w.z; the formulas of Walter et
// al. 2007 then hold below the horizon as well, where Lambda(-w) = -1 - Lambda(w).
double Microfacets::Lambda(const Vector3d &w) const {
    const double across = std::hypot(w.x * alphaX_, w.y * alphaY_);
    const double slope = across > 0 ? w.z / across : std::copysign(1e12, w.z);
    const double a = std::copysign(std::max(std::abs(slope), 1e-12), slope);
    if (distribution_ == MicrofacetDistribution::GGX)
        return (-1 + std::copysign(std::sqrt(1 + 1 / (a * a)), a)) / 2;
    const double inverseRootPi = std::numbers::inv_sqrtpi;
    const double away = a > 0 ? -std::erfc(a) : std::erf(a) - 1;
    return (away + std::exp(-a * a) / a * inverseRootPi) / 2;
}
//<

//> Walk to the next height
// The share of the surface that lies below h is c = (h + 1) / 2. A ray that climbs from there leaves with
// probability c^Lambda; else, and always when it falls, the height where it ends follows from inverting the
// same power.
double Microfacets::NextHeight(const Vector3d &w, double h, double u) const {
    const double c = std::clamp((h + 1) / 2, 0., 1.), lambda = Lambda(w);
    if (w.z > 0 && u >= 1 - std::pow(c, lambda))
        return 2;
    return std::clamp(2 * c * std::pow(1 - u, -1 / lambda) - 1, -1., 1.);
}
//<

//> Sample a slope of Beckmann's distribution that is visible at cotangent $c$
// The density of the slope x along the direction of view is (c - x) exp(-x^2) for x < c; its integral from
// minus infinity is g(x) = c erfc(-x) / 2 + exp(-x^2) / (2 sqrt(pi)). Newton's method, kept inside a
// shrinking bracket.
static double VisibleBeckmannSlope(double c, double u) {
    const auto g = [c](double x) {
        return c * std::erfc(-x) / 2 + std::exp(-x * x) * std::numbers::inv_sqrtpi / 2;
    };
    double low = std::min(c, 0.) - 7, high = std::min(c, 7.);
    const double target = u * g(high);
    double x = c > 1 ? 0 : c > 0 ? (c - 1) / 2 : c - 1 / (2 - 2 * c);
    for (int step = 0; step < 60; ++step) {
        const double miss = g(x) - target;
        if (std::abs(miss) <= 1e-10 * target)
            break;
        (miss < 0 ? low : high) = x;
        x -= miss / ((c - x) * std::exp(-x * x) * std::numbers::inv_sqrtpi);
        if (!(x > low && x < high))
            x = (low + high) / 2;
    }
    return x;
}
//<

//> Sample a visible normal
Vector3d Microfacets::VisibleNormal(const Vector3d &toward, double u0, double u1) const {
    // Stretched by its roughness, the surface has roughness 1 all around.
    const Vector3d v = Normalize(Vector3d(alphaX_ * toward.x, alphaY_ * toward.y, toward.z));
    const double angle = 2 * kPi<double> * u1;
    if (distribution_ == MicrofacetDistribution::GGX) {
        // GGX of roughness 1 is a hemisphere. Its mirror images of one direction fill a cap evenly (Dupuy and
        // Benyoub 2023), and the normal halves the angle.
        const double z = (1 - u0) * (1 + v.z) - v.z, r = std::sqrt(std::max(0., (1 - z) * (1 + z)));
        const Vector3d half = Vector3d(r * std::cos(angle), r * std::sin(angle), z) + v;
        return Normalize(Vector3d(alphaX_ * half.x, alphaY_ * half.y, std::max(half.z, 1e-12)));
    }
    // Gaussian slopes along the view and across it are independent, and only the first shows or hides a
    // facet.
    const double sinTheta = std::hypot(v.x, v.y);
    const double cosPhi = sinTheta > 0 ? v.x / sinTheta : 1, sinPhi = sinTheta > 0 ? v.y / sinTheta : 0;
    const double e =
        std::sqrt(-std::log(u0)); // a second pair of numbers out of one: the Box-Muller transform
    const double across = e * std::cos(angle), uniform = std::erfc(-e * std::sin(angle)) / 2;
    const double along = VisibleBeckmannSlope(std::min(v.z / std::max(sinTheta, 1e-9), 1e8), uniform);
    const double slopeX = along * cosPhi - across * sinPhi, slopeY = along * sinPhi + across * cosPhi;
    return Normalize(Vector3d(-alphaX_ * slopeX, -alphaY_ * slopeY, 1));
}
//<

} // namespace cuticle
//<
