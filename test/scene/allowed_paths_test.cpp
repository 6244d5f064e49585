// Files named by others stay below the folders that are allowed.
#include "deformable_sim/scene/allowed_paths.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {
namespace fs = std::filesystem;

/// A folder `inside` with files and links, beside a folder `inside_not` that is not to be reached.
class Folders : public ::testing::Test {
 protected:
  void SetUp() override {
    top_ = fs::canonical(fs::temp_directory_path()) / ("allowed_paths_" + std::to_string(::getpid()));
    fs::create_directories(top_ / "inside" / "deep");
    fs::create_directories(top_ / "inside_not");
    std::ofstream(top_ / "inside" / "a.yaml") << "a";
    std::ofstream(top_ / "inside_not" / "secret") << "s";
    fs::create_symlink(top_ / "inside_not" / "secret", top_ / "inside" / "link_out");
    fs::create_directory_symlink(top_ / "inside_not", top_ / "inside" / "folder_out");
    fs::create_symlink(top_ / "inside_not" / "not_there", top_ / "inside" / "link_to_nothing");
    fs::create_symlink("a.yaml", top_ / "inside" / "link_within");
    fs::create_symlink("loop", top_ / "inside" / "loop");
    fs::create_directory_symlink(top_ / "inside", top_ / "way_in");
    inside_ = (top_ / "inside").string();
  }
  void TearDown() override { fs::remove_all(top_); }

  std::string refusal(const std::string& name) const {
    try {
      path_within(inside_, name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path top_;
  std::string inside_;
};

TEST_F(Folders, FilesBelowAreFoundByTheirCanonicalPath) {
  const std::string expected = inside_ + "/a.yaml";
  EXPECT_EQ(expected, path_within(inside_, "a.yaml"));
  EXPECT_EQ(expected, path_within(inside_, "deep/.././a.yaml"));
  EXPECT_EQ(expected, path_within(inside_, "link_within"));
  EXPECT_EQ(expected, path_within(inside_, expected));
  EXPECT_EQ(expected, path_within((top_ / "way_in").string(), "a.yaml"));
  EXPECT_EQ(expected, path_within(inside_, (top_ / "way_in" / "a.yaml").string()));
}

// A file that is to be written does not exist yet.
TEST_F(Folders, FilesThatDoNotExistYetHaveAPlaceToo) {
  EXPECT_EQ(inside_ + "/deep/new", path_within(inside_, "deep/new"));
  EXPECT_EQ(inside_ + "/no/folder", path_within(inside_, "no/folder"));
}

TEST_F(Folders, NothingOutsideIsReached) {
  const std::string outside = (top_ / "inside_not" / "secret").string();
  for (const std::string& name :
       {std::string("../inside_not/secret"), outside, std::string("link_out"), std::string("folder_out/secret"),
        std::string("folder_out/new"), std::string("link_to_nothing"), std::string("link_to_nothing/x"),
        std::string("loop"), std::string("no/../../inside_not/secret"), std::string("/etc/passwd"),
        std::string("deep/../../inside"), std::string("."), std::string("..")}) {
    EXPECT_NE(std::string::npos, refusal(name).find("outside of " + inside_)) << name << ": " << refusal(name);
  }
}

TEST_F(Folders, NamesThatCutThemselvesShortAreRefused) {
  EXPECT_NE(std::string::npos, refusal("").find("name of a file is needed"));
  EXPECT_NE(std::string::npos, refusal(std::string("a.yaml\0/x", 9)).find("zero byte"));
  EXPECT_NE(std::string::npos, refusal(std::string(5000, 'x')).find("longer than 4096"));
}

TEST_F(Folders, ARefusalDoesNotTellWhetherTheFileExists) {
  std::string there = refusal("../inside_not/secret"), not_there = refusal("../inside_not/sesame");
  there.replace(there.find("secret"), 6, "X");
  not_there.replace(not_there.find("sesame"), 6, "X");
  EXPECT_EQ(there, not_there);
}

TEST_F(Folders, AFolderThatDoesNotExistAllowsNothing) {
  EXPECT_THROW(path_within(inside_ + "/none", "a.yaml"), InputError);
  EXPECT_THROW(AllowedPaths({inside_ + "/none"}).check("/etc/passwd"), InputError);
  EXPECT_THROW(AllowedPaths(std::vector<std::string>{}).check("a.yaml"), InputError);
}

TEST_F(Folders, AnyOfSeveralFoldersWillDo) {
  const AllowedPaths paths({inside_ + "/deep", inside_});
  EXPECT_EQ(inside_ + "/a.yaml", paths.check(inside_ + "/a.yaml"));
  EXPECT_EQ(inside_ + "/deep/b", paths.check("b"));
  EXPECT_EQ(inside_ + "/a.yaml", paths.check("../a.yaml"));
  EXPECT_THROW(paths.check((top_ / "inside_not" / "secret").string()), InputError);
}

TEST_F(Folders, WithoutFoldersEveryPathStaysAsItIs) {
  EXPECT_EQ("../x//y", AllowedPaths().check("../x//y"));
}

}  // namespace
}  // namespace deformable_sim
