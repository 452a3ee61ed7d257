// Numbers for the samples of a pixel.
#pragma once

#include "core/sampling.h"
#include "parser/scene_description.h"

#include <array>

namespace cuticle {

enum class SamplerKind : uint8_t { LowDiscrepancy, Independent };

// A stream of numbers in [0, OneMinusEpsilon] for one sample of one pixel, a function of seed, spp, pixel,
// sample index and the order of the calls alone. LowDiscrepancy: each Get2D is the two-dimensional Sobol'
// sequence, a (0,2)-sequence, under Owen's nested uniform scramble, drawn by hashing (Burley 2020). So the
// spp samples of a pixel, if spp is a power of two, put one point in each elementary interval of area 1/spp;
// other counts work as well. Which point falls to which sample is a random permutation of its own in every
// dimension, so that dimensions and pixels do not know of each other. (Burley permutes by a nested scramble
// too, which keeps the first 2^k samples stratified, but makes neighbouring samples opposites in every
// dimension at once: the variance of a product of two dimensions is then 1.58 times that of random numbers. A
// renderer that knows spp need not pay that.) Independent: uniform, no structure.
class PixelSampler {
  public:
    // spp >= 1: how many samples of a pixel make one stratified set.
    PixelSampler(SamplerKind kind, int spp, uint64_t seed);

    // Begins sample sampleIndex >= 0 of pixel (px, py); the next Get is its first dimension. Samples from spp
    // on make further sets, each stratified.
    void Start(int px, int py, int sampleIndex);
    float Get1D();
    Point2f Get2D();
    std::array<float, 4> Get4D(); // two Get2D side by side

    int SamplesPerPixel() const { return static_cast<int>(spp_); }
    SamplerKind Kind() const { return kind_; }

  private:
    uint32_t PermutedIndex(uint64_t hash) const;
    uint64_t seed_;
    uint64_t pixel_ = 0;
    uint32_t indexInSet_ = 0, firstOfSet_ = 0, dimension_ = 0;
    uint32_t spp_, mask_; // mask_: as many ones as the largest index in a set has bits
    int shift_;           // half of them
    SamplerKind kind_;
};

// The largest number of samples per pixel: indices keep eight bits to spare, and no picture needs more.
constexpr int kMaxSamples = 1 << 24;

struct SamplerSetup {
    SamplerKind kind = SamplerKind::LowDiscrepancy;
    int spp = 16;
};
// Makes the sampler of a scene, with pbrt-v3's names and defaults: random means Independent, the others mean
// LowDiscrepancy. An unknown name, fewer than 1 sample or more than kMaxSamples is an Error.
SamplerSetup MakeSampler(const Entity &entity);

} // namespace cuticle
