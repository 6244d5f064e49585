// Soft bodies as cubic lattices of springs.
//
// A spring of stiffness k along d adds k d_a d_b d_c d_d / (|d|^2 V) to the moduli C_abcd of a cell of volume V.
// Isotropy asks for C_aaaa = 3 C_aabb = 3 C_abab = 1.2 E: central forces, so nu = 1/4.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

// Part of C_aabb that body diagonals bring where there are 26 neighbours: k3 = k2 in cubes (4/3 of 7/3).
constexpr double kBodyShare = 4.0 / 7.0;
constexpr double kCubeTolerance = 1e-6;

/// Whole stiffnesses, N/m: of the edge along axis a, of a face diagonal normal to axis a, of a body diagonal.
struct CellSprings {
  Vec3 edge = Vec3::Zero(), face = Vec3::Zero();
  double body = 0.0;
};

bool bad(double value) {
  return !(value > 0.0) || !std::isfinite(value);
}

CellSprings from_modulus(const LatticeStiffness& s, const Vec3& cell) {
  const double c_aaaa = 1.2 * s.youngs_modulus, c_aabb = 0.4 * s.youngs_modulus, volume = cell.prod();
  CellSprings k;
  if (s.neighbours == LatticeNeighbours::kEdges) {
    for (int a = 0; a < 3; ++a) k.edge[a] = s.youngs_modulus * volume / (cell[a] * cell[a]);
    return k;
  }
  const Vec3 square = cell.cwiseAbs2();
  const double diagonal = square.sum();
  if (s.neighbours == LatticeNeighbours::kBodies) {
    // In elongated cells body diagonals bring unequal C_aabb: the largest of them gets their share.
    const double largest = std::max({square[0] * square[1], square[1] * square[2], square[0] * square[2]});
    k.body = kBodyShare * c_aabb * diagonal * volume / (4.0 * largest);
  }
  for (int a = 0; a < 3; ++a) {
    const double sides = square[(a + 1) % 3] * square[(a + 2) % 3];
    const double rest = c_aabb - 4.0 * k.body * sides / (diagonal * volume);
    k.face[a] = 0.5 * rest * volume * (square[(a + 1) % 3] + square[(a + 2) % 3]) / sides;
  }
  for (int a = 0; a < 3; ++a) {
    double others = 4.0 * k.body * square[a] * square[a] / diagonal;
    for (const int b : {(a + 1) % 3, (a + 2) % 3})  // the face of axes a and the other one is normal to b
      others += 2.0 * k.face[b] * square[a] * square[a] / (diagonal - square[b]);
    k.edge[a] = (c_aaaa * volume - others) / square[a];
    if (!(k.edge[a] > 0.0))
      throw InputError("cells of " + std::to_string(cell[0]) + " x " + std::to_string(cell[1]) + " x " +
                       std::to_string(cell[2]) +
                       " m are too elongated for an isotropic spring lattice: make them more like cubes");
  }
  return k;
}

CellSprings springs_of(const LatticeStiffness& s, const Vec3& cell) {
  if (!(s.damping_time >= 0.0) || !std::isfinite(s.damping_time))
    throw InputError("damping_time is " + std::to_string(s.damping_time) + "; it must be finite and >= 0 (s)");
  if (!s.springs) {
    if (bad(s.youngs_modulus))
      throw InputError("youngs_modulus is " + std::to_string(s.youngs_modulus) + "; it must be finite and > 0 (Pa)");
    return from_modulus(s, cell);
  }
  if (cell.maxCoeff() - cell.minCoeff() > kCubeTolerance * cell.maxCoeff())
    throw InputError("springs of a lattice can be given for cubic cells only");
  const int kinds = s.neighbours == LatticeNeighbours::kEdges ? 1 : s.neighbours == LatticeNeighbours::kFaces ? 2 : 3;
  CellSprings k;
  for (int i = 0; i < kinds; ++i) {
    const double value = (*s.springs)[static_cast<size_t>(i)];
    if (!(i == 0 ? value > 0.0 : value >= 0.0) || !std::isfinite(value))
      throw InputError("springs of a lattice must be finite, > 0 along edges and >= 0 along diagonals (N/m)");
  }
  k.edge.setConstant((*s.springs)[0]);
  if (kinds > 1) k.face.setConstant((*s.springs)[1]);
  if (kinds > 2) k.body = (*s.springs)[2];
  return k;
}

