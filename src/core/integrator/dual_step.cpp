#include "dual_step.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {

template <class Real>
StepReport DualStep<Real>::advance(double dt, const DualFormula& f, const State& local, Dynamics* d, State* s) {
  find_responses(dt, f, *d);
  predict(dt, f, local, *d, *s);
  Bending* bending = terms_.stiffness.nonZeros() > 0 ? &bending_matrix(dt, f, *d) : nullptr;
  bent_before_ = false;
  chains_->begin(f.tau_v);
  pressed_.assign(d->contacts.size(), 0.0);
  if (!near_.empty()) press(d->contacts);
  for (auto& sheet : sheets_) sheet->begin(work_.x, *f.x_base, response_, f.tau_v);
  for (int k = 1; k <= sweeps_; ++k) {
    if (k > 1 && !near_.empty()) press_in_rows(d->contacts);
    if (bending != nullptr) bend(f, bending, d->kinematics);
    if (!chains_->empty()) chains_->sweep(response_, *f.x_base, &work_.x, &pull_);
    for (auto& sheet : sheets_) {
      sheet->sweep(k == sweeps_ ? SheetLines<Real>::Last::kYes : SheetLines<Real>::Last::kNo);
    }
  }
  for (auto& sheet : sheets_) sheet->store(&work_.x);
  find_velocities(dt, f, *d, *s);
  hold(f, d);
  if (!d->contacts.empty()) {
    release(dt, d->contacts, *s);
    impulses_.resolve(d->contacts, inverse_mass_, dt, 1.0, &work_);
    for (size_t i = 0; i < d->contacts.size(); ++i) d->contacts[i].force = impulses_.impulse(i, d->contacts) / dt;
  }
  StepReport report;
  report.newton_iterations = sweeps_;
  report.force_evaluations = 1;
  report.residual = residual(dt, f, *d, *s);
  report.converged = work_.finite() && report.residual <= tolerance_;
  std::swap(s->x, work_.x);
  std::swap(s->v, work_.v);
  s->time += dt;
  return report;
}

template <class Real>
void DualStep<Real>::sort(const Dynamics& d) {
  prepared_ = true;
  const Eigen::Index n = d.mass->size();
  std::vector<const Energy*> in_rows;
  sheets_.clear();
  const LineSolve how = grouping_ == SpringChains::Grouping::kLines ? LineSolve::kWhole : LineSolve::kSpringBySpring;
  if (d.grids != nullptr) {
    for (const GridSheet& grid : *d.grids) {
      sheets_.push_back(std::make_unique<SheetLines<Real>>(grid, d.kinematics.node, how));
      in_rows.insert(in_rows.end(), grid.replaces.begin(), grid.replaces.end());
    }
  }
  terms_ = sort_terms(name_, d.energies, n, in_rows);
  chains_ = std::make_unique<SpringChains>(terms_.springs, n, grouping_);
  outside_.clear();
  std::vector<const Energy*> masses;
  for (const Energy* energy : d.energies) {
    if (energy->mass_force() != nullptr) {
      masses.push_back(energy);
    } else if (std::find(in_rows.begin(), in_rows.end(), energy) == in_rows.end()) {
      outside_.push_back(energy);
    }
  }
  inverse_mass_ = d.mass->cwiseInverse();
  for (int node : d.kinematics.node) inverse_mass_[node] = 0.0;
  attached_.setZero(n);
  for (const TargetSprings* springs : terms_.targets) {
    for (int node : springs->nodes()) attached_[node] += springs->stiffness();
  }
  work_.x = work_.v = Nodes::Zero(3, n);
  weight_force_.setZero(3, n);
  for (const Energy* energy : masses) energy->add_force(work_, &weight_force_);  // angles of rods have none
  near_.clear();
  tau_v_ = 0.0;
  response_.setZero(n);
  pull_.setZero(3, n);
  force_.setZero(3, n);
  held_bending_.setZero(3, static_cast<Eigen::Index>(d.kinematics.node.size()));
  if (!terms_.local.empty()) local_force_.setZero(3, n);
  if (terms_.stiffness.nonZeros() > 0) bent_ = solution_ = Nodes::Zero(3, n);
  for (Bending& bending : bending_) bending.tau_v = 0.0;
}

