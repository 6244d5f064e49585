#include "deformable_sim/core/linear/aggregation_multigrid.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kStrong = 0.1;          // a link counts from this share of what is strongest at its ends
constexpr double kSmoothed = 2.0 / 3.0;  // weight of the sweep that smooths the interpolation: of 2 / lambda_max
constexpr float kJacobi = 0.7f;          // weight of a sweep on the coarser levels
constexpr int kCoarsest = 40;            // nodes at most, unless a level cannot be halved

/// Links that hold nodes together, as stiff as they are.
GraphMatrix strong_links(const GraphMatrix& laplacian) {
  std::vector<double> strongest(static_cast<size_t>(laplacian.rows()), 0.0);
  const auto each = [&](const auto& visit) {
    for (Eigen::Index i = 0; i < laplacian.rows(); ++i) {
      for (GraphMatrix::InnerIterator it(laplacian, i); it; ++it) {
        if (it.col() != i) visit(i, it.col(), -it.value());
      }
    }
  };
  each([&](Eigen::Index i, Eigen::Index, double k) {
    strongest[static_cast<size_t>(i)] = std::max(strongest[static_cast<size_t>(i)], k);
  });
  std::vector<Eigen::Triplet<double>> entries;
  each([&](Eigen::Index i, Eigen::Index j, double k) {
    const double most = std::sqrt(strongest[static_cast<size_t>(i)] * strongest[static_cast<size_t>(j)]);
    if (k > 0.0 && k >= kStrong * most) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), k);
  });
  GraphMatrix links(laplacian.rows(), laplacian.cols());
  links.setFromTriplets(entries.begin(), entries.end());
  return links;
}

/// (I - w D^-1 L) of the strong links alone, applied to one column a group. Rows of grouped nodes sum to 1.
GraphMatrix interpolation_of(const GraphMatrix& links, const std::vector<int>& group, int count) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < links.rows(); ++i) {
    const int own = group[static_cast<size_t>(i)];
    if (own < 0) continue;
    double degree = 0.0;
    for (GraphMatrix::InnerIterator it(links, i); it; ++it) degree += it.value();
    entries.emplace_back(static_cast<int>(i), own, degree > 0.0 ? 1.0 - kSmoothed : 1.0);
    for (GraphMatrix::InnerIterator it(links, i); it; ++it) {
      entries.emplace_back(static_cast<int>(i), group[static_cast<size_t>(it.col())], kSmoothed * it.value() / degree);
    }
  }
  GraphMatrix p(links.rows(), count);
  p.setFromTriplets(entries.begin(), entries.end());
  return p;
}

}  // namespace

std::vector<int> aggregates(const GraphMatrix& links, int* count) {
  std::vector<int> group(static_cast<size_t>(links.rows()), -1);
  *count = 0;
  const auto each = [&](Eigen::Index i, const auto& visit) {
    for (GraphMatrix::InnerIterator it(links, i); it; ++it) visit(static_cast<size_t>(it.col()), it.value());
  };
  for (Eigen::Index i = 0; i < links.rows(); ++i) {
    int neighbours = 0;
    bool free = group[static_cast<size_t>(i)] < 0;
    each(i, [&](size_t j, double) {
      ++neighbours;
      free = free && group[j] < 0;
    });
    if (!free || neighbours == 0) continue;
    group[static_cast<size_t>(i)] = *count;
    each(i, [&](size_t j, double) { group[j] = *count; });
    ++*count;
  }
  const std::vector<int> first = group;
  for (Eigen::Index i = 0; i < links.rows(); ++i) {
    if (group[static_cast<size_t>(i)] >= 0) continue;
    double strongest = 0.0;
    each(i, [&](size_t j, double k) {
      if (first[j] < 0 || k <= strongest) return;
      strongest = k;
      group[static_cast<size_t>(i)] = first[j];
    });
  }
  return group;
}

LinkRows<float> AggregationMultigrid::Rows::rows(const float* diagonal) const {
  return {static_cast<int>(start.size()) - 1, start.data(), place.data(), value.data(), diagonal};
}

/// Off the diagonal where it is square, times `factor`.
AggregationMultigrid::Rows AggregationMultigrid::rows_of(const GraphMatrix& m, double factor) {
  const bool square = m.rows() == m.cols();
  Rows rows;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (GraphMatrix::InnerIterator it(m, i); it; ++it) {
      if (square && it.col() == i) continue;
      rows.place.push_back(4U * static_cast<unsigned>(it.col()));
      rows.value.push_back(static_cast<float>(factor * it.value()));
    }
    while (rows.place.size() % 4 != 0) {
      rows.place.push_back(0U);
      rows.value.push_back(0.0f);
    }
    rows.start.push_back(static_cast<int>(rows.place.size()));
  }
  return rows;
}

