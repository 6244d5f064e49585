#include "contact_baseline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kMargin = 0.002;  // m
constexpr double kShare = 1.25;    // of the way foreseen
constexpr int kBlock = 32;         // nodes
constexpr double kCell = 1.5;      // of the mean extent of an edge's box: the best of .7, 1, 1.5, 2
constexpr size_t kTable = 4;       // cells an edge

double unit(double s) {
  return s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
}

/// Weights {s, t} of b in a b and of d in c d at the nearest points of two segments.
void nearest_of_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double* s, double* t) {
  const Vec3 u = b - a, v = d - c, w = a - c;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), uw = u.dot(w), vw = v.dot(w), sine = uu * vv - uv * uv;
  *s = sine > 1e-12 * uu * vv ? unit((uv * vw - vv * uw) / sine) : unit(-uw / uu);
  *t = (uv * *s + vw) / vv;
  if (*t < 0.0 || *t > 1.0) {
    *t = unit(*t);
    *s = unit((uv * *t - uw) / uu);
  }
}

/// Weights of a, b, c at the nearest point to p.
std::array<double, 3> nearest_of_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e = b - a, f = c - a, w = p - a, normal = e.cross(f);
  const double area = normal.dot(normal), wb = w.cross(f).dot(normal) / area, wc = e.cross(w).dot(normal) / area;
  if (wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0) return {1.0 - wb - wc, wb, wc};
  const Vec3* corner[3] = {&a, &b, &c};
  std::array<double, 3> best{{0, 0, 0}};
  double least = std::numeric_limits<double>::max();
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 &from = *corner[k], way = *corner[(k + 1) % 3] - from;
    const double s = unit(way.dot(p - from) / way.dot(way)), squared = (p - from - s * way).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    best = {{0, 0, 0}};
    best[k] = 1.0 - s;
    best[(k + 1) % 3] = s;
  }
  return best;
}

}  // namespace

template <typename Visit>
void ContactBaseline::for_each_cell(const Cells& cells, const Box& box, const Visit& visit) {
  // Far more than any scene is wide: a cast instead of floor.
  constexpr double kOffset = 1 << 20;
  const double per_m = 1.0 / cells.size;
  std::array<int, 3> low, high;
  for (int d = 0; d < 3; ++d) {
    low[static_cast<size_t>(d)] = static_cast<int>(box.low[d] * per_m + kOffset);
    high[static_cast<size_t>(d)] = static_cast<int>(box.high[d] * per_m + kOffset);
  }
  for (int i = low[0]; i <= high[0]; ++i)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int k = low[2]; k <= high[2]; ++k) visit(hash(i, j, k) & cells.mask);
}

/// Counts, sums up, puts in: no memory is taken but for more items than ever before.
template <typename BoxOf>
void ContactBaseline::fill(size_t count, const BoxOf& box_of, Cells* cells) {
  cells->begin.assign(cells->mask + 2, 0);
  for (size_t i = 0; i < count; ++i) {
    for_each_cell(*cells, box_of(i), [&](unsigned cell) { ++cells->begin[cell + 1]; });
  }
  for (size_t c = 1; c < cells->begin.size(); ++c) cells->begin[c] += cells->begin[c - 1];
  cells->item.resize(static_cast<size_t>(cells->begin.back()));
  for (size_t i = count; i-- > 0;) {
    for_each_cell(*cells, box_of(i), [&](unsigned cell) {
      cells->item[static_cast<size_t>(--cells->begin[cell + 1])] = static_cast<int>(i);
    });
  }
  // Each begin is now where the cell before it began: one place on.
  for (size_t c = 0; c + 1 < cells->begin.size(); ++c) cells->begin[c] = cells->begin[c + 1];
  cells->begin.back() = static_cast<int>(cells->item.size());
}

