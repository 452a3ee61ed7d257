// The one choice of instruction set for all kernels of the program: those of curves
// (shapes/curve_set_kernel.cpp) and those of hair (fibers/hair_kernel.h).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// The instruction sets that kernels are compiled for, the narrowest first. Sse2 is the baseline of every
// processor: where there is no SSE2 its kernels are compiled as the compiler's generic vectors.
enum class InstructionSet : uint8_t { Sse2, Avx2, Avx512 };

// The name by which a user chooses it: "sse2", "avx2" or "avx512".
const char *IsaName(InstructionSet isa);
// The instruction sets that this processor (and operating system) runs, the widest first.
std::vector<InstructionSet> SupportedIsas();
// Returns the instruction set that `option` names. If it is empty, the one that the environment's CUTICLE_ISA
// names; if that is not set either, the widest that the processor runs. Throws Error for a name that is
// unknown or that the processor does not run.
InstructionSet ChooseIsa(const std::string &option = {});

} // namespace cuticle
