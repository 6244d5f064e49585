#include "deformable_sim/core/strain_projection.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/contact/contact_points.h"

namespace deformable_sim {
namespace {

constexpr double kTolerance = 5e-7;       // relative violation that is left
constexpr double kPlaneTolerance = 1e-7;  // m, by which a plane may be missed
constexpr double kBalance = 1e-3;         // residual over mass that is left, of the largest displacement
constexpr double kGap = 1e-4;             // mean t s that is left, in effective masses times the squared excess
constexpr double kFirstGap = 30.0;  // ... and at the start: generous, so that far limits are felt from the beginning
constexpr double kBoundary = 0.99;  // of the way to s = 0 or t = 0 that a step may go
constexpr double kFelt = 1e-2;      // t / s in effective masses: weaker ones are left out of the matrix
// W, in effective masses: stiff enough not to show (t / W is some 1e-9 m), weak enough for double precision.
constexpr double kStiffest = 1e9;
constexpr int kIterations = 40;

}  // namespace

StrainProjection::StrainProjection(const Model& model) : local_(static_cast<size_t>(model.node_count()), -1) {
  for (const StrainLimit& limit : model.strain_limits)
    for (int node : limit.node) local_[static_cast<size_t>(node)] = 0;
  for (size_t i = 0; i < local_.size(); ++i) {
    if (local_[i] < 0) continue;
    local_[i] = static_cast<int>(world_.size());
    world_.push_back(static_cast<int>(i));
  }
  std::vector<std::array<int, 2>> couplings;
  const auto couple = [&](int i, int j) {
    const int a = local_[static_cast<size_t>(i)], b = local_[static_cast<size_t>(j)];
    if (a >= 0 && b >= 0) couplings.push_back({a, b});
  };
  for (const StrainLimit& limit : model.strain_limits) couple(limit.node[0], limit.node[1]);
  std::vector<ContactPoint> points;
  for (size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].contact_at_faces) add_between_points(model, static_cast<int>(b), &points);
  for (const ContactPoint& p : points)
    for (size_t i = 1; i < static_cast<size_t>(p.count); ++i)
      for (size_t j = 0; j < i; ++j) couple(p.node[i], p.node[j]);

  const auto n = static_cast<Eigen::Index>(world_.size());
  matrix_ = BlockMatrix(static_cast<int>(n), couplings);
  factor_.analyse(matrix_);
  mass_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) mass_[i] = model.mass[world_[static_cast<size_t>(i)]];
  inverse_mass_.resize(n);
  for (const StrainLimit& limit : model.strain_limits) {
    Pair p;
    p.a = local_[static_cast<size_t>(limit.node[0])];
    p.b = local_[static_cast<size_t>(limit.node[1])];
    p.longest = limit.longest;
    p.slot = {matrix_.slot(p.a, p.a), matrix_.slot(p.a, p.b), matrix_.slot(p.b, p.a), matrix_.slot(p.b, p.b)};
    pairs_.push_back(p);
  }
  for (Nodes* nodes : {&start_, &x_, &step_, &residual_}) nodes->setZero(3, n);
}

double StrainProjection::Constraint::mismatch() const {
  return value + slack - impulse / (kStiffest * mass);
}

double StrainProjection::Constraint::firmness() const {
  return slack + impulse / (kStiffest * mass);
}

/// dc/dx . dx
double StrainProjection::rate(const Pair& p, const Nodes& dx) {
  return p.n.dot(dx.col(p.b) - dx.col(p.a));
}

double StrainProjection::rate(const Plane& p, const Nodes& dx) {
  double sum = 0.0;
  for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) sum -= p.weight[k] * p.n.dot(dx.col(p.node[k]));
  return sum;
}

/// r -= impulse dc/dx
void StrainProjection::pull(const Pair& p, double impulse, Nodes* r) {
  r->col(p.a) += impulse * p.n;
  r->col(p.b) -= impulse * p.n;
}

void StrainProjection::pull(const Plane& p, double impulse, Nodes* r) {
  for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) r->col(p.node[k]) += impulse * p.weight[k] * p.n;
}

template <class F>
void StrainProjection::every(F f) {
  for (Pair& p : pairs_)
    if (p.mass > 0.0) f(p);
  for (Plane& p : planes_) f(p);
}

void StrainProjection::zero_held(Nodes* r) const {
  for (int i = 0; i < static_cast<int>(r->cols()); ++i)
    if (!is_free(i)) r->col(i).setZero();
}

