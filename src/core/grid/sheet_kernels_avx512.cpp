// Compiled with -mavx512f -mavx512dq -mfma; called only where the machine has them.
#if defined(__AVX512F__)
#include <immintrin.h>

#include <cstdint>

#include "deformable_sim/core/grid/coarse_kernels.h"
#include "deformable_sim/core/grid/line_kernels.h"
#include "deformable_sim/core/grid/mesh_kernels.h"
#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/grid/stage_kernels.h"
#include "deformable_sim/core/linear/packet_kernels.h"

namespace deformable_sim {
namespace simd_avx512 {

typedef float Float16 __attribute__((vector_size(64), aligned(4), may_alias));
typedef double Double8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef std::int32_t Int16 __attribute__((vector_size(64), aligned(4), may_alias));

/// To the nearest.
static inline Int16 rounded(Float16 a) {
  return (Int16)_mm512_maskz_cvtps_epi32(static_cast<__mmask16>(-1), a);
}

/// One Newton step on an estimate of 14 bits; two in double precision.
static inline Float16 inverse_root(Float16 a) {
  const __m512 half = _mm512_set1_ps(0.5f), three_halves = _mm512_set1_ps(1.5f), v = a;
  const __m512 r = _mm512_maskz_rsqrt14_ps(static_cast<__mmask16>(-1), v);
  return _mm512_mul_ps(r, _mm512_fnmadd_ps(_mm512_mul_ps(_mm512_mul_ps(half, v), r), r, three_halves));
}
/// 2 half_length / a^(1/2), by the same step.
static inline Float16 length_ratio(float half_length, Float16 a) {
  const __m512 v = a, r = _mm512_maskz_rsqrt14_ps(static_cast<__mmask16>(-1), v);
  const __m512 rest = _mm512_fnmadd_ps(v, _mm512_mul_ps(r, r), _mm512_set1_ps(3.0f));
  return _mm512_mul_ps(_mm512_mul_ps(_mm512_set1_ps(half_length), r), rest);
}
static inline Double8 inverse_root(Double8 a) {
  const __m512d half = _mm512_set1_pd(0.5), three_halves = _mm512_set1_pd(1.5), v = a;
  const __m512d half_v = _mm512_mul_pd(half, v);
  __m512d r = _mm512_maskz_rsqrt14_pd(static_cast<__mmask8>(-1), v);
  r = _mm512_mul_pd(r, _mm512_fnmadd_pd(_mm512_mul_pd(half_v, r), r, three_halves));
  return _mm512_mul_pd(r, _mm512_fnmadd_pd(_mm512_mul_pd(half_v, r), r, three_halves));
}

static inline Double8 length_ratio(double half_length, Double8 a) {
  return (2.0 * half_length) * inverse_root(a);
}

}  // namespace simd_avx512
}  // namespace deformable_sim

#define SIMD_LEVEL simd_avx512
#define SIMD_BYTES 64
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
