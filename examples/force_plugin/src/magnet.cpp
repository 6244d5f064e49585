// A force of one's own, outside the package: a point that attracts the nodes of a body.
#include <cmath>
#include <vector>

#include <deformable_sim/core/error.h>
#include <deformable_sim/core/force_plugin.h>
#include <pluginlib/class_list_macros.hpp>

namespace force_plugin {

using deformable_sim::BlockMatrix;
using deformable_sim::Jacobian;
using deformable_sim::Mat3;
using deformable_sim::Nodes;
using deformable_sim::State;
using deformable_sim::Vec3;

/// With r = x - centre and s = r^2 + reach^2, for each node
///
///   E = -strength / sqrt(s)      (J)
///   f = -strength r s^(-3/2)     (N)
///   df/dr = strength s^(-3/2) (3 r r^T / s - I)
///
/// Nodes count alike, whatever their mass. Not good at: a reach well below the distance that a node goes in a step.
class Magnet : public deformable_sim::Energy {
 public:
  Magnet(Vec3 centre, double strength, double reach, int first, int count)
      : centre_(std::move(centre)), strength_(strength), reach_(reach), first_(first), count_(count) {}

  std::string name() const override { return "magnet"; }
  int element_count() const override { return count_; }

  double value(const State& s) const override {
    double sum = 0.0;
    for (int node = first_; node < first_ + count_; ++node) sum -= strength_ / std::sqrt(square(s, node));
    return sum;
  }
  void add_force(const State& s, Nodes* f) const override {
    for (int node = first_; node < first_ + count_; ++node)
      f->col(node) -= strength_ * std::pow(square(s, node), -1.5) * (s.x.col(node) - centre_);
  }

  // A node's force depends on that node alone: no pairs, and the blocks on the diagonal, which are always there.
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix& matrix) override {
    slots_.resize(static_cast<size_t>(count_));
    for (int k = 0; k < count_; ++k) slots_[static_cast<size_t>(k)] = matrix.slot(first_ + k, first_ + k);
  }
  void add_jacobian(const State& s, double dx, double, Jacobian kind, BlockMatrix* a) const override {
    for (int k = 0; k < count_; ++k) {
      const double square_now = square(s, first_ + k), scale = strength_ * std::pow(square_now, -1.5);
      const Vec3 r = s.x.col(first_ + k) - centre_;
      Mat3 block = -scale * Mat3::Identity();
      // The rest has positive eigenvalues, which a projected Jacobian leaves out.
      if (kind == Jacobian::kExact) block += scale * 3.0 / square_now * r * r.transpose();
      a->block(slots_[static_cast<size_t>(k)]) -= dx * block;
    }
  }

 private:
  double square(const State& s, int node) const { return (s.x.col(node) - centre_).squaredNorm() + reach_ * reach_; }

  Vec3 centre_;
  double strength_, reach_;
  int first_, count_;
  std::vector<int> slots_;
};

/// Parameters: position [x, y, z] (m), strength (N m^2, more than 0), reach (m, 0.01).
class MagnetPlugin : public deformable_sim::ForcePlugin {
 public:
  std::unique_ptr<deformable_sim::Energy> make(const deformable_sim::ForceRequest& request,
                                               const deformable_sim::Model& model) override {
    request.check_keys({"position", "strength", "reach"});
    const double strength = request.number("strength", 0.0), reach = request.number("reach", 0.01);
    if (!(strength > 0.0)) throw deformable_sim::InputError("parameters.strength: must be more than 0");
    if (!(reach > 0.0)) throw deformable_sim::InputError("parameters.reach: must be more than 0");
    int first = 0, count = model.point_count();
    if (!request.body.empty()) {
      const deformable_sim::Body& body = model.bodies.at(static_cast<size_t>(model.find_body(request.body)));
      first = body.first_node;
      count = body.node_count;
    }
    return std::make_unique<Magnet>(request.vector("position"), strength, reach, first, count);
  }
};

}  // namespace force_plugin

PLUGINLIB_EXPORT_CLASS(force_plugin::MagnetPlugin, deformable_sim::ForcePlugin)
