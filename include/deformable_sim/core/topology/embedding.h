// Free-form deformation: points that ride on the nodes of a simulated mesh.
#pragma once

#include <Eigen/SparseCore>

#include "deformable_sim/core/topology/tet_mesh.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Where p points lie when n nodes are at x (3 x n, m):
///
///   y_p = sum_i weights(i, p) (x_i + height_p n_i)
///
/// with n_i the unit normals of the sheet's nodes (vertex_normals()). Each column of `weights` sums to one, so an
/// affine motion of the nodes moves points without a height by the same motion, to rounding.
struct Embedding {
  Eigen::SparseMatrix<double> weights;  // n x p
  Eigen::VectorXd height;               // m, above a sheet; empty: none has any
};

/// Points carried by tetrahedra: barycentric weights, or the ten quadratic shape functions where the mesh has nodes in
/// the middle of its edges (at rest these must lie there). A point outside rides on the nearest tetrahedron:
/// first-order expansion of its map about its nearest point, so that it neither lags nor swings with the square of the
/// distance.
///
/// Continuous inside the mesh. Outside, two neighbouring points that ride on different tetrahedra part by their
/// distance to the mesh times the difference of the two deformation gradients: keep the surface inside, or close.
/// Build: O((t + p) log t). Throws InputError when the mesh has no tetrahedron, a flat one, or a point is not finite.
Embedding embed_in_volume(const Nodes& points, const TetMesh& mesh);

/// Points carried by a sheet, at a signed height along its interpolated normals: p lies in the triangle that its three
/// corners make when each moves by the height along its own normal (a cubic equation for the height). Neighbouring
/// triangles share those corners, so the map is continuous above and below the sheet up to its radius of curvature.
/// Points beyond the rim extrapolate the nearest triangle.
///
/// Exact for rigid motions; for affine ones only where the height is zero: a sheet says nothing of its thickness, which
/// is kept. Build: O((t + p) log t). Throws InputError for a point that is not finite or so far away that no triangle
/// reaches it.
Embedding embed_in_sheet(const Nodes& points, const TriangleMesh& mesh);

}  // namespace deformable_sim
