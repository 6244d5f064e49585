// Meshes from files of every format, and the shipped T-shirt.
#include "deformable_sim/scene/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

const std::string kSource = DEFORMABLE_SIM_SOURCE_DIR;
const std::string kData = kSource + "/test/scene/data/";

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Vec3 a = mesh.rest.col(t[0]), b = mesh.rest.col(t[1]), c = mesh.rest.col(t[2]);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

class MeshFormats : public testing::TestWithParam<std::string> {};

TEST_P(MeshFormats, GiveTheSameWeldedQuad) {
  // A 2 m x 1 m quad at z = 0.5 m: four nodes, two triangles wound upwards, numbered as the faces name them.
  const TriangleMesh mesh = load_mesh(kData + GetParam(), 1.0);
  ASSERT_EQ(mesh.rest.cols(), 4);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_FALSE(mesh.is_grid());
  // Coordinates pass through single precision.
  EXPECT_LT((mesh.rest.rowwise().minCoeff() - Vec3(0, 0, 0.5)).norm(), 1e-6);
  EXPECT_LT((mesh.rest.rowwise().maxCoeff() - Vec3(2, 1, 0.5)).norm(), 1e-6);
  EXPECT_NEAR(area(mesh), 2.0, 1e-6);
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Vec3 a = mesh.rest.col(t[0]), b = mesh.rest.col(t[1]), c = mesh.rest.col(t[2]);
    EXPECT_GT((b - a).cross(c - a).z(), 0.0);
  }
  EXPECT_EQ(mesh.triangles[0][0], 0);
  EXPECT_EQ(mesh.triangles[0][1], 1);
  EXPECT_EQ(mesh.triangles[0][2], 2);
}

// The unit of a DAE file is applied; its up axis is not: what is written is what is meant.
INSTANTIATE_TEST_SUITE_P(Files, MeshFormats,
                         testing::Values("quad.obj", "quad.ply", "quad.stl", "quad_cm_z_up.dae", "quad_y_up.dae"));

TEST(MeshScale, IsMetresPerUnitOfTheFile) {
  const TriangleMesh mesh = load_mesh(kData + "quad.obj", 0.001);
  EXPECT_NEAR(area(mesh), 2e-6, 1e-12);
}

/// Connected boundary loops: lengths in nodes, sorted.
std::vector<int> boundary_loops(const TriangleMesh& mesh) {
  std::map<std::array<int, 2>, int> faces_on;
  for (const std::array<int, 3>& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      ++faces_on[{std::min(a, b), std::max(a, b)}];
    }
  }
  std::map<int, std::vector<int>> next;
  for (const auto& [edge, count] : faces_on) {
    if (count != 1) continue;
    next[edge[0]].push_back(edge[1]);
    next[edge[1]].push_back(edge[0]);
  }
  std::vector<int> loops;
  std::set<int> seen;
  for (const auto& [start, unused] : next) {
    std::vector<int> open{start};
    int length = 0;
    while (!open.empty()) {
      const int node = open.back();
      open.pop_back();
      if (!seen.insert(node).second) continue;
      ++length;
      EXPECT_EQ(next[node].size(), 2u) << "a boundary node lies on one loop";
      for (const int other : next[node]) open.push_back(other);
    }
    if (length > 0) loops.push_back(length);
  }
  std::sort(loops.begin(), loops.end());
  return loops;
}

TEST(Tshirt, IsASphereWithFourHoles) {
  // Euler: V - E + F = 2 - holes; neck, hem and two cuffs are left open, the seams are welded.
  const TriangleMesh mesh = load_mesh(kSource + "/meshes/tshirt.obj", 1.0);
  const int euler = static_cast<int>(mesh.rest.cols()) - static_cast<int>(edges_of(mesh).size()) +
                    static_cast<int>(mesh.triangles.size());
  EXPECT_EQ(euler, -2);
  const std::vector<int> loops = boundary_loops(mesh);
  ASSERT_EQ(loops.size(), 4u);
  EXPECT_EQ(loops[1], loops[2]) << "the cuffs are alike";
  EXPECT_GE(mesh.rest.cols(), 1500);
  EXPECT_LE(mesh.rest.cols(), 2500);
  // Front and back of a shirt of about 0.38 m^2 each.
  EXPECT_NEAR(area(mesh), 0.76, 0.05);
}

TEST(Tshirt, IsWhatItsScriptWrites) {
  const std::string made = testing::TempDir() + "tshirt_made.obj";
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) GTEST_SKIP() << "python3 or numpy is missing";
  ASSERT_EQ(std::system(("/usr/bin/python3 '" + kSource + "/scripts/make_tshirt.py' '" + made + "'").c_str()), 0);
  const auto read = [](const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  };
  EXPECT_TRUE(read(made) == read(kSource + "/meshes/tshirt.obj"))
      << "meshes/tshirt.obj is not current: run scripts/make_tshirt.py";
}

}  // namespace
}  // namespace deformable_sim
