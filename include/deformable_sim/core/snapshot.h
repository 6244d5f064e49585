// An immutable copy of what publishers and reports show: one instant of the world.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/contact/contact_report.h"
#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

struct BodyReport {
  double kinetic_energy = 0.0;    // J
  double elastic_energy = 0.0;    // J
  double potential_energy = 0.0;  // J, gravity, zero at z = 0
  double max_strain = 0.0;        // largest relative elongation of a structural edge
  double min_strain = 0.0;        // most negative one
  int contacts = 0;               // contact points with a force
};

/// How much of it is filled.
enum class SnapshotDetail { kMotion, kReports };

struct PartCost {
  std::string part;
  double seconds_per_second = 0.0;  // thread CPU s per simulated s, over the last 50 steps or so
};

struct Snapshot {
  double time = 0.0;  // s
  std::uint64_t step = 0;
  std::shared_ptr<const Model> model;
  Nodes x, v;
  // Of each segment of rods with twist, as Body::first_segment counts them: the first material director, and the
  // tangent it is normal to (unit; the second director is tangent x first). Empty without such rods.
  Nodes directors, tangents;
  RodState rods;                   // of those segments, for SetBodyState
  std::vector<BodyReport> bodies;  // parallel to model->bodies; kMotion: contacts only (nor cost and warnings)
  Eigen::VectorXf contact_force;   // N at each node, normal and friction; empty when nothing touches
  std::vector<GraspReport> grasps;
  std::vector<Collider> colliders;
  std::vector<ContactReport> contacts;  // only where World::contact_reports() was asked for them
  StepReport report;
  std::string integrator;
  double dt = 0.0;              // s
  int substeps = 1;             // of the last step
  std::uint64_t repeated = 0;   // steps that were begun anew in shorter parts, since the start
  double energy_created = 0.0;  // J since the start that no work explains
  double max_penetration =
      0.0;  // m, deepest contact point now inside a collider's surface (contact radius not counted)
  std::vector<PartCost> cost;
  std::vector<std::string> warnings;
};

/// Largest |relative elongation| with its sign over the structural edges at each node of a body (size node_count).
Eigen::VectorXf node_strain(const Body& body, const Nodes& x);
/// Unit outward normal per node of a cloth (area weighted), 3 x node_count.
Eigen::Matrix3Xf node_normals(const Body& body, const Nodes& x);

}  // namespace deformable_sim
