// How many parts an explicit step needs to stay stable.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "deformable_sim/core/integrator/lanczos.h"
#include "deformable_sim/core/integrator/mass_factor.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

constexpr double kSafety = 0.9;
constexpr int kRemeasureSteps = 50;
constexpr double kLeastDamping = 0.005;
constexpr double kProbe = 1e-4;  // m/s, largest component: small against the speeds of drag, large against rounding

/// Of M^(-1/2) C M^(-1/2) by Lanczos' method: C, like what dampers are, counts as symmetric.
double rough_damping_rate(const Dynamics& d, const State& s) {
  const Eigen::Index n = s.x.cols();
  Eigen::VectorXd root = d.mass->cwiseSqrt().cwiseInverse();
  for (int node : d.kinematics.node) root[node] = 0.0;
  State probe = s;
  const auto force = [&](const Nodes& v) {
    probe.v = s.v + v;
    Nodes f = Nodes::Zero(3, n);
    for (const Energy* e : d.energies) e->add_force(probe, &f);
    return f;
  };
  const Nodes rest = force(Nodes::Zero(3, n));
  const auto times = [&](const Nodes& q) -> Nodes {
    const Nodes v = q * root.asDiagonal();
    const double largest = v.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) return Nodes::Zero(3, n);
    const double h = kProbe / largest;
    return (rest - force(h * v)) * root.asDiagonal() / h;
  };
  Nodes start = lanczos_start(n);
  for (int node : d.kinematics.node) start.col(node).setZero();
  return std::max(0.0, largest_eigenvalue(times, std::move(start), kRoughLanczos));
}

}  // namespace

double highest_damping_rate(const Dynamics& d, const State& s, Effort effort) {
  if (effort == Effort::kRough && d.mass_matrix == nullptr) return rough_damping_rate(d, s);
  const Eigen::Index n = s.x.cols();
  std::vector<char> held(static_cast<size_t>(n), 0);
  for (int node : d.kinematics.node) held[static_cast<size_t>(node)] = 1;
  const auto force = [&d](const State& at) {
    Nodes f = Nodes::Zero(3, at.x.cols());
    for (const Energy* e : d.energies) e->add_force(at, &f);
    return f;
  };
  std::unique_ptr<MassFactor> mass_factor;
  if (d.mass_matrix != nullptr) {
    mass_factor = std::make_unique<MassFactor>();
    mass_factor->prepare(*d.mass_matrix, d.kinematics.node);
  }
  const Nodes f0 = force(s);
  Nodes w(3, n);
  // Any start that is not smooth: the fastest damped modes alternate from node to node.
  for (Eigen::Index i = 0; i < w.size(); ++i) w.data()[i] = std::sin(12.9898 * static_cast<double>(i + 1));
  State probe = s;
  double rate = 0.0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    for (Eigen::Index i = 0; i < n; ++i)
      if (held[static_cast<size_t>(i)]) w.col(i).setZero();
    const double largest = w.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) return 0.0;
    w *= kProbe / largest;
    probe.v = s.v + w;
    Nodes image = f0 - force(probe);
    if (mass_factor) {
      mass_factor->solve(&image);
    } else {
      for (Eigen::Index i = 0; i < n; ++i) image.col(i) /= (*d.mass)[i];
    }
    const double next = image.norm() / w.norm();
    w = image;
    const bool settled = std::abs(next - rate) < 1e-3 * next;
    rate = next;
    if (settled) break;
  }
  return rate;
}

int World::Parts::wanted_parts() {
  const int least = controller ? controller->parts() : settings.parts;
  const double limit = integrator->stability_limit();
  if (!std::isfinite(limit)) {
    stable_dt = std::numeric_limits<double>::infinity();
    return meetings ? std::max(least, meetings->parts_for(settings.dt)) : least;
  }
  if (stable_dt_age < 0 || stable_dt_age >= kRemeasureSteps) {
    const double omega = highest_frequency(dynamics, state), rate = highest_damping_rate(dynamics, state);
    stable_dt = stable_step(*integrator, omega, rate);
    // Explicit Euler has no stable step of its own without damping, and none worth taking with little.
    if (limit == 0.0 && omega > 0.0 && stable_dt < kLeastDamping * 2.0 / omega) stable_dt = 2.0 / omega;
    stable_dt_age = 0;
  }
  ++stable_dt_age;
  if (!(stable_dt > 0.0)) return least;  // of forces that are no numbers
  const double parts = std::ceil(settings.dt / (kSafety * stable_dt) - 1e-9);
  return static_cast<int>(std::clamp(parts, static_cast<double>(least), static_cast<double>(kMaxParts)));
}

}  // namespace deformable_sim
