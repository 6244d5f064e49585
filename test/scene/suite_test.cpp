// The scenes of the suite of error against run time.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

#include "study/work_precision_case.h"

namespace deformable_sim::work_precision {
namespace {

class SuiteScene : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, SuiteScene, testing::ValuesIn(scene_names(suite_dir())),
                         [](const testing::TestParamInfo<std::string>& info) { return info.param; });

TEST_P(SuiteScene, SaysWhatItIsForLoadsAndSteps) {
  EXPECT_EQ(content_of(suite_dir() + "/" + GetParam() + ".yaml").substr(0, 2), "# ");
  const std::unique_ptr<Case> c = scene_case(GetParam(), {}, 1.0);
  EXPECT_FALSE(c->title.empty());
  const std::unique_ptr<World> world = c->make(0.005, "tr_bdf2", c->solver);
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(world->step().ok);
  EXPECT_TRUE(world->state().finite());
}

TEST(Suite, CoversSheetsRopesASolidAndThreeStiffnessesADecade) {
  EXPECT_EQ(scene_names(suite_dir()).size(), 21u);
  std::map<std::string, int> kinds;
  for (const std::string& name : scene_names(suite_dir())) ++kinds[scene_case(name, {}, 1.0)->features.kind];
  EXPECT_GE(kinds["cloth"], 6);
  EXPECT_GE(kinds["rope"], 3);
  EXPECT_GE(kinds["soft"], 1);
  int ladder = 0;
  for (const SuiteEntry& entry : suite()) ladder += entry.scene == "hang_20";
  EXPECT_EQ(ladder, 13) << "1, 2 and 5 times 1e2 ... 1e5, and 1e6 N/m";
}

}  // namespace
}  // namespace deformable_sim::work_precision
