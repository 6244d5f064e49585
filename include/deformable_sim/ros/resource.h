// Files behind URLs.
#pragma once

#include <string>

namespace deformable_sim {

/// The bytes of a package://, file:// or http:// URL. Throws InputError (kNotFound).
std::string read_resource(const std::string& url);

}  // namespace deformable_sim
