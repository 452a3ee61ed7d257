//> Define how a picture is denoised
#include "render/denoise.h"

#include "core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace cuticle {

namespace {

using Picture = std::vector<Spectrum>;

//> Say by how much a picture may be smoothed
// Kernel 0 leaves a picture as it is, kernel k > 0 is a Gaussian of KernelSigma(k) pixels.
constexpr size_t kKernels = 9;
constexpr float KernelSigma(size_t kernel) {
    float sigma = 0.5f;
    for (size_t k = 1; k < kernel; ++k)
        sigma *= 1.41421356f;
    return sigma;
}
static_assert(KernelSigma(kKernels - 1) > 5.6f && KernelSigma(kKernels - 1) < 5.7f);
// This kernel and wider ones leave pictures of which every second pixel of every second row says all.
constexpr size_t kFirstCoarse = 6;
// The kernels under which a picture is fitted to guides.
constexpr std::array<size_t, 3> kFitKernels = {4, 6, 8};

struct SmoothingWay {
    size_t kernel;       // of kFitKernels where it is guided
    bool guided = false; // fitted to the guides, else smoothed alone
};
// All ways, the wider the later. To add one: a row here.
constexpr std::array<SmoothingWay, 12> kWays = {
    {{0}, {1}, {2}, {3}, {4}, {0, true}, {5}, {6}, {1, true}, {7}, {8}, {2, true}}};
// Errors are compared over about so many pixels around each, and the choice fades into its neighbours' over
// so many.
constexpr float kChoiceSigma = 8, kFadeSigma = 1.5f;
// A wide kernel gains for pixels what it may lose for means over many. So errors of means under a Gaussian of
// about the area of a block of 8 x 8 pixels count as well, as much as the errors of all its pixels.
constexpr float kBlockSigma = 2.3f;
constexpr double kBlockPixels = 64;
//<

//> Smooth the rows, then the columns
// out[i] is the sum of sources[t][i] * weights[t], for n places. A few places at a time, so that their sums
// stay in registers.
void AddUp(std::span<const float *const> sources, std::span<const float> weights, size_t n, float *out) {
    constexpr size_t kStep = 32;
    const auto some = [&](size_t first, size_t count) {
        std::array<float, kStep> sums{};
        for (size_t t = 0; t < sources.size(); ++t)
            for (size_t i = 0; i < count; ++i)
                sums[i] += sources[t][first + i] * weights[t];
        std::copy_n(sums.begin(), count, out + first);
    };
    size_t first = 0;
    for (; first + kStep <= n; first += kStep)
        some(first, kStep);
    some(first, n - first);
}

// The weights of places -reach to reach under a Gaussian cut off at three standard deviations; they sum to 1.
std::vector<float> KernelOf(float sigma) {
    const auto reach = static_cast<int>(std::ceil(3 * sigma));
    std::vector<float> kernel;
    double sum = 0;
    for (int i = -reach; i <= reach; ++i) {
        kernel.push_back(std::exp(-0.5f * static_cast<float>(i * i) / (sigma * sigma)));
        sum += double{kernel.back()};
    }
    for (float &w : kernel)
        w /= static_cast<float>(sum);
    return kernel;
}

// Number: float or Spectrum, an array of floats either way. What these functions make goes into vectors of
// the caller, which he uses again: fresh memory would cost more than the sums.
template <typename Number>
void Smooth(const std::vector<Number> &picture, Point2i size, float sigma, std::vector<Number> *between,
            std::vector<Number> *smooth) {
    constexpr size_t kChannels = sizeof(Number) / sizeof(float);
    const auto columns = static_cast<size_t>(size.x), rows = static_cast<size_t>(size.y);
    const std::vector<float> kernel = KernelOf(sigma);
    const size_t reach = kernel.size() / 2;
    // The share of the kernel that lies inside the picture, around place `at` of n
    const auto inside = [&](size_t at, size_t n) {
        const size_t before = std::min(reach, at), after = std::min(reach, n - 1 - at);
        return std::span(kernel).subspan(reach - before, before + 1 + after);
    };
    const auto scale = [&](size_t at, size_t n) {
        const std::span<const float> weights = inside(at, n);
        return weights.size() == kernel.size() ? 1 : 1 / std::reduce(weights.begin(), weights.end(), 0.f);
    };
    const size_t width = columns * kChannels;
    between->resize(picture.size()), smooth->resize(picture.size());
    const auto *const in = reinterpret_cast<const float *>(picture.data());
    auto *const half = reinterpret_cast<float *>(between->data());
    auto *const out = reinterpret_cast<float *>(smooth->data());
    ParallelForRange(rows, 8, [&](size_t firstRow, size_t lastRow) {
        std::vector<float> padded(width + 2 * reach * kChannels); // with black on both sides
        std::vector<const float *> sources(kernel.size());
        for (size_t t = 0; t < sources.size(); ++t)
            sources[t] = &padded[t * kChannels];
        for (size_t y = firstRow; y < lastRow; ++y) {
            std::copy_n(in + y * width, width, &padded[reach * kChannels]);
            AddUp(sources, kernel, width, half + y * width);
            for (size_t x = 0; x < columns; ++x)
                if (x < reach || x + reach >= columns)
                    (*between)[y * columns + x] *= scale(x, columns);
        }
    });
    ParallelForRange(rows, 8, [&](size_t firstRow, size_t lastRow) {
        for (size_t y = firstRow; y < lastRow; ++y) {
            std::vector<const float *> sources;
            const std::span<const float> weights = inside(y, rows);
            for (size_t t = 0; t < weights.size(); ++t)
                sources.push_back(half + (y - std::min(reach, y) + t) * width);
            AddUp(sources, weights, width, out + y * width);
            if (weights.size() < kernel.size())
                for (size_t x = 0; x < columns; ++x)
                    (*smooth)[y * columns + x] *= scale(y, rows);
        }
    });
}
//<

//> Halve a picture, and double it again
Point2i Halved(Point2i size) { return {(size.x + 1) / 2, (size.y + 1) / 2}; }

// Means over 2 x 2 pixels; over what there is of them at an odd edge.
template <typename Number>
void Halve(const std::vector<Number> &picture, Point2i size, std::vector<Number> *means) {
    const Point2i halved = Halved(size);
    const auto across = static_cast<size_t>(halved.x), columns = static_cast<size_t>(size.x),
               rows = static_cast<size_t>(size.y);
    means->resize(across * static_cast<size_t>(halved.y));
    ParallelForRange(static_cast<size_t>(halved.y), 8, [&](size_t firstRow, size_t lastRow) {
        for (size_t y = firstRow; y < lastRow; ++y) {
            const Number *const above = &picture[2 * y * columns];
            const Number *const below = &picture[std::min(2 * y + 1, rows - 1) * columns];
            for (size_t x = 0; x < across; ++x) {
                const size_t left = 2 * x, right = std::min(left + 1, columns - 1);
                (*means)[y * across + x] = (above[left] + above[right] + below[left] + below[right]) * 0.25f;
            }
        }
    });
}

// A picture of `size` from means over 2 x 2 of its pixels: cubic polynomials through four means along each
// axis. A new pixel lies a quarter of a step beside a mean; `quarter` are the weights from the far neighbour
// on that side to the second one on the other.
template <typename Number>
void Double(const std::vector<Number> &means, Point2i size, std::vector<Number> *picture) {
    constexpr std::array<float, 4> quarter = {-5 / 128.f, 35 / 128.f, 105 / 128.f, -7 / 128.f};
    const auto across = static_cast<size_t>(Halved(size).x), down = static_cast<size_t>(Halved(size).y),
               columns = static_cast<size_t>(size.x), rows = static_cast<size_t>(size.y);
    // The four means, among n, that make new place `at`
    const auto around = [&](size_t at, size_t n) {
        std::array<size_t, 4> from;
        const auto middle = static_cast<int>(at / 2), side = at % 2 == 1 ? 1 : -1;
        for (int i = 0; i < 4; ++i)
            from[static_cast<size_t>(i)] =
                static_cast<size_t>(std::clamp(middle + side * (2 - i), 0, static_cast<int>(n) - 1));
        return from;
    };
    std::vector<std::array<size_t, 4>> places(columns);
    for (size_t x = 0; x < columns; ++x)
        places[x] = around(x, across);
    picture->resize(columns * rows);
    ParallelForRange(rows, 8, [&](size_t firstRow, size_t lastRow) {
        std::vector<Number> row(across);
        for (size_t y = firstRow; y < lastRow; ++y) {
            const std::array<size_t, 4> r = around(y, down);
            for (size_t x = 0; x < across; ++x)
                row[x] = means[r[0] * across + x] * quarter[0] + means[r[1] * across + x] * quarter[1] +
                         means[r[2] * across + x] * quarter[2] + means[r[3] * across + x] * quarter[3];
            for (size_t x = 0; x < columns; ++x) {
                const std::array<size_t, 4> &c = places[x];
                (*picture)[y * columns + x] = row[c[0]] * quarter[0] + row[c[1]] * quarter[1] +
                                              row[c[2]] * quarter[2] + row[c[3]] * quarter[3];
            }
        }
    });
}
//<

//> Smooth, and give back what is lost of it
// One half of a part, smoothed by every kernel. G p is a Gaussian's picture; what is kept is
// G p + G (p - G p), which is 2 G p - G G p: what the smoothing lost is smoothed and added again. Slopes and
// gentle curves survive, so that a block keeps its brightness. G G is the next Gaussian, so that one
// smoothing more makes the next picture, of which two kernels have need.
class SmoothedHalf {
  public:
    SmoothedHalf(const Picture &picture, Point2i size, Picture *between) : size_(size) {
        pictures_[0] = picture;
        for (size_t k = 1; k < kKernels; ++k) {
            // The picture of this Gaussian; what it makes of that again is the next one's
            Picture &once = pictures_[k];
            const bool coarse = k >= kFirstCoarse;
            if (k == kFirstCoarse)
                Halve(twice_, size, &once);
            else if (k > 1)
                once = twice_;
            else
                Smooth(picture, size, KernelSigma(k), between, &once);
            Smooth(once, coarse ? Halved(size) : size, KernelSigma(k) * (coarse ? 0.5f : 1), between,
                   &twice_);
            ParallelForRange(once.size(), 4096, [&](size_t first, size_t last) {
                for (size_t i = first; i < last; ++i)
                    once[i] = once[i] * 2 - twice_[i];
            });
        }
        twice_ = {};
    }
    // *space: where a coarse picture is doubled.
    const Picture &By(size_t k, Picture *space) const {
        if (k < kFirstCoarse)
            return pictures_[k];
        Double(pictures_[k], size_, space);
        return *space;
    }

