// Which instruction sets loops are compiled for.
#pragma once

namespace deformable_sim {

enum class SimdLevel { kSse2, kAvx2, kAvx512 };

/// The widest that this machine has; the environment variable DEFORMABLE_SIM_SIMD (sse2, avx2, avx512) lowers it.
SimdLevel simd_level();
const char* name_of(SimdLevel level);

}  // namespace deformable_sim
