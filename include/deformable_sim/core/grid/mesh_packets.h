// Nodes that any springs and constant links join, as the kernels of explicit steps want them.
#pragma once

#include <vector>

#include "deformable_sim/core/grid/link_split.h"
#include "deformable_sim/core/grid/mesh_kernels.h"
#include "deformable_sim/core/grid/sheet_rows.h"
#include "deformable_sim/core/linear/constant_links.h"

namespace deformable_sim {

/// A spring between world nodes a and b: rest length (m), stiffness (N/m), damping (N s/m).
struct MeshSpring {
  int a, b;
  double length, stiffness, damping;
};

/// Nodes in packets of `width`: breadth first along the springs, so that neighbours lie near each other, and among some
/// hundred by their number of fast links and of springs, so that packets have few empty entries. The springs and links
/// may go; the packets stay.
///
/// Not good at: a few nodes with many times the springs of the others.
template <class Real>
class MeshPackets {
 public:
  /// mass: kg of all nodes of the world; only those with a spring have a place. All links have the same damping.
  MeshPackets(const Eigen::VectorXd& mass, const std::vector<MeshSpring>& springs,
              const std::vector<const ConstantLinks*>& links, const LinkSplit& split, int width);
  MeshPackets(const MeshPackets&) = delete;
  MeshPackets& operator=(const MeshPackets&) = delete;

  const MeshShape<Real>& shape() const { return shape_; }
  int width() const { return width_; }
  bool has_links() const { return !fast_.place.empty() || !slow_.place.empty(); }
  /// World nodes in their order.
  const std::vector<int>& nodes() const { return node_; }
  /// Where a world node comes in that order, -1: nowhere.
  int index(int node) const { return index_[static_cast<size_t>(node)]; }
  /// Where its x lies among numbers by packets; y and z follow at a width.
  std::ptrdiff_t place(int index) const { return index / width_ * 3 * width_ + index % width_; }

  /// Numbers by packets; points of four numbers; numbers by node.
  template <class Number>
  RowArray<Number> make_coordinates() const {
    return {1, 3 * room()};
  }
  template <class Number>
  RowArray<Number> make_points() const {
    return {1, 4 * room()};
  }
  RowArray<Real> make_numbers() const { return {1, room()}; }

 private:
  struct Row {
    int column;
    double value, rest, damping;
  };
  struct Entries {
    std::vector<int> start, place;
    std::vector<Real> value, rest, damping;
    MeshEntries<Real> view() const;
  };
  std::ptrdiff_t room() const { return static_cast<std::ptrdiff_t>(shape_.packets) * width_; }
  using Rows = std::vector<std::vector<Row>>;
  void order(const Rows& springs, const Rows& fast, const Rows& slow);
  Entries pack(const Rows& rows) const;

  int width_;
  MeshShape<Real> shape_{};
  std::vector<int> node_, index_;
  Entries springs_, fast_, slow_;
};

extern template class MeshPackets<float>;
extern template class MeshPackets<double>;

}  // namespace deformable_sim
