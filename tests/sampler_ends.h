// The ends of [0,1), where samplers fail first, and what a sampler may answer there: for the laws "Ends" of
// every room that draws samples, one law a kind, its rows from the table of the kind.
#pragma once

#include "core/color.h"
#include "core/vecmath.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace cuticle {

// Random numbers at the ends of [0,1), at the middle, where samplers change branches, and two that are
// nothing special.
inline constexpr float kEndsOfU[] = {0,    0x1p-33f, 0x1p-24f, 0.25f,        0.5f - 0x1p-25f,
                                     0.5f, 0.618f,   0.75f,    1 - 0x1p-20f, OneMinusEpsilon};

// Calls back with each pair of them.
template <class F>
void ForEachEnd(F each) {
    for (const float x : kEndsOfU)
        for (const float y : kEndsOfU)
            each(Point2f(x, y));
}

// Says what is wrong with a value and its density; empty if nothing is.
inline std::string FaultOf(const Spectrum &f, float pdf) {
    if (!std::isfinite(pdf) || pdf < 0)
        return fmt::format("density {}", pdf);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(f[i]) || f[i] < 0)
            return fmt::format("value {}", f[i]);
    return {};
}
inline bool IsUnit(const Vector3f &w) { return std::abs(w.Length() - 1) < 2e-6f; }

} // namespace cuticle
