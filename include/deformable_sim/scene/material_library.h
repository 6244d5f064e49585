// The tables of real materials in config/materials, by name.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "deformable_sim/core/material/real_materials.h"

namespace deformable_sim {

/// Three kinds of material; names are unique over all of them.
struct MaterialLibrary {
  std::vector<SolidData> solids;
  std::vector<FabricData> fabrics;
  std::vector<RopeData> ropes;

  /// Throw InputError (kNotFound) naming the nearest entries, and the right kind when the name is of another.
  const SolidData& solid(const std::string& name) const;
  const FabricData& fabric(const std::string& name) const;
  const RopeData& rope(const std::string& name) const;
  std::variant<SolidData, FabricData, RopeData> find(const std::string& name) const;
  /// All names: solids, fabrics, ropes, each in the order of its table.
  std::vector<std::string> names() const;
};

/// Reads solids.yaml, fabrics.yaml and ropes.yaml of a folder. Throws InputError: "file:line: key: what".
MaterialLibrary load_material_library(const std::string& folder);
/// config/materials of the package, installed or not.
std::string default_material_dir();

/// doc/materials.md: the tables as a page.
std::string material_reference(const MaterialLibrary& library);

}  // namespace deformable_sim
