#include "plate_bending.h"

#include <algorithm>
#include <map>
#include <utility>

#include "deformable_sim/core/energy/shell_terms.h"

namespace deformable_sim {

std::vector<QuadraticWeight> quadratic_weights(const PlateMesh& plate, const std::vector<Eigen::Vector4d>& flat,
                                               const Mat3& stiffness, int first_node) {
  // E = 1/2 sum_ij Q_ij x_i.x_j with Q's rows summing to zero = -1/2 sum_i<j Q_ij |x_i - x_j|^2.
  std::map<std::array<int, 2>, double> weights;
  for (const PlatePatch& patch : plate.patches) {
    std::map<int, Vec3> by_node;
    for (int h = 0; h < patch.count; ++h) {
      const auto hinge = static_cast<size_t>(patch.hinge[static_cast<size_t>(h)]);
      for (size_t k = 0; k < 4; ++k) {
        by_node.try_emplace(plate.hinges[hinge][k] - first_node, Vec3::Zero()).first->second +=
            flat[hinge][static_cast<Eigen::Index>(k)] * patch.curvature.col(h);
      }
    }
    for (const auto& [i, by_i] : by_node) {
      for (const auto& [j, by_j] : by_node) {
        if (i < j) weights[{i, j}] -= patch.area * by_i.dot(stiffness * by_j);
      }
    }
  }
  std::vector<QuadraticWeight> links;
  links.reserve(weights.size());
  for (const auto& [pair, weight] : weights) links.push_back({pair[0], pair[1], weight});
  return links;
}

PlateBending::PlateBending(PlateMesh plate, const Mat3& stiffness, std::vector<double> rest,
                           const std::vector<Eigen::Vector4d>& flat, double damping, Part part, int first_node)
    : plate_(std::move(plate)),
      stiffness_(stiffness),
      rest_(std::move(rest)),
      damping_(damping),
      elastic_(part == Part::kViscous ? 0.0 : 1.0),
      first_node_(first_node),
      hinges_(plate_.hinges.size()) {
  if (elastic_ != 0.0) {
    for (const Eigen::Vector4d& weights : flat) flat_.emplace_back(weights.cast<float>());
  }
  for (auto& hinge : plate_.hinges) {
    for (int& node : hinge) node += first_node;
  }
  for (const PlatePatch& patch : plate_.patches) points_.push_back(points_of(patch));
}

double PlateBending::value(const State& s) const {
  if (elastic_ == 0.0) return 0.0;
  for (size_t h = 0; h < hinges_.size(); ++h) hinges_[h].strain = Hinge(gather(s.x, h)).angle() - rest_[h];
  double sum = 0.0;
  for (const PlatePatch& patch : plate_.patches) {
    const Vec3 curvature = curvature_of(patch);
    sum += 0.5 * patch.area * curvature.dot(stiffness_ * curvature);
  }
  return sum;
}

void PlateBending::add_force(const State& s, Nodes* f) const {
  look(s);
  add_moments();
  for (size_t h = 0; h < hinges_.size(); ++h) {
    const auto& node = plate_.hinges[h];
    for (size_t k = 0; k < 4; ++k) {
      f->col(node[k]) -= hinges_[h].moment * hinges_[h].gradient.col(static_cast<Eigen::Index>(k));
    }
  }
}

void PlateBending::add_pattern(std::vector<std::array<int, 2>>* pairs) const {
  for (const Points& points : points_) {
    for (size_t i = 0; i < points.count; ++i) {
      for (size_t j = 0; j < i; ++j) pairs->push_back({points.node[i], points.node[j]});
    }
  }
}

void PlateBending::bind(const BlockMatrix& matrix) {
  patch_slots_.clear();
  hinge_slots_.clear();
  for (const Points& points : points_) {
    for (size_t i = 0; i < points.count; ++i) {
      for (size_t j = 0; j < points.count; ++j) patch_slots_.push_back(matrix.slot(points.node[i], points.node[j]));
    }
  }
  for (const auto& node : plate_.hinges) {
    for (size_t i = 0; i < 4; ++i) {
      for (size_t j = 0; j < 4; ++j) hinge_slots_.push_back(matrix.slot(node[i], node[j]));
    }
  }
}

void PlateBending::add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const {
  look(s);
  const bool exact = kind == Jacobian::kExact && dx != 0.0;
  if (exact) add_moments();
  const bool turning = exact && damping_ > 0.0;
  if (turning) look_at_turning(s);
  const int* slot = patch_slots_.data();
  for (size_t n = 0; n < plate_.patches.size(); ++n) {
    add_patch(n, dx * elastic_ + dv * damping_, turning ? dx * damping_ : 0.0, slot, a);
    slot += points_[n].count * points_[n].count;
  }
  if (exact) add_second_derivatives(s, dx, a);
}

const ConstantLinks* PlateBending::constant_links() const {
  if (elastic_ == 0.0) return nullptr;
  if (links_ == nullptr) {
    std::vector<Eigen::Vector4d> flat;
    for (const Eigen::Vector4f& weights : flat_) flat.emplace_back(weights.cast<double>());
    links_ = std::make_unique<ConstantLinks>(
        make_constant_links(quadratic_weights(plate_, flat, stiffness_, first_node_), damping_, first_node_));
  }
  return links_.get();
}

PlateBending::Points PlateBending::points_of(const PlatePatch& patch) const {
  Points points;
  for (size_t h = 0; h < static_cast<size_t>(patch.count); ++h) {
    const auto& hinge = plate_.hinges[static_cast<size_t>(patch.hinge[h])];
    for (size_t k = 0; k < 4; ++k) {
      const auto end = points.node.begin() + static_cast<std::ptrdiff_t>(points.count);
      const auto found = std::find(points.node.begin(), end, hinge[k]);
      points.corner[h][k] = static_cast<int>(found - points.node.begin());
      if (found == end) points.node[points.count++] = hinge[k];
    }
  }
  return points;
}

Hinge::Points PlateBending::gather(const Nodes& nodes, size_t hinge) const {
  const auto& node = plate_.hinges[hinge];
  Hinge::Points points;
  for (size_t k = 0; k < 4; ++k) points.col(static_cast<Eigen::Index>(k)) = nodes.col(node[k]);
  return points;
}

void PlateBending::look(const State& s) const {
  for (size_t h = 0; h < hinges_.size(); ++h) {
    const Hinge hinge(gather(s.x, h));
    Look& at = hinges_[h];
    at.gradient = hinge.gradient();
    at.strain = elastic_ == 0.0 ? 0.0 : hinge.angle() - rest_[h];
    if (damping_ > 0.0) at.strain += damping_ * at.gradient.cwiseProduct(gather(s.v, h)).sum();
  }
}

/// d(d angle/dx)/dt.
void PlateBending::look_at_turning(const State& s) const {
  for (size_t h = 0; h < hinges_.size(); ++h) {
    const Hinge::Points v = gather(s.v, h);
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(hinges_[h].gradient_rate.data()) =
        Hinge(gather(s.x, h)).hessian() * Eigen::Map<const Eigen::Matrix<double, 12, 1>>(v.data());
  }
}

Vec3 PlateBending::curvature_of(const PlatePatch& patch) const {
  Vec3 curvature = Vec3::Zero();
  for (int h = 0; h < patch.count; ++h) {
    curvature += hinges_[static_cast<size_t>(patch.hinge[static_cast<size_t>(h)])].strain * patch.curvature.col(h);
  }
  return curvature;
}

void PlateBending::add_moments() const {
  for (Look& at : hinges_) at.moment = 0.0;
  for (const PlatePatch& patch : plate_.patches) {
    const Vec3 moment = patch.area * (stiffness_ * curvature_of(patch));
    for (int h = 0; h < patch.count; ++h) {
      hinges_[static_cast<size_t>(patch.hinge[static_cast<size_t>(h)])].moment += moment.dot(patch.curvature.col(h));
    }
  }
}

/// A += J^T (A D) (elastic J + viscous dJ/dt), J = dkappa/dx.
void PlateBending::add_patch(size_t n, double elastic, double viscous, const int* slot, BlockMatrix* a) const {
  const PlatePatch& patch = plate_.patches[n];
  const Points& points = points_[n];
  Eigen::Matrix<double, 3, 3 * static_cast<int>(kMostPoints)> j, rate, moment;
  j.setZero();
  if (viscous != 0.0) rate.setZero();
  for (int h = 0; h < patch.count; ++h) {
    const Look& at = hinges_[static_cast<size_t>(patch.hinge[static_cast<size_t>(h)])];
    for (int k = 0; k < 4; ++k) {
      const int column = 3 * points.corner[static_cast<size_t>(h)][static_cast<size_t>(k)];
      j.middleCols<3>(column) += patch.curvature.col(h) * at.gradient.col(k).transpose();
      if (viscous != 0.0) rate.middleCols<3>(column) += patch.curvature.col(h) * at.gradient_rate.col(k).transpose();
    }
  }
  const int count = static_cast<int>(points.count);
  const Mat3 by_curvature = patch.area * stiffness_;
  for (int i = 0; i < count; ++i) moment.middleCols<3>(3 * i) = elastic * by_curvature * j.middleCols<3>(3 * i);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < i; ++k) {
      const Mat3 block = j.middleCols<3>(3 * i).transpose() * moment.middleCols<3>(3 * k);
      a->block(slot[i * count + k]) += block;
      a->block(slot[k * count + i]) += block.transpose();
    }
    const Mat3 block = j.middleCols<3>(3 * i).transpose() * moment.middleCols<3>(3 * i);
    a->block(slot[i * count + i]) += 0.5 * (block + block.transpose());
  }
  if (viscous == 0.0) return;
  for (int i = 0; i < count; ++i) moment.middleCols<3>(3 * i) = viscous * by_curvature * rate.middleCols<3>(3 * i);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < count; ++k) {
      a->block(slot[i * count + k]) += j.middleCols<3>(3 * i).transpose() * moment.middleCols<3>(3 * k);
    }
  }
}

/// A += dx sum m d2angle/dx2.
void PlateBending::add_second_derivatives(const State& s, double dx, BlockMatrix* a) const {
  for (size_t h = 0; h < hinges_.size(); ++h) {
    const Hinge::Hessian hessian = (dx * hinges_[h].moment) * Hinge(gather(s.x, h)).hessian();
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        a->block(hinge_slots_[16 * h + static_cast<size_t>(4 * i + k)]) += hessian.block<3, 3>(3 * i, 3 * k);
      }
    }
  }
}

}  // namespace deformable_sim
