// Where scenes and the package's own files lie.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"
#include "schema.h"

namespace deformable_sim {
namespace fs = std::filesystem;

std::string package_dir() {
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const fs::path prefix = executable.parent_path().parent_path().parent_path();
    const fs::path share = prefix / "share" / "deformable_sim";
    if (fs::is_directory(share / "config" / "scenes", error)) return share.string();
  }
  return DEFORMABLE_SIM_PACKAGE_DIR;
}

std::string default_scene_dir() {
  const char* given = std::getenv("DEFORMABLE_SIM_SCENES");
  return given && *given ? given : package_dir() + "/config/scenes";
}

std::vector<std::string> scene_names(const std::string& scene_dir) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator it(scene_dir, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == ".yaml") names.push_back(it->path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string find_scene(const std::string& name_or_file, const std::string& scene_dir, const AllowedPaths& files) {
  std::error_code error;
  const fs::path given(name_or_file);
  const bool bare = name_or_file.find('/') == std::string::npos && !given.has_extension();
  fs::path path = bare ? fs::path(scene_dir) / (name_or_file + ".yaml") : given;
  if (!name_or_file.empty()) path = files.check(path.string());
  if (!name_or_file.empty() && fs::exists(path, error) && !fs::is_directory(path, error)) return path.string();
  const std::vector<std::string> names = scene_names(scene_dir);
  throw InputError("no scene '" + name_or_file + "'" + (bare ? " in " + scene_dir : "") + "; there is " +
                       (names.empty() ? "none" : join(names)) + "; or give the path of a file",
                   Code::kNotFound);
}

}  // namespace deformable_sim
