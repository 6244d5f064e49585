// How the curvature of each triangle of a sheet follows from the angles at the edges around it.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// One triangle: curvature (k_xx, k_yy, 2 k_xy), x along the warp, 1/m = `curvature` times the angles of `hinges`.
struct PlatePatch {
  static constexpr size_t kMost = 9;
  int count = 0;  // of hinges: up to three of its own, up to six of its neighbours
  std::array<int, kMost> hinge{};
  Eigen::Matrix<double, 3, static_cast<int>(kMost)> curvature;  // the first `count` columns
  double area = 0.0;                                            // m^2
};

/// A hinge is {a, b, c, d}: the edge from a to b as triangle (a, b, c) runs along it, the other triangle being (b, a,
/// d).
struct PlateMesh {
  std::vector<std::array<int, 4>> hinges;
  std::vector<PlatePatch> patches;  // triangles that have a hinge near; parallel to the faces otherwise
};

/// Curvature as the mean over the triangle of the second derivatives of the deflection w: by Gauss's theorem
///
///   kappa = 1/A sum over edges e of l_e psi_e n_e n_e^T,
///
/// psi_e the slope at the middle of the edge along its outward normal n_e, relative to the flat triangle [Morley 1971].
/// Both triangles of an edge share that slope, so that psi_e + psi'_e = angle_e and constant moments are in
/// equilibrium on any mesh; it is taken from the angles around:
///
///   psi_e = angle_e / 2 + sum c_i angle_i,
///
/// i over the edge itself and the other four edges of its two triangles, c the smallest that makes psi_e exact for
/// every quadratic w. On a free edge psi_e takes the value of least energy: no moment across it. Then the curvature of
/// every quadratic w is exact in every triangle without a free edge, whatever the mesh. Hinges that cannot tell two
/// curvatures apart (a strip one triangle wide) give the one of least energy under `stiffness`.
/// Neighbours of a triangle that is not flat at rest are unfolded into its plane.
/// Throws InputError where the warp direction is normal to a triangle.
PlateMesh plate_mesh(const TriangleMesh& mesh, const Mat3& stiffness, const Vec3& warp_direction);

/// Unit vector along the warp in the plane of the triangle; of zero, any. Throws InputError naming the face when the
/// direction is normal to it.
Vec3 warp_in_face(const TriangleMesh& mesh, int face, const Vec3& warp_direction);

}  // namespace deformable_sim
