// For every machine.
#include "deformable_sim/core/rope/rope_kernels.h"
#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <cmath>
#endif

namespace deformable_sim {
namespace simd_sse2 {

#if defined(__SSE2__)
static inline Two root(Two a) {
  return _mm_sqrt_pd(a);
}
#else
static inline Two root(Two a) {
  return Two{std::sqrt(a[0]), std::sqrt(a[1])};
}
#endif
static inline Two larger(Two a, Two b) {
  return a > b ? a : b;
}
static inline Two smaller(Two a, Two b) {
  return a < b ? a : b;
}

}  // namespace simd_sse2
}  // namespace deformable_sim

#define SIMD_LEVEL simd_sse2
// In this order.
#include "rope_walk.inc"

#include "rope_kernels.inc"
