// Entries of the tables of real materials as the materials of a scene.
#pragma once

#include <string>

#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Each replaces what the entry says something about. Throws InputError naming the nearest entries.
void start_from_fabric(const std::string& name, ClothMaterialSpec* out);
void start_from_rope(const std::string& name, RopeMaterialSpec* out);
void start_from_solid(const std::string& name, SoftMaterialSpec* out);

}  // namespace deformable_sim
