// Voxel solids against a look at every cell: distances, planes, flights, and what is refused.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/contact/surface_query.h"
#include "deformable_sim/core/error.h"
#include "support/small_worlds.h"
#include "support/voxels.h"

namespace deformable_sim {
namespace {

using test::kBlock;
using test::kCell;
using test::VoxelGrid;

constexpr double kDt = 0.01;
constexpr double kRadius = 0.001;

struct Case {
  const char* name;
  VoxelGrid::Filled filled;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

Vec3 random_vector(std::mt19937* random) {
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  return Vec3(in(*random), in(*random), in(*random));
}

/// All around; in and beside an occupied cell; and 1e-7 m to 1 cm from corners, edges and faces of one.
Vec3 sample(const VoxelGrid& grid, int k, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  if (k % 4 == 0) return 0.2 * random_vector(random);
  size_t cell = (*random)() % grid.cells.size();
  while (grid.cells[cell] == 0) cell = (cell + 1) % grid.cells.size();
  const auto at = static_cast<int>(cell);
  const Vec3 low = kCell * (Vec3(at % kBlock, at / kBlock % kBlock, at / kBlock / kBlock) - Vec3::Constant(kBlock / 2));
  Vec3 p = low + kCell * (Vec3::Constant(0.5) + random_vector(random));
  if (k % 4 == 1) return p;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == k % 3 || unit(*random) < 0.5) p[axis] = kCell * std::round(p[axis] / kCell);
  }
  return p + std::pow(10.0, -2.0 - 5.0 * unit(*random)) * random_vector(random);
}

Collider voxel_collider(const VoxelGrid& grid) {
  Collider c = test::collider("map", Shape::Type::kVoxels, Vec3::Zero(), Pose::Identity());
  c.shapes[0].voxels = std::make_shared<const VoxelSolid>(grid.cubes(), kCell);
  return c;
}

class VoxelSolidOf : public testing::TestWithParam<Case> {
 protected:
  VoxelGrid grid{GetParam().filled};
  VoxelSolid solid{grid.cubes(), kCell};
  std::mt19937 random{31};
};

TEST_P(VoxelSolidOf, TellsTheDistanceOfTheNearestCell) {
  // Outside: min of the distances to occupied cells. Inside: minus the min of those to free ones.
  int inside = 0;
  for (int k = 0; k < 600; ++k) {
    const Vec3 p = sample(grid, k, &random);
    const double expected = grid.distance(p);
    MeshPoint found;
    ASSERT_TRUE(solid.nearest(p, std::abs(expected) + 1e-9, &found)) << p.transpose();
    // Doubles of size 0.2 through a division and a product.
    ASSERT_NEAR(found.distance, expected, 1e-14) << p.transpose();
    EXPECT_NEAR(found.normal.norm(), 1.0, 1e-12);
    EXPECT_NEAR(grid.distance(p - found.distance * found.normal), 0.0, 1e-12);
    if (std::abs(expected) > 1e-9) {
      EXPECT_EQ(solid.occupied(p), expected < 0.0);
    }
    if (expected > 1e-9) {
      EXPECT_FALSE(solid.nearest(p, expected - 1e-9, &found));
    }
    if (expected < 0.0) {
      EXPECT_TRUE(solid.nearest(p, 0.0, &found));
    }
    inside += expected < 0.0 ? 1 : 0;
  }
  EXPECT_GT(inside, 40);
}

TEST_P(VoxelSolidOf, IsBoundedByWhatLiesBetweenOccupiedAndFreeCells) {
  // Area of the squares = number of pairs of neighbouring cells of which one is occupied, a corner of each is on them.
  int expected = 0;
  for (int z = -1; z <= test::kBlock; ++z)
    for (int y = -1; y <= test::kBlock; ++y)
      for (int x = -1; x <= test::kBlock; ++x) {
        const int here = grid.at(x, y, z) ? 1 : 0;
        expected += std::abs(here - (grid.at(x + 1, y, z) ? 1 : 0)) + std::abs(here - (grid.at(x, y + 1, z) ? 1 : 0)) +
                    std::abs(here - (grid.at(x, y, z + 1) ? 1 : 0));
      }
  int area = 0;
  for (const VoxelSquare& square : solid.squares()) {
    area += square.size * square.size;
    Vec3 middle =
        Eigen::Map<const Eigen::Vector3i>(square.corner.data()).cast<double>() + Vec3::Constant(0.5 * square.size);
    middle[square.axis] -= 0.5 * square.size;
    const Vec3 out = 0.25 * square.outwards * Vec3::Unit(square.axis);
    EXPECT_GT(grid.distance(kCell * (middle + out)), 0.0);
    EXPECT_LT(grid.distance(kCell * (middle - out)), 0.0);
  }
  EXPECT_EQ(area, expected);
}

TEST_P(VoxelSolidOf, KeepsFastPointsOutByItsPlanes) {
  // p outside, q anywhere within reach and `clearance` above every plane of p: the way from p to q enters no cell.
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<SquarePoint> work;
  int kept = 0, admitted = 0;
  for (int k = 0; k < 600; ++k) {
    const Vec3 p = sample(grid, k, &random);
    const double reach = 0.06;
    MeshPoint surface;
    if (!solid.nearest(p, reach, &surface) || surface.distance < 1e-9) continue;
    std::vector<MeshPoint> planes;
    solid.planes(p, surface, reach, kRadius, &work, &planes);
    ASSERT_FALSE(planes.empty());
    for (int tries = 0; tries < 20; ++tries) {
      const Vec3 q = p + reach * unit(random) * random_vector(&random).normalized();
      double least = 1.0;
      for (const MeshPoint& plane : planes) least = std::min(least, plane.distance + plane.normal.dot(q - p));
      bool enters = false;
      for (int s = 0; s <= 50 && !enters; ++s) enters = grid.holds(p + s / 50.0 * (q - p));
      if (least < kRadius) {
        kept += enters ? 1 : 0;
        continue;
      }
      ++admitted;
      EXPECT_FALSE(enters) << p.transpose() << " to " << q.transpose();
    }
  }
  EXPECT_GT(admitted, 300);
  EXPECT_GT(kept, 100);
}

TEST_P(VoxelSolidOf, LeadsPointsInsideOut) {
  // A point inside that goes `clearance` above all its planes is outside.
  std::vector<SquarePoint> work;
  int led = 0;
  for (int k = 0; k < 1000; ++k) {
    const Vec3 p = sample(grid, k, &random);
    MeshPoint surface;
    if (!solid.nearest(p, 0.0, &surface) || surface.distance > -1e-6 || surface.distance < -0.004) continue;
    std::vector<MeshPoint> planes;
    solid.planes(p, surface, 0.004, kRadius, &work, &planes);
    ASSERT_FALSE(planes.empty());
    Vec3 q = p;
    for (int round = 0; round < 500; ++round)
      for (const MeshPoint& plane : planes)
        q += std::max(0.0, 1.01 * kRadius - plane.distance - plane.normal.dot(q - p)) * plane.normal;
    for (const MeshPoint& plane : planes) ASSERT_GE(plane.distance + plane.normal.dot(q - p), kRadius);
    EXPECT_GT(grid.distance(q), 0.0) << p.transpose();
    ++led;
  }
  EXPECT_GT(led, 50);
}

TEST_P(VoxelSolidOf, KeepsPointsOutInFlight) {
  // Sixty points thrown anew at 3 m/s in every step, ways of up to 50 mm past cells of 20 mm, the map turned at times.
  Collider collider = voxel_collider(grid);
  Nodes x(3, 60);
  for (int i = 0; i < x.cols();) {
    const Vec3 p = 0.25 * random_vector(&random);
    if (grid.distance(p) > 0.0) x.col(i++) = p;
  }
  auto model = test::points_model(x, 0.01, Vec3::Zero());
  model->bodies[0].contact_radius = kRadius;
  ContactFinder finder(model.get());
  finder.set_colliders({collider});
  State state = model->initial;
  const std::vector<NodeRole> roles(60, NodeRole::kFree);
  for (int step = 0; step < 40; ++step) {
    const Pose begin = collider.world_from_collider;
    if (step % 3 == 0) collider.world_from_collider = test::at(0, 0, 0, 0.02, Vec3(1, 2, 3)) * begin;
    for (int i = 0; i < 60; ++i) state.v.col(i) = 3.0 * random_vector(&random);
    const Nodes before = state.x;
    double extra = 0.0;
    for (int attempt = 0; attempt < 20; ++attempt) {
      ContactConstraints contacts;
      finder.find(state, kDt, {{begin, collider.world_from_collider}}, roles, extra, &contacts);
      Nodes after = before + kDt * state.v;
      for (int round = 0; round < 2000; ++round) {
        double worst = 0.0;
        for (const ContactConstraint& c : contacts) {
          const double gap = c.normal.dot(after.col(c.node[0])) - c.offset;
          worst = std::max(worst, -gap);
          if (gap < 0.0) after.col(c.node[0]) -= gap * c.normal;
        }
        if (worst < 1e-7) break;
      }
      const double missed = finder.missed_motion(before, after);
      state.x = after;
      if (missed == 0.0) break;
      extra += missed;
      state.x = before;
    }
    for (int i = 0; i < 60; ++i)
      ASSERT_FALSE(grid.holds(collider.world_from_collider.inverse() * Vec3(state.x.col(i)))) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Every, VoxelSolidOf,
    testing::Values(Case{"lone", [](int x, int y, int z) { return x == 8 && y == 7 && z == 9; }},
                    Case{"edge_to_edge", [](int x, int y, int z) { return x == y && x / 4 == 1 && z > 4 && z < 10; }},
                    Case{"corner_to_corner", [](int x, int y, int z) { return x == y && y == z; }},
                    Case{"block", [](int x, int y, int z) { return x / 8 + y / 8 + z / 8 == 0; }},
                    Case{
                        "block_with_grains",
                        [](int x, int y, int z) { return x / 8 + y / 8 + z / 8 == 0 || (x == 8 && (y * z) % 5 == 3); }},
                    Case{"stairs", [](int x, int y, int z) { return z <= x / 2 + y / 4; }},
                    Case{"hollow",
                         [](int x, int y, int z) {
                           const auto in = [](int k) { return k > 3 && k < 12; };
                           const auto core = [](int k) { return k > 4 && k < 11; };
                           return in(x) && in(y) && in(z) && !(core(x) && core(y) && core(z));
                         }},
                    Case{"grains", [](int x, int y, int z) { return (x * 7 + y * 13 + z * 29) % 11 < 3; }}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(VoxelContact, GivesOnePlaneAWall) {
  // Cells side by side are one floor: a sheet's nodes meet it with normals straight up, one plane each, at z = h + r.
  const VoxelGrid floor([](int, int, int z) { return z < 8; });
  const VoxelGrid grainy([](int x, int y, int z) { return z < 7 || (z == 7 && x + y > 2); });
  for (const VoxelGrid& grid : {floor, grainy}) {
    Nodes x(3, 81);
    for (int i = 0; i < 81; ++i) x.col(i) = Vec3(0.005 * (i % 9), 0.005 * (i / 9), 0.0015);
    auto model = test::points_model(x, 0.01, Vec3(0, 0, -9.81));
    model->bodies[0].contact_radius = kRadius;
    ContactFinder finder(model.get());
    finder.set_colliders({voxel_collider(grid)});
    State state = model->initial;
    state.v.row(0).setConstant(2.0);
    ContactConstraints contacts;
    finder.find(state, kDt, {PoseStep()}, std::vector<NodeRole>(81, NodeRole::kFree), 0.0, &contacts);
    ASSERT_EQ(contacts.size(), 81u);
    for (const ContactConstraint& c : contacts) {
      EXPECT_EQ(c.normal, Vec3::UnitZ());
      EXPECT_NEAR(c.offset, kRadius, 1e-15);
    }
  }
}

TEST(VoxelSolid, HoldsAWholeMapAndItsFarEnds) {
  // Cells 0 and 65535 along each axis: corners of the map, beyond which all is free.
  const VoxelSolid solid({{{{0, 0, 0}}, 0}, {{{65535, 65535, 65535}}, 0}}, 0.05);
  EXPECT_EQ(solid.squares().size(), 12u);
  MeshPoint found;
  ASSERT_TRUE(solid.nearest(Vec3::Constant(-32768 * 0.05 - 1.0), 2.0, &found));
  EXPECT_NEAR(found.distance, std::sqrt(3.0), 1e-9);
  ASSERT_TRUE(solid.nearest(Vec3::Constant(32768 * 0.05 + 1.0), 2.0, &found));
  EXPECT_NEAR(found.distance, std::sqrt(3.0), 1e-9);
  EXPECT_FALSE(solid.occupied(Vec3::Constant(1e30)));
  const VoxelSolid all({{{{0, 0, 0}}, kVoxelLevels}}, 0.05);
  EXPECT_EQ(all.squares().size(), 6u);
  ASSERT_TRUE(all.nearest(Vec3(0, 0, 1638.3), 0.0, &found));
  EXPECT_NEAR(found.distance, -0.1, 1e-9);
}

TEST(VoxelSolid, RefusesWhatIsNone) {
  const auto refused = [](std::vector<VoxelCube> cubes, double resolution, const char* why) {
    try {
      VoxelSolid(std::move(cubes), resolution);
      ADD_FAILURE() << why;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused({}, 0.05, "no occupied space");
  refused({VoxelCube()}, 0.0, "1e-4 ... 100 m");
  refused({VoxelCube()}, std::nan(""), "1e-4 ... 100 m");
  refused({{{{1, 0, 0}}, 1}}, 0.05, "does not fit the grid");
  refused({{{{0, 0, 0}}, 17}}, 0.05, "does not fit the grid");
  refused(std::vector<VoxelCube>(kMostVoxelCubes + 1), 0.05, "at most 500000");
}

}  // namespace
}  // namespace deformable_sim
