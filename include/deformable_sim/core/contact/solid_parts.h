// Closed solids out of a bag of triangles: what a collision mesh must be before anything asks what is inside it.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// One connected closed surface, wound counter-clockwise seen from outside.
struct SolidPart {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 3>> neighbours;  // the triangle across edge k, from vertex k to vertex k + 1
};

/// Welds vertices at exactly the same place, mends triangles without area (drops them, cutting their neighbours where a
/// vertex lies on a side), and splits the rest where it hangs together by a vertex only. Each part is turned so that
/// its normals look outwards, whatever its winding was: a cavity counts as a solid of its own inside another, so it is
/// filled. Parts may overlap.
///
/// Throws InputError naming the triangle or edge: no triangle, more than kMostColliderTriangles (kOutOfRange), an index
/// that is not a vertex, a coordinate that is not finite or beyond 1e6 m, over 1000 triangles without area, an edge
/// with one triangle (the mesh is not closed) or more than two, a surface with one side only, a part that encloses
/// nothing.
std::vector<SolidPart> split_into_solids(const TriangleMesh& mesh);

constexpr int kMostColliderTriangles = 200000;

}  // namespace deformable_sim
