// Every test of a rope, with one model of it.
#include <cmath>

#include "bench.h"
#include "deformable_sim/core/energy/rod_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim::study {
namespace {

constexpr double kStrain = 1e-6;

/// A rope on the bench: its nodes first, then, for rods, one angle a segment.
struct RopeSpecimen {
  Specimen specimen;
  int points;
  double radius_of_gyration;  // m; 0 without angles
};

RopeSpecimen make_rope(const RopeData& rope, const std::string& model, double length, int segments) {
  const Polyline line = make_line(length, segments);
  const Eigen::VectorXd masses = line_masses(line, rope.linear_density);
  const int n = segments + 1;
  if (model == "springs") {
    LineStiffness stiffness;
    stiffness.axial = rope.axial;
    const SpringNetwork network = line_network(line, stiffness);
    RopeSpecimen made{Specimen(line.rest, masses), n, 0.0};
    made.specimen.add(make_springs("stretch springs", network.stretch, 0));
    if (!network.bend.empty()) made.specimen.add(make_springs("bend springs", network.bend, 0));
    return made;
  }
  RodSection section;
  section.stretch = rope.axial;
  section.bend_1 = section.bend_2 = rope.bending;
  section.twist = rope.twist;
  section.radius_of_gyration = rope.diameter / std::sqrt(8.0);
  section.linear_density = rope.linear_density;
  RodRest rest;
  rest.director = Vec3::UnitY();
  RodTerms terms = make_rod(line, section, rest, 0, n, 0);
  Nodes columns = Nodes::Zero(3, n + segments);
  columns.leftCols(n) = line.rest;
  columns.row(0).tail(segments) = section.radius_of_gyration * terms.angles.transpose();
  Eigen::VectorXd mass(n + segments);
  mass << masses, terms.angle_masses;
  RopeSpecimen made{Specimen(columns, mass), n, section.radius_of_gyration};
  for (auto& energy : terms.energies) made.specimen.add(std::move(energy));
  made.specimen.state.directors = terms.directors;
  made.specimen.state.tangents = terms.tangents;
  made.specimen.state.reference_twists = terms.reference_twists;
  for (int s = 0; s < segments; ++s) {
    made.specimen.hold(n + s, 1);  // an angle is one coordinate
    made.specimen.hold(n + s, 2);
  }
  return made;
}

Measurement pull(const RopeData& rope, const std::string& model, int segments) {
  const double length = 1.0;
  RopeSpecimen made = make_rope(rope, model, length, segments);
  Specimen& s = made.specimen;
  s.hold(0);
  s.hold(segments);
  if (made.radius_of_gyration > 0.0) s.hold(made.points, 0);  // else it spins freely
  for (int i = 0; i <= segments; ++i) s.state.x(0, i) *= 1.0 + kStrain;
  if (!s.settle().converged) return {made.points, none(), 0.0};
  return {made.points, s.reactions()(0, segments) / kStrain, 0.0};
}

Measurement turn(const RopeData& rope, const std::string& model, int segments) {
  const double length = 1.0, angle = 1e-3;
  RopeSpecimen made = make_rope(rope, model, length, segments);
  Specimen& s = made.specimen;
  const int first = made.points, last = made.points + segments - 1;
  for (const int node : {0, 1, segments - 1, segments}) s.hold(node);
  s.hold(first, 0);
  s.hold(last, 0);
  s.state.x(0, last) += angle * made.radius_of_gyration;
  if (!s.settle().converged) return {made.points, none(), 0.0};
  const double torque = s.reactions()(0, last) * made.radius_of_gyration;
  // Angles are those of the segments' middles.
  return {made.points, torque * (length - length / segments) / angle, 0.0};
}

Overhang hang(const RopeData& rope, const std::string& model, double length, int segments, Nodes* shape) {
  const double element = length / (segments - 0.5);
  RopeSpecimen made = make_rope(rope, model, segments * element, segments);
  Specimen& s = made.specimen;
  s.weigh(Vec3(0, 0, -kStandardGravity), made.points);
  const double clamp = s.rest(0, 0) + 0.5 * element;
  if (made.radius_of_gyration > 0.0) s.hold(made.points, 0);
  // Frames are carried from step to step: always from the straight rod, never from another shape.
  if (shape->cols() == made.points && made.radius_of_gyration == 0.0) {
    for (int i = 2; i < made.points; ++i) {
      s.state.x.col(i) = Vec3(length * (*shape)(0, i) + clamp, 0.0, length * (*shape)(2, i));
    }
  }
  s.hold(0);
  s.hold(1);
  StaticsSettings settings;
  settings.longest_move = 0.3 * length;
  settings.tolerance = 1e-7;
  Overhang found;
  found.settled = s.settle(settings).converged;
  found.nodes = made.points;
  for (int i = 0; i < made.points; ++i) found.shape.push_back({s.state.x(0, i) - clamp, s.state.x(2, i)});
  *shape = s.state.x.leftCols(made.points);
  shape->row(0).array() -= clamp;
  *shape /= length;
  found.chord = std::atan2(-found.shape.back()[1], found.shape.back()[0]);
  return found;
}

Measurement bend(const RopeData& rope, const std::string& model, int segments, std::vector<Curve>* curves) {
  Overhang last;
  Nodes shape;
  const double guess = std::cbrt(kGammaAt41_5 * rope.bending / (rope.linear_density * kStandardGravity));
  const double length = overhang_at_41_5(
      guess, [&](double l) { return hang(rope, model, l, segments, &shape); }, &last);
  if (std::isfinite(length)) {
    curves->push_back({"cantilever, " + std::to_string(segments) + " segments", "x, m", "z, m", last.shape});
  }
  return {last.nodes, rope.linear_density * kStandardGravity * length * length * length / kGammaAt41_5, 0.0};
}

}  // namespace

std::vector<std::string> rope_models() {
  return {"springs", "rod"};
}

Report study_rope(const RopeData& rope, const std::string& model, const Bench& bench) {
  check_model(model, rope_models(), "rope");
  Report report;
  report.material = rope.origin.name;
  report.title = rope.origin.title;
  report.kind = "rope";
  report.model = model;
  report.source = rope.origin.source;
  const std::vector<int> sizes = bench.effort == Effort::kFull ? std::vector<int>{10, 20, 40} : std::vector<int>{8, 16};
  auto& rows = report.rows;
  rows.push_back(row_of(bench, "traction", "EA = force / strain", "N", rope.axial, sizes,
                        [&](int n) { return pull(rope, model, n); }));
  rows.push_back(row_of(bench, "cantilever 41.5", "EI", "N m^2", rope.bending, sizes,
                        [&](int n) { return bend(rope, model, n, &report.curves); }));
  if (model == "springs") {
    rows.back().gap = "bend springs have no linear bending stiffness: what a cantilever shows depends on the mesh";
    report.gaps = {"a chain of springs has no twist: it neither stores nor passes on a torque",
                   "a chain of springs has no linear bending stiffness; use the rod for ropes that stand out"};
  } else {
    rows.push_back(row_of(bench, "torsion", "GJ = torque length / angle", "N m^2", rope.twist, sizes,
                          [&](int n) { return turn(rope, model, n); }));
  }
  return report;
}

}  // namespace deformable_sim::study
