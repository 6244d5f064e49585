// Sheets as spring networks, calibrated with the Born moduli of the lattice.
//
// A spring of stiffness k, length l and direction n adds k l^2 n_a n_b n_c n_d / A to the moduli C_abcd (N/m) of a
// sheet of area A. For central springs C12 = C66 always; a uniaxial traction test measures E h = C11 - C12^2 / C11 [Van
// Gelder 1998].
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

constexpr double kDefaultBend = 0.01;     // bend springs, as a fraction of the membrane stiffness
constexpr double kLeastStructural = 0.1;  // part of C11 that structural springs keep in elongated cells

/// Stiffnesses of one grid cell of size dx, dy: structural (full, inside the sheet), shear, bend.
struct CellStiffness {
  double x = 0.0, y = 0.0, shear = 0.0, bend_x = 0.0, bend_y = 0.0;  // N/m
  // Bend springs are missing beyond the ends of a row; structural springs there take over, so that tension is uniform.
  double end_x = 0.0, end_y = 0.0;
};

std::string text(double value) {
  return std::to_string(value);
}

double shear_for(double ratio_c12, double c11, double dx, double dy) {
  return 0.5 * ratio_c12 * c11 * (dx * dx + dy * dy) / (dx * dy);
}

/// From E h and nu: C11 = E h / (1 - nu^2), C12 = nu C11. Elongated cells cannot reach a large nu: it is then lowered.
CellStiffness cell_from_membrane(const SheetStiffness& s, double dx, double dy) {
  const double slender = std::min(dx / dy, dy / dx);
  CellStiffness cell;
  const double bend = s.bend ? *s.bend : kDefaultBend * s.membrane;
  cell.bend_x = s.bend ? bend : bend * dy / dx;
  cell.bend_y = s.bend ? bend : bend * dx / dy;

  double c11 = 0.0;
  if (s.shear) {
    cell.shear = *s.shear;
    const double c12 = 2.0 * cell.shear * dx * dy / (dx * dx + dy * dy);
    c11 = 0.5 * (s.membrane + std::sqrt(s.membrane * s.membrane + 4.0 * c12 * c12));
  } else {
    const double nu = std::min(s.poissons_ratio, (1.0 - kLeastStructural) * slender * slender);
    c11 = s.membrane / (1.0 - nu * nu);
    cell.shear = shear_for(nu, c11, dx, dy);
  }
  const double square = dx * dx + dy * dy;
  cell.x = c11 * dy / dx - 2.0 * cell.shear * dx * dx / square - 4.0 * cell.bend_x;
  cell.y = c11 * dx / dy - 2.0 * cell.shear * dy * dy / square - 4.0 * cell.bend_y;
  if (!(cell.x > 0.0) || !(cell.y > 0.0)) {
    throw InputError("shear (" + text(cell.shear) + " N/m) and bend (" + text(bend) +
                     " N/m) springs alone are stiffer than the membrane, E h = " + text(s.membrane) +
                     " N/m; lower them");
  }
  cell.end_x = 2.0 * cell.bend_x;
  cell.end_y = 2.0 * cell.bend_y;
  return cell;
}

/// From k of a structural spring as given; shear and bend, when not given, in the proportion they have for E and nu.
CellStiffness cell_from_stretch(const SheetStiffness& s, double dx, double dy) {
  CellStiffness cell;
  cell.x = cell.y = *s.stretch;
  cell.shear = s.shear ? *s.shear : *s.stretch * s.poissons_ratio / (1.0 - s.poissons_ratio);
  const double bend = s.bend ? *s.bend : kDefaultBend * *s.stretch;
  cell.bend_x = s.bend ? bend : bend * dy / dx;
  cell.bend_y = s.bend ? bend : bend * dx / dy;
  return cell;
}

void check(const SheetStiffness& s) {
  const auto refuse = [](const std::string& what, double value, const std::string& allowed) {
    throw InputError(what + " is " + text(value) + "; it must be " + allowed);
  };
  const auto bad = [](double value) { return !(value >= 0.0) || !std::isfinite(value); };
  if (s.stretch && (bad(*s.stretch) || *s.stretch == 0.0)) refuse("stretch", *s.stretch, "finite and > 0 (N/m)");
  if (!s.stretch && (bad(s.membrane) || s.membrane == 0.0)) refuse("membrane", s.membrane, "finite and > 0 (N/m)");
  if (!(s.poissons_ratio >= 0.0 && s.poissons_ratio < 0.5)) refuse("poissons_ratio", s.poissons_ratio, "in [0, 0.5)");
  if (s.shear && bad(*s.shear)) refuse("shear", *s.shear, "finite and >= 0 (N/m)");
  if (s.bend && bad(*s.bend)) refuse("bend", *s.bend, "finite and >= 0 (N/m)");
  if (bad(s.damping_time)) refuse("damping_time", s.damping_time, "finite and >= 0 (s)");
}

SpringLink link_of(const Nodes& rest, int a, int b, double stiffness, double damping_time) {
  return {a, b, (rest.col(b) - rest.col(a)).norm(), stiffness, damping_time * stiffness};
}

/// Links along one row or column of `count` nodes, the k-th being node(k).
template <class Node>
void add_row(const Nodes& rest, int count, Node node, double structural, double bend, double end, double damping_time,
             SpringNetwork* network) {
  for (int k = 0; k + 1 < count; ++k) {
    const int missing = (k == 0 ? 1 : 0) + (k + 2 == count ? 1 : 0);
    network->stretch.push_back(link_of(rest, node(k), node(k + 1), structural + missing * end, damping_time));
  }
  if (bend == 0.0) return;
  for (int k = 0; k + 2 < count; ++k) {
    network->bend.push_back(link_of(rest, node(k), node(k + 2), bend, damping_time));
  }
}

