// libFuzzer program for octomap files.
#include "fuzz/libfuzzer.h"
#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  deformable_sim::fuzz::try_octomap({reinterpret_cast<const char*>(data), size});
  return 0;
}