/// Nodes that a contact names follow implicit Euler: a formula that remembers throws a stopped node back.
template <class Real>
void DualStep<Real>::find_responses(double dt, const DualFormula& f, const Dynamics& d) {
  const double rate = terms_.everywhere.rate;
  const auto set = [&](Eigen::Index i, double tau_v, double tau_a) {
    if (inverse_mass_[i] > 0.0) response_[i] = 1.0 / ((*d.mass)[i] * (1.0 / tau_a + rate) / tau_v + attached_[i]);
  };
  if (!near_.empty() || tau_v_ != f.tau_v || tau_a_ != f.tau_a) {
    for (Eigen::Index i = 0; i < response_.size(); ++i) set(i, f.tau_v, f.tau_a);
    tau_v_ = f.tau_v;
    tau_a_ = f.tau_a;
  }
  near_.clear();
  for (const ContactConstraint& c : d.contacts) near_.insert(near_.end(), c.node.begin(), c.node.begin() + c.count);
  std::sort(near_.begin(), near_.end());
  near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
  for (int node : near_) set(node, dt, dt);
}

/// Normal forces of contacts, one after the other, so that springs meet the points where they will be.
template <class Real>
void DualStep<Real>::press(const ContactConstraints& contacts) {
  for (size_t i = 0; i < contacts.size(); ++i) {
    const ContactConstraint& c = contacts[i];
    double gap = -c.offset, response = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      gap += c.weight[k] * c.normal.dot(work_.x.col(c.node[k]));
      response += c.weight[k] * c.weight[k] * response_[c.node[k]];
    }
    if (response == 0.0) continue;
    const double force = std::max(0.0, pressed_[i] - gap / response);
    push(c, force - pressed_[i], &work_.x);
    pressed_[i] = force;
  }
}

template <class Real>
void DualStep<Real>::push(const ContactConstraint& c, double force, Nodes* x) const {
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    x->col(c.node[k]) += (force * c.weight[k] * response_[c.node[k]]) * c.normal;
  }
}

/// The same between sweeps, when sheets are in rows.
template <class Real>
void DualStep<Real>::press_in_rows(const ContactConstraints& contacts) {
  for (int node : near_) {
    for (auto& sheet : sheets_) {
      if (sheet->contains(node)) work_.x.col(node) = sheet->position(node);
    }
  }
  press(contacts);
  for (int node : near_) {
    for (auto& sheet : sheets_) {
      if (sheet->contains(node)) sheet->move_to(node, work_.x.col(node));
    }
  }
}

/// Takes those forces back: the impulses at the end of the step, with friction, are to be the whole of the contacts'.
template <class Real>
void DualStep<Real>::release(double dt, const ContactConstraints& contacts, const State& start) {
  for (size_t i = 0; i < contacts.size(); ++i) push(contacts[i], -pressed_[i], &work_.x);
  for (int node : near_) {
    if (inverse_mass_[node] > 0.0) work_.v.col(node) = (work_.x.col(node) - start.x.col(node)) / dt;
  }
}

