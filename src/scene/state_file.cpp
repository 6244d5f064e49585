#include "deformable_sim/scene/state_file.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/whole_file.h"

namespace deformable_sim {
namespace {

/// To be raised when files come to look otherwise.
constexpr std::uint32_t kVersion = 1;

struct Header {
  char magic[8] = {'d', 's', 'i', 'm', 's', 't', 'a', 't'};
  std::uint32_t version = kVersion;
  std::uint32_t byte_order = 0x01020304;
  std::uint64_t length = 0;    // bytes, of what follows
  std::uint64_t checksum = 0;  // of what follows
};

void pass(Archive* archive, SavedState* state) {
  archive->pass(&state->scene);
  archive->pass(&state->time);
  archive->pass(&state->script);
  archive->pass(&state->world);
  archive->pass(&state->frames);
}

/// Throws InputError when `bytes` in all cannot be what begins so.
void check(const Header& header, std::uint64_t bytes) {
  const Header expected;
  if (std::memcmp(header.magic, expected.magic, sizeof expected.magic) != 0) {
    throw InputError("no saved simulation");
  }
  if (header.byte_order != expected.byte_order) throw InputError("saved on a machine of another byte order");
  if (header.version != kVersion) {
    throw InputError("of version " + std::to_string(header.version) + "; this package reads version " +
                     std::to_string(kVersion));
  }
  if (header.length != bytes - sizeof header) {
    throw InputError("cut: " + std::to_string(bytes - sizeof header) + " bytes of " + std::to_string(header.length));
  }
}

}  // namespace

std::string state_bytes(const SavedState& state) {
  Archive archive;
  SavedState copy = state;
  pass(&archive, &copy);
  Header header;
  header.length = archive.bytes().size();
  header.checksum = checksum(archive.bytes().data(), archive.bytes().size());
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  return bytes += archive.bytes();
}

SavedState read_state(const std::string& bytes) {
  Header header;
  if (bytes.size() < sizeof header) throw InputError("no saved simulation");
  std::memcpy(&header, bytes.data(), sizeof header);
  check(header, bytes.size());
  if (header.checksum != checksum(bytes.data() + sizeof header, bytes.size() - sizeof header)) {
    throw InputError("altered: its checksum is another");
  }
  Archive archive(bytes.substr(sizeof header));
  SavedState state;
  pass(&archive, &state);
  archive.end();
  return state;
}

void write_state_file(const std::string& path, const SavedState& state) {
  const std::string problem = write_whole_file(path, state_bytes(state));
  if (!problem.empty()) throw InputError(problem, Code::kUnavailable);
}

SavedState read_state_file(const std::string& path) {
  std::error_code error;
  const auto length = std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error) : 0;
  std::ifstream in(path, std::ios::binary);
  if (error || !in || !std::filesystem::is_regular_file(path)) {
    throw InputError(path + ": cannot be read", Code::kNotFound);
  }
  try {
    Header header;
    if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) throw InputError("no saved simulation");
    check(header, length);
    std::string bytes(length, '\0');
    in.seekg(0);
    if (!in.read(bytes.data(), static_cast<std::streamsize>(length))) throw InputError("cannot be read");
    return read_state(bytes);
  } catch (const InputError& wrong) {
    throw InputError(path + ": " + wrong.what(), wrong.code());
  }
}

}  // namespace deformable_sim
