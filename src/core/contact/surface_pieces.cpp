#include "deformable_sim/core/contact/surface_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {
namespace {

constexpr double kMoreReach = 1.0;    // of the least radius, when what is near is to be known for a while: ...
constexpr size_t kNearReserved = 32;  // pieces near to a piece, for which there is room from the start
constexpr double kStepsAtRest = 4.0;  // ... for so many steps at least

}  // namespace

SurfacePieces::SurfacePieces(const Model* model)
    : model_(model),
      on_surface_(static_cast<size_t>(model->node_count()), 0),
      place_(static_cast<size_t>(model->node_count())),
      radius_start_(model->bodies.size()),
      radius_end_(model->bodies.size()),
      asked_(model->bodies.size()) {
  for (size_t b = 0; b < model->bodies.size(); ++b) {
    if (model->bodies[b].touches != BodyContact::kNone) add_pieces(static_cast<int>(b));
  }
  fans_ = FanClearance(model->node_count(), pieces_);
  for (const Piece& p : pieces_) {
    first_edge_.push_back(edges_.size());
    for (size_t k = 0; k < 3; ++k) {
      if ((p.own_edges >> k & 1u) == 0u) continue;
      edges_.push_back({{p.node[k], p.node[(k + 1) % static_cast<size_t>(p.count)]}});
    }
  }
  first_edge_.push_back(edges_.size());
  edge_slabs_.resize(edges_.size());
  least_radius_ = std::numeric_limits<double>::max();
  for (const Piece& p : pieces_) least_radius_ = std::min(least_radius_, radius_of(p.body));
  std::vector<Vec3> centers;
  for (const Piece& p : pieces_) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < p.count; ++k) sum += model->initial.x.col(p.node[static_cast<size_t>(k)]);
    centers.push_back(sum / p.count);
  }
  tree_ = PieceTree(centers);
  near_.reserve(kNearReserved * pieces_.size());
}

void SurfacePieces::add_pieces(int body) {
  const Body& b = model_->bodies[static_cast<size_t>(body)];
  const size_t first_piece = pieces_.size();
  if (b.line) {
    for (int s = 0; s < b.line->segment_count(); ++s) {
      const auto [i, j] = b.line->segment(s);
      pieces_.push_back({{{b.first_node + i, b.first_node + j, -1}}, 2, body, 0u, 1u});
    }
  } else if (b.surface) {
    for (const auto& t : b.surface->triangles) {
      pieces_.push_back({{{b.first_node + t[0], b.first_node + t[1], b.first_node + t[2]}}, 3, body, 0u, 0u});
    }
  }
  const auto edges = b.surface && !b.line ? edges_of(*b.surface) : std::vector<std::array<int, 2>>{};
  std::vector<char> owned(edges.size(), 0);
  for (size_t i = first_piece; i < pieces_.size(); ++i) {
    Piece& p = pieces_[i];
    for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
      char& mine = on_surface_[static_cast<size_t>(p.node[k])];
      if (mine == 0) p.own_nodes |= 1u << k;
      mine = 1;
      if (p.count == 2) continue;
      const int a = p.node[k] - b.first_node, c = p.node[(k + 1) % 3] - b.first_node;
      const std::array<int, 2> edge{{std::min(a, c), std::max(a, c)}};
      char& taken = owned[static_cast<size_t>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin())];
      if (taken == 0) p.own_edges |= 1u << k;
      taken = 1;
    }
  }
}

