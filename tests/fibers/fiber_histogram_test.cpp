// The histogram of scattered light and its error bars, filled by hand.
#include "fibers/fiber_histogram.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

// The bar of a cut over several cells adds their squares. Exact where no sample has a share in two cells;
// where each sample spreads its share evenly over k, only a k-th of the second moment is seen.
TEST(FiberHistogram, TheBarOfACut) {
    constexpr size_t kColumns = 4;
    constexpr uint64_t kSamples = 100;
    for (const size_t spread : {size_t(1), kColumns}) {
        FiberHistogram h({1, kColumns}, 1, 1);
        for (size_t i = 0; i < kSamples; ++i) {
            const double x = i % 2 == 0 ? 1 : 3, share = x / static_cast<double>(spread);
            for (size_t k = 0; k < spread; ++k)
                h.Add(0, (i / 2 + k) % kColumns, &share);
        }
        h.CountSamples(kSamples, 0);
        const LobeSlice cut = h.AlongTheta(0, 0, 0, 4);
        const double omega = 4 * kPi<double>, n = kSamples, moment = 5 / static_cast<double>(spread);
        ASSERT_EQ(cut.value.size(), 1u);
        EXPECT_NEAR(cut.value[0] * omega, 2, 1e-12);
        // A true variance of 5 - 4 = 1.
        EXPECT_NEAR(cut.error[0] * omega, std::sqrt(std::max(0., moment - 4) / (n - 1)), 1e-12) << spread;
    }
}

} // namespace
} // namespace cuticle
