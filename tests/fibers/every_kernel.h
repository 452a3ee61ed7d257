// Runs a test once with each set of hair kernels that this processor runs.
#pragma once

#include "fibers/hair_lanes.h"

#include <gtest/gtest.h>

#include <string>

namespace cuticle {

class EveryKernel : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        before_ = CurrentHairKernels().name;
        SetHairKernels(GetParam());
    }
    void TearDown() override { SetHairKernels(before_); }

  private:
    std::string before_;
};

} // namespace cuticle

// For a fixture derived from EveryKernel.
#define CUTICLE_WITH_EVERY_KERNEL(fixture)                                                                   \
    INSTANTIATE_TEST_SUITE_P(Kernels, fixture, testing::ValuesIn(HairKernelNames()),                         \
                             [](const testing::TestParamInfo<std::string> &kernel) { return kernel.param; })
