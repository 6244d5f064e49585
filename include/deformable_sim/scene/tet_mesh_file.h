// Volumes of tetrahedra from files.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/topology/tet_mesh.h"

namespace deformable_sim {

/// Whether the extension is one that load_tet_mesh() reads: .msh, .mesh, .node, .ele.
bool is_tet_mesh_file(const std::string& path);

/// The files that are opened where `path` is named: itself, or both of a TetGen pair.
std::vector<std::string> tet_mesh_parts(const std::string& path);

/// Reads linear tetrahedra from ASCII text: Gmsh .msh (versions 2.2 and 4.1), MEDIT .mesh, or a TetGen pair .node and
/// .ele, of which `path` names either. Nodes are numbered in the order of the file; `scale` is metres per unit of the
/// file. Other elements of the file (points, lines, triangles) are skipped. A file whose tetrahedra are all wound the
/// other way, as TetGen does, is turned.
///
/// Throws InputError "file:line: what": missing, binary, truncated, a number that is none, a node that does not exist,
/// a tetrahedron without volume or wound against the others, a node that no tetrahedron uses, second order elements.
TetMesh load_tet_mesh(const std::string& path, double scale);

}  // namespace deformable_sim
