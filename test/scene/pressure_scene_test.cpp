// `pressure` of a cloth: from the scene to a body that swells, whichever way its mesh is wound.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

/// An octahedron, its faces wound counter-clockwise from outside, or all the other way.
std::string write_octahedron(bool clockwise) {
  const std::string path = ::testing::TempDir() + (clockwise ? "octahedron_cw.obj" : "octahedron_ccw.obj");
  std::ofstream file(path);
  file << "v 0.1 0 0\nv -0.1 0 0\nv 0 0.1 0\nv 0 -0.1 0\nv 0 0 0.1\nv 0 0 -0.1\n";
  const int faces[8][3] = {{1, 3, 5}, {3, 2, 5}, {2, 4, 5}, {4, 1, 5}, {3, 1, 6}, {2, 3, 6}, {4, 2, 6}, {1, 4, 6}};
  for (const auto& f : faces)
    file << "f " << f[0] << ' ' << f[clockwise ? 2 : 1] << ' ' << f[clockwise ? 1 : 2] << '\n';
  return path;
}

double volume_after(bool clockwise, double pressure) {
  const std::string mesh = write_octahedron(clockwise);
  const auto world = build_world(
      load_scene_text("gravity: [0, 0, 0]\nair: {damping: 20}\nbodies:\n  - cloth: {name: bag, mesh: " + mesh +
                          ", model: membrane, pressure: " + std::to_string(pressure) +
                          ", material: {membrane_stiffness: 100, bending_rigidity: 1.0e-6}}\n",
                      "s.yaml"));
  while (world->time() < 1.0) world->step();
  TriangleMesh blown = *world->model().bodies[0].surface;
  blown.rest = world->state().x;
  std::remove(mesh.c_str());
  return std::abs(enclosed_volume(blown));
}

TEST(PressureKey, SwellsABagWhicheverWayItIsWound) {
  const double volume = 0.1 * 0.1 * 0.1 * 4.0 / 3.0;
  EXPECT_GT(volume_after(false, 100.0), 1.02 * volume);
  EXPECT_NEAR(volume_after(true, 100.0), volume_after(false, 100.0), 1e-6 * volume);
  EXPECT_LT(volume_after(false, -20.0), 0.999 * volume);
}

std::string refusal(const std::string& cloth) {
  try {
    build_model(load_scene_text("bodies:\n  - cloth: {name: a, " + cloth + "}\n", "s.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PressureKey, IsRefusedWithItsPlace) {
  EXPECT_EQ(refusal("pressure: 100"),
            "s.yaml:2: bodies[0]: pressure needs a closed mesh; this one has an edge with a face on one side only");
  EXPECT_EQ(refusal("pressure: 1.0e7").find("s.yaml:2: bodies[0].cloth.pressure: 1.0e7 is out of range"), 0u);
  EXPECT_EQ(refusal("pressure: .nan").find("s.yaml:2: bodies[0].cloth.pressure: "), 0u);
  EXPECT_EQ(refusal("pressure_rise: 1").find("s.yaml:2: bodies[0].cloth.pressure_rise: belongs to pressure"), 0u);
}

}  // namespace
}  // namespace deformable_sim