ContactBaseline::ContactBaseline(const Model& model)
    : radius_(static_cast<size_t>(model.node_count())),
      reach_(radius_.size()),
      node_blocks_((radius_.size() + kBlock - 1) / kBlock) {
  for (const Body& b : model.bodies) {
    const double r = b.contact_radius;
    for (int i = 0; i < b.node_count; ++i) radius_[static_cast<size_t>(b.first_node + i)] = r;
    const auto add_edge = [&](int i, int j) { edges_.push_back({{b.first_node + i, b.first_node + j}, r}); };
    if (b.line) {
      for (int s = 0; s < b.line->segment_count(); ++s) add_edge(b.line->segment(s)[0], b.line->segment(s)[1]);
      continue;
    }
    for (const auto& [i, j] : edges_of(*b.surface)) add_edge(i, j);
    for (const auto& t : b.surface->triangles) {
      triangles_.push_back({{b.first_node + t[0], b.first_node + t[1], b.first_node + t[2]}, r});
    }
  }
  unsigned cells = 1;
  while (cells < kTable * edges_.size()) cells *= 2;
  node_cells_.mask = edge_cells_.mask = cells - 1;
  boxes_.resize(edges_.size());
}

void ContactBaseline::set_colliders(const std::vector<Collider>& colliders) {
  meshes_.clear();
  for (const Collider& c : colliders) {
    for (const Shape& shape : c.shapes) {
      if (shape.type != Shape::Type::kMesh) continue;
      const ColliderMesh& mesh = *shape.mesh;
      MeshCells known{&mesh, {}};
      known.cells.size = mesh.box().sizes().maxCoeff() / 16.0;
      known.cells.mask = 4095;
      fill(
          mesh.triangles().size(),
          [&](size_t t) {
            Box box{mesh.vertices()[static_cast<size_t>(mesh.triangles()[t][0])], {}};
            box.high = box.low;
            for (const int v : mesh.triangles()[t]) {
              box.low = box.low.cwiseMin(mesh.vertices()[static_cast<size_t>(v)]);
              box.high = box.high.cwiseMax(mesh.vertices()[static_cast<size_t>(v)]);
            }
            return box;
          },
          &known.cells);
      meshes_.push_back(std::move(known));
    }
  }
}

void ContactBaseline::foresee(const Nodes& v, double dt) {
  const Vec3 mean = v.rowwise().mean();
  for (size_t i = 0; i < reach_.size(); ++i) {
    reach_[i] = kMargin + kShare * dt * (v.col(static_cast<Eigen::Index>(i)) - mean).norm();
  }
}

void ContactBaseline::find(const Nodes& x, const Nodes& v, double dt, const std::vector<Collider>& colliders) {
  contacts_.clear();
  seen_.resize(std::max({seen_.size(), edges_.size(), reach_.size()}), 0);
  foresee(v, dt);
  find_edges_on_edges(x);
  if (!triangles_.empty()) find_nodes_on_triangles(x);
  if (colliders.empty()) return;
  // Colliders do not move with the bodies: the way is that of the node alone.
  for (size_t i = 0; i < reach_.size(); ++i) {
    reach_[i] = kMargin + kShare * dt * v.col(static_cast<Eigen::Index>(i)).norm();
  }
  for (size_t b = 0; b < node_blocks_.size(); ++b) {
    Box& box = node_blocks_[b];
    box = {Vec3::Constant(1e9), Vec3::Constant(-1e9)};
    for (size_t i = kBlock * b; i < std::min(reach_.size(), kBlock * (b + 1)); ++i) {
      const auto p = x.col(static_cast<Eigen::Index>(i));
      box.low = box.low.cwiseMin((p.array() - reach_[i] - radius_[i]).matrix());
      box.high = box.high.cwiseMax((p.array() + reach_[i] + radius_[i]).matrix());
    }
  }
  for (size_t c = 0; c < colliders.size(); ++c) find_on_collider(static_cast<int>(c), colliders[c], x);
}