void StrainProjection::begin(const Eigen::VectorXd& inverse_mass, const ContactConstraints& contacts, const Nodes& x) {
  for (size_t i = 0; i < world_.size(); ++i) {
    start_.col(static_cast<Eigen::Index>(i)) = x.col(world_[i]);
    inverse_mass_[static_cast<Eigen::Index>(i)] = inverse_mass[world_[i]];
  }
  x_ = start_;
  for (Pair& p : pairs_) {
    const double compliance = inverse_mass_[p.a] + inverse_mass_[p.b];
    p.mass = compliance > 0.0 ? 1.0 / compliance : 0.0;
    p.impulse = 0.0;
  }
  add_planes(contacts);
  evaluate();
  excess_ = 0.0;
  for (const Pair& p : pairs_)
    if (p.mass > 0.0) excess_ = std::max(excess_, p.value);
}

void StrainProjection::add_planes(const ContactConstraints& contacts) {
  planes_.clear();
  for (size_t c = 0; c < contacts.size(); ++c) {
    const ContactConstraint& contact = contacts[c];
    // Between bodies: any nodes meet, and the matrix has blocks for those of one mesh. What puts bodies apart comes
    // after the limits.
    if (contact.collider < 0 && contact.count > 1) continue;
    Plane plane;
    plane.index = static_cast<int>(c);
    plane.count = contact.count;
    plane.weight = contact.weight;
    plane.n = contact.normal;
    double compliance = 0.0;
    bool known = true;
    for (size_t k = 0; k < static_cast<size_t>(contact.count); ++k) {
      plane.node[k] = local_[static_cast<size_t>(contact.node[k])];
      known = known && plane.node[k] >= 0;
      if (known) compliance += contact.weight[k] * contact.weight[k] * inverse_mass_[plane.node[k]];
    }
    if (!known || compliance == 0.0) continue;
    plane.mass = 1.0 / compliance;
    plane.offset = contact.offset;
    plane.offset += std::min(0.0, -rate(plane, x_) - contact.offset);
    planes_.push_back(plane);
  }
}

void StrainProjection::evaluate() {
  for (Pair& p : pairs_) {
    const Vec3 d = x_.col(p.b) - x_.col(p.a);
    p.length = d.norm();
    p.n = p.length > 0.0 ? Vec3(d / p.length) : Vec3::Zero();
    p.value = p.length - p.longest;
  }
  for (Plane& p : planes_) p.value = p.offset + rate(p, x_);
}

void StrainProjection::start_inside() {
  every([this](Constraint& c) {
    c.slack = std::max(-c.value, excess_);
    c.impulse = kFirstGap * c.mass * excess_ * excess_ / c.slack;
  });
}

void StrainProjection::find_residual() {
  residual_ = (start_ - x_) * mass_.asDiagonal();
  every([this](const auto& c) { pull(c, c.impulse, &residual_); });
  zero_held(&residual_);
}

/// Mean of t s in units of effective mass.
double StrainProjection::mean_product() {
  double sum = 0.0;
  int count = 0;
  every([&](const Constraint& c) {
    sum += c.impulse * c.slack / c.mass;
    ++count;
  });
  return sum / count;
}

bool StrainProjection::is_solved(StrainLimitReport* report) {
  report->violation = 0.0;
  for (const Pair& p : pairs_)
    if (p.mass > 0.0) report->violation = std::max(report->violation, p.value / p.longest);
  double depth = 0.0, mismatch = 0.0, unbalanced = 0.0, moved = 0.0;
  for (const Plane& p : planes_) depth = std::max(depth, p.value);
  every([&](const Constraint& c) { mismatch = std::max(mismatch, std::abs(c.mismatch())); });
  for (Eigen::Index i = 0; i < mass_.size(); ++i) {
    unbalanced = std::max(unbalanced, residual_.col(i).norm() / mass_[i]);
    moved = std::max(moved, (x_.col(i) - start_.col(i)).norm());
  }
  const bool settled = unbalanced <= kBalance * moved && mean_product() <= kGap * excess_ * excess_;
  report->converged = settled && report->violation <= kTolerance && depth <= kPlaneTolerance;
  // The relaxed conditions hold, and the limits do not: they contradict each other.
  return report->converged || (settled && mismatch <= kPlaneTolerance * kTolerance);
}