  private:
    Point2i size_;
    std::array<Picture, kKernels> pictures_;
    Picture twice_;
};
//<

//> Fit a picture to its guides
// A picture under three Gaussians, each made of the one before; the wider two halved.
std::array<Picture, 3> FitLevels(const Picture &picture, Point2i size, Picture *between) {
    std::array<Picture, 3> levels;
    Picture halved;
    Smooth(picture, size, KernelSigma(kFitKernels[0]), between, &levels[0]);
    Halve(levels[0], size, &halved);
    for (size_t i = 1; i < 3; ++i) {
        const float before = KernelSigma(kFitKernels[i - 1]), now = KernelSigma(kFitKernels[i]);
        Smooth(i == 1 ? halved : levels[1], Halved(size), std::sqrt(now * now - before * before) / 2, between,
               &levels[i]);
    }
    return levels;
}

// Two guides g and h of a picture, and under each Gaussian the means of g, h, g g, and of g h, h h.
struct GuideMoments {
    std::vector<float> g, h;
    std::array<Picture, 3> first, second;

    GuideMoments(const Guides &guides, Point2i size, Picture *between) : g(guides[0]), h(guides[1]) {
        Scale(&g), Scale(&h);
        Picture one(g.size()), two(g.size());
        for (size_t i = 0; i < g.size(); ++i)
            one[i] = {g[i], h[i], g[i] * g[i]}, two[i] = {g[i] * h[i], h[i] * h[i], 0};
        first = FitLevels(one, size, between), second = FitLevels(two, size, between);
    }
    // Scales a guide to a mean square of 1; what is black stays so.
    static void Scale(std::vector<float> *guide) {
        double squares = 0;
        for (const float v : *guide)
            squares += Sqr(double{v}) / static_cast<double>(guide->size());
        for (float &v : *guide)
            v = squares > 0 ? static_cast<float>(double{v} / std::sqrt(squares)) : 0;
    }
};

// One half of a part as what is linear in the guides nearby: base + s g + t h, by least squares under each
// Gaussian.
class FittedHalf {
  public:
    FittedHalf(const Picture &picture, Point2i size, const GuideMoments &guides, Picture *between)
        : size_(size), guides_(&guides) {
        Picture times(picture.size());
        const auto productLevels = [&](const std::vector<float> &guide) {
            for (size_t i = 0; i < picture.size(); ++i)
                times[i] = picture[i] * guide[i];
            return FitLevels(times, size, between);
        };
        base_ = FitLevels(picture, size, between);
        s_ = productLevels(guides.g), t_ = productLevels(guides.h);
        for (size_t level = 0; level < 3; ++level)
            ParallelForRange(base_[level].size(), 4096, [&](size_t first, size_t last) {
                for (size_t i = first; i < last; ++i)
                    Solve(level, i);
            });
        Apply(base_[0], s_[0], t_[0], &base_[0]);
        s_[0] = t_[0] = {};
    }
    const Picture &By(size_t level, Picture *space, Picture *s, Picture *t) const {
        if (level == 0)
            return base_[0];
        Double(base_[level], size_, space), Double(s_[level], size_, s), Double(t_[level], size_, t);
        Apply(*space, *s, *t, space);
        return *space;
    }

