// Compiled with -mavx2 -mfma; called only where the machine has them.
#if defined(__AVX2__)
#include <immintrin.h>

#include "deformable_sim/core/rope/rope_kernels.h"

namespace deformable_sim {
namespace simd_avx2 {

static inline Two root(Two a) {
  return _mm_sqrt_pd(a);
}
static inline Two larger(Two a, Two b) {
  return _mm_max_pd(a, b);
}
static inline Two smaller(Two a, Two b) {
  return _mm_min_pd(a, b);
}

}  // namespace simd_avx2
}  // namespace deformable_sim

#define SIMD_LEVEL simd_avx2
// In this order.
#include "rope_walk.inc"

#include "rope_kernels.inc"
#endif
