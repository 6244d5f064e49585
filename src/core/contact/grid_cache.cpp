#include "deformable_sim/core/contact/grid_cache.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "deformable_sim/core/whole_file.h"

namespace deformable_sim {
namespace {

/// To be raised when grids of the same mesh come to look otherwise.
constexpr std::uint32_t kVersion = 1;

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
  header.checksum = deformable_sim::checksum(values.data(), values.size() * sizeof(float));
  return header;
}

std::filesystem::path file_of(const std::string& folder, std::uint64_t hash) {
  char name[40];
  std::snprintf(name, sizeof name, "grid_%016llx.bin", static_cast<unsigned long long>(hash));
  return std::filesystem::path(folder) / name;
}

}  // namespace

std::uint64_t content_hash(const SolidPart& part) {
  std::uint64_t hash = checksum(&kVersion, sizeof kVersion);
  for (const Vec3& v : part.vertices) hash = checksum(v.data(), 3 * sizeof(double), hash);
  for (const std::array<int, 3>& t : part.triangles) hash = checksum(t.data(), sizeof t, hash);
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
  const Header header = header_of(hash, grid, grid.values());
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes.append(reinterpret_cast<const char*>(grid.values().data()), grid.values().size() * sizeof(float));
  // A cache that cannot be written is none.
  write_whole_file(file_of(folder, hash).string(), bytes);
}

}  // namespace deformable_sim