  private:
    // Turns the means of p, p g and p h at a place into base, s and t.
    void Solve(size_t level, size_t i) {
        const Spectrum &one = guides_->first[level][i], &two = guides_->second[level][i];
        constexpr float kNoise = 1e-3f; // what varies less, of mean squares of 1, tells nothing
        const float g = one[0], h = one[1];
        const float gg = std::max(0.f, one[2] - g * g) + kNoise, hh = std::max(0.f, two[1] - h * h) + kNoise,
                    gh = two[0] - g * h;
        const float determinant = std::max(gg * hh - gh * gh, 1e-3f * gg * hh);
        Spectrum &p = base_[level][i];
        const Spectrum pg = s_[level][i] - p * g, ph = t_[level][i] - p * h;
        const Spectrum s = (pg * hh - ph * gh) / determinant, t = (ph * gg - pg * gh) / determinant;
        s_[level][i] = s, t_[level][i] = t;
        p = p - s * g - t * h;
    }
    void Apply(const Picture &base, const Picture &s, const Picture &t, Picture *out) const {
        ParallelForRange(base.size(), 4096, [&](size_t first, size_t last) {
            for (size_t i = first; i < last; ++i)
                (*out)[i] = base[i] + s[i] * guides_->g[i] + t[i] * guides_->h[i];
        });
    }

