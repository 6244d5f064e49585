#include "energy_book.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kShareOfMotion = 0.5;  // of K, that may be unexplained in the steps between two looks
constexpr double kLift = 0.02;          // J/kg
constexpr double kForget = 1.0;         // s

double stored_energy(const Dynamics& d, const Energy* ignored, const State& s) {
  double stored = 0.0;
  for (const Energy* e : d.energies)
    if (e != ignored) stored += e->value(s);
  return stored;
}

}  // namespace

MotionEnergy motion_energy(const Model& model, const State& s) {
  MotionEnergy e;
  if (model.mass_matrix.nonZeros() > 0) {
    for (int j = 0; j < model.mass_matrix.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator it(model.mass_matrix, j); it; ++it)
        e.kinetic += it.value() * s.v.col(it.row()).dot(s.v.col(j));
  } else {
    const double *m = model.mass.data(), *v = s.v.data();
    for (Eigen::Index i = 0, n = s.v.cols(); i < n; ++i, v += 3)
      e.kinetic += m[i] * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  e.kinetic *= 0.5;
  const double *m = model.mass.data(), *x = s.x.data();
  Vec3 moment = Vec3::Zero();
  for (Eigen::Index i = 0, n = model.point_count(); i < n; ++i, x += 3) moment += m[i] * Vec3(x[0], x[1], x[2]);
  e.weight = -model.gravity.dot(moment);
  return e;
}

void EnergyBook::begin() {
  looks_ = evaluations_ = 0;
  at_start_ = at_end_ = kUnknown;
}

void EnergyBook::begin_step() {
  work_before_ = work_;
  at_start_ = at_end_;
  at_end_ = kUnknown;
}

void EnergyBook::restart_step() {
  work_ = work_before_;
  at_end_ = kUnknown;
}

void EnergyBook::begin_held(const Kinematics& k, const Nodes& x) {
  held_.resize(3, static_cast<Eigen::Index>(k.node.size()));
  for (Eigen::Index i = 0; i < held_.cols(); ++i) held_.col(i) = x.col(k.node[static_cast<size_t>(i)]);
}

void EnergyBook::end_held(const Kinematics& k, const Nodes& x) {
  for (Eigen::Index i = 0; i < held_.cols(); ++i)
    work_ += k.reaction.col(i).dot(x.col(k.node[static_cast<size_t>(i)]) - held_.col(i));
}

void EnergyBook::add_colliders(const ContactConstraints& contacts, double h) {
  for (const ContactConstraint& c : contacts)
    if (c.collider >= 0) work_ += h * c.force.dot(c.surface_velocity);
}

namespace {

/// What terms store that may store less than nothing, J.
double stored_below_zero(const Model& model, const State& s) {
  double sum = 0.0;
  for (const auto& e : model.energies) {
    if (e->may_be_negative()) sum += std::min(0.0, e->value(s));
  }
  return sum;
}

}  // namespace

bool EnergyBook::is_possible(const Model& model, const State& s) const {
  if (looks_ == 0) return true;
  const MotionEnergy e = motion_energy(model, s);
  const double slack = kShareOfMotion * e.kinetic + kLift * mass_ + std::abs(work_) + allowed_;
  return e.kinetic + e.weight + stored_below_zero(model, s) <= level() + work_ + slack;
}

bool EnergyBook::has_gained(const Model& model, const Dynamics& d, const Energy* ignored, const State& s, double share,
                            double lift) {
  if (looks_ == 0) return false;
  const MotionEnergy motion = motion_energy(model, s);
  at_end_ = motion.kinetic + stored_energy(d, ignored, s);
  const bool known = !std::isnan(at_start_);
  const double was = known ? at_start_ : last_level();
  const double given = known ? work_ - work_before_ : work_;
  const double scale = motion.kinetic + std::abs(was - motion.weight);
  const double most = std::min(was + std::abs(given), level() + std::abs(work_));
  return at_end_ > most + allowed_ + share * scale + lift * mass_;
}

double EnergyBook::level() const {
  return *std::max_element(level_.begin(), level_.begin() + std::min(looks_, kLooks));
}

double EnergyBook::power(const Dynamics& d, const State& s) {
  double sum = 0.0;
  for (const Energy* e : d.energies) {
    if (e->mass_force() != nullptr || e->value(s) != 0.0) continue;
    force_.setZero(3, s.x.cols());
    e->add_force(s, &force_);
    sum += std::max(0.0, force_.cwiseProduct(s.v).sum());
  }
  return sum;
}

void EnergyBook::end_step(const Model& model, const Dynamics& d, const Energy* ignored, const State& s, double dt,
                          int evaluations) {
  evaluations_ = std::isnan(at_end_) ? evaluations_ + evaluations : 0;
  allowed_ += 2.0 * drive_ * dt;
  if (looks_ > 0 && ++age_ < kLookSteps) return;
  const MotionEnergy motion = motion_energy(model, s);
  const double stored = stored_energy(d, ignored, s);
  const double total = motion.kinetic + stored;
  const double drive = power(d, s);
  if (looks_ > 0) {
    const double left = std::exp(-age_ * dt / kForget);
    const double more = total - level() - work_;
    lately_ *= left;
    scale_ *= left;
    if (drive_ == 0.0 && drive == 0.0 && more > 0.0) {
      created_ += more;
      lately_ += more;
    }
    scale_ = std::max({scale_, motion.kinetic + std::abs(stored - motion.weight), std::abs(work_)});
  } else {
    mass_ = model.mass.head(model.point_count()).sum();
  }
  for (double& level : level_) level += work_;
  level_[static_cast<size_t>(looks_++ % kLooks)] = total;
  if (!std::isfinite(total)) looks_ = 0;
  drive_ = drive;
  work_ = work_before_ = allowed_ = 0.0;
  age_ = 0;
}

void EnergyBook::forget() {
  *this = EnergyBook();
}

void EnergyBook::pass(Archive* archive) {
  if (!archive->looks_on()) begin();
  archive->pass(&created_);
  archive->pass(&lately_);
  archive->pass(&scale_);
}

}  // namespace deformable_sim
