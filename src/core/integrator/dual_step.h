// One step of solvers whose unknowns are the tensions of springs: line_dual and xpbd.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/grid/sheet_lines.h"
#include "deformable_sim/core/integrator/impulse_contacts.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/spring_chains.h"
#include "deformable_sim/core/linear/constant_factor.h"

namespace deformable_sim {

/// v = (x - x_base) / tau_v, a = (v - v_base) / tau_a.
struct DualFormula {
  double tau_v, tau_a;
  const Nodes *x_base, *v_base;
};

template <class Real>
class DualStep {
 public:
  /// name: of the scheme, for refusals; sweeps >= 1.
  DualStep(std::string name, SpringChains::Grouping grouping, int sweeps, double tolerance)
      : name_(std::move(name)), grouping_(grouping), sweeps_(sweeps), tolerance_(tolerance) {}

  void reset() { prepared_ = false; }
  /// To be called before each step.
  void prepare(const Dynamics& d) {
    if (!prepared_) sort(d);
  }
  /// Whether there are forces on single nodes or drag.
  bool has_local_forces() const { return !terms_.local.empty(); }
  /// local: the state those are taken at. The formula may refer to x and v of `s`.
  StepReport advance(double dt, const DualFormula& formula, const State& local, Dynamics* d, State* s);
  /// x and v before the last step; may be swapped away.
  State& start() { return work_; }

 private:
  struct Bending {
    ConstantFactor factor;
    double tau_v = 0.0, tau_a = 0.0;
    Eigen::VectorXd inertia;  // N/m: what is on its diagonal beside the terms; 1 at held nodes
  };

  void sort(const Dynamics& d);
  void find_responses(double dt, const DualFormula& f, const Dynamics& d);
  void predict(double dt, const DualFormula& f, const State& local, const Dynamics& d, const State& s);
  void press(const ContactConstraints& contacts);
  void press_in_rows(const ContactConstraints& contacts);
  void push(const ContactConstraint& contact, double force, Nodes* x) const;
  void release(double dt, const ContactConstraints& contacts, const State& start);
  Bending& bending_matrix(double dt, const DualFormula& f, const Dynamics& d);
  void bend(const DualFormula& f, Bending* matrix, const Kinematics& kinematics);
  Vec3 bending_force(Eigen::Index node, const Nodes& x, const Nodes& base, double per_tau) const;
  void find_velocities(double dt, const DualFormula& f, const Dynamics& d, const State& s);
  void hold(const DualFormula& f, Dynamics* d);
  double residual(double dt, const DualFormula& f, const Dynamics& d, const State& start);

  std::string name_;
  SpringChains::Grouping grouping_;
  int sweeps_;
  double tolerance_;  // m/s^2
  bool prepared_ = false;

  KnownTerms terms_;
  std::vector<const Energy*> outside_;  // terms that are neither in rows nor proportional to mass
  std::vector<std::unique_ptr<SheetLines<Real>>> sheets_;
  std::unique_ptr<SpringChains> chains_;
  Nodes weight_force_;                       // N, of everywhere_ without its drag
  Eigen::VectorXd attached_, inverse_mass_;  // N/m of soft grasps; 0 at held nodes
  std::vector<int> near_;                    // nodes named by a contact, ascending
  Eigen::VectorXd response_;                 // m/N, 0 at held nodes
  double tau_v_ = 0.0, tau_a_ = 0.0;         // of response_, but for near_
  State work_;
  Nodes local_force_, pull_, held_force_, held_bending_, force_;
  // Quadratic terms outside sheets: (M / (tau_v tau_a) + K + D / tau_v) z = force, by whether there are contacts.
  Bending bending_[2];
  Nodes bent_, solution_;
  bool bent_before_ = false;
  std::vector<double> pressed_;  // N, by contact
  ImpulseContacts impulses_;
};

extern template class DualStep<float>;
extern template class DualStep<double>;

}  // namespace deformable_sim
