#include "deformable_sim/core/contact/voxel_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "deformable_sim/core/error.h"
#include "piece_planes.h"

namespace deformable_sim {
namespace {

constexpr int kCells = 1 << kVoxelLevels;
constexpr int kLeafSquares = 4;
/// In shares of the farthest coordinate, m or cells: rounding.
constexpr double kLeastDistance = 1e-13;

/// Sixteen bits, two places apart.
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 16) & 0x0000ff0000ffULL;
  v = (v | v << 8) & 0x00f00f00f00fULL;
  v = (v | v << 4) & 0x0c30c30c30c3ULL;
  return (v | v << 2) & 0x249249249249ULL;
}

std::uint64_t morton(const std::array<int, 3>& key) {
  return spread(static_cast<std::uint64_t>(key[0])) | spread(static_cast<std::uint64_t>(key[1])) << 1 |
         spread(static_cast<std::uint64_t>(key[2])) << 2;
}

std::array<int, 3> cells_of(const VoxelCube& cube) {
  return {cube.key[0], cube.key[1], cube.key[2]};
}

std::uint64_t cell_count(int level) {
  return std::uint64_t{1} << (3 * level);
}

void check(const std::vector<VoxelCube>& cubes, double resolution) {
  if (!(resolution >= 1e-4 && resolution <= 100.0)) throw InputError("resolution must be 1e-4 ... 100 m");
  if (cubes.empty()) throw InputError("has no occupied space");
  if (cubes.size() > static_cast<size_t>(kMostVoxelCubes))
    throw InputError("has " + std::to_string(cubes.size()) + " occupied voxels, at most " +
                         std::to_string(kMostVoxelCubes) + " are allowed",
                     Code::kOutOfRange);
  for (const VoxelCube& cube : cubes)
    for (const int k : cube.key)
      if (cube.level < 0 || cube.level > kVoxelLevels || k % (1 << cube.level) != 0)
        throw InputError("a cube does not fit the grid");
}

template <class Node>
double squared_distance(const Node& node, const Vec3& p) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<size_t>(k);
    const double away = std::max({node.low[i] - p[k], 0.0, p[k] - node.high[i]});
    sum += away * away;
  }
  return sum;
}

Vec3 outward(const VoxelSquare& square) {
  return square.outwards * Vec3::Unit(square.axis);
}

SquarePoint nearest_on_square(const Vec3& p, const VoxelSquare& square) {
  SquarePoint found;
  for (int k = 0; k < 3; ++k) {
    const double low = square.corner[static_cast<size_t>(k)];
    found.point[k] = std::clamp(p[k], low, k == square.axis ? low : low + square.size);
  }
  found.squared_distance = (p - found.point).squaredNorm();
  return found;
}

}  // namespace

VoxelSolid::VoxelSolid(std::vector<VoxelCube> cubes, double resolution)
    : resolution_(resolution), cubes_(std::move(cubes)) {
  check(cubes_, resolution);
  std::sort(cubes_.begin(), cubes_.end(),
            [](const VoxelCube& a, const VoxelCube& b) { return morton(cells_of(a)) < morton(cells_of(b)); });
  for (const VoxelCube& cube : cubes_) first_cell_.push_back(morton(cells_of(cube)));
  for (const VoxelCube& cube : cubes_) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int outwards : {-1, 1}) {
        std::array<int, 3> beside = cells_of(cube);
        beside[static_cast<size_t>(axis)] += outwards * (1 << cube.level);
        add_face(beside, cube.level, axis, outwards);
      }
  }
  nodes_.reserve(squares_.size());
  add_node(0, static_cast<int>(squares_.size()));
  const Node& all = nodes_.front();
  const Eigen::Map<const Eigen::Vector3i> low(all.low.data()), high(all.high.data());
  box_ = Eigen::AlignedBox3d(Vec3(resolution_ * low.cast<double>()), Vec3(resolution_ * high.cast<double>()));
  const Vec3 farthest = box_.min().cwiseAbs().cwiseMax(box_.max().cwiseAbs());
  radius_ = farthest.norm();
  least_ = kLeastDistance * (radius_ / resolution_ + 1.0);
}