/// Nodes lie in all cells that their ways may reach; a triangle looks into those of its own box.
void ContactBaseline::find_nodes_on_triangles(const Nodes& x) {
  fill(
      reach_.size(),
      [&](size_t i) {
        const Vec3 p = x.col(static_cast<Eigen::Index>(i));
        const double near = reach_[i] + radius_[i];
        return Box{p.array() - near, p.array() + near};
      },
      &node_cells_);
  for (const Triangle& t : triangles_) {
    const auto [i, j, k] = t.node;
    const Vec3 a = x.col(i), b = x.col(j), c = x.col(k);
    const double way = t.radius + std::max({reach_[static_cast<size_t>(i)], reach_[static_cast<size_t>(j)],
                                            reach_[static_cast<size_t>(k)]});
    const Box box{a.cwiseMin(b).cwiseMin(c).array() - way, a.cwiseMax(b).cwiseMax(c).array() + way};
    ++look_;
    for_each_cell(node_cells_, box, [&](unsigned cell) {
      for (int at = node_cells_.begin[cell]; at < node_cells_.begin[cell + 1]; ++at) {
        const int node = node_cells_.item[static_cast<size_t>(at)];
        const double near = reach_[static_cast<size_t>(node)] + radius_[static_cast<size_t>(node)];
        const double* p = &x(0, node);
        if (p[0] + near < box.low[0] || p[0] - near > box.high[0] || p[1] + near < box.low[1] ||
            p[1] - near > box.high[1] || p[2] + near < box.low[2] || p[2] - near > box.high[2] || node == i ||
            node == j || node == k || seen_[static_cast<size_t>(node)] == look_) {
          continue;
        }
        seen_[static_cast<size_t>(node)] = look_;
        const auto w = nearest_of_triangle(x.col(node), a, b, c);
        const double squared = (x.col(node) - w[0] * a - w[1] * b - w[2] * c).squaredNorm();
        if (squared > (near + way) * (near + way)) continue;
        contacts_.push_back({{{node, i, j, k}}, {{1.0, w[0], w[1], w[2]}}, 1, -1, std::sqrt(squared)});
      }
    });
  }
}

/// Edges lie in all cells of their boxes.
void ContactBaseline::find_edges_on_edges(const Nodes& x) {
  double size = 0.0;
  for (size_t e = 0; e < edges_.size(); ++e) {
    const auto [i, j] = edges_[e].node;
    const double way = edges_[e].radius + std::max(reach_[static_cast<size_t>(i)], reach_[static_cast<size_t>(j)]);
    boxes_[e] = {(x.col(i).cwiseMin(x.col(j)).array() - way).matrix(),
                 (x.col(i).cwiseMax(x.col(j)).array() + way).matrix()};
    size += (boxes_[e].high - boxes_[e].low).maxCoeff();
  }
  edge_cells_.size = kCell * size / static_cast<double>(edges_.size());
  node_cells_.size = edge_cells_.size;
  fill(
      edges_.size(), [&](size_t e) { return boxes_[e]; }, &edge_cells_);
  for (size_t e = 0; e < edges_.size(); ++e) {
    const Box box = boxes_[e];
    ++look_;
    for_each_cell(edge_cells_, box, [&](unsigned cell) {
      // Each pair once, by the later edge; a cell's edges ascend.
      for (int k = edge_cells_.begin[cell]; k < edge_cells_.begin[cell + 1]; ++k) {
        const auto o = static_cast<size_t>(edge_cells_.item[static_cast<size_t>(k)]);
        if (o >= e) break;
        const Box& other = boxes_[o];
        if (other.high[0] < box.low[0] || other.low[0] > box.high[0] || other.high[1] < box.low[1] ||
            other.low[1] > box.high[1] || other.high[2] < box.low[2] || other.low[2] > box.high[2] || seen_[o] == look_)
          continue;
        seen_[o] = look_;
        test_edges(e, o, x);
      }
    });
  }
}

void ContactBaseline::test_edges(size_t one, size_t other, const Nodes& x) {
  const auto [a, b] = edges_[one].node;
  const auto [c, d] = edges_[other].node;
  if (a == c || a == d || b == c || b == d) return;
  double s = 0.0, t = 0.0;
  nearest_of_segments(x.col(a), x.col(b), x.col(c), x.col(d), &s, &t);
  const double squared = ((1.0 - s) * x.col(a) + s * x.col(b) - (1.0 - t) * x.col(c) - t * x.col(d)).squaredNorm();
  const double near = edges_[one].radius + edges_[other].radius +
                      std::max(reach_[static_cast<size_t>(a)], reach_[static_cast<size_t>(b)]) +
                      std::max(reach_[static_cast<size_t>(c)], reach_[static_cast<size_t>(d)]);
  if (squared <= near * near) {
    contacts_.push_back({{{a, b, c, d}}, {{1.0 - s, s, 1.0 - t, t}}, 2, -1, std::sqrt(squared)});
  }
}

