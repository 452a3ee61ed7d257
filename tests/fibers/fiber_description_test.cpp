// The simulator refuses descriptions of fibers, lights and measurements that have no meaning.
#include "core/error.h"
#include "fibers/fiber_simulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace cuticle {
namespace {

TEST(FiberSimulator, WhatHasNoMeaningIsRefused) {
    const auto refuses =
        [](const std::function<void(FiberDescription *, FiberLight *, FiberMeasurement *)> &change) {
            FiberDescription fiber;
            FiberLight light;
            FiberMeasurement m;
            m.samples = 10;
            change(&fiber, &light, &m);
            EXPECT_THROW(SimulateFiber(fiber, light, m), Error);
        };
    refuses([](auto *f, auto *, auto *) { f->eta = 0; });
    refuses([](auto *f, auto *, auto *) { f->eta = NAN; });
    refuses([](auto *f, auto *, auto *) { f->axisRatio = 0; });
    refuses([](auto *f, auto *, auto *) { f->rotation = INFINITY; });
    refuses([](auto *f, auto *, auto *) { f->alpha = 1; });
    refuses([](auto *f, auto *, auto *) { f->roughnessV = -0.1; });
    refuses([](auto *f, auto *, auto *) { f->sigmaA = {}; });
    refuses([](auto *f, auto *, auto *) { f->sigmaA = {-1}; });
    refuses([](auto *f, auto *, auto *) { f->medullaSigmaA = {1, 2}; });
    refuses([](auto *f, auto *, auto *) { f->medullaRatio = 1; });
    refuses([](auto *f, auto *, auto *) { f->medullaG = 1; });
    refuses([](auto *f, auto *, auto *) { f->medullaSigmaS = NAN; });
    refuses([](auto *, auto *l, auto *) { l->theta = kPi<double> / 2; });
    refuses([](auto *, auto *l, auto *) { l->phi = NAN; });
    refuses([](auto *, auto *l, auto *) { l->h = 1.5; });
    refuses([](auto *, auto *, auto *m) { m->orders = 0; });
    refuses([](auto *, auto *, auto *m) { m->only = 4; });
    refuses([](auto *, auto *, auto *m) { m->samples = 0; });
    refuses([](auto *, auto *, auto *m) { m->faint = NAN; });
    refuses([](auto *, auto *, auto *m) { m->cells = {0, 8}; });
}

} // namespace
} // namespace cuticle
