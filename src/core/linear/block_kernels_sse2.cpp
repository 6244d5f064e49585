// What every x86-64 machine has; other architectures compile the same text for their own registers.
#include "deformable_sim/core/linear/block_kernels.h"

#define SIMD_LEVEL simd_sse2
#include "block_kernels.inc"