Vec3 cell_size(const Nodes& rest, const LatticeCell& cell) {
  const auto length = [&](size_t corner) { return (rest.col(cell[corner]) - rest.col(cell[0])).norm(); };
  return Vec3(length(1), length(2), length(4));
}

/// Sums shares by pair of nodes; links come out in the order of their nodes.
class Shares {
 public:
  void add(int a, int b, double stiffness) { sum_[{std::min(a, b), std::max(a, b)}] += stiffness; }
  std::vector<SpringLink> links(const Nodes& rest, double damping_time) const {
    std::vector<SpringLink> links;
    links.reserve(sum_.size());
    for (const auto& [pair, k] : sum_)
      links.push_back({pair[0], pair[1], (rest.col(pair[1]) - rest.col(pair[0])).norm(), k, damping_time * k});
    return links;
  }

 private:
  std::map<std::array<int, 2>, double> sum_;
};

}  // namespace

std::vector<LatticeCell> lattice_cells(const TetMesh& mesh, const Vec3& cell) {
  const Vec3 origin = mesh.rest.rowwise().minCoeff();
  using Place = std::array<long, 3>;
  std::map<Place, int> nodes;
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    const Vec3 at = (mesh.rest.col(i) - origin).cwiseQuotient(cell);
    const Place place{std::lround(at.x()), std::lround(at.y()), std::lround(at.z())};
    const Vec3 off =
        at - Vec3(static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2]));
    if (off.cwiseAbs().maxCoeff() > 1e-3 || !nodes.insert({place, static_cast<int>(i)}).second)
      throw InputError("node " + std::to_string(i) + " is no node of a lattice of such cells");
  }
  std::map<Place, LatticeCell> cells;
  for (const auto& tet : mesh.tets) {
    Vec3 middle = Vec3::Zero();
    for (int node : tet) middle += 0.25 * mesh.rest.col(node);
    const Vec3 at = (middle - origin).cwiseQuotient(cell);
    const Place place{static_cast<long>(std::floor(at.x())), static_cast<long>(std::floor(at.y())),
                      static_cast<long>(std::floor(at.z()))};
    const auto [entry, is_new] = cells.insert({place, {}});
    if (!is_new) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const auto node = nodes.find({place[0] + (corner & 1), place[1] + (corner >> 1 & 1), place[2] + (corner >> 2)});
      if (node == nodes.end()) throw InputError("the tetrahedra do not fill whole cells of the lattice");
      entry->second[static_cast<size_t>(corner)] = node->second;
    }
  }
  std::vector<LatticeCell> found;
  found.reserve(cells.size());
  for (const auto& entry : cells) found.push_back(entry.second);
  return found;
}

SpringNetwork lattice_network(const Nodes& rest, const std::vector<LatticeCell>& cells, const LatticeStiffness& s) {
  if (cells.empty()) throw InputError("a spring lattice needs at least one cell");
  const CellSprings k = springs_of(s, cell_size(rest, cells.front()));
  Shares edges, faces, bodies;
  for (const LatticeCell& cell : cells) {
    for (int i = 0; i < 8; ++i) {
      for (int j = i + 1; j < 8; ++j) {
        const int a = cell[static_cast<size_t>(i)], b = cell[static_cast<size_t>(j)];
        const int axes = i ^ j;  // those along which the two corners differ
        if (axes == 7) {
          if (k.body > 0.0) bodies.add(a, b, k.body);
        } else if (axes == 1 || axes == 2 || axes == 4) {
          edges.add(a, b, 0.25 * k.edge[axes >> 1]);
        } else {
          const int normal = axes == 6 ? 0 : axes == 5 ? 1 : 2;
          if (k.face[normal] > 0.0) faces.add(a, b, 0.5 * k.face[normal]);
        }
      }
    }
  }
  SpringNetwork network;
  network.stretch = edges.links(rest, s.damping_time);
  network.shear = faces.links(rest, s.damping_time);
  network.bend = bodies.links(rest, s.damping_time);
  return network;
}

Eigen::VectorXd lattice_masses(const Nodes& rest, const std::vector<LatticeCell>& cells, double density) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(rest.cols());
  for (const LatticeCell& cell : cells)
    for (int node : cell) mass[node] += 0.125 * density * cell_size(rest, cell).prod();
  return mass;
}

}  // namespace deformable_sim
