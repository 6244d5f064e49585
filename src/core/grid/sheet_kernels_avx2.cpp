// Compiled with -mavx2 -mfma; called only where the machine has them.
#if defined(__AVX2__)
#include <immintrin.h>

#include <cstdint>

#include "deformable_sim/core/grid/coarse_kernels.h"
#include "deformable_sim/core/grid/line_kernels.h"
#include "deformable_sim/core/grid/mesh_kernels.h"
#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/grid/stage_kernels.h"
#include "deformable_sim/core/linear/packet_kernels.h"

namespace deformable_sim {
namespace simd_avx2 {

typedef float Float8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef double Double4 __attribute__((vector_size(32), aligned(8), may_alias));
typedef std::int32_t Int8 __attribute__((vector_size(32), aligned(4), may_alias));

/// To the nearest.
static inline Int8 rounded(Float8 a) {
  return (Int8)_mm256_cvtps_epi32(a);
}

/// One Newton step on an estimate of 12 bits.
static inline Float8 inverse_root(Float8 a) {
  const __m256 half = _mm256_set1_ps(0.5f), three_halves = _mm256_set1_ps(1.5f), v = a;
  const __m256 r = _mm256_rsqrt_ps(v);
  const __m256 rest = _mm256_fnmadd_ps(_mm256_mul_ps(_mm256_mul_ps(half, v), r), r, three_halves);
  return _mm256_mul_ps(r, rest);
}
/// 2 half_length / a^(1/2), by the same step.
static inline Float8 length_ratio(float half_length, Float8 a) {
  const __m256 v = a, r = _mm256_rsqrt_ps(v);
  const __m256 rest = _mm256_fnmadd_ps(v, _mm256_mul_ps(r, r), _mm256_set1_ps(3.0f));
  return _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(half_length), r), rest);
}
static inline Double4 inverse_root(Double4 a) {
  return _mm256_div_pd(_mm256_set1_pd(1.0), _mm256_sqrt_pd(a));
}

static inline Double4 length_ratio(double half_length, Double4 a) {
  return (2.0 * half_length) * inverse_root(a);
}

}  // namespace simd_avx2
}  // namespace deformable_sim

#define SIMD_LEVEL simd_avx2
#define SIMD_BYTES 32
// In this order.
#include "sheet_kernels.inc"

#include "motion_kernels.inc"

#include "mesh_kernels.inc"

#include "../linear/packet_kernels.inc"

#include "residual_kernels.inc"

#include "stage_kernels.inc"

#include "galerkin_kernels.inc"

#include "coarse_kernels.inc"

#include "line_kernels.inc"
#endif
