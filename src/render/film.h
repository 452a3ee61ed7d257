// The film: every pixel's sum of samples, and of their squares for the variance.
#pragma once

#include "images/image.h"
#include "parser/scene_description.h"
#include "render/binned_sum.h"

#include <optional>
#include <string>
#include <vector>

namespace cuticle {

// Overrides from the command line.
struct FilmOptions {
    std::optional<std::array<float, 4>> crop = {}; // x0 x1 y0 y1, fractions of the picture
    bool quick = false;    // a quarter of the resolution in each direction, as pbrt's --quick
    bool variance = false; // keep what the variance needs
};

// The samples first, ..., last - 1 of every pixel.
struct SampleRange {
    int first = 0, last = 0;
    int Count() const { return last - first; }
};

// The render that a film's samples are taken from. Films of one render can be merged.
struct RenderIdentity {
    std::string scene;      // the file's name and size
    std::string integrator; // its name
    int spp = 0;            // of the whole render
    uint64_t seed = 0;
    std::string ToString() const;
    bool operator==(const RenderIdentity &) const = default;
};

// pbrt-v3's Film "image". Pixels are independent of one another: the reconstruction filter is sampled
// (render/filter.h) instead of splatted, so no sample touches a second pixel and each pixel's variance is its
// own.
//
// A pixel's sums do not depend on the order of its samples (render/binned_sum.h): samples taken apart, by
// whatever threads, jobs or machines, and merged in whatever order, give the picture of one render bit for
// bit. Sums are exact where all samples of the pixel are below 2^16 and multiples of 2^-62 (any above 2^-39
// is); else it is as if each sample were cut below 2^-39 of the pixel's largest one, its square below 2^-78.
//
// A pixel takes 56 bytes, and 80 more with the variance.
class Film {
  public:
    Film(const Entity &entity, const FilmOptions &options);

    Point2i Resolution() const { return resolution_; }
    // The rendered window in pixels: x0 <= x < x1, y0 <= y < y1.
    Point2i WindowMin() const { return min_; }
    Point2i WindowMax() const { return max_; }
    Point2i WindowSize() const { return {max_.x - min_.x, max_.y - min_.y}; }
    size_t Pixels() const { return pixels_.size(); } // of the window
    bool HasVariance() const { return !squares_.empty(); }
    const std::string &Filename() const { return filename_; }

    // Says which samples of which render this film is going to take; without it, it takes part of no render.
    void Expect(const RenderIdentity &render, const SampleRange &samples);
    // Adds one weighted radiance to pixel (x, y), at most 2^24 to each. A value that is not finite is left
    // out and false returned: the caller counts and reports it. Different pixels may be added to from
    // different threads.
    bool Add(int x, int y, const Spectrum &radiance);
    // Adds the samples of another film of the same render. Throws Error, and changes nothing, where the other
    // is of another scene, size, window or sampling, or where both took the same sample.
    void Merge(const Film &other);

    // The picture, scaled by the film's "scale"; where the film keeps the variance, with channels
    // "variance.R" ... (of the pixel's mean, estimated from the spread of its samples; low-discrepancy
    // sampling makes the true one smaller).
    Image Develop() const;
    // The smallest number of samples that any pixel of the window holds.
    int MinSamples() const;

  private:
    struct Pixel {
        [[no_unique_address]] BinnedSums<3, 2, 16> sums;
        uint32_t n = 0;
    };
    using Squares = BinnedSums<3, 3, 32>;
    static_assert(sizeof(Pixel) == 56 && sizeof(Squares) == 80);

    void SetWindow(const ParamSet &params, std::array<float, 4> crop);

    Point2i resolution_, min_, max_;
    std::string filename_;
    double scale_;
    float maxLuminance_;
    RenderIdentity render_;
    std::vector<SampleRange> samples_; // expected, in order, apart from one another
    std::vector<Pixel> pixels_;        // of the window, row by row
    std::vector<Squares> squares_;     // the sums of squares; empty where no variance is asked for
};

// Claims the memory of a film (core/memory_budget.h) before it is made, and before a scene is built for it. A
// crop window counts by its share of the picture.
void ClaimFilm(const Entity &entity, const FilmOptions &options);

} // namespace cuticle
