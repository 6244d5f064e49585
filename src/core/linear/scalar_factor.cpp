#include "deformable_sim/core/linear/scalar_factor.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace deformable_sim {
namespace {

// Between a spring's stiffness along itself and the mean over all directions; half of the former needs fewest
// iterations.
constexpr double kWeight = 0.5;
// A factor is renewed when this many row sums differ by more than this ratio: each stale one costs about an iteration.
constexpr int kStaleRows = 8;
constexpr float kStaleRatio = 2.0f;

double largest_eigenvalue(const Mat3& block) {
  const Mat3 symmetric = 0.5 * (block + block.transpose());
  return Eigen::SelfAdjointEigenSolver<Mat3>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

/// Graph Laplacian of the off-diagonal blocks, with a unit diagonal added: only its pattern and entries are used.
Eigen::SparseMatrix<double> laplacian(const BlockMatrix& a) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(a.block_count()));
  for (int i = 0; i < a.rows(); ++i) {
    double diagonal = 1.0;
    for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
      const int j = a.column()[static_cast<size_t>(k)];
      if (j == i) continue;
      const double weight = kWeight * std::max(0.0, largest_eigenvalue(-a.block(k)));
      diagonal += weight;
      entries.emplace_back(i, j, -weight);
    }
    entries.emplace_back(i, i, diagonal);
  }
  Eigen::SparseMatrix<double> matrix(a.rows(), a.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void ScalarFactor::analyse(const BlockMatrix& a) {
  const Eigen::SparseMatrix<double> matrix = laplacian(a);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
  const auto& order = factor.permutationP().indices();
  const auto n = static_cast<size_t>(a.rows());
  position_.assign(order.data(), order.data() + order.size());

  Eigen::SparseMatrix<double> ordered(a.rows(), a.rows());
  ordered = matrix.twistedBy(factor.permutationP());
  degree_.resize(n);
  weight_start_.assign(1, 0);
  weight_column_.clear();
  weight_.clear();
  for (int i = 0; i < a.rows(); ++i) {  // symmetric: column i stands for row i
    for (Eigen::SparseMatrix<double>::InnerIterator it(ordered, i); it; ++it) {
      if (it.row() == i) degree_[static_cast<size_t>(i)] = static_cast<float>(it.value() - 1.0);
      if (it.row() >= i) continue;
      weight_column_.push_back(static_cast<int>(it.row()));
      weight_.push_back(static_cast<float>(it.value()));
    }
    weight_start_.push_back(static_cast<int>(weight_column_.size()));
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
  entries_.resize(static_cast<size_t>(column_start_.back()));
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
  if (stale <= kStaleRows && factored_(0, 0) > 0.0f) return;
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
      x[weight_column_[static_cast<size_t>(w)]].setConstant(weight_[static_cast<size_t>(w)]);
    }
    Eigen::Array4f diagonal = inverse_diagonal_[k];
    for (int r = row_start_[k]; r < row_start_[k + 1]; ++r) {
      const auto j = static_cast<size_t>(row_column_[static_cast<size_t>(r)]);
      const Eigen::Array4f value = x[j] * inverse_diagonal_[j];
      x[j].setZero();
      const Entry* last = entries_.data() + column_fill_[j];
      for (const Entry* entry = entries_.data() + column_start_[j]; entry != last; ++entry) {
        x[entry->row] -= entry->value * value;
      }
      diagonal -= value * value;
      entries_[static_cast<size_t>(column_fill_[j]++)] = {static_cast<int>(k), value};
    }
    inverse_diagonal_[k] = diagonal.max(1e-6f * inverse_diagonal_[k]).sqrt().inverse();
  }
}

void ScalarFactor::solve(PaddedNodes* x, PaddedNodes* work) const {
  const int n = static_cast<int>(position_.size());
  for (int i = 0; i < n; ++i) work->col(position_[static_cast<size_t>(i)]) = x->col(i);
  float* w = work->data();
  using Lane = Eigen::Map<Eigen::Array4f, Eigen::Aligned16>;
  const Entry* entry = entries_.data();
  for (int j = 0; j < n; ++j) {
    const Eigen::Array4f pivot = inverse_diagonal_[static_cast<size_t>(j)] * Lane(w + 4 * j);
    Lane(w + 4 * j) = pivot;
    for (const Entry* last = entries_.data() + column_start_[static_cast<size_t>(j) + 1]; entry != last; ++entry) {
      Lane(w + 4 * entry->row) -= entry->value * pivot;
    }
  }
  for (int j = n - 1; j >= 0; --j) {
    const Entry* first = entries_.data() + column_start_[static_cast<size_t>(j)];
    const Entry* last = entries_.data() + column_start_[static_cast<size_t>(j) + 1];
    Eigen::Array4f sum = Lane(w + 4 * j), other = Eigen::Array4f::Zero();  // two chains hide the latency of the sum
    for (; last - first > 1; first += 2) {
      sum -= first[0].value * Lane(w + 4 * first[0].row);
      other -= first[1].value * Lane(w + 4 * first[1].row);
    }
    if (first != last) sum -= first->value * Lane(w + 4 * first->row);
    Lane(w + 4 * j) = inverse_diagonal_[static_cast<size_t>(j)] * (sum + other);
  }
  for (int i = 0; i < n; ++i) x->col(i) = work->col(position_[static_cast<size_t>(i)]);
}

}  // namespace deformable_sim
