// Cones and mesh files as colliders of a scene.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/collider_file.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

constexpr const char* kTwoTetrahedra =
    "solid two\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 1 0\nvertex 0 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 5 0 0\nvertex 5 1 0\nvertex 6 0 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 5 0 0\nvertex 6 0 0\nvertex 5 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 6 0 0\nvertex 5 1 0\nvertex 5 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 5 1 0\nvertex 5 0 0\nvertex 5 0 1\nendloop\nendfacet\n"
    "endsolid two\n";

class ColliderFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "/collider_file_XXXXXX";
    folder = mkdtemp(pattern.data());
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
    std::ofstream(folder + "/two.stl") << kTwoTetrahedra;
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(folder);
  }
  std::string folder;
};

TEST_F(ColliderFile, IsOneShapeForEachClosedPart) {
  const std::vector<Shape> shapes = load_collider_mesh(folder + "/two.stl", Vec3(0.1, 0.2, -0.3), 0.004, {});
  ASSERT_EQ(shapes.size(), 2u);
  for (const Shape& shape : shapes) {
    EXPECT_EQ(shape.type, Shape::Type::kMesh);
    EXPECT_EQ(shape.size[0], 0.004);
    ASSERT_TRUE(shape.mesh);
    EXPECT_TRUE(shape.mesh->convex());
    // Single precision in the file's coordinates.
    EXPECT_NEAR((shape.mesh->box().sizes() - Vec3(0.1, 0.2, 0.3)).norm(), 0.0, 1e-7);
    MeshPoint found;  // mirrored by the negative scale, and still with the inside inside
    const Vec3 middle = shape.mesh->box().min() + Vec3(0.02, 0.04, 0.24);
    ASSERT_TRUE(shape.mesh->nearest(middle, 0.0, &found));
    EXPECT_LT(found.distance, 0.0);
  }
  EXPECT_EQ(cache_folder(), folder + "/deformable_sim");
  EXPECT_FALSE(std::filesystem::is_empty(cache_folder()));
}

TEST_F(ColliderFile, StopsAClothInAScene) {
  // A sheet falls on a tetrahedron and a cone; after half a second it hangs over both, and no point is inside.
  std::ofstream(folder + "/s.yaml") << "bodies:\n"
                                       "  - cloth: {name: sheet, size: [0.3, 0.3], cells: [10, 10], pose: {position: "
                                       "[0.05, 0.05, 0.16]}, contact_points: faces}\n"
                                       "colliders:\n"
                                       "  - mesh: {name: rock, file: two.stl, scale: 0.15}\n"
                                       "  - cone: {name: hat, radius: 0.05, length: 0.1, pose: {position: [0.1, 0.1, "
                                       "0.05]}}\n";
  const SceneSpec spec = load_scene_file(folder + "/s.yaml");
  ASSERT_EQ(spec.colliders.size(), 2u);
  EXPECT_EQ(spec.colliders[0].collider.shapes.size(), 2u);
  const auto world = build_world(spec);
  while (world->state().time < 0.5) world->step();
  EXPECT_LT(
      measure_penetration(world->model(), {spec.colliders[0].collider, spec.colliders[1].collider}, world->state().x),
      5e-4);
  EXPECT_GT(world->state().x.row(2).maxCoeff(), 0.1);
}

}  // namespace
}  // namespace deformable_sim
