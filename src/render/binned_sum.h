// Sums that do not depend on order, in whole numbers: partial sums of any split, added in any order, give the
// same bits. The method is that of Demmel and Nguyen ("Parallel Reproducible Summation", 2015), who do it in
// floating point.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace cuticle {

// A finite number as digits * 2^exponent, digits a whole number below 2^48.
struct BinaryNumber {
    uint64_t digits = 0;
    int exponent = 0;
    bool negative = false;

    static BinaryNumber Of(float finite) {
        const auto bits = std::bit_cast<uint32_t>(finite);
        const uint32_t exponent = (bits >> 23) & 0xff, fraction = bits & 0x7fffff;
        // The smallest exponent belongs to numbers without the leading one that others have.
        return {exponent > 0 ? fraction | 0x800000 : fraction,
                static_cast<int>(exponent > 0 ? exponent : 1) - 150, (bits >> 31) != 0};
    }
    BinaryNumber Squared() const { return {digits * digits, 2 * exponent, false}; } // digits below 2^24
};

// Sums of numbers in `Channels` channels; each is a function of the set of numbers added, not of their order.
//
// The binary digits of all numbers stand on one axis, which is cut into bins of 39 digits at fixed places:
// one cut is at 2^Cut. A number is cut at the same places, and its pieces, whole numbers below 2^39, are
// added to one 64-bit counter for each bin. That is exact for kMaxCount numbers. A channel keeps the `Bins`
// highest bins that any of its numbers reaches into; the pieces below them are left out, of those numbers
// that came before and of those that come after. So a sum is exact where all numbers are multiples of the
// last digit that is kept, at most 2^-(39 (Bins - 1)) of the largest number; elsewhere it lacks less than one
// such digit for each number.
template <size_t Channels, size_t Bins, int Cut>
class BinnedSums {
  public:
    static constexpr uint32_t kMaxCount = 1 << 24;

    // Adds a number to one channel; at most kMaxCount numbers in all.
    void Add(size_t channel, const BinaryNumber &x) {
        if (x.digits == 0)
            return;
        const auto place = static_cast<unsigned>(x.exponent + kZero);
        const unsigned bin = place / kBits, shift = place % kBits;
        // At most 48 + 38 digits, which reach into at most three bins
        const uint64_t low = x.digits << shift, high = shift == 0 ? 0 : x.digits >> (64 - shift);
        const uint64_t pieces[3] = {low & kMask, (low >> kBits | high << (64 - kBits)) & kMask,
                                    high >> (2 * kBits - 64)};
        Raise(channel, bin + (pieces[2] ? 2 : pieces[1] ? 1 : 0));
        for (unsigned i = 0; i < 3; ++i)
            if (pieces[i] && bin + i >= lowest_[channel]) {
                const auto piece = static_cast<int64_t>(pieces[i]);
                sums_[channel][bin + i - lowest_[channel]] += x.negative ? -piece : piece;
            }
    }
    // Adds what was added to another; at most kMaxCount numbers together.
    void Add(const BinnedSums &other) {
        for (size_t c = 0; c < Channels; ++c) {
            Raise(c, other.lowest_[c] + Bins - 1);
            for (size_t b = lowest_[c] - other.lowest_[c]; b < Bins; ++b)
                sums_[c][b + other.lowest_[c] - lowest_[c]] += other.sums_[c][b];
        }
    }
    // The sum in double, off by less than 2^-52 of it.
    double Value(size_t channel) const {
        // Carry, so that each bin but the last holds less than 38 digits and a sign: their sum then cancels
        // nothing
        double value = 0, scale = std::ldexp(1., static_cast<int>(lowest_[channel] * kBits) - kZero);
        int64_t carry = 0;
        for (size_t b = 0; b < Bins; ++b, scale *= 0x1p39) {
            const int64_t sum = sums_[channel][b] + carry;
            carry = (sum + (int64_t{1} << (kBits - 1))) >> kBits;
            value += static_cast<double>(sum - carry * (int64_t{1} << kBits)) * scale;
        }
        return value + static_cast<double>(carry) * scale;
    }

    bool operator==(const BinnedSums &) const = default;

    // The counters of all channels, those of a channel from its lowest bin upward, and which bin that is:
    // what a file keeps of the sums.
    using Counters = std::array<std::array<int64_t, Bins>, Channels>;
    const Counters &AllCounters() const { return sums_; }
    const std::array<uint8_t, Channels> &LowestBins() const { return lowest_; }
    // Takes what a file kept; false, and nothing taken, where `count` numbers cannot have made it.
    bool Restore(const Counters &counters, const std::array<uint8_t, Channels> &lowest, uint32_t count) {
        if (count > kMaxCount)
            return false;
        const int64_t most = static_cast<int64_t>(count) * static_cast<int64_t>(kMask);
        for (size_t c = 0; c < Channels; ++c) {
            if (lowest[c] > kHighestBin)
                return false;
            for (const int64_t counter : counters[c])
                if (counter > most || counter < -most)
                    return false;
        }
        sums_ = counters, lowest_ = lowest;
        return true;
    }

  private:
    static constexpr unsigned kBits = 39;
    static constexpr uint64_t kMask = (uint64_t{1} << kBits) - 1;
    // The place on the axis of 2^0, so that 2^-298, the last digit of a square, has one at or above 0, and
    // Cut lies between two bins.
    static constexpr int kZero = 9 * static_cast<int>(kBits) - Cut;
    static_assert(kZero >= 298);
    // The bin of the first digit of the largest square, below 2^256
    static constexpr unsigned kHighestBin = (256 + kZero) / kBits;

    // Sees to it that the bins kept reach up to this one.
    void Raise(size_t channel, size_t highest) {
        if (highest < lowest_[channel] + Bins)
            return;
        const size_t lowest = highest + 1 - Bins, by = lowest - lowest_[channel];
        std::array<int64_t, Bins> &sums = sums_[channel];
        for (size_t b = 0; b < Bins; ++b)
            sums[b] = b + by < Bins ? sums[b + by] : 0;
        lowest_[channel] = static_cast<uint8_t>(lowest);
    }

    std::array<std::array<int64_t, Bins>, Channels> sums_{}; // from the lowest bin kept upward
    std::array<uint8_t, Channels> lowest_{};                 // which bin of the axis that is
};

} // namespace cuticle
