#include "fuzz_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "fuzz_crossing.h"

namespace deformable_sim::fuzz {
namespace {

constexpr double kFar = 1e4;                   // m
constexpr double kLookEvery = 0.02;            // s, simulated
constexpr double kLookForCrossingEvery = 0.1;  // s, simulated: it looks at every pair
constexpr double kSlack = 1e-9;                // s
constexpr double kGrowth = 0.5;
constexpr double kStill = 1e-4;   // m/s: the energy of all bodies at this speed is rounding at rest
constexpr double kHidden = 1e-5;  // m

template <class... Values>
std::string sentence(const char* form, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, form, values...);
  return text;
}

/// Signed distance of a point from a shape, in the shape's frame; positive outside. Shapes without a simple formula:
/// always outside.
double distance(const Shape& s, const Vec3& p) {
  switch (s.type) {
    case Shape::Type::kSphere:
      return p.norm() - s.size[0];
    case Shape::Type::kPlane:
      return p.z();
    case Shape::Type::kCapsule:
      return (p - Vec3(0, 0, std::clamp(p.z(), -0.5 * s.size[1], 0.5 * s.size[1]))).norm() - s.size[0];
    case Shape::Type::kBox: {
      const Vec3 beyond = p.cwiseAbs() - 0.5 * s.size;
      return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
    }
    case Shape::Type::kCylinder: {
      const Eigen::Vector2d beyond(p.head<2>().norm() - s.size[0], std::abs(p.z()) - 0.5 * s.size[1]);
      return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
    }
    case Shape::Type::kCone: {  // right inside; outside, less than it is
      const double radius = s.size[0], length = s.size[1], below_tip = 0.5 * length - p.z();
      const double inside_side = (below_tip * radius - p.head<2>().norm() * length) / std::hypot(radius, length);
      return -std::min(inside_side, length - below_tip);
    }
    default:
      return 1.0;
  }
}

bool says_inside_out(const Snapshot& now) {
  return std::any_of(now.warnings.begin(), now.warnings.end(),
                     [](const std::string& w) { return w.find("inside out") != std::string::npos; });
}

/// By node of the model, not 0: in a grasp.
std::vector<char> held_nodes(const World& world, const Snapshot& now) {
  std::vector<char> held(static_cast<size_t>(world.model().node_count()), 0);
  for (const GraspReport& g : now.grasps) {
    const Body& body = world.model().bodies[static_cast<size_t>(world.model().find_body(g.body))];
    for (const int node : g.nodes) held[static_cast<size_t>(body.first_node + node)] = 1;
  }
  return held;
}

double deepest(const World& world, const Collider& collider, const Snapshot& now) {
  double depth = 0.0;
  const std::vector<char> held = held_nodes(world, now);
  for (const Body& body : world.model().bodies) {
    if (lets_through(collider, body.name)) continue;
    std::vector<char> outside(static_cast<size_t>(body.node_count), body.kind == BodyKind::kSoft ? 0 : 1);
    if (body.kind == BodyKind::kSoft) {
      for (const auto& triangle : body.surface->triangles)
        for (const int node : triangle) outside[static_cast<size_t>(node)] = 1;
    }
    for (int i = 0; i < body.node_count; ++i) {
      if (!outside[static_cast<size_t>(i)] || held[static_cast<size_t>(body.first_node + i)]) continue;
      const Vec3 p = now.x.col(body.first_node + i);
      for (const Shape& shape : collider.shapes) {
        const Pose shape_from_world = (collider.world_from_collider * shape.collider_from_shape).inverse();
        depth = std::max(depth, -distance(shape, shape_from_world * p));
      }
    }
  }
  return depth;
}

}  // namespace

Watch::Watch(const SceneSpec& scene, const World& world, Grasps grasps)
    : explicit_(!make_integrator(world.settings().integrator, world.settings().solver)->needs().jacobian),
      passive_(grasps == Grasps::kRigid && (scene.air.drag_coefficient == 0.0 || scene.air.wind.isZero(0.0))) {}

Finding Watch::look(const World& world) {
  const State& state = world.state();
  const char* integrator = world.settings().integrator.c_str();
  if (!state.finite()) return {"not_finite", sentence("state of %s at %.4g s", integrator, state.time)};
  const double furthest = state.x.cwiseAbs().maxCoeff();
  if (furthest > kFar) return {"far", sentence("%.3g m, %s at %.4g s", furthest, integrator, state.time)};
  if (state.time < next_look_ - kSlack && next_look_ <= state.time + kLookEvery) return {};
  next_look_ = state.time + kLookEvery;
  Snapshot now = world.snapshot();
  Finding finding = look_at_numbers(world, now);
  if (finding.what.empty()) finding = look_at_depth(world, now);
  if (finding.what.empty()) finding = look_at_crossing(world, now);
  if (!finding.what.empty()) return finding;
  return look_at_energy(world, now);
}

