// Lets a test have four threads on a machine of fewer cores.
#pragma once

#include <tbb/global_control.h>

namespace deformable_sim::test {

class FourThreads {
 private:
  tbb::global_control limit_{tbb::global_control::max_allowed_parallelism, 4};
};

}  // namespace deformable_sim::test
