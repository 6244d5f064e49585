#include "stability_limits.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim::stability {
namespace {

constexpr double kDisturbance = 1e-9;  // m
constexpr double kGrown = 1e8;         // times the first energy: no need to go on
constexpr int kSteps = 6000, kEulerSteps = 24000, kBisections = 11;
constexpr double kBelow = 0.8, kAbove = 1.25;  // of the theory, between which is looked

/// Springs or a membrane without weight, and the first nodes held.
Subject weightless(const std::string& name, double damping) {
  auto model = std::make_shared<Model>();
  Subject subject;
  subject.name = name;
  if (name == "rope") {
    const Polyline line = make_line(1.0, 10);
    LineStiffness stiffness;
    stiffness.axial = 1000.0;
    stiffness.bend = 0.0;
    stiffness.damping_time = damping;
    model->mass = line_masses(line, 0.1);
    model->initial.x = line.rest;
    subject.held = {0};
    model->energies.push_back(make_springs("stretch springs", line_network(line, stiffness).stretch, 0));
  } else if (name == "sheet") {
    const TriangleMesh mesh = make_grid(0.6, 0.5, 6, 5);
    SheetStiffness stiffness;
    stiffness.membrane = 100.0;
    stiffness.damping_time = damping;
    model->mass = sheet_masses(mesh, 0.2);
    model->initial.x = mesh.rest;
    subject.held = {0};
    const SpringNetwork network = sheet_network(mesh, stiffness);
    model->energies.push_back(make_springs("stretch springs", network.stretch, 0));
    model->energies.push_back(make_springs("shear springs", network.shear, 0));
  } else {
    throw InputError("no body '" + name + "'; there is rope, sheet");
  }
  model->initial.v = Nodes::Zero(3, model->initial.x.cols());
  subject.model = std::move(model);
  return subject;
}

/// -df/dx or -df/dv of the free coordinates over the masses, M^(-1/2) (.) M^(-1/2), by differences.
Eigen::MatrixXd matrix_of(const Subject& subject, Nodes State::*by) {
  Plain plain(subject, false);
  const Dynamics& d = plain.dynamics();
  const Eigen::Index n = plain.state.x.cols();
  Eigen::VectorXd root(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) root.segment<3>(3 * i).setConstant(1.0 / std::sqrt((*d.mass)[i]));
  for (const int node : subject.held) root.segment<3>(3 * node).setZero();
  const auto force = [&d](const State& s) {
    Nodes f = Nodes::Zero(3, s.x.cols());
    for (const Energy* energy : d.energies) energy->add_force(s, &f);
    return f;
  };
  Eigen::MatrixXd a(3 * n, 3 * n);
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < 3 * n; ++k) {
    State more = plain.state, less = plain.state;
    (more.*by)(k % 3, k / 3) += kStep;
    (less.*by)(k % 3, k / 3) -= kStep;
    const Nodes change = (force(less) - force(more)) / (2.0 * kStep);
    a.col(k) = root.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(change.data(), 3 * n)) * root[k];
  }
  return 0.5 * (a + a.transpose());
}

/// The least limit of all modes; the damping ratio of one is half the rate at which its own shape is damped, over its
/// frequency.
void foretell(const Subject& subject, const Integrator& scheme, Limit* limit) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(matrix_of(subject, &State::x));
  const Eigen::MatrixXd damping = matrix_of(subject, &State::v);
  const double largest = modes.eigenvalues().tail<1>()[0];
  limit->theory = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < modes.eigenvalues().size(); ++k) {
    const double squared = modes.eigenvalues()[k];
    if (squared < 1e-8 * largest) continue;
    const double omega = std::sqrt(squared);
    const Eigen::VectorXd shape = modes.eigenvectors().col(k);
    const double zeta = 0.5 * shape.dot(damping * shape) / omega;
    limit->theory = std::min(limit->theory, scheme.stability_limit(std::max(0.0, zeta)) / omega);
  }
}

}  // namespace

std::vector<std::string> limited_schemes() {
  std::vector<std::string> names;
  for (const std::string& name : integrator_names()) {
    if (!std::isinf(make_integrator(name, {})->stability_limit())) names.push_back(name);
  }
  return names;
}

bool grows(const Subject& subject, const std::string& integrator, double dt, int steps) {
  Plain plain(subject, false);
  const Nodes rest = plain.state.x;
  std::mt19937 generator(5);
  std::normal_distribution<double> normal(0.0, kDisturbance);
  plain.state.x += Nodes::NullaryExpr(3, rest.cols(), [&] { return normal(generator); });
  for (const int node : subject.held) plain.state.x.col(node) = rest.col(node);
  // As if all motions were the fastest: an upper bound of the energy that grows when anything does.
  const double omega = fastest_of(subject).omega;
  const auto energy = [&] {
    const Eigen::VectorXd squares = plain.state.v.colwise().squaredNorm().transpose() +
                                    omega * omega * (plain.state.x - rest).colwise().squaredNorm().transpose();
    return 0.5 * subject.model->mass.dot(squares);
  };
  const double start = energy();
  const std::unique_ptr<Integrator> scheme = make_integrator(integrator, {});
  double halves[2] = {0.0, 0.0};
  for (int k = 0; k < steps; ++k) {
    plain.step(scheme.get(), dt);
    const double now = energy();
    if (!(now < kGrown * start)) return true;
    halves[2 * k / steps] += now;
  }
  return halves[1] > 2.0 * halves[0];
}

Limit measure_limit(const std::string& body, const std::string& integrator, double ratio) {
  const double omega = fastest_of(weightless(body, 0.0)).omega;
  const Subject subject = weightless(body, 2.0 * ratio / omega);
  const std::unique_ptr<Integrator> scheme = make_integrator(integrator, {});
  Limit limit{body, integrator, ratio};
  foretell(subject, *scheme, &limit);
  const Fastest fastest = fastest_of(subject);
  limit.fast = stable_step(*scheme, fastest.omega, fastest.rate);
  if (!(limit.theory > 0.0)) return limit;  // unstable at any step
  const int steps = integrator == "explicit_euler" ? kEulerSteps : kSteps;
  double below = kBelow * limit.theory, above = kAbove * limit.theory;
  for (int k = 0; k < kBisections; ++k) {
    const double middle = 0.5 * (below + above);
    (grows(subject, integrator, middle, steps) ? above : below) = middle;
  }
  limit.measured = 0.5 * (below + above);
  return limit;
}

}  // namespace deformable_sim::stability
