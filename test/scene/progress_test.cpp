#include "deformable_sim/scene/progress.h"

#include <gtest/gtest.h>

namespace deformable_sim::test {
namespace {

/// What is written of a quarter, a half and all of 8 s.
std::string written(Progress::Manner manner, double soon = 0.0) {
  testing::internal::CaptureStderr();
  {
    Progress progress(manner, "to go", soon);
    for (const double taken : {2.0, 2.1, 4.0}) progress.show("steps", taken, 8.0 - taken);
    progress.say("half done");
  }
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, IsABarOnATerminalThatIsTakenAway) {
  const std::string text = written(Progress::Manner::kBar);
  EXPECT_NE(text.find("[######..................] 0:06 to go  steps"), std::string::npos) << text;
  EXPECT_NE(text.find("\r\033[Khalf done\n"), std::string::npos) << text;
}

TEST(Progress, IsLinesElsewhere) {
  const std::string text = written(Progress::Manner::kLines);
  EXPECT_EQ(text, " 25 %, 0:06 to go: steps\n 50 %, 0:04 to go: steps\nhalf done\n");
}

TEST(Progress, IsNothingWhenQuietOrSoonDone) {
  EXPECT_EQ(written(Progress::Manner::kSilent), "");
  EXPECT_EQ(written(Progress::Manner::kBar, 100.0), "half done\n");
  EXPECT_EQ(Progress::fitting(true), Progress::Manner::kSilent);
}

}  // namespace
}  // namespace deformable_sim::test