void StrainProjection::assemble() {
  matrix_.set_zero();
  for (int i = 0; i < static_cast<int>(mass_.size()); ++i)
    matrix_.block(matrix_.diagonal_slot(i)).diagonal().setConstant(mass_[i]);
  for (const Pair& p : pairs_) {
    if (p.mass == 0.0) continue;
    const double along = p.impulse / p.firmness();
    if (along < kFelt * p.mass || p.length == 0.0) continue;
    const double across = p.impulse / p.length;
    Mat3 h = (along - across) * p.n * p.n.transpose();
    h.diagonal().array() += across;
    if (is_free(p.a)) matrix_.block(p.slot[0]) += h;
    if (is_free(p.b)) matrix_.block(p.slot[3]) += h;
    if (!is_free(p.a) || !is_free(p.b)) continue;
    matrix_.block(p.slot[1]) -= h;
    matrix_.block(p.slot[2]) -= h;
  }
  for (const Plane& p : planes_) {
    const double along = p.impulse / p.firmness();
    if (along < kFelt * p.mass) continue;
    const Mat3 h = along * p.n * p.n.transpose();
    for (size_t i = 0; i < static_cast<size_t>(p.count); ++i)
      for (size_t j = 0; j < static_cast<size_t>(p.count); ++j)
        if (is_free(p.node[i]) && is_free(p.node[j]))
          matrix_.block(matrix_.slot(p.node[i], p.node[j])) += p.weight[i] * p.weight[j] * h;
  }
}

/// Newton's direction for the conditions with t s -> t s - product.
void StrainProjection::find_direction() {
  step_ = residual_;
  every([this](const auto& c) { pull(c, (c.impulse * c.mismatch() - c.product) / c.firmness(), &step_); });
  zero_held(&step_);
  factor_.solve(&step_);
  every([this](auto& c) {
    c.impulse_step = (c.impulse * (c.mismatch() + rate(c, step_)) - c.product) / c.firmness();
    c.slack_step = c.impulse_step / (kStiffest * c.mass) - c.mismatch() - rate(c, step_);
  });
}

StrainProjection::StepLength StrainProjection::longest_step(double share) {
  StepLength most;
  every([&](const Constraint& c) {
    if (c.slack_step < 0.0) most.x = std::min(most.x, -share * c.slack / c.slack_step);
    if (c.impulse_step < 0.0) most.impulse = std::min(most.impulse, -share * c.impulse / c.impulse_step);
  });
  return most;
}

/// A predictor, which shows how far mu can go down, and a corrector with the same factor. False without a factor.
bool StrainProjection::newton_step() {
  assemble();
  if (!factor_.factorise(matrix_)) return false;
  every([](Constraint& c) { c.product = c.impulse * c.slack; });
  find_direction();
  const double mean = mean_product();
  const StepLength free = longest_step(1.0);
  double predicted = 0.0;
  int count = 0;
  every([&](const Constraint& c) {
    predicted += (c.impulse + free.impulse * c.impulse_step) * (c.slack + free.x * c.slack_step) / c.mass;
    ++count;
  });
  const double left = predicted / (count * mean), aim = mean * std::min(1.0, left * left * left);
  every([&](Constraint& c) { c.product = c.impulse * c.slack + c.slack_step * c.impulse_step - aim * c.mass; });
  find_direction();
  const StepLength step = longest_step(kBoundary);
  x_ += step.x * step_;
  every([&](Constraint& c) {
    c.slack += step.x * c.slack_step;
    c.impulse += step.impulse * c.impulse_step;
  });
  evaluate();
  return true;
}

StrainLimitReport StrainProjection::solve(const Eigen::VectorXd& inverse_mass, const ContactConstraints& contacts,
                                          Nodes* x, std::vector<double>* impulse,
                                          std::vector<double>* contact_impulse) {
  begin(inverse_mass, contacts, *x);
  StrainLimitReport report;
  bool solved = excess_ == 0.0;
  if (!solved) {
    start_inside();
    find_residual();
    while (!(solved = is_solved(&report)) && report.iterations < kIterations && newton_step()) {
      ++report.iterations;
      find_residual();
    }
  }
  // An iterate on the way is no better than the start.
  for (size_t i = 0; solved && i < world_.size(); ++i)
    if (is_free(static_cast<int>(i))) x->col(world_[i]) = x_.col(static_cast<Eigen::Index>(i));
  for (size_t k = 0; k < pairs_.size(); ++k) (*impulse)[k] = pairs_[k].impulse;
  contact_impulse->assign(contacts.size(), 0.0);
  for (const Plane& p : planes_) (*contact_impulse)[static_cast<size_t>(p.index)] = p.impulse;
  return report;
}

}  // namespace deformable_sim
