#include "deformable_sim/scene/allowed_paths.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "deformable_sim/core/error.h"
#include "schema.h"

namespace deformable_sim {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestPath = 4096;  // bytes, as the kernel has it
constexpr std::size_t kMostQuoted = 80;

/// What a message shows of a name that came over the network.
std::string quoted(const std::string& name) {
  std::string text;
  for (const char c : name.substr(0, kMostQuoted)) text += c >= ' ' && c < 0x7f ? c : '?';
  return "'" + text + (name.size() > kMostQuoted ? "...'" : "'");
}

bool is_below(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end() && path != folder;
}

/// With all links followed, or empty: a link that points to nothing or to itself, a part that may not be searched.
fs::path follow_links(const fs::path& path) {
  std::error_code error;
  const fs::path followed = fs::weakly_canonical(path, error);
  if (error) return {};
  // What does not exist was appended as it stood; a link to nothing is among that.
  fs::path part;
  for (const fs::path& name : followed) {
    part /= name;
    if (fs::is_symlink(fs::symlink_status(part, error))) return {};
  }
  return followed;
}

void check_name_of_file(const std::string& name) {
  if (name.empty()) throw InputError("the name of a file is needed");
  if (name.find('\0') != std::string::npos) throw InputError("file " + quoted(name) + ": a zero byte in its name");
  if (name.size() > kLongestPath) {
    throw InputError("file " + quoted(name) + ": its name is longer than " + std::to_string(kLongestPath) + " bytes");
  }
}

/// The canonical path, or empty when it is not below `folder`.
fs::path find_within(const fs::path& folder, const std::string& name) {
  const fs::path path = follow_links(folder / name);  // an absolute name replaces the folder
  return is_below(folder, path) ? path : fs::path();
}

}  // namespace

std::string path_within(const std::string& folder, const std::string& name) {
  check_name_of_file(name);
  std::error_code error;
  const fs::path canonical = fs::canonical(folder, error);
  if (error || !fs::is_directory(canonical, error)) {
    throw InputError("folder " + folder + " does not exist", Code::kNotFound);
  }
  const fs::path path = find_within(canonical, name);
  if (path.empty()) throw InputError("file " + quoted(name) + ": outside of " + folder + ", where files may lie");
  return path.string();
}

AllowedPaths::AllowedPaths(std::vector<std::string> folders) : all_(false) {
  for (const std::string& folder : folders) {
    std::error_code error;
    const fs::path canonical = fs::canonical(folder, error);
    if (!error && fs::is_directory(canonical, error)) folders_.push_back(canonical.string());
  }
}

std::string AllowedPaths::check(const std::string& path) const {
  if (all_) return path;
  check_name_of_file(path);
  for (const std::string& folder : folders_) {
    const fs::path found = find_within(folder, fs::path(path).is_absolute() ? path : folders_.front() + "/" + path);
    if (!found.empty()) return found.string();
  }
  throw InputError("file " + quoted(path) + ": outside of the folders whose files may be named: " +
                   (folders_.empty() ? "none" : join(folders_)));
}

}  // namespace deformable_sim
