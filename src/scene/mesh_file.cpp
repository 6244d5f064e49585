#include "deformable_sim/scene/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "collada_screen.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/spec.h"
#include "face_files.h"

namespace deformable_sim {
namespace {

constexpr std::uintmax_t kMaxMeshBytes = 256u << 20;

/// Collects faces of all parts of a file, welding vertices by position.
class Welder {
 public:
  void add_faces(const Faces& faces, const Vec3& scale) {
    std::vector<int> node_of(faces.points().size(), -1);
    for (std::array<int, 3> triangle : faces.triangles()) {
      for (int& corner : triangle) {
        int& node = node_of[static_cast<size_t>(corner)];
        const Faces::Point& p = faces.points()[static_cast<size_t>(corner)];
        if (node < 0) node = node_at({p[0], p[1], p[2]}, scale);
        corner = node;
      }
      triangles_.push_back(triangle);
    }
  }

  void add_part(const aiMesh& part, const aiMatrix4x4& root_from_part, const Vec3& scale) {
    std::vector<int> node_of(part.mNumVertices, -1);
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) {
        throw InputError("has a face with " + std::to_string(face.mNumIndices) +
                         " vertices; lines and points are no cloth");
      }
      std::array<int, 3> triangle{};
      for (size_t k = 0; k < 3; ++k) {
        const unsigned vertex = face.mIndices[k];
        if (vertex >= part.mNumVertices) {
          throw InputError("face " + std::to_string(f) + " names vertex " + std::to_string(vertex) + " of " +
                           std::to_string(part.mNumVertices));
        }
        if (node_of[vertex] < 0) node_of[vertex] = node_at(root_from_part * part.mVertices[vertex], scale);
        triangle[k] = node_of[vertex];
      }
      triangles_.push_back(triangle);
    }
  }

  void add_tree(const aiScene& scene, const aiNode& node, const aiMatrix4x4& root_from_parent, const Vec3& scale) {
    const aiMatrix4x4 root_from_node = root_from_parent * node.mTransformation;
    for (unsigned k = 0; k < node.mNumMeshes; ++k) add_part(*scene.mMeshes[node.mMeshes[k]], root_from_node, scale);
    for (unsigned k = 0; k < node.mNumChildren; ++k) add_tree(scene, *node.mChildren[k], root_from_node, scale);
  }

  TriangleMesh mesh() const {
    TriangleMesh result;
    result.rest.resize(3, static_cast<Eigen::Index>(positions_.size()));
    for (size_t k = 0; k < positions_.size(); ++k) result.rest.col(static_cast<Eigen::Index>(k)) = positions_[k];
    result.triangles = triangles_;
    return result;
  }

 private:
  /// Ordered by bits, so that even a vertex that is not a number has its place (check_mesh refuses it by its index).
  using Bits = std::array<std::uint32_t, 3>;

  int node_at(const aiVector3D& p, const Vec3& scale) {
    const float coordinates[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 becomes +0
    Bits bits;
    std::memcpy(bits.data(), coordinates, sizeof bits);
    const auto added = node_at_.emplace(bits, static_cast<int>(positions_.size()));
    if (added.second) {
      if (positions_.size() >= static_cast<size_t>(kMaxNodes)) {
        throw InputError("has more than " + std::to_string(kMaxNodes) + " vertices", Code::kOutOfRange);
      }
      positions_.push_back(scale.cwiseProduct(Vec3(p.x, p.y, p.z)));
    }
    return added.first->second;
  }

  std::map<Bits, int> node_at_;
  std::vector<Vec3> positions_;
  std::vector<std::array<int, 3>> triangles_;
};

/// In lower case, with its dot; refuses what is no mesh.
std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const std::vector<std::string> known{".obj", ".stl", ".ply", ".dae"};
  if (std::find(known.begin(), known.end(), extension) == known.end()) {
    throw InputError(path + ": meshes are OBJ, STL, PLY or DAE files");
  }
  return extension;
}

void check_size(const std::string& path, std::uintmax_t bytes) {
  if (bytes > kMaxMeshBytes) {
    throw InputError(path + ": larger than " + std::to_string(kMaxMeshBytes >> 20) + " MiB", Code::kOutOfRange);
  }
}

/// A mesh is one file: whatever else it names stays closed.
class NoFiles : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

void add_collada(const std::string& bytes, const Vec3& scale, Welder* welder) {
  screen_collada(bytes);
  Assimp::Importer importer;
  importer.SetIOHandler(new NoFiles);  // the importer owns it
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, "dae");
  if (!scene || !scene->mRootNode) throw InputError(std::string("not a readable mesh: ") + importer.GetErrorString());
  welder->add_tree(*scene, *scene->mRootNode, aiMatrix4x4(), scale);
}

std::string read_bytes(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path + ": no such mesh file", Code::kNotFound);
  extension_of(path);
  check_size(path, std::filesystem::file_size(path, error));
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path + ": cannot be read", Code::kNotFound);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace

TriangleMesh load_faces(const std::string& path, const Vec3& scale) {
  return faces_from_bytes(read_bytes(path), path, scale);
}

TriangleMesh faces_from_bytes(const std::string& bytes, const std::string& name, const Vec3& scale) {
  const std::string extension = extension_of(name);
  check_size(name, bytes.size());
  Welder welder;
  try {
    if (extension == ".dae") {
      add_collada(bytes, scale, &welder);
    } else {
      const auto read = extension == ".obj" ? read_obj : extension == ".stl" ? read_stl : read_ply;
      welder.add_faces(read(bytes, name), scale);
    }
    TriangleMesh mesh = welder.mesh();
    if (mesh.triangles.empty()) throw InputError("has no faces");
    return mesh;
  } catch (const InputError& error) {
    const std::string what = error.what();
    throw InputError(what.rfind(name, 0) == 0 ? what : name + ": " + what, error.code());
  }
}

TriangleMesh load_mesh(const std::string& path, double scale) {
  TriangleMesh mesh = load_faces(path, Vec3::Constant(scale));
  try {
    check_mesh(mesh);
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what(), error.code());
  }
  return mesh;
}

}  // namespace deformable_sim
