// The film: every pixel's sum of samples, and of their squares for the variance.
#pragma once

#include "images/image.h"
#include "parser/scene_description.h"

#include <optional>

namespace cuticle {

// Overrides from the command line.
struct FilmOptions {
    std::optional<std::array<float, 4>> crop; // x0 x1 y0 y1, fractions of the picture
    bool quick = false; // a quarter of the resolution in each direction, as pbrt's --quick
};

// pbrt-v3's Film "image". Pixels are independent of one another: the reconstruction filter is sampled
// (render/filter.h) instead of splatted, so no sample touches a second pixel, the sum does not depend on the
// order of threads, and each pixel's variance is its own.
class Film {
  public:
    Film(const Entity &entity, const FilmOptions &options);

    Point2i Resolution() const { return resolution_; }
    // The rendered window in pixels: x0 <= x < x1, y0 <= y < y1.
    Point2i WindowMin() const { return min_; }
    Point2i WindowMax() const { return max_; }
    Point2i WindowSize() const { return {max_.x - min_.x, max_.y - min_.y}; }
    size_t Pixels() const { return pixels_.size(); } // of the window
    const std::string &Filename() const { return filename_; }

    // Adds one weighted radiance to pixel (x, y). A value that is not finite is left out and false returned:
    // the caller counts and reports it. Different pixels may be added to from different threads.
    bool Add(int x, int y, const Spectrum &radiance);

    // The picture, scaled by the film's "scale"; with variance channels "variance.R" ... (of the pixel's
    // mean, estimated from the spread of its samples; low-discrepancy sampling makes the true one smaller) on
    // request.
    Image Develop(bool variance) const;
    // The smallest number of samples that any pixel of the window holds.
    int MinSamples() const;

  private:
    struct Pixel {
        std::array<double, 3> sum{}, sumSquares{};
        uint32_t n = 0;
    };
    Point2i resolution_, min_, max_;
    std::string filename_;
    double scale_;
    float maxLuminance_;
    std::vector<Pixel> pixels_;
};

} // namespace cuticle
