// The nodes of a sheet on which more acts than springs, bending and weight: contacts, soft grasps, strain limits.
#include "deformable_sim/core/integrator/sheet_solve.h"

namespace deformable_sim {
namespace {

// As in ImplicitStage.
constexpr double kDeep = 3e-4;  // m

constexpr double kRough = 35.0;  // m/s^2

}  // namespace

int SheetSolve::touch(int node) {
  int& touched = touched_of_[static_cast<size_t>(node)];
  if (touched < 0) {
    touched = static_cast<int>(touched_.size());
    touched_.push_back({node, rows_.place(node), false});
  }
  return touched;
}

void SheetSolve::find_touched(const Dynamics& d, const SheetSurroundings& around) {
  for (const Touched& t : touched_) {
    touched_of_[static_cast<size_t>(t.node)] = -1;
    untouched_weight_.data()[t.place] = system_->weight()[t.place];
  }
  touched_.clear();
  constraints_.clear();
  constraint_of_.clear();
  const auto mine = [this](int node) { return node >= first_ && node < first_ + count_; };
  for (size_t k = 0; k < d.contacts.size(); ++k) {
    if (!mine(d.contacts[k].node[0])) continue;
    constraints_.push_back(d.contacts[k]);
    constraint_of_.push_back(k);
    ContactConstraint& c = constraints_.back();
    for (size_t i = 0; i < static_cast<size_t>(c.count); ++i) {
      c.node[i] = touch(c.node[i] - first_);
      touched_[static_cast<size_t>(c.node[i])].near = true;
    }
  }
  for (const TargetSprings* springs : around.targets) {
    for (int node : springs->nodes()) {
      if (mine(node)) touch(node - first_);
    }
  }
  for (const LimitSprings* limits : around.limits) {
    for (const LimitSprings::Element& e : limits->elements()) {
      if (!mine(e.a)) continue;
      touch(e.a - first_);
      touch(e.b - first_);
    }
  }
  const auto count = static_cast<Eigen::Index>(touched_.size());
  if (touched_x_.cols() < count) {
    for (Nodes* nodes : {&touched_x_, &touched_start_, &touched_force_, &contact_force_}) nodes->setZero(3, 2 * count);
    touched_inverse_mass_.setZero(2 * count);
  }
  touched_base_.resize(touched_.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Touched& t = touched_[static_cast<size_t>(k)];
    touched_start_.col(k) = start_->x.col(first_ + t.node);
    untouched_weight_.data()[t.place] = 0.0f;
    touched_inverse_mass_[k] = static_cast<double>(system_->weight()[t.place]);
  }
  touched_x_ = touched_start_;
  for (const Held& held : held_) {
    const int t = touched_of_[static_cast<size_t>(held.node)];
    if (t >= 0) touched_x_.col(t) = held_position(held);
  }
  contacts_.begin(equation_.contact_span(), touched_start_, touched_x_, touched_inverse_mass_, constraints_);
}

void SheetSolve::gather() {
  for (size_t k = 0; k < touched_.size(); ++k) {
    touched_x_.col(static_cast<Eigen::Index>(k)) = at(x_.data(), touched_[k].place);
  }
}

/// f := forces of soft grasps and strain limits on the touched nodes, at touched_x_.
void SheetSolve::add_terms(Nodes* f) const {
  f->leftCols(static_cast<Eigen::Index>(touched_.size())).setZero();
  const auto index = [this](int node) {
    return node < first_ || node >= first_ + count_ ? -1 : touched_of_[static_cast<size_t>(node - first_)];
  };
  for (const TargetSprings* springs : around_->targets) {
    for (size_t k = 0; k < springs->nodes().size(); ++k) {
      const int i = index(springs->nodes()[k]);
      if (i < 0) continue;
      f->col(i) -= springs->stiffness() * (touched_x_.col(i) - springs->targets().col(static_cast<Eigen::Index>(k)));
    }
  }
  for (const LimitSprings* limits : around_->limits) {
    for (LimitSprings::Element e : limits->elements()) {
      e.a = index(e.a);
      e.b = index(e.b);
      if (e.a < 0) continue;
      const double tension = LimitSprings::tension(e, touched_x_);
      if (tension == 0.0) continue;
      const Vec3 pull = tension * (touched_x_.col(e.b) - touched_x_.col(e.a)).normalized();
      f->col(e.a) += pull;
      f->col(e.b) -= pull;
    }
  }
}

/// Residual of the touched nodes, with contacts.
void SheetSolve::add_touched(bool along_step) {
  sums_ = base_sums_;
  contact_force_.leftCols(static_cast<Eigen::Index>(touched_.size())).setZero();
  if (!contacts_.empty()) contacts_.add_force(touched_x_, &contact_force_);
  const Xyz<float> downhill = system_->residual(), step = system_->step();
  for (size_t k = 0; k < touched_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::ptrdiff_t place = touched_[k].place;
    const Vec3 whole = touched_base_[k] + contact_force_.col(i);
    downhill.x[place] = static_cast<float>(whole[0]);
    downhill.y[place] = static_cast<float>(whole[1]);
    downhill.z[place] = static_cast<float>(whole[2]);
    const double w = touched_inverse_mass_[i];
    sums_.squares += w * w * whole.squaredNorm();
    if (along_step) sums_.work += contact_force_.col(i).dot(Vec3(step.x[place], step.y[place], step.z[place]));
  }
}

/// Worth more iterations than were asked for: World would take such a step again in two parts, at three times the cost
/// and with a larger error. Limits, all but rigid, are better met in shorter parts.
bool SheetSolve::is_rough(const StepReport& report) const {
  if (contacts_.empty()) return report.residual > kRough && around_->limits.empty();
  return report.residual > kRough || contacts_.any_deeper(kDeep, touched_x_);
}

/// What the touched nodes add to the matrix.
void SheetSolve::couple() {
  std::vector<SheetCoupling>& couplings = system_->couplings();
  couplings.clear();
  const auto index = [this](int node) {
    return node < first_ || node >= first_ + count_ ? -1 : touched_of_[static_cast<size_t>(node - first_)];
  };
  const auto place = [this](int k) { return touched_[static_cast<size_t>(k)].place; };
  for (const TargetSprings* springs : around_->targets) {
    for (int node : springs->nodes()) {
      const int i = index(node);
      if (i >= 0)
        couplings.push_back({{place(i), 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}, 1, springs->stiffness() * Mat3::Identity()});
    }
  }
  for (const LimitSprings* limits : around_->limits) {
    for (LimitSprings::Element e : limits->elements()) {
      e.a = index(e.a);
      e.b = index(e.b);
      if (e.a < 0) continue;
      const double tension = LimitSprings::tension(e, touched_x_);
      if (tension == 0.0) continue;
      const Vec3 d = touched_x_.col(e.b) - touched_x_.col(e.a);
      const double r = d.norm(), transverse = settings_.jacobian == Jacobian::kAxial ? 0.0 : tension / r;
      const Vec3 n = d / r;
      const Mat3 h = (e.stiffness - transverse) * n * n.transpose() + transverse * Mat3::Identity();
      couplings.push_back({{place(e.a), place(e.b), 0, 0}, {1.0, -1.0, 0.0, 0.0}, 2, h});
    }
  }
  contacts_.for_each_jacobian(touched_x_, [&](const ContactConstraint& c, const Mat3& h) {
    SheetCoupling coupling{{0, 0, 0, 0}, {0.0, 0.0, 0.0, 0.0}, c.count, h};
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      coupling.place[k] = place(c.node[k]);
      coupling.weight[k] = touched_inverse_mass_[c.node[k]] > 0.0 ? c.weight[k] : 0.0;
    }
    couplings.push_back(coupling);
  });
}

/// See PenaltyContacts::push_out.
void SheetSolve::push_out() {
  contacts_.push_out(kDeep, touched_inverse_mass_, &touched_x_);
  for (size_t k = 0; k < touched_.size(); ++k) {
    put(x_.data(), touched_[k].place, touched_x_.col(static_cast<Eigen::Index>(k)));
  }
}

void SheetSolve::report_contacts(ContactConstraints* contacts) {
  contacts_.report(touched_x_, &constraints_);
  for (size_t k = 0; k < constraints_.size(); ++k) {
    ContactConstraint& c = (*contacts)[constraint_of_[k]];
    c.force = constraints_[k].force;
    c.stuck = constraints_[k].stuck;
  }
}

}  // namespace deformable_sim