    Point2i size_;
    const GuideMoments *guides_;
    std::array<Picture, 3> base_, s_, t_;
};
//<

//> Weigh errors by how bright the picture is
// Eyes see relative differences. A floor keeps black corners from deciding.
std::vector<float> WeightsOf(const Picture &picture, Point2i size) {
    const Picture smooth = Smoothed(picture, size, 2);
    double mean = 0;
    for (const Spectrum &s : picture)
        mean += double{s.y()} / static_cast<double>(picture.size());
    std::vector<float> weights(picture.size());
    for (size_t i = 0; i < picture.size(); ++i)
        weights[i] = static_cast<float>(1 / (Sqr(double{smooth[i].y()}) + 0.1 * mean * mean + 1e-30));
    return weights;
}
//<

double Square(const Spectrum &s) {
    return (Sqr(double{s.c[0]}) + Sqr(double{s.c[1]}) + Sqr(double{s.c[2]})) / 3;
}

//> Estimate the error of a picture from two halves
// a and b: one place in the means of two halves of the samples; x and y: in what a way of smoothing makes of
// each. The estimate is of the mean square error of (x + y) / 2, without bias; it may be negative.
double ErrorOf(const Spectrum &a, const Spectrum &b, const Spectrum &x, const Spectrum &y) {
    return 0.5 * (Square(x - b) + Square(y - a)) - 0.5 * Square(a - b) - 0.25 * Square(x - y);
}

// Sets *errors to those of all pixels, times their weights.
void FindErrors(const Picture &a, const Picture &b, const Picture &x, const Picture &y,
                const std::vector<float> &weights, std::vector<float> *errors) {
    errors->resize(a.size());
    ParallelForRange(a.size(), 4096, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            (*errors)[i] = static_cast<float>(double{weights[i]} * ErrorOf(a[i], b[i], x[i], y[i]));
    });
}
//<

//> Choose for every pixel how much to smooth
// Memory that is used again and again.
struct Workspace {
    Picture between, halved, doubledX, doubledY, doubledS, doubledT, wideX, wideY;
    std::vector<float> errors, blockErrors, floatsBetween, share, doubledShare;
};

