// Sees to it that no two pieces of surfaces cross in a step.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/contact/surface_pieces.h"

namespace deformable_sim {

/// Two pieces apart at the start of a step have a plane between them, of normal n. If some plane of the same normal
/// lies between them at the end, then one that moves evenly lay between them all the while, as their corners moved
/// along straight lines: nothing has crossed. keep_apart() sees to that for every two pieces, whatever the time scheme
/// has made of their contacts. n is one of unit_directions(), or across the shortest connection at the start or at the
/// end; whoever finds no such plane is moved to its side of the one across the connection at the start.
///
/// Not good at: long steps of fast rotation, in which no plane of one normal stands between at both ends; pieces that
/// cross at the start, which are not seen until they have come apart.
class CrossingGuard {
 public:
  CrossingGuard(const Model* model, SurfacePieces* pieces) : model_(model), pieces_(pieces) {}

  /// Moves nodes, by inverse mass (1/kg, 0: held), until every two pieces are on their own sides; their velocities
  /// become those of the ways they made in dt (s) from `before`. Returns by how much the worst pair fails to be, m; 0
  /// when all are.
  double keep_apart(const Nodes& before, const Eigen::VectorXd& inverse_mass, double dt, State* s);
  /// Names the bodies of an edge and a triangle that cross at x, or of parts at no distance, which have no direction to
  /// come apart in, and where; empty when there are none.
  std::string find_crossing(const Nodes& x);

 private:
  struct Pair {
    Meeting parts;
    Vec3 normal;
    double least;  // m that they have to be apart along it at the end
  };

  double find_failing(const Nodes& before, const Nodes& x, const Eigen::VectorXd& inverse_mass);
  double separate(const Pair& pair, const Eigen::VectorXd& inverse_mass, Nodes* x);

  const Model* model_;
  SurfacePieces* pieces_;
  std::vector<Pair> pairs_;
  std::vector<char> moved_;  // by node
};

}  // namespace deformable_sim
