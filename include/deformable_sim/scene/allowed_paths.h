// Which files a request from the network may name.
#pragma once

#include <string>
#include <vector>

namespace deformable_sim {

/// The canonical path of `name`, which need not exist yet, when it lies below `folder`.
///
/// folder  an existing folder; what links in it point to counts, not where the links lie.
/// name    relative to `folder`, or absolute.
/// Throws InputError: `name` is empty, holds a zero byte, lies outside (through `..`, as an absolute path, or through a
/// link, also one that points to nothing), or `folder` does not exist. A file outside is refused with the same words
/// whether it exists or not.
/// Not good at: links that somebody else changes between this and the opening of the file. The folder must belong to
/// those who run the node.
std::string path_within(const std::string& folder, const std::string& name);

/// Folders below which files may be read. The default allows every file: what a user opens at the machine.
class AllowedPaths {
 public:
  AllowedPaths() = default;

  /// Only what lies below one of these; folders that do not exist allow nothing. Relative names are looked up in the
  /// first.
  explicit AllowedPaths(std::vector<std::string> folders);

  /// The path to open: canonical where folders were given, else `path` as it is. Throws InputError as path_within().
  std::string check(const std::string& path) const;

 private:
  bool all_ = true;
  std::vector<std::string> folders_;
};

}  // namespace deformable_sim
