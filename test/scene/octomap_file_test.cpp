// OctoMap files, written by OctoMap 1.9.7, as colliders of a scene; broken ones are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/contact/voxel_solid.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/octomap_file.h"

namespace deformable_sim {
namespace {

const std::string kData = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data/";

std::string bytes_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Centre and size of every cube, m, in the order of x.
std::vector<std::array<double, 4>> cubes_of(const Shape& shape) {
  std::vector<std::array<double, 4>> cubes;
  for (const VoxelCube& cube : shape.voxels->cubes()) {
    const double size = shape.voxels->resolution() * (1 << cube.level);
    const auto middle = [&](size_t k) {
      return shape.voxels->resolution() * (cube.key[k] - kVoxelOrigin) + 0.5 * size;
    };
    cubes.push_back({middle(0), middle(1), middle(2), size});
  }
  std::sort(cubes.begin(), cubes.end());
  return cubes;
}

class OctomapFile : public testing::TestWithParam<const char*> {};

TEST_P(OctomapFile, HoldsTheVoxelsThatOctoMapListed) {
  // The leaves OctoMap itself called occupied when it wrote the files: one of 4 cells, three of one; free ones are not.
  const std::vector<std::array<double, 4>> expected{
      {-0.225, 0.025, 0.025, 0.05}, {0.1, 0.1, 0.1, 0.2}, {0.425, 0.025, 0.025, 0.05}, {0.475, 0.075, 0.025, 0.05}};
  const auto cubes = cubes_of(load_octomap(kData + GetParam()));
  ASSERT_EQ(cubes.size(), expected.size());
  for (size_t i = 0; i < cubes.size(); ++i)
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(cubes[i][k], expected[i][k], 1e-12);
}

TEST_P(OctomapFile, EndsWhereverItIsCutWithARefusal) {
  const std::string whole = bytes_of(kData + GetParam());
  for (size_t length = 0; length < whole.size(); ++length)
    EXPECT_THROW(octomap_from_bytes(whole.substr(0, length), "cut"), InputError) << length;
  EXPECT_THROW(octomap_from_bytes(whole + "x", "long"), InputError);
}

TEST_P(OctomapFile, SurvivesAnyByteBeingAnother) {
  // Whatever stands there, the file is read or refused; nothing else happens.
  const std::string whole = bytes_of(kData + GetParam());
  int read = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {1, 3, 85, 128, 255}) {
      std::string other = whole;
      other[i] = static_cast<char>(other[i] ^ change);
      try {
        octomap_from_bytes(other, "other");
        ++read;
      } catch (const InputError&) {
      }
    }
  }
  EXPECT_GT(read, 0);
}

INSTANTIATE_TEST_SUITE_P(Every, OctomapFile, testing::Values("blocks.bt", "blocks.ot", "blocks_color.ot"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

void expect_refused(const OctomapTree& tree, const std::string& why) {
  try {
    octomap_shape(tree);
    ADD_FAILURE() << why;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
}

TEST(OctomapTree, RefusesWhatIsNone) {
  OctomapTree tree;
  tree.resolution = 0.05;
  expect_refused(tree, "no occupied space");
  tree.data = std::string("\x01\x00", 2);  // one free child
  expect_refused(tree, "no occupied space");
  tree.data = std::string("\x02\x00", 2);  // one occupied child
  EXPECT_EQ(octomap_shape(tree).voxels->cubes().size(), 1u);
  tree.id = "MapOfMine";
  expect_refused(tree, "id 'MapOfMine'; OcTree, OcTreeStamped and ColorOcTree are allowed");
  tree.id = "OcTree";
  tree.resolution = std::nan("");
  expect_refused(tree, "resolution");
  tree.resolution = 0.05;
  tree.data = std::string(100000, '\xff');  // a child of a child of a child ...
  expect_refused(tree, "deeper than 16 levels");
  tree.binary = false;
  std::string node(5, '\0');
  const float nan = std::nanf("");
  std::memcpy(node.data(), &nan, sizeof nan);
  tree.data = node;
  expect_refused(tree, "not a number");
}

TEST(OctomapScene, StopsACloth) {
  // A sheet falls on the block of 0.2 m and hangs over its edges; no node is inside, it lies where the block ends.
  const std::string yaml =
      "bodies:\n"
      "  - cloth: {name: sheet, size: [0.3, 0.3], cells: [12, 12], pose: {position: [0.1, 0.1, 0.22]}}\n"
      "colliders:\n"
      "  - octomap: {name: map, file: " +
      kData + "blocks.bt}\n";
  const SceneSpec spec = load_scene_text(yaml, "text");
  ASSERT_EQ(spec.colliders.size(), 1u);
  const auto world = build_world(spec);
  while (world->state().time < 0.5) ASSERT_TRUE(world->step().ok);
  EXPECT_LT(measure_penetration(world->model(), {spec.colliders[0].collider}, world->state().x), 1e-3);
  for (int i = 0; i < world->state().x.cols(); ++i)
    EXPECT_FALSE(spec.colliders[0].collider.shapes[0].voxels->occupied(world->state().x.col(i)));
  EXPECT_NEAR(world->state().x(2, 84), 0.201, 1e-4);  // the middle
  EXPECT_LT(world->state().x.row(2).minCoeff(), 0.18);
}

TEST(OctomapScene, NamesTheLineOfAFileThatIsNone) {
  const auto message = [](const std::string& file) -> std::string {
    try {
      load_scene_text("bodies:\n  - cloth: {name: a}\ncolliders:\n  - octomap:\n      name: map\n      file: " + file,
                      "s");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("nothing.bt").find("s:6: colliders[0].octomap.file"), std::string::npos) << message("nothing.bt");
  EXPECT_NE(message(kData + "quad.obj").find("not an OctoMap file"), std::string::npos);
}

}  // namespace
}  // namespace deformable_sim
