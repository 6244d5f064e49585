// libFuzzer program for the material files.
#include "fuzz/libfuzzer.h"
#include "fuzz/targets.h"
#include "fuzz/yaml_mutator.h"

namespace fuzz = deformable_sim::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::try_materials({reinterpret_cast<const char*>(data), size});
  return 0;
}

/// Changes one of the three files.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (seed % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  const std::string text(reinterpret_cast<const char*>(data), size), border = "\n%%\n";
  const std::size_t first = text.find(border);
  const std::size_t second = first == std::string::npos ? first : text.find(border, first + border.size());
  if (second == std::string::npos) return LLVMFuzzerMutate(data, size, max_size);
  const std::size_t begins[] = {0, first + border.size(), second + border.size()}, ends[] = {first, second, size};
  const std::size_t k = seed / 4 % 3;
  const std::string part = text.substr(begins[k], ends[k] - begins[k]);
  return fuzz::give_back(text.substr(0, begins[k]) + fuzz::mutate_yaml(part, "", seed / 12) + text.substr(ends[k]),
                         max_size, data);
}