VoxelSolid::Cover VoxelSolid::cover(const std::array<int, 3>& key, int level) const {
  const std::uint64_t begin = morton(key), end = begin + cell_count(level);
  const auto after = std::upper_bound(first_cell_.begin(), first_cell_.end(), begin);
  if (after != first_cell_.begin()) {
    const auto before = static_cast<size_t>(after - first_cell_.begin()) - 1;
    if (first_cell_[before] + cell_count(cubes_[before].level) >= end) return Cover::kAll;
    if (first_cell_[before] == begin) return Cover::kSome;
  }
  return after != first_cell_.end() && *after < end ? Cover::kSome : Cover::kNone;
}

/// `key`, `level`: the cube beyond the face; outwards leads into it.
void VoxelSolid::add_face(const std::array<int, 3>& key, int level, int axis, int outwards) {
  const auto a = static_cast<size_t>(axis);
  const bool beyond_grid = key[a] < 0 || key[a] >= kCells;
  const Cover covered = beyond_grid ? Cover::kNone : cover(key, level);
  if (covered == Cover::kAll) return;
  const int size = 1 << level;
  if (covered == Cover::kNone) {
    VoxelSquare square{key, size, axis, outwards};
    if (outwards < 0) square.corner[a] += size;
    for (int& c : square.corner) c -= kVoxelOrigin;
    squares_.push_back(square);
    return;
  }
  const int half = size / 2;
  for (int part = 0; part < 4; ++part) {
    std::array<int, 3> quarter = key;
    if (outwards < 0) quarter[a] += half;
    quarter[(a + 1) % 3] += (part & 1) * half;
    quarter[(a + 2) % 3] += (part >> 1) * half;
    add_face(quarter, level - 1, axis, outwards);
  }
}

/// Squares follow the Morton curve of their cubes: halves of their list lie apart in space.
int VoxelSolid::add_node(int first, int last) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  Node node;
  node.low.fill(std::numeric_limits<int>::max());
  node.high.fill(std::numeric_limits<int>::min());
  const auto extend = [&node](const std::array<int, 3>& low, const std::array<int, 3>& high) {
    for (size_t k = 0; k < 3; ++k) {
      node.low[k] = std::min(node.low[k], low[k]);
      node.high[k] = std::max(node.high[k], high[k]);
    }
  };
  node.first = first;
  if (last - first <= kLeafSquares) {
    node.count = last - first;
    for (int i = first; i < last; ++i) {
      const VoxelSquare& square = squares_[static_cast<size_t>(i)];
      std::array<int, 3> high = square.corner;
      for (int k = 0; k < 3; ++k)
        if (k != square.axis) high[static_cast<size_t>(k)] += square.size;
      extend(square.corner, high);
    }
  } else {
    const int middle = first + (last - first) / 2;
    add_node(first, middle);
    node.right = add_node(middle, last);
    for (const size_t child : {index + 1, static_cast<size_t>(node.right)})
      extend(nodes_[child].low, nodes_[child].high);
  }
  nodes_[index] = node;
  return static_cast<int>(index);
}

bool VoxelSolid::occupied_cell(const Vec3& p) const {
  std::array<int, 3> key{};
  for (int k = 0; k < 3; ++k) {
    const double cell = std::floor(p[k]) + kVoxelOrigin;
    if (!(cell >= 0.0 && cell < kCells)) return false;
    key[static_cast<size_t>(k)] = static_cast<int>(cell);
  }
  return cover(key, 0) == Cover::kAll;
}

bool VoxelSolid::occupied(const Vec3& p) const {
  return occupied_cell(p / resolution_);
}

void VoxelSolid::descend(int index, const Vec3& p, SquarePoint* best) const {
  const Node& node = nodes_[static_cast<size_t>(index)];
  for (int i = node.first; i < node.first + node.count; ++i) {
    SquarePoint candidate = nearest_on_square(p, squares_[static_cast<size_t>(i)]);
    candidate.square = i;
    if (candidate.squared_distance < best->squared_distance) *best = candidate;
  }
  if (node.count > 0) return;
  int near = index + 1, far = node.right;
  double near_distance = squared_distance(nodes_[static_cast<size_t>(near)], p);
  double far_distance = squared_distance(nodes_[static_cast<size_t>(far)], p);
  if (far_distance < near_distance) {
    std::swap(near, far);
    std::swap(near_distance, far_distance);
  }
  if (near_distance < best->squared_distance) descend(near, p, best);
  if (far_distance < best->squared_distance) descend(far, p, best);
}

