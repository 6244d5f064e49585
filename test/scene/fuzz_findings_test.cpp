// What the fuzzers found, once more: every file of test/scene/data/fuzz is read, or refused, and nothing else happens.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "fuzz/targets.h"

namespace deformable_sim {
namespace {

void replay(const std::string& target, void (*attempt)(const std::string&)) {
  const std::string folder = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data/fuzz/" + target;
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    std::ostringstream text;
    text << std::ifstream(file.path(), std::ios::binary).rdbuf();
    EXPECT_NO_THROW(attempt(text.str())) << file.path();
    ++count;
  }
  EXPECT_GT(count, 0);
}

TEST(FuzzFindings, OfScenesAreReadOrRefused) {
  replay("scene", fuzz::try_scene);
}

TEST(FuzzFindings, OfMeshesAreReadOrRefused) {
  replay("mesh", fuzz::try_mesh);
}

TEST(FuzzFindings, OfOctomapsAreReadOrRefused) {
  replay("octomap", fuzz::try_octomap);
}

TEST(FuzzFindings, OfMaterialsAreReadOrRefused) {
  replay("material", fuzz::try_materials);
}

}  // namespace
}  // namespace deformable_sim
