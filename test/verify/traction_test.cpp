// A simulated traction test gives the material back, at any mesh size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/system.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// Constant forces on nodes.
class Load : public Energy {
 public:
  explicit Load(Nodes force) : force_(std::move(force)) {}
  std::string name() const override { return "load"; }
  int element_count() const override { return static_cast<int>(force_.cols()); }
  double value(const State& s) const override { return -force_.cwiseProduct(s.x).sum(); }
  void add_force(const State&, Nodes* f) const override { *f += force_; }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}

 private:
  Nodes force_;
};

struct Traction {
  double modulus;  // E h, N/m
  double ratio;    // Poisson
};

/// Slope of component `row` of the displacement over the rest coordinate `by`, over the middle third of the nodes.
double strain(const Nodes& rest, const Nodes& x, int row, double length) {
  double su = 0, sx = 0, sxx = 0, sxu = 0, n = 0;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    if (std::abs(rest(0, i)) > length / 6.0) continue;
    const double at = rest(row, i), moved = x(row, i) - at;
    n += 1;
    su += moved;
    sx += at;
    sxx += at * at;
    sxu += at * moved;
  }
  return (n * sxu - sx * su) / (n * sxx - sx * sx);
}

/// Pulls a strip of length x width along x with an even line load at both ends; one node holds it in place.
Traction pull(const TriangleMesh& mesh, const SheetStiffness& stiffness, double length, double width, double load) {
  System strip(mesh.rest, sheet_masses(mesh, 0.15));
  strip.add_springs(sheet_network(mesh, stiffness));
  Nodes force = Nodes::Zero(3, mesh.rest.cols());
  for (const auto& edge : edges_of(mesh)) {
    for (const double side : {-1.0, 1.0}) {
      const auto at_end = [&](int i) { return std::abs(mesh.rest(0, i) - side * 0.5 * length) < 1e-9; };
      if (!at_end(edge[0]) || !at_end(edge[1])) continue;
      const double half = 0.5 * side * load * (mesh.rest.col(edge[1]) - mesh.rest.col(edge[0])).norm();
      for (int i : edge) force(0, i) += half;
    }
  }
  EXPECT_NEAR(force.row(0).cwiseMax(0.0).sum(), load * width, 1e-9);
  strip.add(std::make_unique<Load>(force));
  int middle = 0;
  mesh.rest.colwise().squaredNorm().minCoeff(&middle);
  strip.hold(middle);
  EXPECT_LT(relax(&strip, 10.0, 20, 1e-6), 1e-5);
  const double along = strain(mesh.rest, strip.state.x, 0, length);
  return {load / along, -strain(mesh.rest, strip.state.x, 1, length) / along};
}

/// Triangles as equilateral as the strip allows, inner nodes shaken by a tenth of an edge. Not a grid to the solver.
TriangleMesh irregular_mesh(double length, double width, int cells) {
  const double edge = length / cells;
  const int rows = std::max(2, static_cast<int>(std::lround(width / (edge * std::sqrt(0.75)))));
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> shake(-0.1 * edge, 0.1 * edge);
  TriangleMesh mesh;
  std::vector<Vec3> nodes;
  std::vector<int> first;
  for (int r = 0; r <= rows; ++r) {
    first.push_back(static_cast<int>(nodes.size()));
    const bool shifted = r % 2 == 1;
    const int count = shifted ? cells + 2 : cells + 1;  // shifted rows have half cells at both ends
    for (int c = 0; c < count; ++c) {
      double x = shifted ? std::clamp((c - 0.5) * edge, 0.0, length) : c * edge;
      double y = width * r / rows;
      if (r > 0 && r < rows && x > 0.0 && x < length) {
        x += shake(generator);
        y += shake(generator);
      }
      nodes.emplace_back(x - 0.5 * length, y - 0.5 * width, 0.0);
    }
  }
  mesh.rest.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (size_t i = 0; i < nodes.size(); ++i) mesh.rest.col(static_cast<Eigen::Index>(i)) = nodes[i];
  for (int r = 0; r < rows; ++r) {
    // `wide` is the shifted row of the two, with one node more: `narrow` node c lies between wide nodes c and c + 1.
    const bool up = r % 2 == 0;
    const int narrow = first[static_cast<size_t>(up ? r : r + 1)], wide = first[static_cast<size_t>(up ? r + 1 : r)];
    const auto add = [&](int a, int b, int c) {
      if (up)
        mesh.triangles.push_back({a, b, c});
      else
        mesh.triangles.push_back({a, c, b});
    };
    for (int c = 0; c <= cells; ++c) {
      add(narrow + c, wide + c + 1, wide + c);
      if (c < cells) add(narrow + c, narrow + c + 1, wide + c + 1);
    }
  }
  check_mesh(mesh);
  return mesh;
}

