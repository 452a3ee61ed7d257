// The film: every pixel's sum of samples, and of their squares for the variance.
#pragma once

#include "images/image.h"
#include "parser/scene_description.h"
#include "render/binned_sum.h"
#include "render/denoise.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cuticle {

// Overrides from the command line.
struct FilmOptions {
    std::optional<std::array<float, 4>> crop = {}; // x0 x1 y0 y1, fractions of the picture
    bool quick = false;               // a quarter of the resolution in each direction, as pbrt's --quick
    bool variance = false;            // keep what the variance needs
    std::optional<bool> denoise = {}; // keep what denoising needs; default: the Film's
                                      // "denoise", where no variance is asked for
    int shrink = 1;                   // this fraction of the resolution each way; at least 1
    int Divisor() const { return quick ? 4 * shrink : shrink; } // of the resolution
};

// The samples first, ..., last - 1 of every pixel.
struct SampleRange {
    int first = 0, last = 0;
    int Count() const { return last - first; }
    bool operator==(const SampleRange &) const = default;
};

// The render that a film's samples are taken from: all that determines its picture besides the film's own
// size, window and scale. Films of one render can be merged.
struct RenderIdentity {
    // The causes of the picture, by names that a user knows ("seed", "hair-model"), each with its value.
    std::vector<std::pair<std::string, std::string>> facts;

    // Says in what another one differs from this one first, as "the seed is 1, not 2"; "" where in nothing.
    std::string Difference(const RenderIdentity &other) const;
    bool operator==(const RenderIdentity &) const = default;
};

// The piece of a film that one thread works on: this many pixels to a side, or what is left at its edges.
inline constexpr int kFilmTile = 16;

class FilmTile;

// A range of samples that a film takes, and how many of them, from the first one on, each tile has got: an
// interrupted pass over the picture claims no more than it did.
struct FilmRange {
    SampleRange range;
    std::vector<uint32_t> done;
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
// A pixel takes 56 bytes, 80 more with the variance, and 160 more for denoising.
class Film {
  public:
    // 2^28 pixels of this film take 15 GB; what is more is a slip of the pen.
    static constexpr int64_t kMaxPixels = int64_t{1} << 28;
    Film(const Entity &entity, const FilmOptions &options);
    // The size of such a film's window, in pixels, without the memory that the film takes.
    static Point2i WindowSizeOf(const Entity &entity, const FilmOptions &options);

    Point2i Resolution() const { return resolution_; }
    // The rendered window in pixels: x0 <= x < x1, y0 <= y < y1.
    Point2i WindowMin() const { return min_; }
    Point2i WindowMax() const { return max_; }
    Point2i WindowSize() const { return {max_.x - min_.x, max_.y - min_.y}; }
    size_t Pixels() const { return pixels_.size(); } // of the window
    bool HasVariance() const { return !squares_.empty(); }
    // Whether direct light and the two halves of the samples are kept apart, for denoising.
    bool HasParts() const { return !parts_.empty(); }
    const std::string &Filename() const { return filename_; }

    // The tiles of the window are numbered row by row. [min, max) are the pixels of one.
    size_t Tiles() const;
    std::pair<Point2i, Point2i> TileWindow(size_t tile) const;

    // Says which samples of which render this film is going to take; without it, it takes part of no render.
    void Expect(const RenderIdentity &render, const SampleRange &samples);
    const RenderIdentity &Identity() const { return render_; }
    const std::vector<FilmRange> &Taken() const { return taken_; }
    // How many samples of the range under way (the one last expected) the pixels of a tile have got.
    int Done(size_t tile) const { return static_cast<int>(taken_.back().done[tile]); }
    // The fewest samples, of all ranges, that any tile has got; all samples, over all pixels.
    int FewestDone() const;
    uint64_t SamplesDone() const;
    // Adds what was taken apart: the next `count` samples, of the range under way, of each pixel of a tile.
    // Different tiles may be joined from different threads.
    void Join(const FilmTile &tile, int count);
    // How many samples were taken, counted by Join, and left out as not finite.
    uint64_t LeftOut() const;
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
    // Direct light, and what is scattered more often, each as the means of the samples of even and of odd
    // number, scaled. A pixel that has one half alone has it twice. The film must have parts.
    std::array<PartHalves, 2> DevelopParts() const;
    // The smallest number of samples that any pixel of the window holds.
    int MinSamples() const;
    // Says in what another film differs in shape or render from this one; "" where they can be merged.
    std::string Difference(const Film &other) const;

  private:
    friend class FilmTile;
    friend class FilmFile;
    Film() = default; // for FilmFile
    struct Pixel {
        [[no_unique_address]] BinnedSums<3, 2, 16> sums;
        uint32_t n = 0;
    };
    using Squares = BinnedSums<3, 3, 32>;
    // Denoising needs these besides: the sums of the even samples' light, of their direct light, and of the
    // odd ones' direct light.
    struct Parts {
        [[no_unique_address]] BinnedSums<9, 2, 16> sums;
        uint32_t even = 0; // how many samples of even number there are
    };
    static_assert(sizeof(Pixel) == 56 && sizeof(Squares) == 80 && sizeof(Parts) == 160);

    static void Add(const Spectrum &radiance, Pixel *pixel, Squares *squares);
    float Darkening(const Spectrum &radiance) const;
    size_t IndexOf(int x, int y) const {
        return static_cast<size_t>(y - min_.y) * static_cast<size_t>(max_.x - min_.x) +
               static_cast<size_t>(x - min_.x);
    }
    void ReadParams(const Entity &entity, const FilmOptions &options);
    void MakePixels(bool variance, bool parts);
    void SetWindow(const ParamSet &params, std::array<float, 4> crop);

    Point2i resolution_, min_, max_;
    std::string filename_;
    double scale_ = 1;
    float maxLuminance_ = 0;
    RenderIdentity render_;
    std::vector<FilmRange> taken_; // apart from one another
    std::vector<Pixel> pixels_;    // of the window, row by row
    std::vector<Squares> squares_; // the sums of squares; empty where no variance is asked for
    std::vector<Parts> parts_;     // empty where nothing will be denoised
};

// Samples of one tile of a film, taken by one thread and joined to the film as one: whoever looks at the film
// meanwhile sees all of them or none.
class FilmTile {
  public:
    FilmTile(const Film &film, size_t tile);
    // As Film::Add, for a pixel of the tile of a film without parts.
    bool Add(int x, int y, const Spectrum &radiance);
    // As Film::Add, for a film with parts: `sample` is the sample's number, `direct` a part of the radiance.
    bool Add(int x, int y, const Spectrum &radiance, int sample, const Spectrum &direct);
    size_t Number() const { return number_; }
    Point2i Min() const { return min_; }
    Point2i Max() const { return max_; }

  private:
    friend class Film;
    size_t IndexOf(int x, int y) const {
        return static_cast<size_t>((y - min_.y) * (max_.x - min_.x) + x - min_.x);
    }
    const Film &film_;
    size_t number_;
    Point2i min_, max_;
    std::vector<Film::Pixel> pixels_;
    std::vector<Film::Squares> squares_;
    std::vector<Film::Parts> parts_;
};

// Claims the memory of a film (core/memory_budget.h) before it is made, and before a scene is built for it. A
// crop window counts by its share of the picture.
void ClaimFilm(const Entity &entity, const FilmOptions &options);

} // namespace cuticle
