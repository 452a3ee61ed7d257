// Random numbers by address: a value depends only on what it is asked for, never on who asked before, so that
// strands come out the same in any order and for any number of threads.
#pragma once

#include <cstdint>

namespace cuticle {

// A bijective scramble of 64 bits (the finaliser of SplitMix64, Steele et al. 2014).
constexpr uint64_t MixBits(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

// The random stream of one thing (a strand, a guide): Uniform(k) is its k-th number.
class HashStream {
  public:
    // what: which kind of thing; index: which one.
    constexpr HashStream(uint64_t seed, uint64_t what, uint64_t index)
        : key_(MixBits(MixBits(MixBits(seed) ^ what) ^ index)) {}
    // In [0, 1).
    constexpr float Uniform(uint64_t k) const {
        return static_cast<float>(MixBits(key_ ^ k) >> 40) * 0x1p-24f;
    }
    // In [-1, 1).
    constexpr float Signed(uint64_t k) const { return 2 * Uniform(k) - 1; }

  private:
    uint64_t key_;
};

} // namespace cuticle
