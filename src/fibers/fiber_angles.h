//> Measure directions in the frame of a fiber
#pragma once

#include "core/special.h"
#include "core/vecmath.h"

#include <cmath>

namespace cuticle {

//> Split a direction into its angles
// Unit vectors are asked for. cos theta is the length across the fiber, right also where sin theta is nearly
// 1. The azimuth stays a vector (y, z) across the fiber, of any length. Straight along the fiber (closer than
// 1e-18, where squares of floats lose their digits) it is taken as (1, 0).
template <typename T>
struct FiberAngles {
    T sinTheta, cosTheta, y, z;
    // The direction of inclination theta that lies phi further around the fiber.
    CUTICLE_INLINE Vector3<T> Turned(T sin, T cos, T sinPhi, T cosPhi) const {
        const T scale = cos / std::hypot(y, z);
        return {sin, scale * (y * cosPhi - z * sinPhi), scale * (z * cosPhi + y * sinPhi)};
    }
};
template <typename T>
CUTICLE_INLINE FiberAngles<T> AnglesOf(T x, T y, T z) {
    const T square = y * y + z * z;
    if (square < T(1e-36L))
        return {x, 0, 1, 0};
    return {x, std::sqrt(square), y, z};
}
// phi_i - phi_o as a vector of any length, its sine and cosine scaled.
template <typename T>
CUTICLE_INLINE SinCosine<T> RelativeAzimuth(const FiberAngles<T> &o, const FiberAngles<T> &i) {
    return {o.y * i.z - o.z * i.y, o.y * i.y + o.z * i.z};
}
//<

//> Bring a vector in the plane to length 1
// Takes any length, also one whose square underflows, as near total reflection; gives (1, 0) for none.
template <typename T>
CUTICLE_INLINE SinCosine<T> UnitVector(T sin, T cos) {
    const T larger = std::max(std::abs(sin), std::abs(cos));
    if (!(larger > 0))
        return {0, 1};
    const T s = sin / larger, c = cos / larger, inverse = 1 / std::sqrt(s * s + c * c);
    return {s * inverse, c * inverse};
}
//<

} // namespace cuticle
//<
