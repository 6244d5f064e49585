#include "deformable_sim/core/contact/contact_points.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace deformable_sim {
namespace {

/// Halves [first, last) across its longest extent until it holds at most `size` points.
void split(const std::vector<Vec3>& at, int size, int first, int last, std::vector<int>* order,
           std::vector<PointBlock>* blocks) {
  if (last - first <= size) {
    if (last > first) blocks->push_back({first, last});
    return;
  }
  Eigen::AlignedBox3d box;
  for (int i = first; i < last; ++i) box.extend(at[static_cast<size_t>((*order)[static_cast<size_t>(i)])]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  const auto begin = order->begin();
  // Ties are broken by index, so the order depends on the points alone.
  std::nth_element(begin + first, begin + middle, begin + last, [&](int a, int b) {
    const double xa = at[static_cast<size_t>(a)][axis], xb = at[static_cast<size_t>(b)][axis];
    return xa < xb || (xa == xb && a < b);
  });
  split(at, size, first, middle, order, blocks);
  split(at, size, middle, last, order, blocks);
}

}  // namespace

Vec3 position(const ContactPoint& point, const Nodes& x) {
  Vec3 p = x.col(point.node[0]);
  if (point.count == 1) return p;
  for (int k = 1; k < point.count; ++k) p += x.col(point.node[static_cast<size_t>(k)]);
  return p / point.count;
}

void add_node_points(const Model& model, int body, std::vector<ContactPoint>* points) {
  const Body& b = model.bodies[static_cast<size_t>(body)];
  // Of a solid only the surface can touch anything.
  std::vector<char> outside(static_cast<size_t>(b.node_count), b.volume ? 0 : 1);
  if (b.volume) {
    for (const auto& t : b.surface->triangles)
      for (int node : t) outside[static_cast<size_t>(node)] = 1;
  }
  for (int i = 0; i < b.node_count; ++i)
    if (outside[static_cast<size_t>(i)]) points->push_back({{{b.first_node + i, -1, -1}}, 1, body});
}

void add_between_points(const Model& model, int body, std::vector<ContactPoint>* points) {
  const Body& b = model.bodies[static_cast<size_t>(body)];
  const int first = b.first_node;
  if (b.line) {
    for (int s = 0; s < b.line->segment_count(); ++s) {
      const auto [i, j] = b.line->segment(s);
      points->push_back({{{first + i, first + j, -1}}, 2, body});
    }
  }
  if (b.surface) {
    for (const auto& [i, j] : edges_of(*b.surface)) points->push_back({{{first + i, first + j, -1}}, 2, body});
    for (const auto& t : b.surface->triangles)
      points->push_back({{{first + t[0], first + t[1], first + t[2]}}, 3, body});
  }
}

std::vector<PointBlock> sort_into_blocks(const Nodes& x, int size, std::vector<ContactPoint>* points) {
  std::vector<Vec3> at;
  for (const ContactPoint& p : *points) at.push_back(position(p, x));
  std::vector<int> order(points->size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<PointBlock> blocks;
  split(at, size, 0, static_cast<int>(order.size()), &order, &blocks);
  // Within a block by index: the same order whatever the library's nth_element leaves.
  for (const PointBlock& b : blocks) std::sort(order.begin() + b.first, order.begin() + b.last);
  std::vector<ContactPoint> sorted;
  for (int i : order) sorted.push_back((*points)[static_cast<size_t>(i)]);
  *points = std::move(sorted);
  return blocks;
}

}  // namespace deformable_sim
