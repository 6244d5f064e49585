#include "deformable_sim/core/whole_file.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace deformable_sim {
namespace {

bool write_all(int handle, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(handle, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return fsync(handle) == 0;
}

/// The name itself reaches the disk with its folder.
void sync_folder(const std::filesystem::path& folder) {
  const int handle = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  fsync(handle);
  close(handle);
}

}  // namespace

std::string write_whole_file(const std::string& path, std::string_view bytes) {
  const auto went_wrong = [&path](const char* what) { return std::string(what) + " " + path + ": " + strerror(errno); };
  std::error_code error;
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::filesystem::create_directories(folder, error);
  std::string scratch = path + ".XXXXXX";
  const int handle = mkstemp(scratch.data());
  if (handle < 0) return went_wrong("cannot write");
  // As a file made in the ordinary way, not for its owner alone.
  const mode_t mask = umask(0);
  umask(mask);
  fchmod(handle, 0666 & ~mask);
  const bool whole = write_all(handle, bytes);
  std::string problem = whole ? "" : went_wrong("cannot write");
  close(handle);
  if (whole && std::rename(scratch.c_str(), path.c_str()) != 0) problem = went_wrong("cannot replace");
  if (!problem.empty()) {
    unlink(scratch.c_str());
    return problem;
  }
  sync_folder(folder);
  return "";
}

}  // namespace deformable_sim
