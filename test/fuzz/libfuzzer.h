// What libFuzzer calls and offers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace deformable_sim {
namespace fuzz {

/// Copies `text`, cut to `max_size`, where libFuzzer wants it; returns its size.
inline std::size_t give_back(const std::string& text, std::size_t max_size, std::uint8_t* out) {
  const std::size_t size = std::min(text.size(), max_size);
  std::memcpy(out, text.data(), size);
  return size;
}

}  // namespace fuzz
}  // namespace deformable_sim
