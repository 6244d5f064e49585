// Which of the kernels of ropes are for an instruction set. Registers are short ones: what AVX2 brings is the fused
// multiplication, and AVX-512 nothing more.
#include "deformable_sim/core/rope/rope_kernels.h"

namespace deformable_sim {

namespace simd_sse2 {
extern const RopeKernels rope_kernels;
}
#if defined(__x86_64__)
namespace simd_avx2 {
extern const RopeKernels rope_kernels;
}

const RopeKernels& rope_kernels(SimdLevel level) {
  return level == SimdLevel::kSse2 ? simd_sse2::rope_kernels : simd_avx2::rope_kernels;
}
#else
const RopeKernels& rope_kernels(SimdLevel) {
  return simd_sse2::rope_kernels;
}
#endif

}  // namespace deformable_sim
