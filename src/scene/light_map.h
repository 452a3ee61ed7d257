// LightMap: the picture of a light, as infinite, goniometric and projection lights show it.
#pragma once

#include "core/check.h"
#include "core/color.h"
#include "core/vecmath.h"
#include "parser/param_set.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cuticle {

// (phi / 2 pi, theta / pi) of a direction of any length, theta from +z, phi from +x; each in [0, 1).
Point2f SphericalMapPoint(const Vector3f &w);

// A picture with v down its rows. As in pbrt-v3, values of 8-bit files are taken as linear.
class LightMap {
  public:
    // Around: the left and the right border are one, as in a map of the sphere. Held: all borders are ends.
    enum class Border { Around, Held };

    // Reads the file that "mapname" names, times scale; without that parameter the map is scale everywhere.
    // Error at the parameter when the file cannot be used. Values below 0, NaN or above kMaxLightValue
    // become 0, with a Warning.
    LightMap(const ParamSet &params, const Spectrum &scale, Border border);

    size_t Width() const { return width_; }
    size_t Height() const { return height_; }
    // The value at (u, v): bilinear between texel centres, held at the borders that are not one.
    Spectrum Lookup(float u, float v) const {
        const auto clamped = [](float x, float size) { return std::clamp(x * size - 0.5f, 0.f, size - 1); };
        const bool around = border_ == Border::Around;
        const float width = static_cast<float>(width_), height = static_cast<float>(height_);
        const float x = around ? u * width - 0.5f : clamped(u, width), y = clamped(v, height);
        const float xFloor = std::floor(x), yFloor = std::floor(y), fx = x - xFloor, fy = y - yFloor;
        const size_t x0 = around ? static_cast<size_t>(xFloor + width) % width_ : static_cast<size_t>(xFloor);
        const size_t x1 = around ? (x0 + 1) % width_ : std::min(x0 + 1, width_ - 1);
        const size_t y0 = static_cast<size_t>(yFloor), y1 = std::min(y0 + 1, height_ - 1);
        return (Texel(x0, y0) * (1 - fx) + Texel(x1, y0) * fx) * (1 - fy) +
               (Texel(x0, y1) * (1 - fx) + Texel(x1, y1) * fx) * fy;
    }
    // The mean of Lookup over all directions, the map being one of the sphere.
    Spectrum MeanOverSphere() const;

  private:
    const Spectrum &Texel(size_t x, size_t y) const {
        const size_t i = y * width_ + x;
        DCHECK_LT(i, texels_.size());
        return texels_[i];
    }

    size_t width_ = 1, height_ = 1;
    Border border_ = Border::Held;
    std::vector<Spectrum> texels_;
};

} // namespace cuticle
