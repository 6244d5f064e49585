// Distance grids on disk: what comes back, and what is not believed.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/grid_cache.h"
#include "support/collider_meshes.h"

namespace deformable_sim {
namespace {

class GridCache : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "/grid_cache_XXXXXX";
    folder = mkdtemp(pattern.data());
    folder += "/below";
  }
  void TearDown() override { std::filesystem::remove_all(std::filesystem::path(folder).parent_path()); }

  /// Builds the L and tells whether its grid had to be filled.
  bool fills() {
    bool filled = false;
    MeshBuild build;
    build.cache_folder = folder;
    build.progress = [&filled](double) { filled = true; };
    const auto mesh = make_collider_meshes(test::l_mesh(), build)[0];
    values = mesh->grid().values();
    return filled;
  }
  std::filesystem::path file() const { return std::filesystem::directory_iterator(folder)->path(); }

  std::string folder;
  std::vector<float> values;
};

TEST_F(GridCache, GivesBackTheSameValues) {
  ASSERT_TRUE(fills());
  const std::vector<float> built = values;
  EXPECT_FALSE(fills());
  EXPECT_EQ(values, built);
  // Nothing but the file is left behind.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST_F(GridCache, IsNotBelievedWhenBroken) {
  ASSERT_TRUE(fills());
  const std::vector<float> built = values;
  const std::uintmax_t size = std::filesystem::file_size(file());
  for (const std::uintmax_t length : {size / 2, size - 1, std::uintmax_t{5}, std::uintmax_t{0}}) {
    std::filesystem::resize_file(file(), length);
    EXPECT_TRUE(fills()) << length;
    EXPECT_EQ(values, built);
    EXPECT_FALSE(fills());
  }
  // One bit in the header, among the values, and at the end.
  for (const std::streamoff at : {std::streamoff{20}, std::streamoff{2000}, static_cast<std::streamoff>(size) - 1}) {
    std::fstream changed(file(), std::ios::in | std::ios::out | std::ios::binary);
    changed.seekg(at);
    const char byte = static_cast<char>(changed.get() ^ 1);
    changed.seekp(at);
    changed.put(byte);
    changed.close();
    EXPECT_TRUE(fills()) << at;
    EXPECT_EQ(values, built);
  }
}

TEST_F(GridCache, IsDoneWithoutWhereNothingCanBeWritten) {
  std::ofstream(folder) << "a file where the folder would be";
  EXPECT_TRUE(fills());
  EXPECT_TRUE(fills());
}

TEST(ContentHash, ChangesWithEveryCoordinateAndTriangle) {
  const SolidPart part = split_into_solids(test::l_mesh())[0];
  const std::uint64_t hash = content_hash(part);
  SolidPart moved = part;
  moved.vertices[3].y() += 1e-15;
  EXPECT_NE(content_hash(moved), hash);
  SolidPart turned = part;
  std::swap(turned.triangles[2][0], turned.triangles[2][1]);
  EXPECT_NE(content_hash(turned), hash);
}

}  // namespace
}  // namespace deformable_sim