/// Along each direction a node is at the whole step below its place, so that two are further apart than one step less
/// than their numbers say.
void SurfacePieces::place(const Step& step) {
  Vec3 origin = Vec3::Zero();
  double count = 0.0;
  for (size_t i = 0; i < on_surface_.size(); ++i) {
    if (on_surface_[i] == 0) continue;
    origin += step.start.col(static_cast<Eigen::Index>(i));
    count += 1.0;
  }
  origin /= count;
  double furthest = 0.0, widest = 0.0;
  for (size_t i = 0; i < on_surface_.size(); ++i) {
    if (on_surface_[i] == 0) continue;
    const auto k = static_cast<Eigen::Index>(i);
    furthest = std::max(furthest, (step.start.col(k) - origin).squaredNorm());
    furthest = std::max(furthest, (step.end.col(k) - origin).squaredNorm());
  }
  for (size_t b = 0; b < model_->bodies.size(); ++b) {
    if (model_->bodies[b].touches != BodyContact::kNone) widest = std::max(widest, radius_of(static_cast<int>(b)));
  }
  const auto reach = [&](const Reach& near) { return near.share * widest + near.wide; };
  const double extent =
      std::sqrt(furthest) + std::max(reach(step.near_start), reach(step.near_end)) + kMoreReach * widest;
  scale_ = (kMostLane - 8) / std::max(1e-6, extent);
  gaps_ = {lanes_of(step.near_start.wide), lanes_of(step.near_end.wide)};
  for (size_t b = 0; b < model_->bodies.size(); ++b) {
    // Without the step for rounding: lanes_of() of the width has it.
    radius_start_[b] = lanes_of(step.near_start.share * radius_of(static_cast<int>(b))) - all_lanes(1);
    radius_end_[b] = lanes_of(step.near_end.share * radius_of(static_cast<int>(b))) - all_lanes(1);
  }
  const Eigen::Matrix<double, 8, 3> directions = scale_ * unit_directions();
  for (size_t i = 0; i < on_surface_.size(); ++i) {
    if (on_surface_[i] == 0) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const Eigen::Matrix<double, 8, 1> from = directions * (step.start.col(k) - origin),
                                      to = directions * (step.end.col(k) - origin);
    for (int d = 0; d < 8; ++d) {
      place_[i].start[d] = static_cast<std::int16_t>(std::floor(from[d]));
      place_[i].end[d] = static_cast<std::int16_t>(std::floor(to[d]));
    }
  }
  for (size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& p = pieces_[i];
    const Lanes &start = radius_start_[static_cast<size_t>(p.body)], &end = radius_end_[static_cast<size_t>(p.body)];
    Slabs& slabs = tree_.slabs_of(static_cast<int>(i));
    slabs = slabs_of(p.node.data(), p.count);
    slabs.inflate(start, end);
    for (size_t k = first_edge_[i]; k < first_edge_[i + 1]; ++k) {
      edge_slabs_[k] = slabs_of(edges_[k].data(), 2);
      edge_slabs_[k].inflate(start, end);
    }
  }
}

void SurfacePieces::forget() {
  last_start_.resize(3, 0);
  fans_.forget();
}

bool SurfacePieces::is_covered(const Step& step) const {
  if (last_start_.cols() != step.start.cols()) return false;
  const auto room = [this](const Reach& last, const Reach& now) {
    if (last.share < now.share) return -1.0;
    return 2.0 * (last.share - now.share) * least_radius_ + last.wide - now.wide;
  };
  const double at_start = room(last_near_start_, step.near_start), at_end = room(last_near_end_, step.near_end);
  if (at_start < 0.0 || at_end < 0.0) return false;
  for (Eigen::Index i = 0; i < step.end.cols(); ++i) {
    if (!is_on_surface(static_cast<int>(i))) continue;
    if (2.0 * (step.start.col(i) - last_start_.col(i)).norm() > at_start) return false;
    if (2.0 * (step.end.col(i) - last_end_.col(i)).norm() > at_end) return false;
  }
  return true;
}

double SurfacePieces::remember(const Step& step) {
  near_.clear();
  last_start_ = step.start;
  last_end_ = step.end;
  last_near_start_ = step.near_start;
  last_near_end_ = step.near_end;
  double fastest = 0.0;
  for (Eigen::Index i = 0; i < step.end.cols(); ++i) {
    if (is_on_surface(static_cast<int>(i))) {
      fastest = std::max(fastest, (step.end.col(i) - step.start.col(i)).squaredNorm());
    }
  }
  const double more = kMoreReach * least_radius_;
  if (kStepsAtRest * std::sqrt(fastest) > 0.5 * more) return 0.0;
  last_near_start_.wide += more;
  last_near_end_.wide += more;
  return more;
}

}  // namespace deformable_sim