Finding Watch::look_at_numbers(const World& world, const Snapshot& now) const {
  const auto bad = [&](const std::string& of) {
    return Finding{"not_finite", of + sentence(" of %s at %.4g s", now.integrator.c_str(), now.time)};
  };
  for (size_t b = 0; b < now.bodies.size(); ++b) {
    const BodyReport& r = now.bodies[b];
    for (const double value : {r.kinetic_energy, r.potential_energy, r.max_strain, r.min_strain})
      if (!std::isfinite(value)) return bad("report of body " + world.model().bodies[b].name);
    // Rubber turned inside out has no energy by its law, which is said.
    const bool no_energy = r.elastic_energy == std::numeric_limits<double>::infinity() && says_inside_out(now);
    if (!std::isfinite(r.elastic_energy) && !no_energy)
      return bad("elastic energy of body " + world.model().bodies[b].name);
    const Body& body = world.model().bodies[b];
    if (body.stress && !body.stress(now.x.middleCols(body.first_node, body.node_count)).allFinite())
      return bad("stress of body " + body.name);
  }
  for (const GraspReport& g : now.grasps) {
    if (!g.force.allFinite() || !g.torque.allFinite() || !std::isfinite(g.load)) return bad("wrench of " + g.name);
    if (!g.world_from_grasp.matrix().allFinite()) return bad("pose of " + g.name);
  }
  for (const Collider& c : now.colliders)
    if (!c.world_from_collider.matrix().allFinite()) return bad("pose of " + c.name);
  if (!now.contact_force.allFinite()) return bad("contact forces");
  for (const ContactReport& c : world.contact_reports()) {
    if (!c.force.allFinite() || !c.point.allFinite() || !c.normal.allFinite() || !std::isfinite(c.distance))
      return bad("a contact");
    if (std::abs(c.normal.norm() - 1.0) > 1e-6) return bad("normal, not of unit length, of a contact");
  }
  if (!now.directors.allFinite() || !now.tangents.allFinite() || !now.rods.allFinite()) return bad("rod frames");
  if (!std::isfinite(now.report.residual)) return bad("residual");
  if (!std::isfinite(now.max_penetration)) return bad("penetration");
  return {};
}

Finding Watch::look_at_depth(const World& world, const Snapshot& now) {
  // Nodes that slipped off at the end of the step were held when depths were measured, and held ones do not count.
  const auto slipped = std::count_if(now.grasps.begin(), now.grasps.end(),
                                     [](const GraspReport& g) { return g.phase == GraspPhase::kSlipped; });
  const bool just_slipped = slipped > slipped_;
  slipped_ = slipped;
  if (just_slipped) return {};
  for (const Collider& c : now.colliders) {
    const double depth = deepest(world, c, now);
    if (depth <= now.max_penetration + kHidden) continue;
    return {"hidden", sentence("%.3g mm inside %s, %.3g mm reported, %s at %.4g s", 1e3 * depth, c.name.c_str(),
                               1e3 * now.max_penetration, now.integrator.c_str(), now.time)};
  }
  return {};
}

Finding Watch::look_at_crossing(const World& world, const Snapshot& now) {
  if (now.time < next_crossing_look_ - kSlack && next_crossing_look_ <= now.time + kLookForCrossingEvery) return {};
  next_crossing_look_ = now.time + kLookForCrossingEvery;
  const std::string found = find_crossing(world.model(), now.x, held_nodes(world, now));
  if (found.empty()) return {};
  return {"crossing", found + sentence(", %s at %.4g s", now.integrator.c_str(), now.time)};
}

bool Watch::has_moved(const Snapshot& now) {
  std::vector<Pose> poses;
  for (const GraspReport& g : now.grasps) poses.push_back(g.world_from_grasp);
  for (const Collider& c : now.colliders) poses.push_back(c.world_from_collider);
  bool same = poses.size() == poses_.size();
  for (size_t k = 0; same && k < poses.size(); ++k) same = poses[k].isApprox(poses_[k], 1e-12);
  poses_ = std::move(poses);
  return !same;
}

Finding Watch::look_at_energy(const World& world, const Snapshot& now) {
  const bool moved = has_moved(now), inside = now.max_penetration > 0.0;
  if (!passive_ || moved || inside || now.integrator == "explicit_euler") {
    quiet_ = false;
    return {};
  }
  double kinetic = 0.0, elastic = 0.0, potential = 0.0;
  for (const BodyReport& r : now.bodies) {
    kinetic += r.kinetic_energy;
    elastic += std::abs(r.elastic_energy);
    potential += r.potential_energy;
  }
  const Vec3 span = now.x.rowwise().maxCoeff() - now.x.rowwise().minCoeff();
  const double mass = world.model().mass.head(world.model().point_count()).sum();
  const double weight = mass * world.model().gravity.norm();
  const double energy = kinetic + elastic + potential;
  if (!quiet_ || energy < least_) {
    least_ = energy;
    scale_ = kinetic + elastic + weight * span.norm();
    top_ = potential;
    quiet_ = true;
    return {};
  }
  // A stiff body gets much elastic energy from errors of position that are nothing to speak of: of implicit schemes
  // only what has become motion counts.
  const double found = explicit_ ? energy : kinetic + potential;
  const double rounding = 0.5 * mass * kStill * kStill;
  const double allowed = kGrowth * (scale_ + std::max(0.0, top_ - potential)) + rounding;
  if (found - least_ <= allowed) return {};
  return {"energy", sentence("%.3g J more than at the least, %.3g J allowed; kinetic %.3g, elastic %.3g, %s at %.4g s",
                             found - least_, allowed, kinetic, elastic, now.integrator.c_str(), now.time)};
}

}  // namespace deformable_sim::fuzz
