// Test problems that are ordinary differential equations: a force on each node by itself, and the matrix of one step.
#pragma once

#include <functional>
#include <utility>

#include "support/system.h"

namespace deformable_sim::test {

/// f(x, v, t) on every node, with the derivatives df/dx and df/dv that an implicit scheme shall use.
class PointForce : public Energy {
 public:
  using Force = std::function<Vec3(const Vec3& x, const Vec3& v, double t)>;
  using Slopes = std::function<std::pair<Mat3, Mat3>(const Vec3& x, const Vec3& v, double t)>;
  PointForce(Force force, Slopes slopes) : force_(std::move(force)), slopes_(std::move(slopes)) {}

  std::string name() const override { return "point force"; }
  int element_count() const override { return 1; }
  double value(const State&) const override { return 0.0; }
  void add_force(const State& s, Nodes* f) const override {
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) f->col(i) += force_(s.x.col(i), s.v.col(i), s.time);
  }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State& s, double dx, double dv, Jacobian, BlockMatrix* a) const override {
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) {
      const auto [by_x, by_v] = slopes_(s.x.col(i), s.v.col(i), s.time);
      a->block(a->diagonal_slot(static_cast<int>(i))) -= dx * by_x + dv * by_v;
    }
  }

 private:
  Force force_;
  Slopes slopes_;
};

/// f = -stiffness x - damping v.
inline std::unique_ptr<Energy> linear_force(double stiffness, double damping) {
  return std::make_unique<PointForce>(
      [=](const Vec3& x, const Vec3& v, double) { return Vec3(-stiffness * x - damping * v); },
      [=](const Vec3&, const Vec3&, double) {
        return std::pair<Mat3, Mat3>(-stiffness * Mat3::Identity(), -damping * Mat3::Identity());
      });
}

/// One step of x'' = -x - 2 zeta x' as a matrix that acts on (x, v, x_before, v_before); the last two rows and columns
/// are zero unless the scheme remembers.
inline Eigen::Matrix4d step_matrix(const std::string& scheme, double zeta, double dt) {
  System body(Nodes::Zero(3, 1), Eigen::VectorXd::Ones(1));
  body.add(linear_force(1.0, 2.0 * zeta));
  const auto integrator = make_integrator(scheme, exact_settings(1e-14));
  body.step(*integrator, dt);
  const bool remembers = body.state.x_before.cols() > 0;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  for (Eigen::Index k = 0; k < (remembers ? 4 : 2); ++k) {
    Eigen::Vector4d unit = Eigen::Vector4d::Unit(k);
    body.state.x(0, 0) = unit[0];
    body.state.v(0, 0) = unit[1];
    if (remembers) {
      body.state.x_before(0, 0) = unit[2];
      body.state.v_before(0, 0) = unit[3];
      body.state.dt_before = dt;
    }
    body.step(*integrator, dt);
    unit << body.state.x(0, 0), body.state.v(0, 0), remembers ? body.state.x_before(0, 0) : 0.0,
        remembers ? body.state.v_before(0, 0) : 0.0;
    matrix.col(k) = unit;
  }
  return matrix;
}

}  // namespace deformable_sim::test
