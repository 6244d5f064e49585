#include "deformable_sim/scene/collider_file.h"

#include <cstdlib>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/mesh_file.h"

namespace deformable_sim {

std::string cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache == '/') return std::string(cache) + "/deformable_sim";
  const char* home = std::getenv("HOME");
  if (home && *home == '/') return std::string(home) + "/.cache/deformable_sim";
  return "";
}

std::vector<Shape> mesh_shapes(const TriangleMesh& mesh, double padding, const DistanceGrid::Progress& progress) {
  MeshBuild build;
  build.cache_folder = cache_folder();
  build.progress = progress;
  std::vector<Shape> shapes;
  for (const auto& solid : make_collider_meshes(mesh, build)) {
    Shape shape;
    shape.type = Shape::Type::kMesh;
    shape.size = Vec3(padding, 0, 0);
    shape.mesh = solid;
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

std::vector<Shape> load_collider_mesh(const std::string& path, const Vec3& scale, double padding,
                                      const DistanceGrid::Progress& progress) {
  const TriangleMesh mesh = load_faces(path, scale);
  try {
    return mesh_shapes(mesh, padding, progress);
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what(), error.code());
  }
}

}  // namespace deformable_sim