/// Where nodes go without springs and bending.
template <class Real>
void DualStep<Real>::predict(double dt, const DualFormula& f, const State& local, const Dynamics& d, const State& s) {
  const double rate = terms_.everywhere.rate;
  work_.time = s.time + dt;
  // response m (1 / tau_a + rate) / tau_v = 1 but where a soft grasp pulls.
  const double of_v = f.tau_v / (1.0 + rate * f.tau_a), of_force = f.tau_a * of_v;
  work_.x = *f.x_base + of_v * *f.v_base;
  work_.x.colwise() += of_force * terms_.everywhere.acceleration;
  const auto put = [&](Eigen::Index i, double tau_v, double tau_a, const Nodes& x, const Nodes& v) {
    const double inertia = (*d.mass)[i] / tau_v;
    work_.x.col(i) =
        response_[i] * (inertia * ((1.0 / tau_a + rate) * x.col(i) + tau_v / tau_a * v.col(i)) + weight_force_.col(i));
  };
  for (const TargetSprings* springs : terms_.targets) {
    for (int node : springs->nodes()) put(node, f.tau_v, f.tau_a, *f.x_base, *f.v_base);
  }
  for (int node : near_) put(node, dt, dt, s.x, s.v);
  for (const TargetSprings* springs : terms_.targets) {
    for (size_t k = 0; k < springs->nodes().size(); ++k) {
      const int node = springs->nodes()[k];
      work_.x.col(node) +=
          (response_[node] * springs->stiffness()) * springs->targets().col(static_cast<Eigen::Index>(k));
    }
  }
  if (!terms_.local.empty()) {
    local_force_.setZero();
    for (const Energy* energy : terms_.local) energy->add_force(local, &local_force_);
    for (Eigen::Index i = 0; i < work_.x.cols(); ++i) work_.x.col(i) += response_[i] * local_force_.col(i);
  }
  const Kinematics& k = d.kinematics;
  for (size_t i = 0; i < k.node.size(); ++i) {
    work_.x.col(k.node[i]) = k.target.col(static_cast<Eigen::Index>(i));
    pull_.col(k.node[i]).setZero();
  }
}

/// Near contacts every node has the inertia of implicit Euler here: one matrix for any set of touched nodes.
template <class Real>
typename DualStep<Real>::Bending& DualStep<Real>::bending_matrix(double dt, const DualFormula& f, const Dynamics& d) {
  Bending& bending = bending_[d.contacts.empty() ? 0 : 1];
  const double tau_v = d.contacts.empty() ? f.tau_v : dt, tau_a = d.contacts.empty() ? f.tau_a : dt;
  if (bending.tau_v == tau_v && bending.tau_a == tau_a) return bending;
  bending.tau_v = tau_v;
  bending.tau_a = tau_a;
  const Eigen::Index n = d.mass->size();
  bending.inertia = *d.mass * ((1.0 / tau_a + terms_.everywhere.rate) / tau_v) + attached_;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const Eigen::SparseMatrix<double>& matrix, double factor) {
    for (int j = 0; j < matrix.outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, j); it; ++it) {
        if (inverse_mass_[it.row()] == 0.0 || inverse_mass_[j] == 0.0) continue;
        entries.emplace_back(static_cast<int>(it.row()), j, factor * it.value());
      }
    }
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), inverse_mass_[i] > 0.0 ? bending.inertia[i] : 1.0);
  }
  add(terms_.stiffness, 1.0);
  if (terms_.damping.nonZeros() > 0) add(terms_.damping, 1.0 / f.tau_v);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  bending.factor.factorise(matrix);
  return bending;
}

/// Bending at what the rest of the forces has led to, exactly: (inertia + K + D / tau_v) z = f.
template <class Real>
void DualStep<Real>::bend(const DualFormula& f, Bending* matrix, const Kinematics& kinematics) {
  if (bent_before_) work_.x -= bent_;
  bent_before_ = true;
  const double per_tau = 1.0 / f.tau_v;
  for (Eigen::Index i = 0; i < solution_.cols(); ++i) {
    if (inverse_mass_[i] > 0.0) {
      solution_.col(i) = bending_force(i, work_.x, *f.x_base, per_tau);
    } else {
      solution_.col(i).setZero();
    }
  }
  matrix->factor.solve(&solution_);
  force_ = work_.x + solution_;
  for (size_t k = 0; k < kinematics.node.size(); ++k) {
    held_bending_.col(static_cast<Eigen::Index>(k)) = bending_force(kinematics.node[k], force_, *f.x_base, per_tau);
  }
  for (Eigen::Index i = 0; i < solution_.cols(); ++i) {
    bent_.col(i) = (response_[i] * matrix->inertia[i]) * solution_.col(i);
  }
  work_.x += bent_;
}

