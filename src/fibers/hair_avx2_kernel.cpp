//> Compile the kernels for processors with AVX2 and FMA
// Four lanes fill half of such a processor's register; the gain is in fused multiply-adds, which the compiler
// forms, and in code with three operands.
#define CUTICLE_KERNEL avx2
#include "fibers/hair_kernel.h"
//<