bool AggregationMultigrid::add_level(const GraphMatrix& laplacian, GraphMatrix* coarse) {
  const GraphMatrix links = strong_links(laplacian);
  int count = 0;
  const std::vector<int> group = aggregates(links, &count);
  if (count == 0 || count == laplacian.rows()) return false;
  const GraphMatrix p = interpolation_of(links, group, count), transposed = p.transpose();
  const GraphMatrix product = laplacian * p;
  *coarse = (transposed * product).pruned();
  Level level;
  level.size = count;
  level.interpolation = rows_of(p, 1.0);
  level.restriction = rows_of(transposed, 1.0);
  level.links = rows_of(*coarse, -1.0);
  for (int i = 0; i < count; ++i) level.degree.push_back(static_cast<float>(coarse->coeff(i, i)));
  for (AxisValues* values : {&level.row_sum, &level.diagonal, &level.relaxation}) values->setZero(4, count);
  for (PaddedNodes* nodes : {&level.r, &level.z, &level.y}) nodes->setZero(4, count);
  levels_.push_back(std::move(level));
  return true;
}

void AggregationMultigrid::prepare(const GraphMatrix& laplacian) {
  levels_.clear();
  works_ = false;
  GraphMatrix here = laplacian, coarse;
  while (add_level(here, &coarse)) {
    if (levels_.back().size <= kCoarsest) break;
    here.swap(coarse);
  }
  if (levels_.empty()) return;
  const int n = levels_.back().size;
  dense_.resize(n, n);
  dense_inverse_.resize(n, n);
  factor_ = Eigen::LDLT<Eigen::MatrixXd>(n);
  inverse_.setZero(4, static_cast<Eigen::Index>(n) * n);
}

std::vector<int> AggregationMultigrid::sizes() const {
  std::vector<int> sizes;
  for (const Level& level : levels_) sizes.push_back(level.size);
  return sizes;
}

bool AggregationMultigrid::refresh(const AxisValues& row_sum) {
  works_ = !levels_.empty();
  const AxisValues* above = &row_sum;
  for (Level& level : levels_) {
    kernels_.interpolate(level.restriction.rows(nullptr), above->data(), level.row_sum.data());
    above = &level.row_sum;
    for (int i = 0; i < level.size; ++i) {
      const auto sum = level.row_sum.col(i).head<3>().array() + level.degree[static_cast<size_t>(i)];
      if (!(sum > 0.0f).all()) works_ = false;
      level.diagonal.col(i).head<3>() = sum;
      level.relaxation.col(i).head<3>() = kJacobi / sum;
    }
  }
  works_ = works_ && factorise();
  return works_ || levels_.empty();
}

bool AggregationMultigrid::factorise() {
  const Level& level = levels_.back();
  for (int axis = 0; axis < 3; ++axis) {
    dense_.setZero();
    for (int i = 0; i < level.size; ++i) {
      dense_(i, i) = static_cast<double>(level.diagonal(axis, i));
      for (int k = level.links.start[static_cast<size_t>(i)]; k < level.links.start[static_cast<size_t>(i) + 1]; ++k) {
        dense_(i, static_cast<int>(level.links.place[static_cast<size_t>(k)] / 4)) -=
            static_cast<double>(level.links.value[static_cast<size_t>(k)]);
      }
    }
    factor_.compute(dense_);
    if (factor_.info() != Eigen::Success || !(factor_.vectorD().minCoeff() > 0.0)) return false;
    dense_inverse_.setIdentity();
    factor_.solveInPlace(dense_inverse_);
    for (int j = 0; j < level.size; ++j) {
      for (int i = 0; i < level.size; ++i) {
        inverse_(axis, j * level.size + i) = static_cast<float>(0.5 * (dense_inverse_(i, j) + dense_inverse_(j, i)));
      }
    }
  }
  return true;
}

void AggregationMultigrid::solve_coarsest() {
  Level& level = levels_.back();
  level.z.setZero();
  for (int j = 0; j < level.size; ++j) {
    level.z.array() += inverse_.middleCols(j * level.size, level.size).array().colwise() * level.r.col(j).array();
  }
}

void AggregationMultigrid::correct(const PaddedNodes& r, PaddedNodes* c) {
  if (!works_) {
    c->setZero();
    return;
  }
  const size_t last = levels_.size() - 1;
  const PaddedNodes* above = &r;
  for (size_t k = 0; k <= last; ++k) {
    Level& level = levels_[k];
    kernels_.interpolate(level.restriction.rows(nullptr), above->data(), level.r.data());
    if (k == last) break;
    level.z.array() = level.relaxation.array() * level.r.array();
    kernels_.coarse_residue(level.links.rows(level.diagonal.data()), level.r.data(), level.z.data(), level.y.data());
    above = &level.y;
  }
  solve_coarsest();
  for (size_t k = last; k > 0; --k) {
    Level& finer = levels_[k - 1];
    kernels_.interpolate(levels_[k].interpolation.rows(nullptr), levels_[k].z.data(), finer.y.data());
    finer.z += finer.y;
    kernels_.coarse_sweep(finer.links.rows(finer.diagonal.data()), finer.relaxation.data(), finer.r.data(),
                          finer.z.data(), finer.y.data());
    finer.z.swap(finer.y);
  }
  kernels_.interpolate(levels_[0].interpolation.rows(nullptr), levels_[0].z.data(), c->data());
}

}  // namespace deformable_sim
