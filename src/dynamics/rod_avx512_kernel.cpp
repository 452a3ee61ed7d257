//> Compile the rods for processors with AVX-512
#define CUTICLE_KERNEL avx512
#include "dynamics/rod_kernel.h"
//<
