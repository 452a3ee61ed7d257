//> Hold eight strands beside one another
// The kernels of rods and their caller share plain memory in which eight strands lie lane by lane.
#pragma once

#include "dynamics/rod.h"

#include <cstddef>
#include <cstdint>

namespace cuticle {

inline constexpr size_t kRodLanes = 8;

// One number for each strand of a batch.
struct alignas(8 * kRodLanes) Octet {
    double lane[kRodLanes]{};
};

// One part of a step on a batch: see rods::RodSolver.
struct RodBatchStep {
    const rods::RodArrays<Octet> *arrays;
    rods::RodStiffness stiffness;
    rods::RodFormula formula;
    double dt;
    Octet *scratch;
};

// The solver for one instruction set.
struct RodKernel {
    void (*begin)(const RodBatchStep &);
    void (*newton)(const RodBatchStep &, Octet *largestMove); // squared
    void (*projectLengths)(const RodBatchStep &, Octet *largestError);
    void (*end)(const RodBatchStep &);
};

//> Name the kernels of rods
namespace sse2 {
extern const RodKernel kRodKernel;
}
namespace avx2 {
extern const RodKernel kRodKernel;
}
namespace avx512 {
extern const RodKernel kRodKernel;
}
//<

} // namespace cuticle
//<
