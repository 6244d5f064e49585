// What the vector kernels take from GCC and clang lacks, slow and right: included before them where fuzzers are built.
#pragma once

namespace deformable_sim {

/// Lane k of the result is lane mask[k] of `a`.
template <class Vector, class Mask>
inline Vector __builtin_shuffle(Vector a, Mask mask) {
  constexpr int kLanes = sizeof(Vector) / sizeof(a[0]);
  Vector result = a;
  for (int k = 0; k < kLanes; ++k) result[k] = a[mask[k] & (kLanes - 1)];
  return result;
}

/// The same of the lanes of `a` and behind them those of `b`.
template <class Vector, class Mask>
inline Vector __builtin_shuffle(Vector a, Vector b, Mask mask) {
  constexpr int kLanes = sizeof(Vector) / sizeof(a[0]);
  Vector result = a;
  for (int k = 0; k < kLanes; ++k) {
    const int from = static_cast<int>(mask[k] & (2 * kLanes - 1));
    result[k] = from < kLanes ? a[from] : b[from - kLanes];
  }
  return result;
}

}  // namespace deformable_sim
