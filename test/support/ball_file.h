// A ball of tetrahedra as a file that scenes can name.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "deformable_sim/core/topology/tet_mesh.h"

namespace deformable_sim::test {

/// A ball of linear tetrahedra, a cube's nodes moved onto spheres; writes a MEDIT file.
inline std::string ball_file(double radius, int cells) {
  TetMesh mesh = make_box(Vec3::Constant(2.0), {cells, cells, cells});
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    const Vec3 p = mesh.rest.col(i);
    if (p.norm() > 0.0) mesh.rest.col(i) *= radius * p.cwiseAbs().maxCoeff() / p.norm();
  }
  const std::string path = testing::TempDir() + "ball.mesh";
  std::ofstream file(path);
  file.precision(17);
  file << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.rest.cols() << "\n";
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) file << mesh.rest.col(i).transpose() << " 0\n";
  file << "Tetrahedra\n" << mesh.tets.size() << "\n";
  for (const auto& t : mesh.tets) file << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << " " << t[3] + 1 << " 0\n";
  file << "End\n";
  return path;
}

}  // namespace deformable_sim::test
