// Files that are there as a whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace deformable_sim {

constexpr std::uint64_t kChecksumStart = 14695981039346656037ull;

/// FNV-1a, 64 bits [Fowler, Noll & Vo]: tells files that were cut or altered by accident, not by intent.
inline std::uint64_t checksum(const void* data, std::size_t bytes, std::uint64_t so_far = kChecksumStart) {
  const auto* byte = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; ++i) so_far = (so_far ^ byte[i]) * 1099511628211ull;
  return so_far;
}

/// Writes `bytes` under a name of their own in the same folder, waits until they are on the disk, and renames: whoever
/// is killed at any moment leaves the file as it was before or as it is now. Makes the folder. What went wrong, or
/// empty.
std::string write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace deformable_sim
