//> Define how a picture is denoised
#include "render/denoise.h"

#include "core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

using Picture = std::vector<Spectrum>;

//> Say by how much a picture may be smoothed
// Standard deviations in pixels, each about 1.4 times the one before.
constexpr std::array kSigmas = {0.f, 0.5f, 0.7f, 1.f, 1.4f, 2.f, 2.8f, 4.f, 5.6f};
// Errors are compared over about so many pixels around each, and the choice fades into its neighbours' over
// so many.
constexpr float kChoiceSigma = 8, kFadeSigma = 1.5f;
// A wide kernel gains for pixels what it may lose for means over many. So errors of means under a Gaussian of
// about the area of a block of 8 x 8 pixels count as well, as much as the errors of all its pixels.
constexpr float kBlockSigma = 2.3f;
constexpr double kBlockPixels = 64;
//<

//> Smooth the rows, then the columns
// Number: float or Spectrum.
template <typename Number>
std::vector<Number> SmoothedBy(const std::vector<Number> &picture, Point2i size, float sigma) {
    if (!(sigma > 0))
        return picture;
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    std::vector<float> kernel(static_cast<size_t>(reach) + 1);
    for (size_t i = 0; i < kernel.size(); ++i)
        kernel[i] = std::exp(-0.5f * static_cast<float>(i * i) / (sigma * sigma));
    const auto columns = static_cast<size_t>(size.x), rows = static_cast<size_t>(size.y);
    // Calls add(from, weight) for what lies within reach of place `to` of n, and returns the weights' sum.
    const auto gather = [&](size_t to, size_t n, const auto &add) {
        const auto k = static_cast<size_t>(reach);
        float weights = 0;
        for (size_t from = to - std::min(k, to); from <= std::min(n - 1, to + k); ++from) {
            const float w = kernel[from < to ? to - from : from - to];
            add(from, w);
            weights += w;
        }
        return weights;
    };
    std::vector<Number> half(picture.size()), whole(picture.size());
    ParallelFor(rows, [&](size_t y) {
        const Number *const in = &picture[y * columns];
        for (size_t x = 0; x < columns; ++x) {
            Number sum{};
            const float weights = gather(x, columns, [&](size_t from, float w) { sum += in[from] * w; });
            half[y * columns + x] = sum * (1 / weights);
        }
    });
    ParallelFor(rows, [&](size_t y) { // whole rows at once, as they lie in memory
        Number *const out = &whole[y * columns];
        const float weights = gather(y, rows, [&](size_t from, float w) {
            for (size_t x = 0; x < columns; ++x)
                out[x] += half[from * columns + x] * w;
        });
        for (size_t x = 0; x < columns; ++x)
            out[x] = out[x] * (1 / weights);
    });
    return whole;
}
//<

//> Smooth, and give back what is lost of it
// The loss of the first smoothing is smoothed and added again: slopes and gentle curves survive, so that a
// block keeps its brightness.
Picture SmoothedTwice(const Picture &picture, Point2i size, float sigma) {
    if (!(sigma > 0))
        return picture;
    Picture once = Smoothed(picture, size, sigma), lost(picture.size());
    for (size_t i = 0; i < picture.size(); ++i)
        lost[i] = picture[i] - once[i];
    lost = Smoothed(lost, size, sigma);
    for (size_t i = 0; i < picture.size(); ++i)
        once[i] += lost[i];
    return once;
}
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
    double sum = 0;
    for (const float c : s.c)
        sum += double{c} * double{c} / 3;
    return sum;
}

//> Estimate the error of a picture from two halves
// a and b: one place in the means of two halves of the samples; x and y: in what a way of smoothing makes of
// each. The estimate is of the mean square error of (x + y) / 2, without bias; it may be negative.
double ErrorOf(const Spectrum &a, const Spectrum &b, const Spectrum &x, const Spectrum &y) {
    return 0.5 * (Square(x - b) + Square(y - a)) - 0.5 * Square(a - b) - 0.25 * Square(x - y);
}
//<

//> Choose for every pixel how much to smooth
// Smooths the halves of a part each as much as is best for it there, by one of the first `count` kSigmas.
PartHalves DenoisePart(const PartHalves &part, Point2i size, const std::vector<float> &weights,
                       size_t count) {
    const size_t n = part.a.size();
    const Picture wideA = Smoothed(part.a, size, kBlockSigma), wideB = Smoothed(part.b, size, kBlockSigma);
    std::vector<float> least(n);
    std::vector<uint8_t> choice(n, 0);
    for (size_t k = 0; k < count; ++k) {
        const Picture x = SmoothedTwice(part.a, size, kSigmas[k]);
        const Picture y = SmoothedTwice(part.b, size, kSigmas[k]);
        const Picture wideX = Smoothed(x, size, kBlockSigma), wideY = Smoothed(y, size, kBlockSigma);
        std::vector<float> error(n);
        for (size_t i = 0; i < n; ++i)
            error[i] = static_cast<float>(double{weights[i]} *
                                          (ErrorOf(part.a[i], part.b[i], x[i], y[i]) +
                                           kBlockPixels * ErrorOf(wideA[i], wideB[i], wideX[i], wideY[i])));
        error = SmoothedBy(error, size, kChoiceSigma);
        for (size_t i = 0; i < n; ++i)
            if (k == 0 || error[i] < least[i])
                least[i] = error[i], choice[i] = static_cast<uint8_t>(k);
    }
    PartHalves denoised{Picture(n), Picture(n)};
    for (size_t k = 0; k < count; ++k) {
        std::vector<float> share(n);
        size_t chosen = 0;
        for (size_t i = 0; i < n; ++i)
            if (choice[i] == k)
                share[i] = 1, ++chosen;
        if (chosen == 0)
            continue;
        if (chosen < n)
            share = SmoothedBy(share, size, kFadeSigma);
        const Picture x = SmoothedTwice(part.a, size, kSigmas[k]);
        const Picture y = SmoothedTwice(part.b, size, kSigmas[k]);
        for (size_t i = 0; i < n; ++i)
            denoised.a[i] += x[i] * share[i], denoised.b[i] += y[i] * share[i];
    }
    return denoised;
}
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
        double before = 0, after = 0, squares = 0;
        const auto n = static_cast<double>(a.size());
        for (size_t i = 0; i < a.size(); ++i) {
            const double w{weights[i]};
            const double then = w * 0.25 * Square(a[i] - b[i]), now = w * ErrorOf(a[i], b[i], x[i], y[i]);
            before += then / n, after += now / n, squares += Sqr(now - then) / n;
        }
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
    return SmoothedBy(picture, size, sigma);
}

//> Denoise all parts, by as much as keeps blocks right
// Pixels may gain where blocks lose: a small picture of much detail has its edges within one kernel's reach.
// Then the widest kernel is taken from the choice until blocks are no worse.
DenoisedPicture Denoise(Point2i size, std::span<const PartHalves> parts) {
    const auto n = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    DenoiseComparison all{size, Picture(n), Picture(n), {}, {}};
    for (const PartHalves &part : parts)
        AddTo(&all.a, part.a), AddTo(&all.b, part.b);
    const std::vector<float> weights = WeightsOf(MeanOf(all.a, all.b), size);
    DenoisedPicture result;
    for (size_t count = kSigmas.size(); count > 0; --count) {
        all.x.assign(n, {}), all.y.assign(n, {});
        for (const PartHalves &part : parts) {
            const PartHalves denoised = DenoisePart(part, size, weights, count);
            AddTo(&all.x, denoised.a), AddTo(&all.y, denoised.b);
        }
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
