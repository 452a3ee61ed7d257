//> Compile the kernels for any processor
#define CUTICLE_KERNEL sse2
#include "fibers/hair_kernel.h"
//<
