// Where the bands along hems and seams of a sheet lie.
#pragma once

#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// A half-space: normal . x >= offset, in the rest shape (m).
struct HalfSpace {
  Vec3 normal;
  double offset;
};

/// A rectangle along one border or fold edge, as wide as the band and by as much longer at both ends, so that bends of
/// the border leave no gap. The first two half-spaces end the band's width, the others its length.
struct SeamBand {
  std::array<HalfSpace, 4> bounds;
};

/// Edges with one face, as {a, b, face}, in the direction of the face.
std::vector<std::array<int, 3>> border_edges(const TriangleMesh& mesh);

struct SeamBands {
  std::vector<SeamBand> bands;
  std::vector<std::vector<int>> of_triangle;  // the bands that reach into each triangle
};

/// Bands of a width (m, > 0) along borders, and on both sides of edges where faces turn by more than 60 degrees at
/// rest. They do not cross other borders and folds. Throws InputError (kOutOfRange) beyond `most` reaches into
/// triangles.
SeamBands seam_bands(const TriangleMesh& mesh, double width, size_t most);

}  // namespace deformable_sim