void ContactBaseline::find_on_collider(int index, const Collider& collider, const Nodes& x) {
  for (const Shape& shape : collider.shapes) {
    const Pose shape_from_world = (collider.world_from_collider * shape.collider_from_shape).inverse();
    const Box extent = extent_of(shape);
    const Mat3 size_of = shape_from_world.linear().cwiseAbs();
    for (size_t b = 0; b < node_blocks_.size(); ++b) {
      const Vec3 center = shape_from_world * (0.5 * (node_blocks_[b].low + node_blocks_[b].high));
      const Vec3 half = size_of * (0.5 * (node_blocks_[b].high - node_blocks_[b].low));
      if ((center - half - extent.high).maxCoeff() > 0.0 || (extent.low - center - half).maxCoeff() > 0.0) continue;
      for (size_t i = kBlock * b; i < std::min(reach_.size(), kBlock * (b + 1)); ++i) {
        const Vec3 p = shape_from_world * x.col(static_cast<Eigen::Index>(i));
        const double near = reach_[i] + radius_[i];
        if ((p - extent.high).maxCoeff() > near || (extent.low - p).maxCoeff() > near) continue;
        const double d = distance(shape, p, near);
        if (d <= near) contacts_.push_back({{{static_cast<int>(i), -1, -1, -1}}, {{1.0, 0, 0, 0}}, 1, index, d});
      }
    }
  }
}

ContactBaseline::Box ContactBaseline::extent_of(const Shape& shape) {
  constexpr double kFar = 1e6;
  switch (shape.type) {
    case Shape::Type::kSphere:
      return {Vec3::Constant(-shape.size[0]), Vec3::Constant(shape.size[0])};
    case Shape::Type::kBox:
      return {-0.5 * shape.size, 0.5 * shape.size};
    case Shape::Type::kCapsule: {
      const Vec3 half(shape.size[0], shape.size[0], shape.size[0] + 0.5 * shape.size[1]);
      return {-half, half};
    }
    case Shape::Type::kPlane:
      return {Vec3::Constant(-kFar), Vec3(kFar, kFar, 0.0)};
    case Shape::Type::kMesh:
      return {shape.mesh->box().min(), shape.mesh->box().max()};
    default:
      throw InputError("the baseline knows no such shape");
  }
}

/// Signed, of p in the shape's frame; of a mesh beyond `reach`: anything above it.
double ContactBaseline::distance(const Shape& shape, const Vec3& p, double reach) {
  switch (shape.type) {
    case Shape::Type::kSphere:
      return p.norm() - shape.size[0];
    case Shape::Type::kBox: {
      const Vec3 beyond = p.cwiseAbs() - 0.5 * shape.size;
      return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
    }
    case Shape::Type::kCapsule: {
      const double half = 0.5 * shape.size[1];
      return (p - Vec3(0, 0, std::min(half, std::max(-half, p[2])))).norm() - shape.size[0];
    }
    case Shape::Type::kPlane:
      return p[2];
    default:
      return mesh_distance(*shape.mesh, p, reach);
  }
}

/// The sign is that of the nearest face's normal: right but beside sharp edges.
double ContactBaseline::mesh_distance(const ColliderMesh& mesh, const Vec3& p, double reach) {
  const auto known = std::find_if(meshes_.begin(), meshes_.end(), [&](const MeshCells& m) { return m.mesh == &mesh; });
  const Cells& cells = known->cells;
  double least = std::numeric_limits<double>::max(), sign = 1.0;
  const Box around{p.array() - reach, p.array() + reach};
  seen_.resize(std::max(seen_.size(), mesh.triangles().size()), 0);
  ++look_;
  for_each_cell(cells, around, [&](unsigned cell) {
    for (int k = cells.begin[cell]; k < cells.begin[cell + 1]; ++k) {
      const auto t = static_cast<size_t>(cells.item[static_cast<size_t>(k)]);
      if (seen_[t] == look_) continue;
      seen_[t] = look_;
      const Vec3& a = mesh.vertices()[static_cast<size_t>(mesh.triangles()[t][0])];
      const Vec3& b = mesh.vertices()[static_cast<size_t>(mesh.triangles()[t][1])];
      const Vec3& c = mesh.vertices()[static_cast<size_t>(mesh.triangles()[t][2])];
      const auto w = nearest_of_triangle(p, a, b, c);
      const Vec3 apart = p - w[0] * a - w[1] * b - w[2] * c;
      if (apart.squaredNorm() >= least) continue;
      least = apart.squaredNorm();
      sign = apart.dot((b - a).cross(c - a)) < 0.0 ? -1.0 : 1.0;
    }
  });
  return sign * std::sqrt(least);
}

}  // namespace bench
}  // namespace deformable_sim
