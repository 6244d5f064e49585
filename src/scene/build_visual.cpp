// Visual surfaces of bodies.
#include "build_parts.h"
#include "deformable_sim/core/topology/skin.h"
#include "deformable_sim/scene/mesh_file.h"

namespace deformable_sim {

void add_visual(const VisualSpec& spec, Body* body) {
  if (spec.mesh.empty()) return;
  try {
    const TriangleMesh surface = load_mesh(spec.mesh, spec.mesh_scale);
    body->skin = body->volume ? make_skin(surface, *body->volume) : make_skin(surface, body->surface);
  } catch (const InputError& error) {
    const std::string line = spec.where.line > 0 ? ":" + std::to_string(spec.where.line) : "";
    throw PlacedError(spec.where.file + line + ": " + spec.path + ": " + error.what(), error.code());
  }
}

}  // namespace deformable_sim
