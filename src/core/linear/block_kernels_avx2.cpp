// Compiled with -mavx2 -mfma; called only where the machine has them.
#if defined(__AVX2__)
#include "deformable_sim/core/linear/block_kernels.h"

#define SIMD_LEVEL simd_avx2
#include "block_kernels.inc"
#endif
