// Every test of a solid, with one model of it: a stress-strain law on linear or quadratic tetrahedra, or a spring
// lattice.
#include <algorithm>
#include <cmath>

#include "bench.h"
#include "deformable_sim/core/energy/solid_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim::study {
namespace {

constexpr double kStrain = 1e-6;
constexpr double kSide = 0.01;  // m, of the section
const char kQuadratic[] = "_quadratic";

struct SolidModel {
  bool lattice = false, quadratic = false;
  SolidLaw law = SolidLaw::kHooke;
};

SolidModel solid_model(const std::string& name) {
  check_model(name, solid_models(), "solid");
  if (name == "lattice") return {true, false, SolidLaw::kHooke};
  const size_t at = name.rfind(kQuadratic);
  const bool quadratic = at != std::string::npos;
  return {false, quadratic, solid_law(quadratic ? name.substr(0, at) : name)};
}

Specimen make_block(const SolidData& solid, const SolidModel& model, const Vec3& size,
                    const std::array<int, 3>& cells) {
  TetMesh mesh = make_box(size, cells);
  if (model.lattice) {
    const Vec3 cell(size[0] / cells[0], size[1] / cells[1], size[2] / cells[2]);
    const std::vector<LatticeCell> lattice = lattice_cells(mesh, cell);
    LatticeStiffness stiffness;
    stiffness.youngs_modulus = solid.youngs_modulus;
    const SpringNetwork network = lattice_network(mesh.rest, lattice, stiffness);
    Specimen block(mesh.rest, lattice_masses(mesh.rest, lattice, solid.density));
    block.add(make_springs("stretch springs", network.stretch, 0));
    if (!network.shear.empty()) block.add(make_springs("shear springs", network.shear, 0));
    if (!network.bend.empty()) block.add(make_springs("bend springs", network.bend, 0));
    return block;
  }
  if (model.quadratic) mesh = with_mid_nodes(mesh);
  Specimen block(mesh.rest, solid_masses(mesh, solid.density));
  block.add(make_solid(mesh, solid_material(model.law, solid.youngs_modulus, solid.poissons_ratio), 0.0, 0));
  return block;
}

bool at(double value, double wanted) {
  return std::abs(value - wanted) < 1e-9;
}

struct Traction {
  int nodes;
  double modulus, ratio;
};

/// A bar 4 sections long, its ends on rollers, pulled by kStrain.
Traction pull(const SolidData& solid, const SolidModel& model, int n) {
  const double length = 4.0 * kSide, half = 0.5 * kSide;
  Specimen bar = make_block(solid, model, Vec3(length, kSide, kSide), {4 * n, n, n});
  double width = 0.0, narrowed = 0.0;
  for (int i = 0; i < bar.node_count(); ++i) {
    const Vec3 x = bar.rest.col(i);
    bar.state.x(0, i) += kStrain * x[0];
    if (!at(std::abs(x[0]), 0.5 * length)) continue;
    bar.hold(i, 0);
    if (at(x[0], -0.5 * length) && at(x[1], -half) && at(x[2], -half)) bar.hold(i);
    if (at(x[0], -0.5 * length) && at(x[1], half) && at(x[2], -half)) bar.hold(i, 2);
  }
  if (!bar.settle().converged) return {bar.node_count(), none(), none()};
  const Nodes reactions = bar.reactions();
  double force = 0.0;
  for (int i = 0; i < bar.node_count(); ++i) {
    const Vec3 x = bar.rest.col(i), u = bar.state.x.col(i) - x;
    if (at(x[0], 0.5 * length)) force += reactions(0, i);
    width += x[1] * x[1];
    narrowed += x[1] * u[1];
  }
  // Least squares through the middle: the corner that is held only shifts the bar.
  double mean = 0.0;
  for (int i = 0; i < bar.node_count(); ++i) mean += (bar.state.x(1, i) - bar.rest(1, i)) / bar.node_count();
  for (int i = 0; i < bar.node_count(); ++i) narrowed -= bar.rest(1, i) * mean;
  return {bar.node_count(), force / (kSide * kSide) / kStrain, -narrowed / width / kStrain};
}

/// Stress over strain (Pa) of a cube whose surface is displaced by kStrain direction x, by virtual work.
Measurement deform_cube(const SolidData& solid, const SolidModel& model, const Mat3& direction, int n) {
  Specimen cube = make_block(solid, model, Vec3::Constant(kSide), {n, n, n});
  for (int i = 0; i < cube.node_count(); ++i) {
    const Vec3 x = cube.rest.col(i);
    cube.state.x.col(i) += kStrain * (direction * x);
    if (at(x.cwiseAbs().maxCoeff(), 0.5 * kSide)) cube.hold(i);
  }
  if (!cube.settle().converged) return {cube.node_count(), none(), 0.0};
  const Nodes reactions = cube.reactions();
  double work = 0.0;
  for (int i = 0; i < cube.node_count(); ++i) work += reactions.col(i).dot(direction * Vec3(cube.rest.col(i)));
  return {cube.node_count(), work / (kSide * kSide * kSide) / kStrain, 0.0};
}

/// Young's modulus by bending: a clamped bar ten sections long under a light load of its own, against Timoshenko's
/// beam. The clamp keeps the section plane and carries the weight all over it, but lets it contract and widen, as the
/// beam's does: a rigid one would hold up a material that is nearly incompressible by some percent. The corners of a
/// bent section neither rise nor sink; they are what the tip is measured against.
Measurement bend(const SolidData& solid, const SolidModel& model, int n) {
  const double length = 10.0 * kSide, area = kSide * kSide, inertia = area * area / 12.0, shear_share = 5.0 / 6.0;
  Specimen bar = make_block(solid, model, Vec3(length, kSide, kSide), {10 * n, n, n});
  const auto end = [&](int i) { return at(bar.rest(0, i), -0.5 * length); };
  const auto corner = [&](int i) {
    return end(i) && at(std::abs(bar.rest(1, i)), 0.5 * kSide) && at(std::abs(bar.rest(2, i)), 0.5 * kSide);
  };
  // A millionth of the length as deflection: small rotations, whatever the stiffness.
  const double load = 8e-6 * solid.youngs_modulus * inertia / (length * length * length);  // N/m
  const double total = bar.mass.sum();
  double at_end = 0.0;
  for (int i = 0; i < bar.node_count(); ++i) at_end += end(i) ? bar.mass[i] : 0.0;
  int corners = 0;
  for (int i = 0; i < bar.node_count(); ++i) {
    bar.load(i, Vec3(0, 0, load * length * ((end(i) ? bar.mass[i] / at_end : 0.0) - bar.mass[i] / total)));
    if (end(i)) bar.hold(i, 0);
    if (!corner(i)) continue;
    if (corners == 0) bar.hold(i);
    if (corners == 1) bar.hold(i, 2);
    ++corners;
  }
  if (!bar.settle().converged) return {bar.node_count(), none(), 0.0};
  double tip = 0.0, clamp = 0.0;
  int count = 0;
  for (int i = 0; i < bar.node_count(); ++i) {
    const double sunk = bar.rest(2, i) - bar.state.x(2, i);
    if (corner(i)) clamp += sunk / corners;
    if (!at(bar.rest(0, i), 0.5 * length)) continue;
    tip += sunk;
    ++count;
  }
  const double l2 = length * length;
  const double expected = load * l2 * l2 / (8.0 * solid.youngs_modulus * inertia) +
                          load * l2 / (2.0 * shear_share * solid.shear_modulus() * area);
  return {bar.node_count(), solid.youngs_modulus * expected / (tip / count - clamp), 0.0};
}

/// Shear modulus by torsion: the ends turn against each other, free to warp; a square section has 0.140577 a^4.
Measurement twist(const SolidData& solid, const SolidModel& model, int n) {
  const double length = 2.0 * kSide;
  Specimen bar = make_block(solid, model, Vec3(length, kSide, kSide), {2 * n, n, n});
  bool placed = false;
  for (int i = 0; i < bar.node_count(); ++i) {
    const Vec3 x = bar.rest.col(i);
    const double angle = kStrain * x[0] / length;
    bar.state.x.col(i) += Vec3(0, -angle * x[2], angle * x[1]);
    if (!at(std::abs(x[0]), 0.5 * length)) continue;
    bar.hold(i, 1);
    bar.hold(i, 2);
    if (!placed) bar.hold(i, 0);
    placed = true;
  }
  if (!bar.settle().converged) return {bar.node_count(), none(), 0.0};
  const Nodes reactions = bar.reactions();
  double torque = 0.0;
  for (int i = 0; i < bar.node_count(); ++i) {
    if (at(bar.rest(0, i), 0.5 * length)) {
      torque += bar.rest(1, i) * reactions(2, i) - bar.rest(2, i) * reactions(1, i);
    }
  }
  return {bar.node_count(), torque * length / (kStrain * 0.140577015 * std::pow(kSide, 4)), 0.0};
}

}  // namespace

