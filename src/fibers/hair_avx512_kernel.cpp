//> Compile the kernels for processors with AVX-512
// Four lanes fill a quarter of such a processor's register; the gain is in twice as many registers, and in
// masks that have registers of their own.
#define CUTICLE_KERNEL avx512
#include "fibers/hair_kernel.h"
//<
