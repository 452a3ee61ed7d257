// Degrees and radians in double, where vecmath.h has them in float.
#pragma once

#include "core/vecmath.h"

namespace cuticle {

// A degree in radians.
inline constexpr double kDegree = kPi<double> / 180;
inline constexpr double Radians(double degrees) { return degrees * kPi<double> / 180; }
inline constexpr double Degrees(double radians) { return radians * 180 / kPi<double>; }

} // namespace cuticle
