// Registers of 16 bytes, as every x86-64 has; other machines use what the compiler makes of them.
#include <cmath>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "deformable_sim/core/grid/coarse_kernels.h"
#include "deformable_sim/core/grid/line_kernels.h"
#include "deformable_sim/core/grid/mesh_kernels.h"
#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/grid/stage_kernels.h"
#include "deformable_sim/core/linear/packet_kernels.h"

namespace deformable_sim {
namespace simd_sse2 {

typedef float Float4 __attribute__((vector_size(16), aligned(4), may_alias));
typedef double Double2 __attribute__((vector_size(16), aligned(8), may_alias));
typedef std::int32_t Int4 __attribute__((vector_size(16), aligned(4), may_alias));

#if defined(__SSE2__)
/// To the nearest.
static inline Int4 rounded(Float4 a) {
  return (Int4)_mm_cvtps_epi32(a);
}
static inline Float4 inverse_root(Float4 a) {
  return _mm_div_ps(_mm_set1_ps(1.0f), _mm_sqrt_ps(a));
}
static inline Double2 inverse_root(Double2 a) {
  return _mm_div_pd(_mm_set1_pd(1.0), _mm_sqrt_pd(a));
}
#else
static inline Int4 rounded(Float4 a) {
  Int4 n;
  for (int i = 0; i < 4; ++i) n[i] = static_cast<std::int32_t>(std::lrint(a[i]));
  return n;
}
static inline Float4 inverse_root(Float4 a) {
  Float4 r;
  for (int i = 0; i < 4; ++i) r[i] = 1.0f / std::sqrt(a[i]);
  return r;
}
static inline Double2 inverse_root(Double2 a) {
  Double2 r;
  for (int i = 0; i < 2; ++i) r[i] = 1.0 / std::sqrt(a[i]);
  return r;
}
#endif
/// 2 half_length / a^(1/2).
static inline Float4 length_ratio(float half_length, Float4 a) {
  return (2.0f * half_length) * inverse_root(a);
}
static inline Double2 length_ratio(double half_length, Double2 a) {
  return (2.0 * half_length) * inverse_root(a);
}

}  // namespace simd_sse2
}  // namespace deformable_sim

#define SIMD_LEVEL simd_sse2
#define SIMD_BYTES 16
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
