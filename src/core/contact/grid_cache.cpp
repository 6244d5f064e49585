#include "deformable_sim/core/contact/grid_cache.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace deformable_sim {
namespace {

constexpr std::uint64_t kStart = 14695981039346656037ull;
/// To be raised when grids of the same mesh come to look otherwise.
constexpr std::uint32_t kVersion = 1;

std::uint64_t hash_of(const void* data, size_t bytes, std::uint64_t hash) {
  const auto* byte = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < bytes; ++i) hash = (hash ^ byte[i]) * 1099511628211ull;
  return hash;
}

struct Header {
  char magic[8] = {'d', 's', 'i', 'm', 'g', 'r', 'i', 'd'};
  std::uint32_t version = kVersion;
  std::uint32_t byte_order = 0x01020304;
  std::uint64_t hash = 0;
  std::int32_t size[3] = {0, 0, 0};
  std::uint32_t unused = 0;  // no padding: headers are compared byte by byte
  double origin[3] = {0, 0, 0};
  double spacing = 0.0;
  std::uint64_t checksum = 0;  // of the values
};

Header header_of(std::uint64_t hash, const DistanceGrid& grid, const std::vector<float>& values) {
  Header header;
  header.hash = hash;
  for (int k = 0; k < 3; ++k) {
    header.size[k] = grid.size()[k];
    header.origin[k] = grid.origin()[k];
  }
  header.spacing = grid.spacing();
  header.checksum = hash_of(values.data(), values.size() * sizeof(float), kStart);
  return header;
}

std::filesystem::path file_of(const std::string& folder, std::uint64_t hash) {
  char name[40];
  std::snprintf(name, sizeof name, "grid_%016llx.bin", static_cast<unsigned long long>(hash));
  return std::filesystem::path(folder) / name;
}

}  // namespace

std::uint64_t content_hash(const SolidPart& part) {
  std::uint64_t hash = hash_of(&kVersion, sizeof kVersion, kStart);
  for (const Vec3& v : part.vertices) hash = hash_of(v.data(), 3 * sizeof(double), hash);
  for (const std::array<int, 3>& t : part.triangles) hash = hash_of(t.data(), sizeof t, hash);
  return hash;
}

bool read_grid(const std::string& folder, std::uint64_t hash, DistanceGrid* grid) {
  std::ifstream in(file_of(folder, hash), std::ios::binary);
  Header header;
  std::vector<float> values(static_cast<size_t>(grid->size().prod()));
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (!in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float))))
    return false;
  const Header expected = header_of(hash, *grid, values);
  if (std::memcmp(&header, &expected, sizeof header) != 0 || in.peek() != std::ifstream::traits_type::eof())
    return false;
  for (const float value : values)
    if (!std::isfinite(value)) return false;
  grid->set_values(std::move(values));
  return true;
}

void write_grid(const std::string& folder, std::uint64_t hash, const DistanceGrid& grid) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const std::filesystem::path file = file_of(folder, hash);
  // A name of its own until it is whole; another writer of the same grid then replaces it by the same.
  std::string scratch = file.string() + ".XXXXXX";
  const int handle = mkstemp(scratch.data());
  if (handle < 0) return;
  close(handle);
  bool written = false;
  {
    std::ofstream out(scratch, std::ios::binary);
    const Header header = header_of(hash, grid, grid.values());
    out.write(reinterpret_cast<const char*>(&header), sizeof header);
    out.write(reinterpret_cast<const char*>(grid.values().data()),
              static_cast<std::streamsize>(grid.values().size() * sizeof(float)));
    out.flush();
    written = out.good();
  }
  if (written) std::filesystem::rename(scratch, file, error);
  if (!written || error) std::filesystem::remove(scratch, error);
}

}  // namespace deformable_sim
