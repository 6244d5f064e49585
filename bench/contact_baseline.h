// What contact costs at least: the same detection as plain loops, written for these scenes alone.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {
namespace bench {

/// A node and a triangle (first = 1) or two edges (first = 2) of bodies, or a node (first = 1, the others -1) and a
/// collider.
struct BaselineContact {
  std::array<int, 4> node;
  std::array<double, 4> weight;  // of the first, then of the second part, each summing to 1
  int first;
  int collider;     // -1: of bodies
  double distance;  // m; to a collider's surface with its sign
};

/// Nodes against triangles and edges against edges of all bodies in a hashed grid of boxes; nodes against colliders by
/// formulas, against meshes by their triangles in a grid. One loop after the other, no virtual call, single thread.
///
/// It finds what comes nearer than the contact radii together plus the ways that the parts may make in the step:
/// 1.25 |v - mean v| dt and 2 mm each. It does nothing else: neither merges what several pieces find alike, nor
/// remembers where contacts stick, nor looks after the step whether all stayed on their sides, as the library does.
class ContactBaseline {
 public:
  explicit ContactBaseline(const Model& model);
  void set_colliders(const std::vector<Collider>& colliders);
  /// All contacts of the step of dt (s) from x, v; colliders where `colliders` have them.
  void find(const Nodes& x, const Nodes& v, double dt, const std::vector<Collider>& colliders);
  const std::vector<BaselineContact>& contacts() const { return contacts_; }

 private:
  struct Box {
    Vec3 low, high;
  };
  struct Triangle {
    std::array<int, 3> node;
    double radius;
  };
  struct Edge {
    std::array<int, 2> node;
    double radius;
  };
  /// Items by cell: those of cell c are item[begin[c]] ... item[begin[c + 1] - 1].
  struct Cells {
    double size = 1.0;
    unsigned mask = 0;
    std::vector<int> begin, item;
  };
  struct MeshCells {
    const ColliderMesh* mesh;
    Cells cells;
  };

  static unsigned hash(int i, int j, int k) {
    return static_cast<unsigned>(i) * 73856093u ^ static_cast<unsigned>(j) * 19349663u ^
           static_cast<unsigned>(k) * 83492791u;
  }
  template <typename Visit>
  static void for_each_cell(const Cells& cells, const Box& box, const Visit& visit);
  template <typename BoxOf>
  static void fill(size_t count, const BoxOf& box_of, Cells* cells);
  void foresee(const Nodes& v, double dt);
  void find_nodes_on_triangles(const Nodes& x);
  void find_edges_on_edges(const Nodes& x);
  void test_edges(size_t one, size_t other, const Nodes& x);
  void find_on_collider(int index, const Collider& collider, const Nodes& x);
  static Box extent_of(const Shape& shape);
  double distance(const Shape& shape, const Vec3& p, double reach);
  double mesh_distance(const ColliderMesh& mesh, const Vec3& p, double reach);

  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<double> radius_, reach_;  // by node; reach: the way it may make
  Cells node_cells_, edge_cells_;
  std::vector<Box> boxes_, node_blocks_;  // of edges; of nodes
  std::vector<MeshCells> meshes_;
  std::vector<int> seen_;
  int look_ = 0;
  std::vector<BaselineContact> contacts_;
};

}  // namespace bench
}  // namespace deformable_sim
