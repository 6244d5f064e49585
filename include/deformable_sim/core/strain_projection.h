// The nearest positions at which no strain limit is exceeded, by an interior-point method.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/linear/block_factor.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

struct StrainLimitReport {
  int iterations = 0;      // of the projection, a sparse factorisation each; 0 when nothing was too long
  double violation = 0.0;  // of the worst limit after it, relative to its longest
  bool converged = true;   // violation <= 5e-7; false when held nodes are further apart than the limits allow
};

/// Minimises sum m |x - y|^2 / 2 over the positions x with c(x) <= 0,
///
///   c = |x_b - x_a| - l           every limit
///   c = offset - n.p(x) + g       every plane of a collider, g the smaller of 0 and its gap at y: nothing is pressed
///   further in
///
/// from the positions y that a step has led to; held nodes stay. The problem is convex, so there is one solution, and
/// it moves nodes by equal and opposite impulses t >= 0 along the limits: momentum is kept, nothing is pushed apart.
/// The conditions M (x - y) + sum t dc/dx = 0, c + s = t / W, t s = mu are solved by Newton's method while mu goes to
/// zero [Mehrotra 1992]; W is so large that it shows only where limits contradict each other, whose excess it spreads.
/// One step costs one sparse Cholesky factor of the 3n x 3n matrix
///
///   M + sum t / (s + t / W) n n^T + t/|d| (I - n n^T)
///
/// and some ten steps are enough whatever the size. Methods that add one violated limit after the other (Gauss-Seidel
/// passes, active sets) need as many as there are limits between a node and what holds it.
class StrainProjection {
 public:
  explicit StrainProjection(const Model& model);

  /// Moves `x` (all nodes of the model). inverse_mass: 0 at held nodes. impulse (kg m, one a limit) and contact_impulse
  /// (one a contact): t, out.
  StrainLimitReport solve(const Eigen::VectorXd& inverse_mass, const ContactConstraints& contacts, Nodes* x,
                          std::vector<double>* impulse, std::vector<double>* contact_impulse);

 private:
  struct Constraint {
    double mass = 0.0;  // effective, kg; 0 = between held nodes, left out
    double value = 0.0, slack = 0.0, slack_step = 0.0;
    double impulse = 0.0, impulse_step = 0.0;
    double product = 0.0;     // how much of t s the step is to take away
    double mismatch() const;  // c + s - t / W
    double firmness() const;  // s + t / W
  };
  struct Pair : Constraint {
    int a, b;                 // local nodes
    double longest;           // m
    double length = 0.0;      // m, of the present positions
    Vec3 n = Vec3::Zero();    // from a to b
    std::array<int, 4> slot;  // of aa, ab, ba, bb
  };
  struct Plane : Constraint {
    int index = 0;  // of the contact
    int count = 1;
    std::array<int, 4> node{};  // local
    std::array<double, 4> weight{};
    Vec3 n = Vec3::Zero();
    double offset = 0.0;
  };
  struct StepLength {
    double x = 1.0, impulse = 1.0;
  };

  static double rate(const Pair& p, const Nodes& dx);
  static double rate(const Plane& p, const Nodes& dx);
  static void pull(const Pair& p, double impulse, Nodes* r);
  static void pull(const Plane& p, double impulse, Nodes* r);
  template <class F>
  void every(F f);

  void begin(const Eigen::VectorXd& inverse_mass, const ContactConstraints& contacts, const Nodes& x);
  void add_planes(const ContactConstraints& contacts);
  void evaluate();
  void start_inside();
  /// residual_ = M (y - x) + sum of pulls, zero at held nodes.
  void find_residual();
  bool is_solved(StrainLimitReport* report);
  double mean_product();
  void assemble();
  void find_direction();
  StepLength longest_step(double share);
  bool newton_step();
  bool is_free(int node) const { return inverse_mass_[node] > 0.0; }
  void zero_held(Nodes* r) const;

  std::vector<int> world_;  // node of each local one
  std::vector<int> local_;  // of each world node, or -1
  std::vector<Pair> pairs_;
  std::vector<Plane> planes_;
  BlockMatrix matrix_;
  BlockFactor factor_;
  Eigen::VectorXd mass_, inverse_mass_;  // local; inverse 0 at held nodes
  Nodes start_, x_, step_, residual_;
  double excess_ = 0.0;  // m, of the worst limit at the start
};

}  // namespace deformable_sim
