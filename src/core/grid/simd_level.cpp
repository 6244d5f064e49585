// Which instruction sets this machine has, and the kernels made for each.
#include <cstdlib>
#include <string>

#include "deformable_sim/core/grid/coarse_kernels.h"
#include "deformable_sim/core/grid/line_kernels.h"
#include "deformable_sim/core/grid/mesh_kernels.h"
#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/grid/stage_kernels.h"
#include "deformable_sim/core/linear/packet_kernels.h"

namespace deformable_sim {

#define DEFORMABLE_SIM_KERNELS(level)                  \
  namespace level {                                    \
  extern const SheetKernels sheet_kernels;             \
  extern const MotionKernels<float> motion_kernels_f;  \
  extern const MotionKernels<double> motion_kernels_d; \
  extern const MeshKernels<float> mesh_kernels_f;      \
  extern const MeshKernels<double> mesh_kernels_d;     \
  extern const StageKernels stage_kernels;             \
  extern const CoarseKernels coarse_kernels;           \
  extern const PacketKernels packet_kernels;           \
  extern const LineKernels<float> line_kernels_f;      \
  extern const LineKernels<double> line_kernels_d;     \
  }
DEFORMABLE_SIM_KERNELS(simd_sse2)
#if defined(__x86_64__)
DEFORMABLE_SIM_KERNELS(simd_avx2)
DEFORMABLE_SIM_KERNELS(simd_avx512)
#endif
#undef DEFORMABLE_SIM_KERNELS

namespace {

SimdLevel widest() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return SimdLevel::kAvx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return SimdLevel::kAvx2;
#endif
  return SimdLevel::kSse2;
}

}  // namespace

SimdLevel simd_level() {
  const SimdLevel most = widest();
  const char* wanted = std::getenv("DEFORMABLE_SIM_SIMD");
  if (wanted == nullptr) return most;
  for (SimdLevel level : {SimdLevel::kSse2, SimdLevel::kAvx2}) {
    if (std::string(wanted) == name_of(level) && level < most) return level;
  }
  return most;
}

const char* name_of(SimdLevel level) {
  switch (level) {
    case SimdLevel::kAvx512:
      return "avx512";
    case SimdLevel::kAvx2:
      return "avx2";
    case SimdLevel::kSse2:
      break;
  }
  return "sse2";
}

#if defined(__x86_64__)
const SheetKernels& sheet_kernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return simd_avx512::sheet_kernels;
  return level == SimdLevel::kAvx2 ? simd_avx2::sheet_kernels : simd_sse2::sheet_kernels;
}
const MotionKernels<float>& motion_kernels(SimdLevel level, float) {
  if (level == SimdLevel::kAvx512) return simd_avx512::motion_kernels_f;
  return level == SimdLevel::kAvx2 ? simd_avx2::motion_kernels_f : simd_sse2::motion_kernels_f;
}
const MotionKernels<double>& motion_kernels(SimdLevel level, double) {
  if (level == SimdLevel::kAvx512) return simd_avx512::motion_kernels_d;
  return level == SimdLevel::kAvx2 ? simd_avx2::motion_kernels_d : simd_sse2::motion_kernels_d;
}
const MeshKernels<float>& mesh_kernels(SimdLevel level, float) {
  if (level == SimdLevel::kAvx512) return simd_avx512::mesh_kernels_f;
  return level == SimdLevel::kAvx2 ? simd_avx2::mesh_kernels_f : simd_sse2::mesh_kernels_f;
}
const MeshKernels<double>& mesh_kernels(SimdLevel level, double) {
  if (level == SimdLevel::kAvx512) return simd_avx512::mesh_kernels_d;
  return level == SimdLevel::kAvx2 ? simd_avx2::mesh_kernels_d : simd_sse2::mesh_kernels_d;
}
const PacketKernels& packet_kernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return simd_avx512::packet_kernels;
  return level == SimdLevel::kAvx2 ? simd_avx2::packet_kernels : simd_sse2::packet_kernels;
}
const StageKernels& stage_kernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return simd_avx512::stage_kernels;
  return level == SimdLevel::kAvx2 ? simd_avx2::stage_kernels : simd_sse2::stage_kernels;
}
const CoarseKernels& coarse_kernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return simd_avx512::coarse_kernels;
  return level == SimdLevel::kAvx2 ? simd_avx2::coarse_kernels : simd_sse2::coarse_kernels;
}
const LineKernels<float>& line_kernels(SimdLevel level, float) {
  if (level == SimdLevel::kAvx512) return simd_avx512::line_kernels_f;
  return level == SimdLevel::kAvx2 ? simd_avx2::line_kernels_f : simd_sse2::line_kernels_f;
}
const LineKernels<double>& line_kernels(SimdLevel level, double) {
  if (level == SimdLevel::kAvx512) return simd_avx512::line_kernels_d;
  return level == SimdLevel::kAvx2 ? simd_avx2::line_kernels_d : simd_sse2::line_kernels_d;
}
#else
const LineKernels<float>& line_kernels(SimdLevel, float) {
  return simd_sse2::line_kernels_f;
}
const LineKernels<double>& line_kernels(SimdLevel, double) {
  return simd_sse2::line_kernels_d;
}
const MotionKernels<double>& motion_kernels(SimdLevel, double) {
  return simd_sse2::motion_kernels_d;
}
const MotionKernels<float>& motion_kernels(SimdLevel, float) {
  return simd_sse2::motion_kernels_f;
}
const CoarseKernels& coarse_kernels(SimdLevel) {
  return simd_sse2::coarse_kernels;
}
const MeshKernels<double>& mesh_kernels(SimdLevel, double) {
  return simd_sse2::mesh_kernels_d;
}
const MeshKernels<float>& mesh_kernels(SimdLevel, float) {
  return simd_sse2::mesh_kernels_f;
}
const PacketKernels& packet_kernels(SimdLevel) {
  return simd_sse2::packet_kernels;
}
const StageKernels& stage_kernels(SimdLevel) {
  return simd_sse2::stage_kernels;
}
const SheetKernels& sheet_kernels(SimdLevel) {
  return simd_sse2::sheet_kernels;
}
#endif

}  // namespace deformable_sim
