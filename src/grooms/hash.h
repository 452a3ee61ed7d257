// Random numbers by address: a value depends only on what it is asked for, never on who asked before, so that
// strands come out the same in any order and for any number of threads.
#pragma once

#include "core/sampling.h"

namespace cuticle {

// The random stream of one thing (a strand, a guide): Uniform(k) is its k-th number.
class HashStream {
  public:
    // what: which kind of thing; index: which one.
    constexpr HashStream(uint64_t seed, uint64_t what, uint64_t index)
        : key_(Scramble(Scramble(Scramble(seed) ^ what) ^ index)) {}
    // Returns the k-th number, in [0, 1).
    constexpr float Uniform(uint64_t k) const {
        return static_cast<float>(Scramble(key_ ^ k) >> 40) * 0x1p-24f;
    }
    // Returns the same stretched to [-1, 1).
    constexpr float Signed(uint64_t k) const { return 2 * Uniform(k) - 1; }

  private:
    // A step of SplitMix64 (Steele et al. 2014): 0 does not stay 0.
    static constexpr uint64_t Scramble(uint64_t v) { return MixBits(v + 0x9e3779b97f4a7c15u); }
    uint64_t key_;
};

} // namespace cuticle
