#include "deformable_sim/core/linear/scalar_factor.h"

#include <algorithm>
#include <numeric>

#include <Eigen/SparseCholesky>

namespace deformable_sim {
namespace {

// Between a spring's stiffness along itself and the mean over all directions; half of the former needs fewest
// iterations.
constexpr double kWeight = 0.5;
// A factor is renewed when more than one row sum in this many has changed by more than the ratio. Some ten stale rows
// cost an iteration, a new factor costs as much as seven.
constexpr int kStaleShare = 12;
constexpr float kStaleRatio = 2.0f;

using Lane = Eigen::Map<Eigen::Array4f, Eigen::Aligned16>;
/// An entry's three values, and whatever follows: what it is multiplied with is zero in the fourth place.
using Value = Eigen::Map<const Eigen::Array4f>;

/// Stiffness of a link: for one spring, whose block is -k n n^T, exactly k.
double link_weight(const Mat3& block) {
  return kWeight * block.norm();
}

/// A matrix with the pattern of `a` that has a Cholesky factor: for the elimination order and the pattern of L.
Eigen::SparseMatrix<double> pattern_matrix(const BlockMatrix& a) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(a.block_count()));
  for (int i = 0; i < a.rows(); ++i) {
    const int first = a.row_start()[static_cast<size_t>(i)], last = a.row_start()[static_cast<size_t>(i) + 1];
    for (int k = first; k < last; ++k) {
      const int j = a.column()[static_cast<size_t>(k)];
      entries.emplace_back(i, j, j == i ? static_cast<double>(last - first) : -1.0);
    }
  }
  Eigen::SparseMatrix<double> matrix(a.rows(), a.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void ScalarFactor::prepare(const BlockMatrix& a) {
  if (a.row_start() != pattern_rows_ || a.column() != pattern_columns_) analyse(a);
  std::fill(degree_.begin(), degree_.end(), 0.0f);
  for (size_t i = 0; i < position_.size(); ++i) {
    for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
      const auto j = static_cast<size_t>(a.column()[static_cast<size_t>(k)]);
      if (j == i) continue;
      const auto weight = static_cast<float>(link_weight(a.block(k)));
      degree_[static_cast<size_t>(position_[i])] += weight;
      const int entry = weight_of_slot_[static_cast<size_t>(k)];
      if (entry >= 0) weight_[static_cast<size_t>(entry)] = -weight;
    }
  }
  factored_.setZero();
}

void ScalarFactor::analyse(const BlockMatrix& a) {
  pattern_rows_ = a.row_start();
  pattern_columns_ = a.column();
  const Eigen::SparseMatrix<double> matrix = pattern_matrix(a);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
  const auto& order = factor.permutationP().indices();
  const auto n = static_cast<size_t>(a.rows());
  position_.assign(order.data(), order.data() + order.size());

  degree_.resize(n);
  weight_start_.assign(n + 1, 0);
  for (size_t i = 0; i < n; ++i) {
    for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
      if (position_[static_cast<size_t>(a.column()[static_cast<size_t>(k)])] < position_[i])
        ++weight_start_[static_cast<size_t>(position_[i]) + 1];
    }
  }
  std::partial_sum(weight_start_.begin(), weight_start_.end(), weight_start_.begin());
  weight_.resize(static_cast<size_t>(weight_start_.back()));
  weight_column_.resize(weight_.size());
  weight_of_slot_.assign(static_cast<size_t>(a.block_count()), -1);
  for (size_t i = 0; i < n; ++i) {
    int next = weight_start_[static_cast<size_t>(position_[i])];
    for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
      const int column = position_[static_cast<size_t>(a.column()[static_cast<size_t>(k)])];
      if (column >= position_[i]) continue;
      weight_column_[static_cast<size_t>(next)] = column;
      weight_of_slot_[static_cast<size_t>(k)] = next++;
    }
  }

  const Eigen::SparseMatrix<double> lower = factor.matrixL();
  column_start_.assign(1, 0);
  std::vector<int> row_length(n, 0);
  for (int j = 0; j < a.rows(); ++j) {
    int length = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (it.row() == j) continue;
      ++length;
      ++row_length[static_cast<size_t>(it.row())];
    }
    column_start_.push_back(column_start_.back() + length);
  }
  row_start_.assign(1, 0);
  for (size_t i = 0; i < n; ++i) row_start_.push_back(row_start_.back() + row_length[i]);
  row_column_.resize(static_cast<size_t>(row_start_.back()));
  std::vector<int> next(row_start_.begin(), row_start_.end() - 1);
  for (int j = 0; j < a.rows(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (it.row() != j) row_column_[static_cast<size_t>(next[static_cast<size_t>(it.row())]++)] = j;
    }
  }
  entry_row_.resize(static_cast<size_t>(column_start_.back()));
  entry_value_.assign(3 * entry_row_.size() + 1, 0.0f);
  column_fill_.resize(n);
  inverse_diagonal_.resize(n);
  work_row_.assign(n, Eigen::Array4f::Zero());
  row_sum_.setOnes(4, a.rows());
  factored_.setZero(4, a.rows());
}

