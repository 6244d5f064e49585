// Springs solved chain by chain, their tensions the unknowns.
#pragma once

#include <vector>

#include "deformable_sim/core/energy/known_terms.h"

namespace deformable_sim {

/// Nonlinear block Gauss-Seidel on the tensions t of springs between points that answer to forces by x += w f:
///
///   (1 / K + G W G^T) dt = (k (|d| - L) + c n.(d - d_base) / tau - t) / K,   K = k + c / tau,   x -= W G^T dt
///
/// G the directions n of a chain's springs: a tridiagonal system a chain, solved exactly. A chain of one spring is the
/// compliant constraint of XPBD [Macklin 2016].
class SpringChains {
 public:
  enum class Grouping {
    kLines,   // as long as springs of a term go straight on, by the numbers of their nodes, or a node has but two
    kSingly,  // every spring for itself, by colours: springs of a colour share no node
  };
  SpringChains(const std::vector<KnownSpring>& springs, Eigen::Index nodes, Grouping grouping);

  bool empty() const { return springs_.empty(); }
  /// Springs without tension.
  void begin(double tau);
  /// One sweep. weight: m/N by node, 0 at held ones; base: of the velocities (x - base) / tau. x moves; pull (N)
  /// gathers the forces on nodes of no weight.
  void sweep(const Eigen::VectorXd& weight, const Nodes& base, Nodes* x, Nodes* pull);

 private:
  struct Slot {
    Vec3 n;
    double s, back;  // see sweep()
  };
  void group_lines(const std::vector<KnownSpring>& springs, Eigen::Index nodes);
  void group_singly(const std::vector<KnownSpring>& springs, Eigen::Index nodes);
  void solve(int first, int last, const Eigen::VectorXd& weight, const Nodes& base, Nodes* x, Nodes* pull);

  std::vector<KnownSpring> springs_;  // chain after chain; b of one is a of the next
  std::vector<int> start_;            // of chains, and the end
  std::vector<double> tension_;       // N
  std::vector<Slot> slots_;           // of one chain
  double tau_ = 0.0;
};

}  // namespace deformable_sim
