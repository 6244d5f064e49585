// Projective dynamics: implicit Euler by a matrix that never changes.
//
// With S the difference of a spring's ends and p = L n its projection, a step minimises by turns
//   |x - y|_M^2 / (2 dt^2) + sum k/2 |S x - p|^2 over p (each spring) and over x (one constant matrix) [Bouaziz 2014],
// which is x += A^-1 r, A = M / dt^2 + sum k S^T S + bending, r the unbalanced force at x [Liu 2017].
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/grid/sheet_lines.h"
#include "deformable_sim/core/integrator/impulse_contacts.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "deformable_sim/core/linear/constant_factor.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

constexpr char kName[] = "projective_dynamics";

class ProjectiveDynamics : public Integrator {
 public:
  explicit ProjectiveDynamics(const SolverSettings& settings)
      : iterations_(settings.newton_iterations), tolerance_(settings.tolerance) {}

  std::string name() const override { return kName; }
  Needs needs() const override { return {false, true}; }
  int order() const override { return 1; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { prepared_ = false; }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    if (!prepared_) prepare(*d);
    if (dt != factored_dt_) factorise(dt, *d);
    begin(dt, *d, *s);
    StepReport report;
    work_.v = (work_.x - s->x) / dt;
    for (ContactConstraint& c : d->contacts) c.force.setZero();
    double left = find_residual(dt, *d, *s);
    while (report.newton_iterations < iterations_ && left > tolerance_) {
      step_ = residual_;
      factor_.solve(&step_);
      work_.x += step_;
      work_.v = (work_.x - s->x) / dt;
      ++report.newton_iterations;
      left = find_residual(dt, *d, *s);
    }
    report.force_evaluations = report.newton_iterations + 1;
    report.linear_iterations = report.newton_iterations;
    take_reactions(outer_force_, &d->kinematics);
    if (!d->contacts.empty()) left = resolve_contacts(dt, d, *s);
    report.residual = left;
    report.converged = work_.finite() && left <= tolerance_;
    std::swap(s->x, work_.x);
    std::swap(s->v, work_.v);
    s->time += dt;
    return report;
  }

 private:
  void prepare(const Dynamics& d) {
    prepared_ = true;
    factored_dt_ = 0.0;
    terms_ = sort_terms(kName, d.energies, d.mass->size(), {});
    free_.assign(static_cast<size_t>(d.mass->size()), 1);
    for (int node : d.kinematics.node) free_[static_cast<size_t>(node)] = 0;
    inverse_mass_ = d.mass->cwiseInverse();
    for (int node : d.kinematics.node) inverse_mass_[node] = 0.0;
    std::vector<const Energy*> in_rows;
    sheets_.clear();
    if (d.grids != nullptr) {
      for (const GridSheet& grid : *d.grids) {
        sheets_.push_back(std::make_unique<SheetLines<double>>(grid, d.kinematics.node));
        in_rows.insert(in_rows.end(), grid.replaces.begin(), grid.replaces.end());
      }
    }
    others_.clear();
    for (const Energy* energy : d.energies) {
      if (std::find(in_rows.begin(), in_rows.end(), energy) == in_rows.end()) others_.push_back(energy);
    }
  }

  bool is_free(Eigen::Index node) const { return free_[static_cast<size_t>(node)] != 0; }

  void factorise(double dt, const Dynamics& d) {
    factored_dt_ = dt;
    const Eigen::Index n = d.mass->size();
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](Eigen::Index a, Eigen::Index b, double value) {
      if (is_free(a) && is_free(b)) entries.emplace_back(static_cast<int>(a), static_cast<int>(b), value);
    };
    for (Eigen::Index i = 0; i < n; ++i) {
      add(i, i, (*d.mass)[i] * (1.0 / dt + terms_.everywhere.rate) / dt);
      if (!is_free(i)) entries.emplace_back(static_cast<int>(i), static_cast<int>(i), 1.0);
    }
    for (const TargetSprings* springs : terms_.targets) {
      for (int node : springs->nodes()) add(node, node, springs->stiffness());
    }
    for (const KnownSpring& spring : terms_.springs) {
      const double k = spring.stiffness + spring.damping / dt;
      add(spring.a, spring.a, k);
      add(spring.b, spring.b, k);
      add(spring.a, spring.b, -k);
      add(spring.b, spring.a, -k);
    }
    const auto add_all = [&](const Eigen::SparseMatrix<double>& matrix, double factor) {
      for (int j = 0; j < matrix.outerSize(); ++j) {
        for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, j); it; ++it) add(it.row(), j, factor * it.value());
      }
    };
    add_all(terms_.stiffness, 1.0);
    add_all(terms_.damping, 1.0 / dt);
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_.factorise(matrix);
  }

  /// From where the body is: at rest nothing moves, however few iterations there are.
  void begin(double dt, const Dynamics& d, const State& s) {
    work_.x = s.x;
    work_.time = s.time + dt;
    const Kinematics& k = d.kinematics;
    for (size_t i = 0; i < k.node.size(); ++i) work_.x.col(k.node[i]) = k.target.col(static_cast<Eigen::Index>(i));
    for (auto& sheet : sheets_) sheet->begin(work_.x, s.x, inverse_mass_, dt);
  }

  /// residual_ := what is unbalanced at the free nodes, N; outer_force_ := the rest. RMS per mass, m/s^2.
  double find_residual(double dt, const Dynamics& d, const State& s) {
    residual_.setZero(3, work_.x.cols());
    for (const Energy* energy : others_) energy->add_force(work_, &residual_);
    for (auto& sheet : sheets_) {
      sheet->move_to(work_.x);
      sheet->add_forces(&residual_);
    }
    for (const ContactConstraint& c : d.contacts) {
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) residual_.col(c.node[k]) += c.weight[k] * c.force;
    }
    outer_force_.resize(3, work_.x.cols());
    double sum = 0.0;
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < work_.x.cols(); ++i) {
      outer_force_.col(i) = (*d.mass)[i] / dt * (work_.v.col(i) - s.v.col(i)) - residual_.col(i);
      if (!is_free(i)) {
        residual_.col(i).setZero();
        continue;
      }
      residual_.col(i) = -outer_force_.col(i);
      sum += (inverse_mass_[i] * residual_.col(i)).squaredNorm();
      ++count;
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
  }

  /// Afterwards, by impulses. What is left unbalanced, contacts included.
  double resolve_contacts(double dt, Dynamics* d, const State& s) {
    impulses_.resolve(d->contacts, inverse_mass_, dt, 1.0, &work_);
    for (size_t i = 0; i < d->contacts.size(); ++i) d->contacts[i].force = impulses_.impulse(i, d->contacts) / dt;
    return find_residual(dt, *d, s);
  }

  int iterations_;
  double tolerance_;  // m/s^2
  bool prepared_ = false;
  double factored_dt_ = 0.0;  // s, 0: not yet
  KnownTerms terms_;
  std::vector<const Energy*> others_;  // not of sheets in rows
  std::vector<std::unique_ptr<SheetLines<double>>> sheets_;
  std::vector<char> free_;
  Eigen::VectorXd inverse_mass_;  // 0 at held nodes
  ConstantFactor factor_;
  State work_;
  Nodes residual_, step_, outer_force_;
  ImpulseContacts impulses_;
};

}  // namespace

std::unique_ptr<Integrator> make_projective_dynamics(const SolverSettings& settings) {
  return std::make_unique<ProjectiveDynamics>(settings);
}

}  // namespace deformable_sim
