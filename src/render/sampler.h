// Numbers for the samples of a pixel.
#pragma once

#include "core/sampling.h"
#include "scene/scene_description.h"

#include <array>

namespace cuticle {

enum class SamplerKind : uint8_t { LowDiscrepancy, Independent };

// A stream of numbers in [0, OneMinusEpsilon] for one sample of one pixel, a function of seed, pixel, sample
// index and the order of the calls alone. LowDiscrepancy: each Get2D is the two-dimensional Sobol' sequence, a (0,2)-sequence,
// under Owen's nested uniform scramble and an order of its own, both drawn by hashing (Burley 2020), so that
// dimensions and pixels do not know of each other. The first 2^k samples, and every aligned 2^k after them, put one
// point in each elementary interval of area 2^-k; other counts work as well. Independent: uniform, no structure.
class PixelSampler {
  public:
    // spp is taken for information only; every value >= 1 is fine.
    PixelSampler(SamplerKind kind, int spp, uint64_t seed)
        : seed_(MixBits(seed + 1)), spp_(spp), kind_(kind) {}

    // Begins sample sampleIndex >= 0 of pixel (px, py); the next Get is its first dimension.
    void Start(int px, int py, int sampleIndex);
    float Get1D();
    Point2f Get2D();
    std::array<float, 4> Get4D(); // two Get2D side by side

    int SamplesPerPixel() const { return spp_; }
    SamplerKind Kind() const { return kind_; }

  private:
    uint64_t seed_;
    uint64_t pixel_ = 0;
    uint32_t index_ = 0, reversedIndex_ = 0, dimension_ = 0;
    int spp_;
    SamplerKind kind_;
};

struct SamplerSetup {
    SamplerKind kind = SamplerKind::LowDiscrepancy;
    int spp = 16;
};
// Sampler directives, with pbrt-v3's names and defaults: halton, sobol, 02sequence, lowdiscrepancy, zerotwosequence,
// maxmindist and stratified (xsamples ysamples) all mean LowDiscrepancy; random means Independent. An unknown name or
// fewer than 1 sample is an Error.
SamplerSetup MakeSampler(const Entity &entity);

} // namespace cuticle
