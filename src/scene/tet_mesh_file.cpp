#include "deformable_sim/scene/tet_mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <unordered_map>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/spec.h"
#include "mesh_text.h"

namespace deformable_sim {
namespace {

constexpr long kMaxTets = 8L * kMaxNodes;
constexpr long kMaxTag = 1L << 40;
constexpr double kFlat = 1e-9;  // of the cube of the longest edge: a tetrahedron of less volume counts as flat

std::string extension_of(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Nodes by the numbers that a file gives them, and tetrahedra of those; every one with its line.
class TetCollector {
 public:
  void add_node(const MeshText& text, long tag, const Vec3& at) {
    if (nodes_.size() >= static_cast<size_t>(kMaxNodes)) {
      text.refuse("more than " + std::to_string(kMaxNodes) + " nodes");
    }
    if (!index_of_.emplace(tag, static_cast<int>(nodes_.size())).second) {
      text.refuse("node " + std::to_string(tag) + " is given twice");
    }
    nodes_.push_back({tag, at, text.line()});
  }

  void read_tet(MeshText* text) {
    Tet tet{{}, 0};
    for (int& node : tet.node) {
      const long tag = text->integer("a node of a tetrahedron", 0, kMaxTag);
      const auto found = index_of_.find(tag);
      if (found == index_of_.end()) text->refuse("there is no node " + std::to_string(tag));
      node = found->second;
    }
    tet.line = text->line();
    if (tets_.size() >= static_cast<size_t>(kMaxTets)) {
      text->refuse("more than " + std::to_string(kMaxTets) + " tetrahedra");
    }
    tets_.push_back(tet);
  }

  /// `elements` and `nodes` are the texts that tetrahedra and nodes came from.
  TetMesh mesh(const MeshText& elements, const MeshText& nodes, double scale) {
    if (tets_.empty()) elements.refuse("the file ends without a tetrahedron");
    turn_to_positive(elements);
    check_all_used(nodes);
    TetMesh mesh;
    mesh.rest.resize(3, static_cast<Eigen::Index>(nodes_.size()));
    for (size_t k = 0; k < nodes_.size(); ++k) mesh.rest.col(static_cast<Eigen::Index>(k)) = scale * nodes_[k].at;
    for (const Tet& tet : tets_) mesh.tets.push_back(tet.node);
    return mesh;
  }

 private:
  struct Node {
    long tag;
    Vec3 at;
    int line;
  };
  struct Tet {
    std::array<int, 4> node;
    int line;
  };

  const Vec3& at(int node) const { return nodes_[static_cast<size_t>(node)].at; }

  /// 6 V, positive when the corners are in the order of TetMesh; 0 when flat.
  double volume(const Tet& tet) const {
    const auto& n = tet.node;
    const Vec3 u = at(n[1]) - at(n[0]), v = at(n[2]) - at(n[0]), w = at(n[3]) - at(n[0]);
    const double longest = std::max({u.norm(), v.norm(), w.norm(), (v - u).norm(), (w - u).norm(), (w - v).norm()});
    const double six_volumes = u.cross(v).dot(w);
    return std::abs(six_volumes) > kFlat * longest * longest * longest ? six_volumes : 0.0;
  }

  void turn_to_positive(const MeshText& text) {
    size_t positive = 0;
    for (const Tet& tet : tets_) {
      const double six_volumes = volume(tet);
      if (six_volumes == 0.0) text.refuse_at(tet.line, "the tetrahedron has no volume");
      positive += six_volumes > 0.0;
    }
    const bool most = 2 * positive >= tets_.size();
    for (Tet& tet : tets_) {
      if ((volume(tet) > 0.0) != most) {
        text.refuse_at(tet.line, "the tetrahedron is inverted: wound against the others");
      }
      if (!most) std::swap(tet.node[0], tet.node[1]);
    }
  }

  void check_all_used(const MeshText& text) const {
    std::vector<char> used(nodes_.size(), 0);
    for (const Tet& tet : tets_) {
      for (const int node : tet.node) used[static_cast<size_t>(node)] = 1;
    }
    for (size_t k = 0; k < nodes_.size(); ++k) {
      if (!used[k]) {
        text.refuse_at(nodes_[k].line, "node " + std::to_string(nodes_[k].tag) +
                                           " belongs to no tetrahedron and would fall on its own; save the mesh "
                                           "without such nodes");
      }
    }
  }

  std::unordered_map<long, int> index_of_;
  std::vector<Node> nodes_;
  std::vector<Tet> tets_;
};

void read_node(MeshText* text, long tag, TetCollector* out) {
  Vec3 at;
  for (int k = 0; k < 3; ++k) at[k] = text->number("a coordinate");
  out->add_node(*text, tag, at);
}

constexpr int kGmshTet = 4;
constexpr int kGmshQuadraticTet = 11;

/// A tetrahedron, or nothing when the element is of another type.
void read_gmsh_element(MeshText* text, long type, TetCollector* out) {
  if (type == kGmshQuadraticTet) {
    text->refuse(
        "second order tetrahedra are not read; save the mesh with first order elements: `element: "
        "quadratic_tetrahedron` in the scene adds the middle nodes itself");
  }
  if (type == kGmshTet) out->read_tet(text);
  text->skip_line();
}

void read_gmsh_4(MeshText* text, const std::string& section, TetCollector* out) {
  const long blocks = text->integer("the number of blocks", 0, kMaxTag);
  text->skip_line();
  for (long b = 0; b < blocks; ++b) {
    text->word("a block");
    text->word("the tag of an entity");
    if (section == "$Nodes") {
      text->word("whether nodes are parametric");
      const long count = text->integer("the number of nodes", 0, kMaxNodes);
      std::vector<long> tags;
      for (long k = 0; k < count; ++k) tags.push_back(text->integer("the tag of a node", 1, kMaxTag));
      for (const long tag : tags) {
        read_node(text, tag, out);
        text->skip_line();
      }
    } else {
      const long type = text->integer("the type of an element", 1, 1000);
      const long count = text->integer("the number of elements", 0, kMaxTets);
      for (long k = 0; k < count; ++k) {
        text->word("the tag of an element");
        read_gmsh_element(text, type, out);
      }
    }
  }
}

void read_gmsh_2(MeshText* text, const std::string& section, TetCollector* out) {
  const bool nodes = section == "$Nodes";
  const long count = text->integer("the number of " + section.substr(1), 0, nodes ? kMaxNodes : kMaxTets);
  for (long k = 0; k < count; ++k) {
    if (nodes) {
      read_node(text, text->integer("the tag of a node", 1, kMaxTag), out);
      text->skip_line();
      continue;
    }
    text->word("the tag of an element");
    const long type = text->integer("the type of an element", 1, 1000);
    const long tags = text->integer("the number of tags", 0, 100);
    for (long t = 0; t < tags; ++t) text->word("a tag");
    read_gmsh_element(text, type, out);
  }
}

TetMesh load_gmsh(const std::string& path, double scale) {
  MeshText text(path, 0);
  TetCollector out;
  if (text.word("$MeshFormat") != "$MeshFormat") text.refuse("a Gmsh file starts with $MeshFormat");
  const std::string version = text.word("the version");
  if (version != "4.1" && version != "2.2") {
    text.refuse("version " + version.substr(0, 10) + " is not read; allowed: 4.1, 2.2");
  }
  if (text.integer("the file type", 0, 1) != 0) text.refuse("is binary; a text (ASCII) file is allowed");
  while (!text.done()) {
    const std::string section = text.word("a section");
    if (section == "$Nodes" || section == "$Elements") {
      (version == "4.1" ? read_gmsh_4 : read_gmsh_2)(&text, section, &out);
      const std::string end = "$End" + section.substr(1);
      if (text.word(end) != end) text.refuse(end + " should stand here");
    }
  }
  return out.mesh(text, text, scale);
}

TetMesh load_medit(const std::string& path, double scale) {
  MeshText text(path, '#');
  TetCollector out;
  if (text.word("MeshVersionFormatted") != "MeshVersionFormatted") {
    text.refuse("a MEDIT file starts with MeshVersionFormatted");
  }
  text.skip_line();
  while (!text.done()) {
    const std::string keyword = text.word("a keyword");
    if (keyword == "End") break;
    if (keyword == "Dimension") {
      if (text.integer("the dimension", 2, 3) != 3) text.refuse("a volume needs 3 dimensions");
    } else if (keyword == "Vertices") {
      const long count = text.integer("the number of vertices", 0, kMaxNodes);
      for (long k = 0; k < count; ++k) {
        read_node(&text, k + 1, &out);
        text.skip_line();
      }
    } else if (keyword == "Tetrahedra") {
      const long count = text.integer("the number of tetrahedra", 0, kMaxTets);
      for (long k = 0; k < count; ++k) {
        out.read_tet(&text);
        text.skip_line();
      }
    }
  }
  return out.mesh(text, text, scale);
}

TetMesh load_tetgen(const std::string& path, double scale) {
  const std::vector<std::string> parts = tet_mesh_parts(path);
  MeshText nodes(parts[0], '#'), elements(parts[1], '#');
  TetCollector out;
  const long node_count = nodes.integer("the number of nodes", 1, kMaxNodes);
  if (nodes.integer("the dimension", 2, 3) != 3) nodes.refuse("a volume needs 3 dimensions");
  nodes.skip_line();
  for (long k = 0; k < node_count; ++k) {
    read_node(&nodes, nodes.integer("the number of a node", 0, kMaxTag), &out);
    nodes.skip_line();
  }
  const long count = elements.integer("the number of tetrahedra", 1, kMaxTets);
  if (elements.integer("nodes per tetrahedron", 4, 10) != 4) {
    elements.refuse(
        "second order tetrahedra are not read; save the mesh with 4 nodes each: `element: quadratic_tetrahedron` in "
        "the scene adds the middle nodes itself");
  }
  elements.skip_line();
  for (long k = 0; k < count; ++k) {
    elements.word("the number of a tetrahedron");
    out.read_tet(&elements);
    elements.skip_line();
  }
  return out.mesh(elements, nodes, scale);
}

}  // namespace

bool is_tet_mesh_file(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".msh" || extension == ".mesh" || extension == ".node" || extension == ".ele";
}

std::vector<std::string> tet_mesh_parts(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension != ".node" && extension != ".ele") return {path};
  const std::string stem = std::filesystem::path(path).replace_extension().string();
  return {stem + ".node", stem + ".ele"};
}

TetMesh load_tet_mesh(const std::string& path, double scale) {
  const std::string extension = extension_of(path);
  if (extension == ".msh") return load_gmsh(path, scale);
  if (extension == ".mesh") return load_medit(path, scale);
  if (is_tet_mesh_file(path)) return load_tetgen(path, scale);
  throw InputError(path + ": volumes are .msh (Gmsh), .mesh (MEDIT) or .node and .ele (TetGen) files");
}

}  // namespace deformable_sim
