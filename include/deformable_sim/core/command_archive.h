// Commands as bytes.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/command.h"

namespace deformable_sim {

/// Every number to the last bit, meshes whole.
std::string command_bytes(const Command& command);

/// `known`: colliders whose meshes need not be built anew where the command's are the same. Throws InputError: bytes
/// that command_bytes() did not write.
Command read_command(const std::string& bytes, const std::vector<Collider>& known);

}  // namespace deformable_sim
