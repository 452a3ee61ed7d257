//> Compile the rods for every processor
#define CUTICLE_KERNEL sse2
#include "dynamics/rod_kernel.h"
//<