SpringNetwork grid_network(const TriangleMesh& mesh, const SheetStiffness& s) {
  const double dx = (mesh.rest.col(1) - mesh.rest.col(0)).norm();
  const double dy = (mesh.rest.col(mesh.cols) - mesh.rest.col(0)).norm();
  const CellStiffness cell = s.stretch ? cell_from_stretch(s, dx, dy) : cell_from_membrane(s, dx, dy);
  const auto share = [](int k, int count) { return k == 0 || k == count - 1 ? 0.5 : 1.0; };  // a free edge has one side

  SpringNetwork network;
  for (int r = 0; r < mesh.rows; ++r) {
    const double half = share(r, mesh.rows);
    add_row(
        mesh.rest, mesh.cols, [&](int k) { return r * mesh.cols + k; }, half * cell.x, half * cell.bend_x,
        half * cell.end_x, s.damping_time, &network);
  }
  for (int c = 0; c < mesh.cols; ++c) {
    const double half = share(c, mesh.cols);
    add_row(
        mesh.rest, mesh.rows, [&](int k) { return k * mesh.cols + c; }, half * cell.y, half * cell.bend_y,
        half * cell.end_y, s.damping_time, &network);
  }
  if (cell.shear == 0.0) return network;
  for (int r = 0; r + 1 < mesh.rows; ++r) {
    for (int c = 0; c + 1 < mesh.cols; ++c) {
      const int a = r * mesh.cols + c;
      network.shear.push_back(link_of(mesh.rest, a, a + mesh.cols + 1, cell.shear, s.damping_time));
      network.shear.push_back(link_of(mesh.rest, a + 1, a + mesh.cols, cell.shear, s.damping_time));
    }
  }
  return network;
}

double area_of(const TriangleMesh& mesh, const std::array<int, 3>& t) {
  return 0.5 *
         Vec3(mesh.rest.col(t[1]) - mesh.rest.col(t[0])).cross(Vec3(mesh.rest.col(t[2]) - mesh.rest.col(t[0]))).norm();
}

/// Area of the faces at each edge of `edges`, which is sorted.
std::vector<double> edge_areas(const TriangleMesh& mesh, const std::vector<std::array<int, 2>>& edges) {
  std::vector<double> areas(edges.size(), 0.0);
  for (const auto& t : mesh.triangles) {
    const double area = area_of(mesh, t);
    for (size_t k = 0; k < 3; ++k) {
      const std::array<int, 2> edge{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      areas[static_cast<size_t>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin())] += area;
    }
  }
  return areas;
}

/// Averaged over all directions the Born moduli give E h = sum k l^2 / (3 A): with k = E h (area at the edge) / l^2
/// [Van Gelder 1998] the sum is exactly 3 A E h. Bend springs take their share of that.
SpringNetwork mesh_network(const TriangleMesh& mesh, const SheetStiffness& s) {
  const std::vector<std::array<int, 2>> edges = edges_of(mesh);
  const std::vector<double> areas = edge_areas(mesh, edges);
  SpringNetwork network;
  double area3 = 0.0;  // 3 A
  for (double area : areas) area3 += area;

  const double typical = s.stretch ? *s.stretch : s.membrane;
  const double bend = s.bend ? *s.bend : kDefaultBend * typical;
  double bend_sum = 0.0;
  if (bend > 0.0) {
    for (const auto& hinge : hinges_of(mesh)) {
      const SpringLink link = link_of(mesh.rest, hinge[2], hinge[3], bend, s.damping_time);
      if (!(link.rest_length > 0.0)) continue;  // two faces folded flat onto each other at rest
      network.bend.push_back(link);
      bend_sum += bend * link.rest_length * link.rest_length;
    }
  }
  const double membrane = s.membrane - bend_sum / area3;
  if (!s.stretch && !(membrane > 0.0)) {
    throw InputError("bend springs (" + text(bend) +
                     " N/m) alone are stiffer than the membrane, E h = " + text(s.membrane) + " N/m; lower them");
  }
  for (size_t k = 0; k < edges.size(); ++k) {
    SpringLink link = link_of(mesh.rest, edges[k][0], edges[k][1], 0.0, 0.0);
    link.stiffness = s.stretch ? *s.stretch : membrane * areas[k] / (link.rest_length * link.rest_length);
    link.damping = s.damping_time * link.stiffness;
    network.stretch.push_back(link);
  }
  return network;
}

}  // namespace

SpringNetwork sheet_network(const TriangleMesh& mesh, const SheetStiffness& stiffness) {
  check(stiffness);
  return mesh.is_grid() ? grid_network(mesh, stiffness) : mesh_network(mesh, stiffness);
}

Eigen::VectorXd sheet_masses(const TriangleMesh& mesh, double areal_density) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.rest.cols());
  if (mesh.is_grid()) {
    for (int r = 0; r + 1 < mesh.rows; ++r) {
      for (int c = 0; c + 1 < mesh.cols; ++c) {
        const int a = r * mesh.cols + c;
        // The mean of the two ways to cut the cell: a third of each triangle would alternate from node to node.
        const double quarter =
            0.25 * areal_density *
            (area_of(mesh, {a, a + 1, a + mesh.cols}) + area_of(mesh, {a + 1, a + mesh.cols + 1, a + mesh.cols}));
        for (int node : {a, a + 1, a + mesh.cols, a + mesh.cols + 1}) mass[node] += quarter;
      }
    }
    return mass;
  }
  for (const auto& t : mesh.triangles) {
    const double third = areal_density * area_of(mesh, t) / 3.0;
    for (int node : t) mass[node] += third;
  }
  return mass;
}

}  // namespace deformable_sim
