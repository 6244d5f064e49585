// Counts what a thread takes from the heap. Replaces malloc: included by one file of a program only.
#pragma once

#include <cstdlib>

namespace deformable_sim::test {

inline thread_local bool counting = false;
inline thread_local long allocations = 0;

/// How many times `run` takes memory in this thread.
template <typename Run>
long count_allocations(const Run& run) {
  allocations = 0;
  counting = true;
  run();
  counting = false;
  return allocations;
}

}  // namespace deformable_sim::test

// Eigen takes its memory from malloc, the standard library from operator new, which calls malloc: one hook sees both.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  if (deformable_sim::test::counting) ++deformable_sim::test::allocations;
  return __libc_malloc(size);
}
