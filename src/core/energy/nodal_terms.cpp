// Terms that act on each node alone: gravity and mass damping.
#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {
namespace {

/// E = -sum m g.x, f = m g.
class Gravity : public Energy {
 public:
  Gravity(const Eigen::VectorXd& mass, const Vec3& gravity)
      : mass_(mass), gravity_(gravity), mass_force_{gravity, 0.0} {}
  std::string name() const override { return "gravity"; }
  int element_count() const override { return static_cast<int>(mass_.size()); }
  double value(const State& s) const override { return -gravity_.dot(s.x * mass_); }
  void add_force(const State&, Nodes* f) const override { f->noalias() += gravity_ * mass_.transpose(); }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}
  const MassForce* mass_force() const override { return &mass_force_; }

 private:
  Eigen::VectorXd mass_;
  Vec3 gravity_;
  MassForce mass_force_;
};

/// f = -rate m v, the same for all nodes of a mass: damps rigid motion too.
class MassDamping : public Energy {
 public:
  MassDamping(const Eigen::VectorXd& mass, double rate) : coefficient_(rate * mass), mass_force_{Vec3::Zero(), rate} {}
  std::string name() const override { return "mass damping"; }
  int element_count() const override { return static_cast<int>(coefficient_.size()); }
  double value(const State&) const override { return 0.0; }
  void add_force(const State& s, Nodes* f) const override {
    for (Eigen::Index i = 0; i < coefficient_.size(); ++i) f->col(i) -= coefficient_[i] * s.v.col(i);
  }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double dv, Jacobian, BlockMatrix* a) const override {
    for (int i = 0; i < element_count(); ++i) {
      a->block(a->diagonal_slot(i)).diagonal().array() += dv * coefficient_[i];
    }
  }
  const MassForce* mass_force() const override { return &mass_force_; }

 private:
  Eigen::VectorXd coefficient_;  // N s/m
  MassForce mass_force_;
};

}  // namespace

std::unique_ptr<Energy> make_gravity(const Eigen::VectorXd& mass, const Vec3& gravity) {
  return std::make_unique<Gravity>(mass, gravity);
}

std::unique_ptr<Energy> make_mass_damping(const Eigen::VectorXd& mass, double rate) {
  return std::make_unique<MassDamping>(mass, rate);
}

}  // namespace deformable_sim
