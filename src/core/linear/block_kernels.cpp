#include "deformable_sim/core/linear/block_kernels.h"

namespace deformable_sim {

namespace simd_sse2 {
extern const BlockKernels block_kernels;
}
#if defined(__x86_64__)
namespace simd_avx2 {
extern const BlockKernels block_kernels;
}

const BlockKernels& block_kernels(SimdLevel level) {
  return level == SimdLevel::kSse2 ? simd_sse2::block_kernels : simd_avx2::block_kernels;
}
#else
const BlockKernels& block_kernels(SimdLevel) {
  return simd_sse2::block_kernels;
}
#endif

}  // namespace deformable_sim