TEST(TractionOfAGrid, GivesEBackAtThreeMeshSizesAndCellShapes) {
  // E h = (F / w) / strain within 5 %, nu within 0.02; the grid is exact but for finite strain (0.1 %).
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  stiffness.poissons_ratio = 0.243;
  for (const auto& [cells_x, cells_y] : {std::array<int, 2>{10, 4}, {20, 8}, {40, 16}, {30, 8}, {16, 9}}) {
    const Traction found = pull(make_grid(0.5, 0.2, cells_x, cells_y), stiffness, 0.5, 0.2, 0.261);
    const std::string name = "traction, grid of " + std::to_string(cells_x) + " x " + std::to_string(cells_y);
    check("C2", name + ", E h, N/m", found.modulus, 261.0, 0.01);
    check("C2", name + ", Poisson's ratio", found.ratio, 0.243, 0.02, Tolerance::kAbsolute);
  }
}

TEST(TractionOfAGrid, GivesEBackAcrossTheWeftAsWell) {
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  TriangleMesh mesh = make_grid(0.2, 0.5, 8, 25);
  // Turned by 90 degrees: what was y is pulled along x now.
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    const Vec3 p = mesh.rest.col(i);
    mesh.rest.col(i) = Vec3(p.y(), -p.x(), 0);
  }
  check("C2", "traction along the weft of a grid, E h, N/m", pull(mesh, stiffness, 0.5, 0.2, 0.261).modulus, 261.0,
        0.01);
}

TEST(TractionOfAGrid, GivesEBackWithItsOwnShearAndBend) {
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  stiffness.shear = 30.0;
  stiffness.bend = 5.0;
  check("C2", "traction, grid with its own shear and bend springs, E h, N/m",
        pull(make_grid(0.5, 0.2, 20, 8), stiffness, 0.5, 0.2, 0.261).modulus, 261.0, 0.01);
}

TEST(TractionOfAGrid, OfGivenSpringsIsTheirLattice) {
  // k3 = 0: E h = k1 (k1 + 2 k2) / (k1 + k2), nu = k2 / (k1 + k2).
  SheetStiffness stiffness;
  stiffness.stretch = 100.0;
  stiffness.shear = 50.0;
  stiffness.bend = 0.0;
  const Traction found = pull(make_grid(0.5, 0.2, 20, 8), stiffness, 0.5, 0.2, 0.1);
  check("C2", "traction, grid of given springs, E h, N/m", found.modulus, 100.0 * 200.0 / 150.0, 0.01);
  check("C2", "traction, grid of given springs, Poisson's ratio", found.ratio, 1.0 / 3.0, 0.01, Tolerance::kAbsolute);
}

TEST(TractionOfAMesh, GivesEBackAtThreeMeshSizes) {
  // Within 5 %: Born moduli bound those of an irregular network from above. Central forces: nu = 1/3 whatever is asked.
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  for (const int cells : {15, 25, 40}) {
    const Traction found = pull(irregular_mesh(0.5, 0.2, cells), stiffness, 0.5, 0.2, 0.261);
    const std::string name = "traction, irregular mesh of " + std::to_string(cells) + " cells";
    check("C2", name + ", E h, N/m", found.modulus, 261.0, 0.05);
    check("C2", name + ", Poisson's ratio", found.ratio, 1.0 / 3.0, 0.03, Tolerance::kAbsolute);
  }
}

TEST(TractionOfARope, GivesEaBackAtThreeMeshSizes) {
  // EA = F L / elongation, bend springs included, exactly; and from k directly, k / n without them.
  const double length = 0.8, pull_force = 0.05;
  for (const int n : {5, 20, 80}) {
    for (const bool direct : {false, true}) {
      LineStiffness stiffness;
      stiffness.axial = 50.0;
      if (direct) {
        stiffness.stretch = 50.0 / (length / n);
        stiffness.bend = 0.0;
      }
      const Polyline line = make_line(length, n);
      System rope(line.rest, line_masses(line, 0.05));
      rope.add_springs(line_network(line, stiffness)).hold(0);
      Nodes force = Nodes::Zero(3, n + 1);
      force(0, n) = pull_force;
      rope.add(std::make_unique<Load>(force));
      ASSERT_LT(relax(&rope, 10.0, 20, 1e-7), 1e-6);
      const double elongation = rope.state.x(0, n) - line.rest(0, n);
      check("C2", "traction, rope of " + std::to_string(n) + (direct ? " given springs" : " springs") + ", EA, N",
            pull_force * length / elongation, 50.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
