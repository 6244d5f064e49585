// A body beyond the strains its material's law holds for says so.
#include <gtest/gtest.h>

#include "support/small_worlds.h"

namespace deformable_sim::test {
namespace {

/// Warnings of a sheet of 0.5 m whose law holds in [low, high], stretched uniformly along x by `strain`.
std::vector<std::string> warnings_at(double strain, double low, double high) {
  Sheet sheet;
  sheet.gravity = Vec3::Zero();
  const std::shared_ptr<Model> model = sheet_model(sheet);
  model->bodies[0].valid_strain = {{low, high}};
  model->initial.x.row(0) *= 1.0 + strain;
  World world(model, WorldSettings{}, {}, {});
  return world.snapshot().warnings;
}

TEST(ElasticLimit, IsNamedWithTheStrainThatPassedIt) {
  // max over structural edges of l / L - 1 against Body::valid_strain.
  const auto warnings = warnings_at(0.14, -0.08, 0.08);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "body towel is stretched to 14 %, beyond the 8 % its material law holds for");
}

TEST(ElasticLimit, OfCompressionIsTheLowerOne) {
  const auto warnings = warnings_at(-0.125, -0.05, 0.08);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "body towel is compressed to 12.5 %, beyond the 5 % its material law holds for");
}

TEST(ElasticLimit, IsSilentWithinTheRangeAndWithoutOne) {
  EXPECT_TRUE(warnings_at(0.079, -0.08, 0.08).empty());
  EXPECT_TRUE(warnings_at(-0.049, -0.05, 0.08).empty());
  EXPECT_TRUE(warnings_at(3.0, Body{}.valid_strain[0], Body{}.valid_strain[1]).empty());
}

}  // namespace
}  // namespace deformable_sim::test
