// What contacts between bodies add to a matrix whose pattern does not know them.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "deformable_sim/core/linear/linear_solver.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// C = sum over couplings of W^T H W, W p = sum_k weight[k] p[node[k]], H symmetric and positive semi-definite. Its
/// diagonal blocks D belong into the matrix at hand; what is beside them, C - D, is known here alone.
///
/// An iterative solver adds it to its products. For one that has factors of the matrix P, D included, solve() finds
/// (P + C - D) x = b by conjugate gradients preconditioned with P^-1: as P z = r, products with P follow by recurrence.
/// The number of iterations grows with the square root of H over what else holds the nodes, and with the number of
/// couplings while they are few.
class NodeCouplings {
 public:
  struct Coupling {
    std::array<int, 4> node;
    std::array<double, 4> weight;  // 0 at held nodes
    int count;
    Mat3 matrix;  // N/m
  };
  /// z = P^-1 r, to three digits or better; false when there is none.
  using Precondition = std::function<bool(const Nodes& r, Nodes* z)>;

  void clear() { couplings_.clear(); }
  bool empty() const { return couplings_.empty(); }
  void add(const Coupling& coupling) { couplings_.push_back(coupling); }

  /// y += (C - D) p, in columns place(node) of arrays of three or more rows; returns p^T (C - D) p.
  template <class Place, class In, class Out>
  double add_beside_diagonal(const Place& place, const In& p, Out* y) const {
    using Real = typename In::Scalar;
    double work = 0.0;
    for (const Coupling& c : couplings_) {
      Vec3 sum = Vec3::Zero();
      std::array<Vec3, 4> own;
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        own[k] = c.weight[k] * p.col(place(c.node[k])).template head<3>().template cast<double>();
        sum += own[k];
      }
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        const Vec3 force = c.matrix * (sum - own[k]);
        work += own[k].dot(force);
        y->col(place(c.node[k])).template head<3>() += (c.weight[k] * force).template cast<Real>();
      }
    }
    return work;
  }

  /// `x` is P^-1 b on entry. weight and tolerance as LinearSolver has them. `report` gets the iterations.
  void solve(const Nodes& b, const Eigen::VectorXd& weight, const LinearTolerance& tolerance,
             const Precondition& precondition, Nodes* x, LinearReport* report);

 private:
  std::vector<Coupling> couplings_;
  Nodes r_, before_, z_, p_, of_p_, q_;
};

}  // namespace deformable_sim
