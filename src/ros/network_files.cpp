#include "deformable_sim/ros/network_files.h"

#include <filesystem>
#include <vector>

#include <ros/package.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {

namespace {

namespace fs = std::filesystem;

bool take_scheme(const std::string& scheme, std::string* url) {
  if (url->rfind(scheme, 0) != 0) return false;
  url->erase(0, scheme.size());
  return true;
}

}  // namespace

AllowedPaths network_files(const Parameters& parameters) {
  std::vector<std::string> folders{parameters.scene_dir, package_dir()};
  const fs::path scene = fs::canonical(find_scene(parameters.scene, parameters.scene_dir));
  if (scene.parent_path() != scene.root_path()) folders.push_back(scene.parent_path().string());
  for (const std::string& folder : parameters.allowed_dirs) {
    if (!fs::is_directory(folder)) throw InputError("parameter ~allowed_dirs: no folder " + printable(folder));
    folders.push_back(folder);
  }
  return AllowedPaths(folders);
}

std::string path_of_url(const std::string& url, const AllowedPaths& files) {
  std::string rest = url;
  if (take_scheme("package://", &rest)) {
    const std::size_t slash = rest.find('/');
    if (slash == std::string::npos) throw InputError("'" + printable(url) + "': a file of the package is needed");
    const std::string name = rest.substr(0, slash);
    check_name("package", name);
    const std::string folder = ros::package::getPath(name);
    if (folder.empty()) throw InputError("package '" + name + "' is not found", Code::kNotFound);
    return files.check(folder + rest.substr(slash));
  }
  if (!take_scheme("file://", &rest) && rest.find("://") != std::string::npos) {
    throw InputError("'" + printable(url) + "': a path, file:// or package:// is allowed");
  }
  return files.check(rest);
}

}  // namespace deformable_sim
