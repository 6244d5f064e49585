// Highest natural frequency, for the step limit of explicit schemes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/lanczos.h"
#include "deformable_sim/core/integrator/mass_factor.h"

namespace deformable_sim {
namespace {

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

}  // namespace

Nodes lanczos_start(Eigen::Index n) {
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

double highest_frequency(const Dynamics& d, const State& s, Effort effort) {
  MassScaledStiffness stiffness(d, s, effort);
  Nodes q = lanczos_start(s.x.cols());
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    if (stiffness.root()[i] == 0.0) q.col(i).setZero();
  }
  const double largest = largest_eigenvalue([&stiffness](const Nodes& at) { return stiffness.times(at); }, std::move(q),
                                            effort == Effort::kRough ? kRoughLanczos : kFineLanczos);
  return std::sqrt(std::max(0.0, largest));
}

}  // namespace deformable_sim
