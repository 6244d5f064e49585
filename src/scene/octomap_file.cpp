#include "deformable_sim/scene/octomap_file.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <vector>

#include "deformable_sim/core/contact/voxel_solid.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr std::uintmax_t kMostBytes = 256u << 20;
constexpr size_t kLongestHeader = 65536;

/// Reads one tree, depth first, as OctoMap writes it.
class TreeReader {
 public:
  TreeReader(const std::string& data, size_t bytes_after_odds) : data_(data), bytes_after_odds_(bytes_after_odds) {}

  std::vector<VoxelCube> read(bool binary) {
    if (binary) {
      read_binary({}, kVoxelLevels);
    } else {
      read_full({}, kVoxelLevels);
    }
    if (at_ != data_.size())
      throw InputError(std::to_string(data_.size() - at_) + " bytes follow the tree; is its id the right one?");
    return std::move(cubes_);
  }

 private:
  using Key = std::array<std::uint16_t, 3>;

  void take(void* out, size_t count) {
    if (data_.size() - at_ < count) throw InputError("the tree ends early, after " + std::to_string(at_) + " bytes");
    std::memcpy(out, data_.data() + at_, count);
    at_ += count;
  }

  static Key child_of(const Key& key, int level, int child) {
    Key result = key;
    for (int k = 0; k < 3; ++k)
      if ((child >> k & 1) != 0) result[static_cast<size_t>(k)] |= static_cast<std::uint16_t>(1 << (level - 1));
    return result;
  }

  void add(const Key& key, int level) {
    if (cubes_.size() >= static_cast<size_t>(kMostVoxelCubes))
      throw InputError("has more than " + std::to_string(kMostVoxelCubes) + " occupied voxels", Code::kOutOfRange);
    cubes_.push_back({key, level});
  }

  /// Two bits a child: 01 free, 10 occupied (the higher bit first), 11 has children.
  void read_binary(const Key& key, int level) {
    if (level == 0) throw InputError("the tree is deeper than 16 levels");
    unsigned char bytes[2];
    take(bytes, 2);
    const unsigned bits = bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
    for (int child = 0; child < 8; ++child)
      if ((bits >> (2 * child) & 3U) == 2U) add(child_of(key, level, child), level - 1);
    for (int child = 0; child < 8; ++child)
      if ((bits >> (2 * child) & 3U) == 3U) read_binary(child_of(key, level, child), level - 1);
  }

  /// Log odds, what else a node of this kind has, and a bit for each child.
  void read_full(const Key& key, int level) {
    float odds = 0.0F;
    unsigned char rest[4], children = 0;
    take(&odds, sizeof odds);
    take(rest, bytes_after_odds_);
    take(&children, 1);
    if (std::isnan(odds)) throw InputError("a node's log odds are not a number");
    if (children == 0) {
      if (odds >= 0.0F) add(key, level);
      return;
    }
    if (level == 0) throw InputError("the tree is deeper than 16 levels");
    for (int child = 0; child < 8; ++child)
      if ((children >> child & 1) != 0) read_full(child_of(key, level, child), level - 1);
  }

  const std::string& data_;
  size_t bytes_after_odds_;
  size_t at_ = 0;
  std::vector<VoxelCube> cubes_;
};

size_t bytes_after_odds(const std::string& id) {
  if (id == "OcTree" || id == "OcTreeStamped") return 0;
  if (id == "ColorOcTree") return 3;
  throw InputError("octree id '" + id.substr(0, 40) + "'; OcTree, OcTreeStamped and ColorOcTree are allowed");
}

/// Reads the header's `key value` lines; `*bytes` keeps what follows the line `data`.
OctomapTree split_header(const std::string& bytes) {
  OctomapTree tree;
  const std::string first = bytes.substr(0, bytes.find('\n'));
  tree.binary = first.rfind("# Octomap OcTree binary file", 0) == 0;
  if (!tree.binary && first.rfind("# Octomap OcTree file", 0) != 0)
    throw InputError("not an OctoMap file: its first line must be '# Octomap OcTree file' or '... binary file'");
  size_t at = first.size() + 1;
  while (at < bytes.size() && at < kLongestHeader) {
    const size_t end = std::min(bytes.find('\n', at), bytes.size());
    std::istringstream line(bytes.substr(at, end - at));
    at = end + 1;
    std::string key;
    line >> key;
    if (key == "id") line >> tree.id;
    if (key == "res") line >> tree.resolution;
    if (key != "data") continue;
    if (at <= bytes.size()) tree.data = bytes.substr(at);
    return tree;
  }
  throw InputError("the header has no line 'data'");
}

}  // namespace

Shape octomap_shape(const OctomapTree& tree) {
  if (!std::isfinite(tree.resolution)) throw InputError("resolution must be 1e-4 ... 100 m");
  const size_t more = bytes_after_odds(tree.id);
  Shape shape;
  shape.type = Shape::Type::kVoxels;
  std::vector<VoxelCube> cubes;
  if (!tree.data.empty()) cubes = TreeReader(tree.data, more).read(tree.binary);
  shape.voxels = std::make_shared<const VoxelSolid>(std::move(cubes), tree.resolution);
  return shape;
}

Shape octomap_from_bytes(const std::string& bytes, const std::string& name) {
  try {
    return octomap_shape(split_header(bytes));
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what(), error.code());
  }
}

Shape load_octomap(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path + ": no such file", Code::kNotFound);
  if (std::filesystem::file_size(path, error) > kMostBytes)
    throw InputError(path + ": larger than " + std::to_string(kMostBytes >> 20) + " MiB", Code::kOutOfRange);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path + ": cannot be read", Code::kNotFound);
  return octomap_from_bytes({std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()}, path);
}

}  // namespace deformable_sim
