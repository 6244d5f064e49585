// Stretch of a sheet as a term of the equations of motion, and the strains and stresses of a state.
#include "deformable_sim/core/element/membrane.h"

#include <string>

#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/largest_stress.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/material/plate_patches.h"

namespace deformable_sim {
namespace {

/// `warp` is a unit vector in the plane of the face.
MembraneRest rest_of(const TriangleMesh& mesh, int face, const Vec3& warp) {
  const auto& t = mesh.triangles[static_cast<size_t>(face)];
  const Vec3 e1 = mesh.rest.col(t[1]) - mesh.rest.col(t[0]), e2 = mesh.rest.col(t[2]) - mesh.rest.col(t[0]);
  MembraneRest rest;
  rest.axes.col(0) = warp;
  rest.axes.col(1) = e1.cross(e2).normalized().cross(rest.axes.col(0));
  Eigen::Matrix2d edges;
  edges << rest.axes.transpose() * e1, rest.axes.transpose() * e2;
  rest.area = 0.5 * edges.determinant();
  rest.gradient.bottomRows<2>() = edges.inverse();
  rest.gradient.row(0) = -rest.gradient.row(1) - rest.gradient.row(2);
  return rest;
}

MembraneParameters parameters_of(const SheetMaterial& material) {
  return {solid_of(material), plane_stiffness(material), material.damping};
}

template <class Law>
std::unique_ptr<Energy> make(const std::string& name, const TriangleMesh& mesh, const SheetMaterial& material,
                             int first_node) {
  using Term = ElementEnergy<Membrane<Law>>;
  const Vec3 warp = direction_that_matters(plane_stiffness(material), material.warp_direction);
  std::vector<typename Term::Element> elements;
  elements.reserve(mesh.triangles.size());
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto& t = mesh.triangles[f];
    const int face = static_cast<int>(f);
    elements.push_back({{t[0] + first_node, t[1] + first_node, t[2] + first_node},
                        rest_of(mesh, face, warp_in_face(mesh, face, warp))});
  }
  return std::make_unique<Term>("membrane: " + name, std::move(elements), parameters_of(material));
}

Matrix32 stress_of(SolidLaw law, const Matrix32& f, const MembraneRest& rest, const MembraneParameters& p) {
  if (law == SolidLaw::kStVenantKirchhoff) return GreenLaw::stress(f, rest, p);
  if (law == SolidLaw::kHooke) return LinearLaw::stress(f, rest, p);
  return PrincipalLaw::stress(f, rest, p);
}

/// Averages values of the faces (larger first) over those around each node, by rest area.
template <class WarpOf, class OfFace>
Eigen::Matrix2Xf at_nodes(const TriangleMesh& mesh, const Nodes& x, const WarpOf& warp_of, const OfFace& of_face) {
  Eigen::Matrix2Xd sum = Eigen::Matrix2Xd::Zero(2, mesh.rest.cols());
  Eigen::RowVectorXd area = Eigen::RowVectorXd::Zero(mesh.rest.cols());
  for (size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& t = mesh.triangles[k];
    const int face = static_cast<int>(k);
    const MembraneRest rest = rest_of(mesh, face, warp_of(face));
    const Matrix32 f = (Mat3() << x.col(t[0]), x.col(t[1]), x.col(t[2])).finished() * rest.gradient;
    const Eigen::Vector2d value = of_face(f, rest);
    for (const int node : t) {
      sum.col(node) += rest.area * value;
      area[node] += rest.area;
    }
  }
  return (sum.array().rowwise() / area.array()).matrix().cast<float>();
}

}  // namespace

std::unique_ptr<Energy> make_membrane(const TriangleMesh& mesh, const SheetMaterial& material, int first_node) {
  check_material(material);
  switch (material.law) {
    case SolidLaw::kHooke:
      return make<LinearLaw>("hooke", mesh, material, first_node);
    case SolidLaw::kStVenantKirchhoff:
      return make<GreenLaw>("st_venant_kirchhoff", mesh, material, first_node);
    case SolidLaw::kCorotational:
      return make<PrincipalLaw>("corotational", mesh, material, first_node);
    case SolidLaw::kNeoHookean:
      return make<PrincipalLaw>("neo_hookean", mesh, material, first_node);
    case SolidLaw::kStableNeoHookean:
      return make<PrincipalLaw>("stable_neo_hookean", mesh, material, first_node);
    case SolidLaw::kMooneyRivlin:
      break;
  }
  return make<PrincipalLaw>("mooney_rivlin", mesh, material, first_node);
}

Eigen::Matrix2Xf principal_strains(const TriangleMesh& mesh, const Nodes& x_body) {
  const auto any = [&](int face) { return warp_in_face(mesh, face, Vec3::Zero()); };
  return at_nodes(mesh, x_body, any, [](const Matrix32& f, const MembraneRest&) {
    return Eigen::Vector2d(principal_stretches(f).stretch.array() - 1.0);
  });
}

Eigen::Matrix2Xf principal_stresses(const TriangleMesh& mesh, const SheetMaterial& material, const Nodes& x_body) {
  const MembraneParameters p = parameters_of(material);
  const double per = material.thickness > 0.0 ? 1.0 / material.thickness : 1.0;
  const Vec3 direction = direction_that_matters(p.stiffness, material.warp_direction);
  const auto warp = [&](int face) { return warp_in_face(mesh, face, direction); };
  return at_nodes(mesh, x_body, warp, [&](const Matrix32& f, const MembraneRest& rest) {
    // sigma = P F^T / (s1 s2), in the plane of the deformed triangle.
    const PrincipalStretches at = principal_stretches(f);
    const Matrix32 nominal = stress_of(material.law, f, rest, p);
    const Eigen::Matrix2d cauchy =
        at.u.transpose() * nominal * f.transpose() * at.u / std::max(at.stretch.prod(), 1e-12);
    const double mean = 0.5 * cauchy.trace(), half = 0.5 * (cauchy(0, 0) - cauchy(1, 1));
    const double radius = std::hypot(half, 0.5 * (cauchy(0, 1) + cauchy(1, 0)));
    return Eigen::Vector2d(per * (mean + radius), per * (mean - radius));
  });
}

Eigen::VectorXf sheet_stress(const TriangleMesh& mesh, const SheetMaterial& material, const Nodes& x_body) {
  const Eigen::Matrix2Xf s = principal_stresses(mesh, material, x_body);
  Eigen::VectorXf result(s.cols());
  for (Eigen::Index i = 0; i < s.cols(); ++i) {
    const float a = s(0, i), b = s(1, i), square = a * a - a * b + b * b;
    result[i] = shown_stress(square < 0.0F ? 0.0F : std::sqrt(square));
  }
  return result;
}

}  // namespace deformable_sim
