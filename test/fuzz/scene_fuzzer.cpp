// libFuzzer program for scene texts.
#include "fuzz/libfuzzer.h"
#include "fuzz/targets.h"
#include "fuzz/yaml_mutator.h"

namespace fuzz = deformable_sim::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::try_scene({reinterpret_cast<const char*>(data), size});
  return 0;
}

/// Three of four changes keep it YAML; the others are of bytes, on what any of the two made.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (seed % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  return fuzz::give_back(fuzz::mutate_yaml({reinterpret_cast<const char*>(data), size}, "", seed / 4), max_size, data);
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* first, std::size_t first_size,
                                                 const std::uint8_t* second, std::size_t second_size, std::uint8_t* out,
                                                 std::size_t max_size, unsigned seed) {
  return fuzz::give_back(fuzz::mutate_yaml({reinterpret_cast<const char*>(first), first_size},
                                           {reinterpret_cast<const char*>(second), second_size}, seed),
                         max_size, out);
}
