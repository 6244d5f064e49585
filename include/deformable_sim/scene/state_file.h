// Saved simulations as files.
#pragma once

#include <cstdint>
#include <string>

namespace deformable_sim {

/// A simulation at one instant: what World::save() gives, and what plays beside the world.
struct SavedState {
  std::string scene;         // file or title, for messages
  double time = 0.0;         // s, simulated
  std::uint64_t script = 0;  // events of the scene's script that were played
  std::string world;         // World::save()
  std::string frames;        // what follows tf, of the node; may be empty
};

/// As bytes with version, length and checksum.
std::string state_bytes(const SavedState& state);
/// Throws InputError saying what is wrong: no such bytes, another version or byte order, cut, altered.
SavedState read_state(const std::string& bytes);

/// A file that is there as a whole or not at all, whenever the process is killed. Throws InputError (kUnavailable) when
/// it cannot be written.
void write_state_file(const std::string& path, const SavedState& state);
/// Throws InputError naming the file. Nothing is read of a file whose length is not what its first bytes say.
SavedState read_state_file(const std::string& path);

}  // namespace deformable_sim
