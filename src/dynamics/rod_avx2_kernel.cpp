//> Compile the rods for processors with AVX2
#define CUTICLE_KERNEL avx2
#include "dynamics/rod_kernel.h"
//<
