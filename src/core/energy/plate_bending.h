// Bending of a sheet by the angles between neighbouring triangles.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/element/hinge.h"
#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/material/bending_law.h"
#include "deformable_sim/core/material/plate_patches.h"

namespace deformable_sim {

/// Weights of the quadratic energy of a plate laid flat: `flat`, by hinge, is d angle / dw of its four points, 1/m.
/// Nodes less `first_node`.
std::vector<QuadraticWeight> quadratic_weights(const PlateMesh& plate, const std::vector<Eigen::Vector4d>& flat,
                                               const Mat3& stiffness, int first_node);

/// Energy over triangles, r the angles beyond rest of the hinges around, M the patch's curvature, D the plate
/// stiffness:
///
///   E = sum A/2 (M r)^T D (M r),   hinge moments m = sum A M^T D M (r + damping dr/dt),   f = -sum m dr/dx
///
/// Each hinge is looked at once. Projected Jacobian: without the second derivatives of the angles (Gauss-Newton).
class PlateBending : public Energy {
 public:
  enum class Part { kElasticAndViscous, kViscous };

  /// `rest`: one angle (rad) a hinge; damping in s.
  /// `flat`: d angle / dw of each hinge laid flat, by its points, 1/m.
  PlateBending(PlateMesh plate, const Mat3& stiffness, std::vector<double> rest,
               const std::vector<Eigen::Vector4d>& flat, double damping, Part part, int first_node);

  std::string name() const override { return "bending: hinges"; }
  int element_count() const override { return static_cast<int>(plate_.hinges.size()); }
  double value(const State& s) const override;
  void add_force(const State& s, Nodes* f) const override;
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override;
  void bind(const BlockMatrix& matrix) override;
  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override;
  /// Quadratic bending: along a sheet's normal the same as flat, across it what stretch makes stiffer by far.
  const ConstantLinks* constant_links() const override;

 private:
  static constexpr size_t kMostPoints = 12;

  /// What one evaluation finds at a hinge.
  struct Look {
    double strain = 0.0, moment = 0.0;  // rad beyond rest, with the viscous part in forces; N m
    Hinge::Points gradient;             // 1/m
    Hinge::Points gradient_rate;        // 1/(m s)
  };

  /// The points of a patch, and where those of its hinges are among them.
  struct Points {
    size_t count = 0;
    std::array<int, kMostPoints> node{};
    std::array<std::array<int, 4>, PlatePatch::kMost> corner{};
  };

  Points points_of(const PlatePatch& patch) const;
  Hinge::Points gather(const Nodes& nodes, size_t hinge) const;
  void look(const State& s) const;
  void look_at_turning(const State& s) const;
  Vec3 curvature_of(const PlatePatch& patch) const;
  void add_moments() const;
  void add_patch(size_t n, double elastic, double viscous, const int* slot, BlockMatrix* a) const;
  void add_second_derivatives(const State& s, double dx, BlockMatrix* a) const;

  PlateMesh plate_;  // world nodes
  Mat3 stiffness_;
  std::vector<double> rest_;  // rad
  double damping_;            // s
  double elastic_;            // 1, or 0 for the viscous part alone
  std::vector<Points> points_;
  std::vector<int> patch_slots_, hinge_slots_;
  int first_node_;
  std::vector<Eigen::Vector4f> flat_;             // by hinge
  mutable std::unique_ptr<ConstantLinks> links_;  // once asked for
  mutable std::vector<Look> hinges_;  // of the evaluation in progress: a term is used by one thread at a time
};

}  // namespace deformable_sim
