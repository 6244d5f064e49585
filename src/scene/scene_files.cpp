// Where scenes and the package's own files lie.
#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"
#include "schema.h"

namespace deformable_sim {
namespace fs = std::filesystem;

namespace {

/// PREFIX/share/deformable_sim where an installation has its scenes, else empty.
std::string share_of(const fs::path& prefix) {
  std::error_code error;
  const fs::path share = prefix / "share" / "deformable_sim";
  return fs::is_directory(share / "config" / "scenes", error) ? share.string() : "";
}

/// Of the file that this code was loaded from: the library, or a program it was linked into.
fs::path own_file() {
  Dl_info info{};
  const auto* place = reinterpret_cast<const void*>(&share_of);
  return dladdr(place, &info) != 0 && info.dli_fname != nullptr ? fs::path(info.dli_fname) : fs::path();
}

}  // namespace

std::string package_dir() {
  std::error_code error;
  // PREFIX/lib/deformable_sim/simulate; PREFIX/lib/library, or PREFIX/lib/TRIPLET/library; PREFIX/bin/simulate.
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path().parent_path();
  const fs::path library = fs::weakly_canonical(own_file(), error).parent_path().parent_path();
  for (const fs::path& prefix : {program.parent_path(), program, library, library.parent_path()}) {
    const std::string share = prefix.empty() ? "" : share_of(prefix);
    if (!share.empty()) return share;
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