std::vector<std::string> solid_models() {
  std::vector<std::string> names;
  for (const std::string& law : solid_law_names()) {
    names.push_back(law);
    names.push_back(law + kQuadratic);
  }
  names.push_back("lattice");
  return names;
}

Report study_solid(const SolidData& solid, const std::string& name, const Bench& bench) {
  const SolidModel model = solid_model(name);
  Report report;
  report.material = solid.origin.name;
  report.title = solid.origin.title;
  report.kind = "solid";
  report.model = name;
  report.source = solid.origin.source;
  const bool full = bench.effort == Effort::kFull;
  const std::vector<int> sizes = full ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2};
  const Mat3 swell = -Mat3::Identity();
  Mat3 shear = Mat3::Zero();
  shear(0, 1) = 1.0;
  const auto traction = [&](bool ratio) {
    return [&solid, &model, ratio](int n) {
      const Traction t = pull(solid, model, n);
      return Measurement{t.nodes, ratio ? t.ratio : t.modulus, 0.0};
    };
  };
  auto& rows = report.rows;
  rows.push_back(row_of(bench, "traction", "E = stress / strain", "Pa", solid.youngs_modulus, sizes, traction(false)));
  rows.push_back(row_of(bench, "traction", "Poisson's ratio", "", solid.poissons_ratio, sizes, traction(true)));
  rows.push_back(row_of(bench, "shear", "G = shear stress / angle", "Pa", solid.shear_modulus(), sizes,
                        [&](int n) { return deform_cube(solid, model, shear, n); }));
  rows.push_back(
      row_of(bench, "compression", "K = pressure / loss of volume", "Pa", solid.bulk_modulus(), sizes, [&](int n) {
        Measurement m = deform_cube(solid, model, swell, n);
        m.value /= 9.0;  // work 3 P per epsilon, loss of volume 3 epsilon
        return m;
      }));
  rows.push_back(row_of(bench, "bent bar, L/h = 10", "E from the deflection", "Pa", solid.youngs_modulus, sizes,
                        [&](int n) { return bend(solid, model, n); }));
  if (!model.quadratic && !model.lattice) {
    rows.back().gap =
        "linear tetrahedra lock in bending: too stiff by the factor shown at each size, one, two and four "
        "elements through the thickness; quadratic ones do not";
  }
  const std::vector<int> finer = model.quadratic ? sizes : full ? std::vector<int>{2, 4, 8} : std::vector<int>{2, 4};
  rows.push_back(row_of(bench, "torsion", "G from the torque", "Pa", solid.shear_modulus(), finer,
                        [&](int n) { return twist(solid, model, n); }));
  if (model.lattice) {
    report.gaps.push_back(
        "central springs fix Poisson's ratio at 1/4: G = 0.4 E and K = 2/3 E, whatever was asked for");
    for (Row& row : rows) {
      if (row.error() && std::abs(*row.error()) > 0.02) row.gap = "central springs have Poisson's ratio 1/4";
    }
  }
  return report;
}

}  // namespace deformable_sim::study
