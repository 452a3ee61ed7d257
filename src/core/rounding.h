// Bounds of rounding errors.
#pragma once

#include "core/vecmath.h"

namespace cuticle {

template <typename T>
Vector3<T> Abs(const Vector3<T> &v) {
    return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}
// Returns a bound, for each coordinate, of what rounding p to single precision changes, with room for the
// double's last bits.
inline Vector3f RoundingError(const Vector3d &p) { return Vector3f(Abs(p) * 0x1.01p-24); }

} // namespace cuticle