void VoxelSolid::within(int index, const Vec3& p, double squared_reach, std::vector<SquarePoint>* found) const {
  const Node& node = nodes_[static_cast<size_t>(index)];
  if (squared_distance(node, p) > squared_reach) return;
  if (node.count == 0) {
    within(index + 1, p, squared_reach, found);
    within(node.right, p, squared_reach, found);
    return;
  }
  for (int i = node.first; i < node.first + node.count; ++i) {
    SquarePoint candidate = nearest_on_square(p, squares_[static_cast<size_t>(i)]);
    candidate.square = i;
    if (candidate.squared_distance <= squared_reach) found->push_back(candidate);
  }
}

/// The plane through the nearest point of a square, p on its outer side whichever face of the square p sees.
MeshPoint VoxelSolid::facing(const Vec3& p, const SquarePoint& nearest) const {
  MeshPoint plane;
  plane.triangle = nearest.square;
  plane.distance = std::sqrt(nearest.squared_distance);
  plane.normal = plane.distance > least_ ? Vec3((p - nearest.point) / plane.distance)
                                         : outward(squares_[static_cast<size_t>(nearest.square)]);
  return plane;
}

bool VoxelSolid::exact(const Vec3& p, double reach, MeshPoint* found) const {
  SquarePoint best;
  // A square exactly at the reach counts, rounding included.
  best.squared_distance = reach * reach * (1.0 + 1e-12) + std::numeric_limits<double>::min();
  if (squared_distance(nodes_.front(), p) > best.squared_distance) return false;
  descend(0, p, &best);
  const bool inside = occupied_cell(p);
  if (best.square < 0) {
    if (!inside) return false;
    best.squared_distance = std::numeric_limits<double>::infinity();
    descend(0, p, &best);
  }
  *found = facing(p, best);
  if (inside) {
    found->distance = -found->distance;
    if (best.squared_distance > least_ * least_) found->normal = -found->normal;
  }
  return true;
}

bool VoxelSolid::nearest(const Vec3& p, double reach, MeshPoint* found) const {
  if (!exact(p / resolution_, reach / resolution_, found)) return false;
  found->distance *= resolution_;
  return found->distance <= reach;
}

void VoxelSolid::gather(const Vec3& p, double reach, double clearance, std::vector<SquarePoint>* work,
                        std::vector<MeshPoint>* planes) const {
  work->clear();
  within(0, p, reach * reach, work);
  const auto number_of = [](const SquarePoint& c) { return c.square; };
  const auto face = [&](const SquarePoint& c) { return facing(p, c); };
  const auto height = [&](const MeshPoint& plane, const SquarePoint& c) {
    const VoxelSquare& square = squares_[static_cast<size_t>(c.square)];
    double highest = plane.distance;
    for (int k = 0; k < 3; ++k) {
      const double extent = k == square.axis ? 0.0 : square.size;
      highest +=
          plane.normal[k] * (square.corner[static_cast<size_t>(k)] - p[k]) + std::max(0.0, plane.normal[k] * extent);
    }
    return highest;
  };
  gather_planes({clearance, 0.0, least_}, number_of, face, height, work, planes);
}

void VoxelSolid::planes(const Vec3& p, const MeshPoint& surface, double reach, double clearance,
                        std::vector<SquarePoint>* work, std::vector<MeshPoint>* planes) const {
  const double cell = 1.0 / resolution_;
  MeshPoint here = surface;
  here.distance *= cell;
  const PlaneLimits limits{cell * clearance, 0.0, least_};
  const size_t first = planes->size();
  planes_at(
      Vec3(cell * p), here, cell * reach, limits,
      [this](const Vec3& at, double within_reach, MeshPoint* found) { return exact(at, within_reach, found); },
      [&](const Vec3& at, double within_reach) { gather(at, within_reach, limits.clearance, work, planes); }, planes);
  for (size_t k = first; k < planes->size(); ++k) (*planes)[k].distance *= resolution_;
}

}  // namespace deformable_sim
