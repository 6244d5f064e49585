// Constructors of the bending terms of a sheet.
#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/error.h"
#include "plate_bending.h"

namespace deformable_sim {
namespace {

/// Two terms as one.
class Sum : public Energy {
 public:
  Sum(std::unique_ptr<Energy> first, std::unique_ptr<Energy> second)
      : first_(std::move(first)), second_(std::move(second)) {}

  std::string name() const override { return first_->name(); }
  int element_count() const override { return first_->element_count() + second_->element_count(); }
  double value(const State& s) const override { return first_->value(s) + second_->value(s); }
  void add_force(const State& s, Nodes* f) const override {
    first_->add_force(s, f);
    second_->add_force(s, f);
  }
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override {
    first_->add_pattern(pairs);
    second_->add_pattern(pairs);
  }
  void bind(const BlockMatrix& matrix) override {
    first_->bind(matrix);
    second_->bind(matrix);
  }
  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override {
    first_->add_jacobian(s, dx, dv, kind, a);
    second_->add_jacobian(s, dx, dv, kind, a);
  }

 private:
  std::unique_ptr<Energy> first_, second_;
};

Hinge::Points rest_points(const TriangleMesh& mesh, const std::array<int, 4>& hinge) {
  Hinge::Points x;
  for (size_t k = 0; k < 4; ++k) x.col(static_cast<Eigen::Index>(k)) = mesh.rest.col(hinge[k]);
  return x;
}

std::vector<double> rest_angles(const TriangleMesh& mesh, const BendingMaterial& material, const PlateMesh& plate) {
  std::vector<double> rest(plate.hinges.size(), 0.0);
  std::map<std::array<int, 2>, size_t> hinge_of;
  for (size_t h = 0; h < rest.size(); ++h) {
    const auto& hinge = plate.hinges[h];
    hinge_of[{std::min(hinge[0], hinge[1]), std::max(hinge[0], hinge[1])}] = h;
    if (material.rest == BendingMaterial::Rest::kAsMeshed) rest[h] = Hinge(rest_points(mesh, hinge)).angle();
  }
  for (const Crease& crease : material.creases) {
    const auto found = hinge_of.find({std::min(crease.node_a, crease.node_b), std::max(crease.node_a, crease.node_b)});
    if (found == hinge_of.end()) {
      throw InputError("a crease joins nodes " + std::to_string(crease.node_a) + " and " +
                       std::to_string(crease.node_b) + "; it must be an edge between two faces");
    }
    rest[found->second] = crease.angle;
  }
  return rest;
}

/// d angle / dw of a hinge laid flat, by its points.
Eigen::Vector4d flat_weights(const TriangleMesh& mesh, const std::array<int, 4>& hinge) {
  const Hinge::Points x = rest_points(mesh, hinge);
  const Vec3 e = x.col(1) - x.col(0), p = x.col(2) - x.col(0), q = x.col(3) - x.col(0);
  const double along1 = p.dot(e) / e.squaredNorm(), along2 = q.dot(e) / e.squaredNorm();
  const double inverse1 = 1.0 / (p - along1 * e).norm(), inverse2 = 1.0 / (q - along2 * e).norm();
  return {(along1 - 1.0) * inverse1 + (along2 - 1.0) * inverse2, -along1 * inverse1 - along2 * inverse2, inverse1,
          inverse2};
}

std::vector<Eigen::Vector4d> flat_weights(const TriangleMesh& mesh, const PlateMesh& plate) {
  std::vector<Eigen::Vector4d> flat;
  for (const auto& hinge : plate.hinges) flat.push_back(flat_weights(mesh, hinge));
  return flat;
}

void check_flat(const BendingMaterial& material) {
  check_material(material);
  if (material.rest != BendingMaterial::Rest::kFlat || !material.creases.empty()) {
    throw InputError("quadratic bending is flat at rest; rest angles as meshed and creases need the hinge angles");
  }
}

}  // namespace

std::unique_ptr<Energy> make_bending(const TriangleMesh& mesh, const BendingMaterial& material, int first_node) {
  check_material(material);
  const Mat3 stiffness = plate_stiffness(material);
  PlateMesh plate = plate_mesh(mesh, stiffness, direction_that_matters(stiffness, material.warp_direction));
  std::vector<double> rest = rest_angles(mesh, material, plate);
  const std::vector<Eigen::Vector4d> flat = flat_weights(mesh, plate);
  return std::make_unique<PlateBending>(std::move(plate), stiffness, std::move(rest), flat, material.damping,
                                        PlateBending::Part::kElasticAndViscous, first_node);
}

std::vector<QuadraticWeight> quadratic_bending_weights(const TriangleMesh& mesh, const BendingMaterial& material) {
  check_flat(material);
  const Mat3 stiffness = plate_stiffness(material);
  const PlateMesh plate = plate_mesh(mesh, stiffness, direction_that_matters(stiffness, material.warp_direction));
  return quadratic_weights(plate, flat_weights(mesh, plate), stiffness, 0);
}

std::unique_ptr<Energy> make_quadratic_bending(const TriangleMesh& mesh, const BendingMaterial& material,
                                               int first_node) {
  check_flat(material);
  const Mat3 stiffness = plate_stiffness(material);
  PlateMesh plate = plate_mesh(mesh, stiffness, direction_that_matters(stiffness, material.warp_direction));
  std::unique_ptr<Energy> links = make_quadratic_links(
      "bending: quadratic", quadratic_weights(plate, flat_weights(mesh, plate), stiffness, 0), 0.0, first_node);
  if (material.damping == 0.0) return links;
  const size_t hinges = plate.hinges.size();
  auto dampers = std::make_unique<PlateBending>(std::move(plate), stiffness, std::vector<double>(hinges, 0.0),
                                                std::vector<Eigen::Vector4d>(), material.damping,
                                                PlateBending::Part::kViscous, first_node);
  return std::make_unique<Sum>(std::move(links), std::move(dampers));
}

}  // namespace deformable_sim
