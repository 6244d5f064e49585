// The reference page and the smallest scene are what the loader knows.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kSource = DEFORMABLE_SIM_SOURCE_DIR;

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(SceneReference, IsCurrent) {
  EXPECT_TRUE(read(kSource + "/doc/scene_reference.md") == scene_reference())
      << "regenerate: simulate --scene-reference > doc/scene_reference.md";
}

TEST(SceneReference, DocumentsEveryKeyWithItsMeaning) {
  std::istringstream page(scene_reference());
  std::string line;
  int keys = 0;
  while (std::getline(page, line)) {
    if (line.rfind("| `", 0) != 0) continue;
    ++keys;
    const size_t last = line.find_last_of('|'), before = line.find_last_of('|', last - 1);
    EXPECT_GT(last - before, 4u) << line;
  }
  EXPECT_GT(keys, 90);
}

TEST(MinimalScene, HasAtMostFifteenLines) {
  const std::string text = read(kSource + "/config/scenes/minimal.yaml");
  ASSERT_FALSE(text.empty());
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 15);
}

}  // namespace
}  // namespace deformable_sim
