// Highest natural frequency, for the step limit of explicit schemes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/mass_factor.h"

namespace deformable_sim {
namespace {

constexpr int kMostSteps = 200;

/// When Lanczos' method ends.
struct Patience {
  int check_every;
  double change;  // of the eigenvalue between two checks
};
constexpr Patience kFine{10, 1e-4}, kRough{5, 2e-2};

/// M^(-1/2) K M^(-1/2), or L^-1 K L^-T of a mass matrix L L^T, by central differences of the forces: no matrix of K has
/// to exist.
class MassScaledStiffness {
 public:
  MassScaledStiffness(const Dynamics& d, const State& s, Effort effort) : dynamics_(d), rest_(s), moved_(s) {
    root_ = d.mass->cwiseSqrt().cwiseInverse();
    for (int node : d.kinematics.node) root_[node] = 0.0;
    if (d.mass_matrix != nullptr) {
      mass_factor_ = std::make_unique<MassFactor>();
      mass_factor_->prepare(*d.mass_matrix, d.kinematics.node);
    }
    const double extent = (s.x.rowwise().maxCoeff() - s.x.rowwise().minCoeff()).norm();
    step_ = 1e-7 * (extent > 0.0 ? extent : 1.0);
    if (effort == Effort::kRough) rest_force_ = force(0.0, Nodes::Zero(3, s.x.cols()));
  }

  Nodes times(const Nodes& q) {
    Nodes direction = q;
    if (mass_factor_) {
      mass_factor_->solve_upper(&direction);
    } else {
      direction *= root_.asDiagonal();
    }
    const double scale = direction.cwiseAbs().maxCoeff();
    if (!(scale > 0.0)) return Nodes::Zero(3, q.cols());
    const double h = step_ / scale;
    Nodes image = rest_force_.cols() > 0 ? Nodes((rest_force_ - force(h, direction)) / h)
                                         : Nodes((force(-h, direction) - force(h, direction)) / (2.0 * h));
    if (mass_factor_) {
      mass_factor_->solve_lower(&image);
    } else {
      image *= root_.asDiagonal();
    }
    return image;
  }

  const Eigen::VectorXd& root() const { return root_; }

 private:
  Nodes force(double h, const Nodes& direction) {
    moved_.x = rest_.x + h * direction;
    Nodes f = Nodes::Zero(3, moved_.x.cols());
    for (const Energy* energy : dynamics_.energies) energy->add_force(moved_, &f);
    return f;
  }

  const Dynamics& dynamics_;
  const State& rest_;
  State moved_;
  Eigen::VectorXd root_;  // m^(-1/2), 0 for held nodes
  double step_;           // m
  Nodes rest_force_;      // of one-sided differences
  std::unique_ptr<MassFactor> mass_factor_;
};

/// Fixed pseudo-random numbers in [-1, 1]: no direction is left out, and every call gives the same bits.
Nodes start_vector(Eigen::Index n) {
  Nodes q(3, n);
  std::uint64_t state = 0x9E3779B97F4A7C15u;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    q.data()[i] = static_cast<double>(state >> 11) / 4503599627370496.0 - 1.0;
  }
  return q;
}

double largest_of_tridiagonal(const std::vector<double>& alpha, const std::vector<double>& beta) {
  const auto n = static_cast<Eigen::Index>(alpha.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(alpha.data(), n),
                                Eigen::Map<const Eigen::VectorXd>(beta.data(), n - 1), Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[n - 1];
}

}  // namespace

double highest_frequency(const Dynamics& d, const State& s, Effort effort) {
  const Patience patience = effort == Effort::kRough ? kRough : kFine;
  MassScaledStiffness stiffness(d, s, effort);
  Nodes q = start_vector(s.x.cols());
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    if (stiffness.root()[i] == 0.0) q.col(i).setZero();
  }
  if (!(q.norm() > 0.0)) return 0.0;
  q /= q.norm();

  Nodes last = Nodes::Zero(3, q.cols());
  std::vector<double> alpha, beta;
  double found = 0.0;
  for (int k = 1; k <= kMostSteps; ++k) {
    Nodes next = stiffness.times(q);
    alpha.push_back(next.cwiseProduct(q).sum());
    next -= alpha.back() * q;
    if (k > 1) next -= beta.back() * last;
    const double norm = next.norm();
    const bool exhausted = norm <= 1e-6 * std::abs(alpha.front()) || norm == 0.0;
    if (exhausted || k % patience.check_every == 0) {
      const double largest = largest_of_tridiagonal(alpha, beta);
      const bool settled = std::abs(largest - found) <= patience.change * std::abs(largest);
      found = largest;
      if (exhausted || settled) break;
    }
    beta.push_back(norm);
    last = q;
    q = next / norm;
  }
  return std::sqrt(std::max(0.0, found));
}

}  // namespace deformable_sim
