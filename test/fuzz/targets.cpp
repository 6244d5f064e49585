#include "fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "../../src/scene/body_rules.h"
#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/material_library.h"
#include "deformable_sim/scene/mesh_file.h"
#include "deformable_sim/scene/octomap_file.h"
#include "deformable_sim/scene/tet_mesh_file.h"

namespace deformable_sim {
namespace fuzz {
namespace {

// What is larger is loaded and not built: a fuzzer lives on many inputs.
constexpr double kMostNodes = 100;
constexpr size_t kBuiltOneIn = 4;      // of what loads, by what it says: the loader is what most changes concern
constexpr double kLeastLattice = 0.2;  // m
constexpr size_t kMostColliderFaces = 24;
constexpr int kMostIterations = 30;
constexpr int kMostLinearIterations = 300;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

/// Messages go to terminals, logs and ROS clients: one line of moderate length.
void check_message(const std::string& message) {
  require(!message.empty() && message.size() < 4000, "the refusal is no line of moderate length");
  require(message.find('\n') == std::string::npos, "the refusal is more than one line: " + message);
}

template <class Action>
bool accepted(const Action& action) {
  try {
    action();
    return true;
  } catch (const InputError& error) {
    check_message(error.what());
    return false;
  }
}

bool is_small(const SceneSpec& spec) {
  double nodes = 0.0;
  for (const BodySpec& body : spec.bodies) {
    nodes += expected_nodes(body) * body.cloth.upsample;
    if (!body.mesh.empty() && body.soft.lattice_cell && *body.soft.lattice_cell < kLeastLattice) return false;
  }
  return nodes <= kMostNodes && spec.step.solver.newton_iterations <= kMostIterations &&
         spec.step.solver.linear_iterations <= kMostLinearIterations;
}

/// Explicit schemes cut a step into stable parts, 100 000 of them at most: a short one keeps that from taking long.
void shorten_explicit_step(SceneSpec* spec) {
  const std::string& name = spec->step.integrator;
  const bool implicit = name.find("implicit") != std::string::npos || name.find("bdf2") != std::string::npos;
  if (implicit && spec->step.mode == SolverMode::kManual) return;
  spec->step.dt = std::min(spec->step.dt, 1e-5);
  spec->step.dt_given = true;
}

/// A folder of this process.
class Scratch {
 public:
  Scratch() : folder_(std::filesystem::temp_directory_path() / ("deformable_sim_fuzz_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string folder() const { return folder_.string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }

 private:
  std::filesystem::path folder_;
};

const Scratch& scratch() {
  static const Scratch kScratch;
  return kScratch;
}

std::vector<std::string> split(const std::string& text) {
  const std::string border = "\n%%\n";
  std::vector<std::string> parts;
  size_t at = 0;
  for (size_t end; (end = text.find(border, at)) != std::string::npos; at = end + border.size()) {
    parts.push_back(text.substr(at, end - at + 1));
  }
  parts.push_back(text.substr(at));
  return parts;
}

void check_triangles(const TriangleMesh& mesh) {
  for (const auto& triangle : mesh.triangles) {
    for (const int node : triangle) require(node >= 0 && node < mesh.rest.cols(), "a triangle names no vertex");
  }
}

void try_triangles(const std::string& format, const std::string& bytes) {
  TriangleMesh mesh;
  if (!accepted([&] { mesh = faces_from_bytes(bytes, "fuzz." + format, Vec3::Ones()); })) return;
  check_triangles(mesh);
  accepted([&] { check_mesh(mesh); });
  if (mesh.triangles.size() <= kMostColliderFaces) accepted([&] { make_collider_meshes(mesh, {}); });
}

void try_tetrahedra(const std::string& format, const std::string& bytes) {
  std::string path;
  if (format == "tetgen") {
    const std::vector<std::string> parts = split(bytes);
    path = scratch().write("fuzz.node", parts[0]);
    scratch().write("fuzz.ele", parts.size() > 1 ? parts[1] : "");
  } else {
    path = scratch().write("fuzz." + format, bytes);
  }
  accepted([&] {
    const TetMesh mesh = load_tet_mesh(path, 1.0);
    require(mesh.rest.allFinite(), "a node is not finite");
    for (const auto& tet : mesh.tets) {
      for (const int node : tet) require(node >= 0 && node < mesh.rest.cols(), "a tetrahedron names no node");
    }
  });
}

}  // namespace

void try_scene(const std::string& text) {
  const std::string folder = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data";
  static const AllowedPaths kFiles({folder});
  SceneSpec spec;
  if (!accepted([&] { spec = load_scene_text(text, folder + "/fuzz.yaml", {}, kFiles); })) return;
  if (!is_small(spec) || std::hash<std::string>()(text) % kBuiltOneIn != 0) return;
  shorten_explicit_step(&spec);
  std::unique_ptr<World> world;
  if (!accepted([&] { world = build_world(spec); })) return;
  if (world->state().x.cols() > kMostNodes) return;
  for (int k = 0; k < 2; ++k) {
    world->step();
    require(world->state().x.allFinite() && world->state().v.allFinite(), "a node is not finite after a step");
  }
}

void try_mesh(const std::string& bytes) {
  const size_t end = std::min(bytes.find('\n'), bytes.size());
  const std::string format = bytes.substr(0, end), rest = bytes.substr(std::min(end + 1, bytes.size()));
  if (format == "obj" || format == "stl" || format == "ply" || format == "dae") try_triangles(format, rest);
  if (format == "msh" || format == "mesh" || format == "tetgen") try_tetrahedra(format, rest);
}

void try_octomap(const std::string& bytes) {
  accepted([&] { octomap_from_bytes(bytes, "fuzz.bt"); });
}

void try_materials(const std::string& text) {
  std::vector<std::string> parts = split(text);
  parts.resize(3);
  const char* const names[] = {"solids.yaml", "fabrics.yaml", "ropes.yaml"};
  for (size_t k = 0; k < 3; ++k) scratch().write(names[k], parts[k]);
  accepted([&] { load_material_library(scratch().folder()); });
}

}  // namespace fuzz
}  // namespace deformable_sim