/// On one node, N.
template <class Real>
Vec3 DualStep<Real>::bending_force(Eigen::Index node, const Nodes& x, const Nodes& base, double per_tau) const {
  Vec3 f = Vec3::Zero();
  for (Eigen::SparseMatrix<double>::InnerIterator it(terms_.stiffness, node); it; ++it) {
    f -= it.value() * x.col(it.row());
  }
  if (terms_.damping.nonZeros() == 0) return f;
  for (Eigen::SparseMatrix<double>::InnerIterator it(terms_.damping, node); it; ++it) {
    f -= (it.value() * per_tau) * (x.col(it.row()) - base.col(it.row()));
  }
  return f;
}

template <class Real>
void DualStep<Real>::find_velocities(double dt, const DualFormula& f, const Dynamics& d, const State& s) {
  const double per_tau = 1.0 / f.tau_v;
  work_.v = per_tau * (work_.x - *f.x_base);
  for (int node : near_) work_.v.col(node) = (work_.x.col(node) - s.x.col(node)) / dt;
  const Kinematics& k = d.kinematics;
  for (size_t i = 0; i < k.node.size(); ++i) {
    work_.v.col(k.node[i]) = (k.target.col(static_cast<Eigen::Index>(i)) - s.x.col(k.node[i])) / dt;
  }
}

/// Forces of holders.
template <class Real>
void DualStep<Real>::hold(const DualFormula& f, Dynamics* d) {
  Kinematics& k = d->kinematics;
  const auto count = static_cast<Eigen::Index>(k.node.size());
  held_force_.setZero(3, count);
  for (auto& sheet : sheets_) sheet->add_held_forces(&held_force_);
  if (bent_before_) held_force_ += held_bending_;
  k.reaction.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    const double m = (*d->mass)[node];
    const Vec3 v = work_.v.col(node);
    Vec3 force = held_force_.col(i) + pull_.col(node) + weight_force_.col(node) - m * terms_.everywhere.rate * v;
    if (!terms_.local.empty()) force += local_force_.col(node);
    k.reaction.col(i) = m / f.tau_a * (v - f.v_base->col(node)) - force;
  }
  for (const TargetSprings* springs : terms_.targets) {
    // A held node is no soft grasp's to move; what pulls at it, its holder feels.
    for (size_t i = 0; i < springs->nodes().size(); ++i) {
      const auto held = std::lower_bound(k.node.begin(), k.node.end(), springs->nodes()[i]);
      if (held == k.node.end() || *held != springs->nodes()[i]) continue;
      k.reaction.col(held - k.node.begin()) +=
          springs->stiffness() * (work_.x.col(*held) - springs->targets().col(static_cast<Eigen::Index>(i)));
    }
  }
}

/// RMS of what is left of the equations of motion at the free nodes, with the forces of the terms at the end.
template <class Real>
double DualStep<Real>::residual(double dt, const DualFormula& f, const Dynamics& d, const State& start) {
  force_.setZero();
  for (const Energy* energy : outside_) energy->add_force(work_, &force_);
  for (auto& sheet : sheets_) {
    if (!near_.empty()) sheet->move_to(work_.x);
    sheet->add_forces(&force_);
  }
  for (const ContactConstraint& c : d.contacts) {
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) force_.col(c.node[k]) += c.weight[k] * c.force;
  }
  // The acceleration of nodes near contacts is another: what is added here makes up for it.
  const double per_tau = 1.0 / f.tau_a;
  for (int node : near_) {
    const Vec3 v = work_.v.col(node);
    force_.col(node) += (*d.mass)[node] * (per_tau * (v - f.v_base->col(node)) - (v - start.v.col(node)) / dt);
  }
  const Vec3 g = terms_.everywhere.acceleration;
  const double rate = terms_.everywhere.rate;
  double sum = 0.0;
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < work_.x.cols(); ++i) {
    const double w = inverse_mass_[i];
    if (w == 0.0) continue;
    const Vec3 v = work_.v.col(i);
    sum += (w * force_.col(i) + g - rate * v - per_tau * (v - f.v_base->col(i))).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

template class DualStep<float>;
template class DualStep<double>;

}  // namespace deformable_sim
