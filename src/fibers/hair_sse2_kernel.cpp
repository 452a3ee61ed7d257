//> Compile the kernels for any x86-64 processor
#define CUTICLE_KERNEL sse2
#define CUTICLE_KERNEL_ARCH xsimd::sse2
#include "fibers/hair_kernel.h"
//<