void ScalarFactor::refresh(const BlockMatrix& a) {
  int stale = 0;
  for (int i = 0; i < a.rows(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
      sum += a.block(k).diagonal();
    }
    row_sum_.col(i).head<3>() = sum.cast<float>();
    const auto now = row_sum_.col(i).array(), then = factored_.col(i).array();
    if ((now > kStaleRatio * then).any() || (kStaleRatio * now < then).any()) ++stale;
  }
  if (stale * kStaleShare <= a.rows() && factored_(0, 0) > 0.0f) return;
  factored_ = row_sum_;
  factorise();
}

/// Row by row: L_k,1..k-1 solves a triangular system with the rows above it.
void ScalarFactor::factorise() {
  for (size_t i = 0; i < position_.size(); ++i) {
    const auto p = static_cast<size_t>(position_[i]);
    inverse_diagonal_[p] = degree_[p] + factored_.col(static_cast<Eigen::Index>(i)).array();
  }
  std::copy(column_start_.begin(), column_start_.end() - 1, column_fill_.begin());
  Eigen::Array4f* x = work_row_.data();
  for (size_t k = 0; k < position_.size(); ++k) {
    for (int w = weight_start_[k]; w < weight_start_[k + 1]; ++w) {
      x[weight_column_[static_cast<size_t>(w)]].head<3>().setConstant(weight_[static_cast<size_t>(w)]);
    }
    Eigen::Array4f diagonal = inverse_diagonal_[k];
    for (int r = row_start_[k]; r < row_start_[k + 1]; ++r) {
      const auto j = static_cast<size_t>(row_column_[static_cast<size_t>(r)]);
      const Eigen::Array4f value = x[j] * inverse_diagonal_[j];
      x[j].setZero();
      const int last = column_fill_[j]++;
      for (int e = column_start_[j]; e < last; ++e) {
        x[entry_row_[static_cast<size_t>(e)]] -= Value(entry_value_.data() + 3 * e) * value;
      }
      diagonal -= value * value;
      entry_row_[static_cast<size_t>(last)] = static_cast<int>(k);
      Eigen::Map<Eigen::Array3f>(entry_value_.data() + 3 * last) = value.head<3>();
    }
    inverse_diagonal_[k] = diagonal.max(1e-6f * inverse_diagonal_[k]).sqrt().inverse();
  }
}

void ScalarFactor::solve(PaddedNodes* x, PaddedNodes* work) const {
  const int n = static_cast<int>(position_.size());
  for (int i = 0; i < n; ++i) work->col(position_[static_cast<size_t>(i)]) = x->col(i);
  float* w = work->data();
  const int* row = entry_row_.data();
  const float* value = entry_value_.data();
  for (int j = 0; j < n; ++j) {
    const Eigen::Array4f pivot = inverse_diagonal_[static_cast<size_t>(j)] * Lane(w + 4 * j);
    Lane(w + 4 * j) = pivot;
    for (int e = column_start_[static_cast<size_t>(j)]; e < column_start_[static_cast<size_t>(j) + 1]; ++e) {
      Lane(w + 4 * row[e]) -= Value(value + 3 * e) * pivot;
    }
  }
  for (int j = n - 1; j >= 0; --j) {
    int e = column_start_[static_cast<size_t>(j)];
    const int last = column_start_[static_cast<size_t>(j) + 1];
    Eigen::Array4f sum = Lane(w + 4 * j), other = Eigen::Array4f::Zero();  // two chains hide the latency of the sum
    for (; last - e > 1; e += 2) {
      sum -= Value(value + 3 * e) * Lane(w + 4 * row[e]);
      other -= Value(value + 3 * e + 3) * Lane(w + 4 * row[e + 1]);
    }
    if (e != last) sum -= Value(value + 3 * e) * Lane(w + 4 * row[e]);
    Lane(w + 4 * j) = inverse_diagonal_[static_cast<size_t>(j)] * (sum + other);
  }
  for (int i = 0; i < n; ++i) x->col(i) = work->col(position_[static_cast<size_t>(i)]);
}

}  // namespace deformable_sim
