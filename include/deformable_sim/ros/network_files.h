// Files that requests name: scenes, and the meshes and octomaps of scenes and obstacles.
#pragma once

#include <string>

#include "deformable_sim/ros/parameters.h"
#include "deformable_sim/scene/allowed_paths.h"

namespace deformable_sim {

/// What requests may name: files below ~scene_dir, this package's share directory, the folder of the scene the node was
/// started with (unless that is the root of the file system), and ~allowed_dirs. Throws InputError when that scene, or
/// one of ~allowed_dirs, does not exist.
AllowedPaths network_files(const Parameters& parameters);

/// The path to open of a path, a file:// or a package:// URL. Throws InputError: other schemes, an unknown package
/// (kNotFound), a file that `files` do not allow.
std::string path_of_url(const std::string& url, const AllowedPaths& files);

}  // namespace deformable_sim