// The two halves of a part, smoothed in every way, and the errors of each way there: over 2 x 2 pixels.
class SmoothedPart {
  public:
    // guides: none where it is null.
    SmoothedPart(const PartHalves &part, Point2i size, const std::vector<float> &weights,
                 const GuideMoments *guides, Workspace *space)
        : size_(size), a_(part.a, size, &space->between), b_(part.b, size, &space->between) {
        if (guides) {
            fittedA_.emplace(part.a, size, *guides, &space->between);
            fittedB_.emplace(part.b, size, *guides, &space->between);
        }
        const Point2i half = Halved(size);
        const auto widen = [&](const Picture &p, Picture *wide) {
            Halve(p, size, &space->halved);
            Smooth(space->halved, half, kBlockSigma / 2, &space->between, wide);
        };
        Picture wideA, wideB;
        widen(part.a, &wideA), widen(part.b, &wideB);
        std::vector<float> wideWeights, error;
        Halve(weights, size, &wideWeights);
        for (size_t way = 0; way < kWays.size(); ++way) {
            if (!Has(way))
                continue;
            const auto [xMade, yMade] = By(way, space);
            const Picture &x = *xMade, &y = *yMade;
            FindErrors(part.a, part.b, x, y, weights, &space->errors);
            Halve(space->errors, size, &error);
            widen(x, &space->wideX), widen(y, &space->wideY);
            FindErrors(wideA, wideB, space->wideX, space->wideY, wideWeights, &space->blockErrors);
            for (size_t i = 0; i < error.size(); ++i)
                error[i] += static_cast<float>(kBlockPixels) * space->blockErrors[i];
            Smooth(error, half, kChoiceSigma / 2, &space->floatsBetween, &errors_[way]);
        }
    }
    // Adds to *x and *y what the halves become, each place by the way of the first `ways` that is best there.
    void AddBest(size_t ways, Picture *x, Picture *y, Workspace *space) const {
        std::vector<uint8_t> choice(errors_[0].size(), 0);
        std::vector<float> least = errors_[0];
        for (size_t way = 1; way < ways; ++way)
            for (size_t i = 0; i < least.size(); ++i)
                if (Has(way) && errors_[way][i] < least[i])
                    least[i] = errors_[way][i], choice[i] = static_cast<uint8_t>(way);
        for (size_t way = 0; way < ways; ++way) {
            const auto chosen = static_cast<size_t>(std::ranges::count(choice, way));
            if (chosen == 0)
                continue;
            std::vector<float> &share = space->doubledShare;
            if (chosen < choice.size()) {
                std::ranges::transform(choice, least.begin(),
                                       [&](uint8_t c) { return c == way ? 1.f : 0.f; });
                Smooth(least, Halved(size_), kFadeSigma / 2, &space->floatsBetween, &space->share);
                Double(space->share, size_, &share);
            } else {
                share.assign(x->size(), 1);
            }
            const auto [a, b] = By(way, space);
            ParallelForRange(x->size(), 4096, [&, aMade = a, bMade = b](size_t first, size_t last) {
                for (size_t i = first; i < last; ++i)
                    (*x)[i] += (*aMade)[i] * share[i], (*y)[i] += (*bMade)[i] * share[i];
            });
        }
    }

  private:
    bool Has(size_t way) const { return !kWays[way].guided || fittedA_; }
    std::pair<const Picture *, const Picture *> By(size_t way, Workspace *space) const {
        const auto [kernel, guided] = kWays[way];
        if (!guided)
            return {&a_.By(kernel, &space->doubledX), &b_.By(kernel, &space->doubledY)};
        return {&fittedA_->By(kernel, &space->doubledX, &space->doubledS, &space->doubledT),
                &fittedB_->By(kernel, &space->doubledY, &space->doubledS, &space->doubledT)};
    }

    Point2i size_;
    SmoothedHalf a_, b_;
    std::optional<FittedHalf> fittedA_, fittedB_;
    std::array<std::vector<float>, kWays.size()> errors_;
};
//<

//> Measure the whole picture's error
// The halves of the samples and of the denoised picture, pixel by pixel or block by block.
struct DenoiseComparison {
    Point2i size;
    Picture a, b, x, y;

    DenoiseComparison InBlocks() const {
        constexpr int kBlock = 8;
        const Point2i blocks{(size.x + kBlock - 1) / kBlock, (size.y + kBlock - 1) / kBlock};
        const auto mean = [&](const Picture &picture) {
            Picture means(static_cast<size_t>(blocks.x * blocks.y));
            std::vector<float> counts(means.size());
            for (int v = 0; v < size.y; ++v)
                for (int u = 0; u < size.x; ++u) {
                    const auto to = static_cast<size_t>(v / kBlock * blocks.x + u / kBlock);
                    means[to] += picture[static_cast<size_t>(v) * static_cast<size_t>(size.x) +
                                         static_cast<size_t>(u)];
                    ++counts[to];
                }
            for (size_t i = 0; i < means.size(); ++i)
                means[i] /= counts[i];
            return means;
        };
        return {blocks, mean(a), mean(b), mean(x), mean(y)};
    }
    // Relative root mean squares before and after. *isWorse: whether it is worse after, beyond what chance
    // explains (two standard errors).
    std::pair<double, double> Errors(const std::vector<float> &weights, bool *isWorse) const {
        struct Sums {
            double before = 0, after = 0, squares = 0;
        };
        const auto n = static_cast<double>(a.size());
        const auto [before, after, squares] = ParallelReduce(
            a.size(), 4096, Sums{},
            [&](size_t first, size_t last) {
                Sums sums;
                for (size_t i = first; i < last; ++i) {
                    const double w = double{weights[i]} / n;
                    const double then = w * 0.25 * Square(a[i] - b[i]),
                                 now = w * ErrorOf(a[i], b[i], x[i], y[i]);
                    sums.before += then, sums.after += now, sums.squares += Sqr(now - then) * n;
                }
                return sums;
            },
            [](Sums *total, const Sums &more) {
                total->before += more.before, total->after += more.after, total->squares += more.squares;
            });
        const double spread = std::sqrt(std::max(0., squares - Sqr(after - before)) / n);
        *isWorse = after - before > 2 * spread;
        return {std::sqrt(std::max(0., before)), std::sqrt(std::max(0., after))};
    }
};
//<

Picture MeanOf(const Picture &a, const Picture &b) {
    Picture mean(a.size());
    for (size_t i = 0; i < a.size(); ++i)
        mean[i] = (a[i] + b[i]) * 0.5f;
    return mean;
}

void AddTo(Picture *sum, const Picture &more) {
    for (size_t i = 0; i < more.size(); ++i)
        (*sum)[i] += more[i];
}

} // namespace

std::vector<Spectrum> Smoothed(const std::vector<Spectrum> &picture, Point2i size, float sigma) {
    static_assert(sizeof(Spectrum) == 3 * sizeof(float));
    if (!(sigma > 0))
        return picture;
    std::vector<Spectrum> between, smooth;
    Smooth(picture, size, sigma, &between, &smooth);
    return smooth;
}

//> Denoise all parts, by as much as keeps blocks right
// Pixels may gain where blocks lose: a small picture of much detail has its edges within one kernel's reach.
// Then the widest kernel is taken from the choice until blocks are no worse.
DenoisedPicture Denoise(Point2i size, std::span<const PartHalves> parts, const Guides *guides) {
    const auto n = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    DenoiseComparison all{size, Picture(n), Picture(n), {}, {}};
    for (const PartHalves &part : parts)
        AddTo(&all.a, part.a), AddTo(&all.b, part.b);
    const std::vector<float> weights = WeightsOf(MeanOf(all.a, all.b), size);
    Workspace space;
    std::optional<GuideMoments> moments;
    if (guides)
        moments.emplace(*guides, size, &space.between);
    std::vector<SmoothedPart> smoothed;
    smoothed.reserve(parts.size());
    for (const PartHalves &part : parts)
        smoothed.emplace_back(part, size, weights, moments ? &*moments : nullptr, &space);
    DenoisedPicture result;
    for (size_t ways = kWays.size(); ways > 0; --ways) {
        all.x.assign(n, {}), all.y.assign(n, {});
        for (const SmoothedPart &part : smoothed)
            part.AddBest(ways, &all.x, &all.y, &space);
        bool pixelsAreWorse = false, blocksAreWorse = false;
        std::tie(result.before.pixels, result.after.pixels) = all.Errors(weights, &pixelsAreWorse);
        const DenoiseComparison blocks = all.InBlocks();
        std::tie(result.before.blocks, result.after.blocks) =
            blocks.Errors(WeightsOf(MeanOf(blocks.a, blocks.b), blocks.size), &blocksAreWorse);
        if (!pixelsAreWorse && !blocksAreWorse)
            break;
    }
    result.picture = MeanOf(all.x, all.y);
    return result;
}
//<

std::string DenoisedPicture::Words() const {
    return fmt::format(
        "pixels are off by {:.2g} % (before {:.2g} %), blocks of 8 x 8 by {:.2g} % (before {:.2g} %)",
        100 * after.pixels, 100 * before.pixels, 100 * after.blocks, 100 * before.blocks);
}

} // namespace cuticle
//<
