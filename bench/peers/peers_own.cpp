// This package's part of the comparison: writes the scenes with their converged solutions, and runs one setting.
//
//   peers_own --write NAME FILE    cloth_40, cloth_80, rope_swing or rope_rest
//   peers_own FILE STEP [LIMIT]    STEP: the keys of `step` of a scene file, "{dt: 0.01, integrator: bdf2}"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/world.h"
#include "peer_scene.h"
#include "scenes.h"

namespace peers {
namespace {

using deformable_sim::Nodes;
using deformable_sim::SpringNetwork;
using deformable_sim::World;

constexpr double kGravity = 9.81;
constexpr double kArealDensity = 0.2, kMembrane = 1e3;  // kg/m^2, N/m
constexpr double kLinearDensity = 0.05, kAxial = 1e4;   // kg/m, N
constexpr double kSpan = 0.6;                           // m, between the ends of the rope at rest
constexpr double kPoisson = 1.0 / 3.0;                  // where shear springs are as stiff as those on free edges
constexpr int kRopeNodes = 200, kFrameRate = 60, kHalvings = 6;
constexpr double kShortest = 1.2e-6;  // s, a step
constexpr double kSameForce = 1e-9;   // relative: rounding
constexpr double kPi = 3.14159265358979323846;

std::string text(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.17g", value);
  return out;
}

/// Cells of the sheet; 0: a rope.
int cells_of(const std::string& name) {
  return name.rfind("cloth_", 0) == 0 ? std::stoi(name.substr(6)) : 0;
}

std::string body_text(const std::string& name) {
  if (const int cells = cells_of(name)) {
    const std::string n = std::to_string(cells);
    return "  - cloth: {name: body, size: [1.0, 1.0], cells: [" + n + ", " + n +
           "], model: springs, bending: springs, pins: [corner_2, corner_3], material: {areal_density: " +
           text(kArealDensity) + ", membrane_stiffness: " + text(kMembrane) + ", poissons_ratio: " + text(kPoisson) +
           ", bend_stiffness: 0, damping: 0}}\n";
  }
  return "  - rope: {name: body, length: 1.0, segments: " + std::to_string(kRopeNodes - 1) +
         ", model: springs, pins: " + (name == "rope_rest" ? "[end_0, end_1]" : "[end_0]") +
         ", material: {linear_density: " + text(kLinearDensity) + ", axial_stiffness: " + text(kAxial) +
         ", bend_stiffness: 0, damping: 0}}\n";
}

/// The scene as this package has it, at its start.
std::unique_ptr<World> build(const Scene& scene, const std::string& step) {
  auto world = deformable_sim::bench::build("step: " + step + "\nair: {damping: " + text(scene.drag) + "}\nbodies:\n" +
                                            body_text(scene.name));
  if (world->state().x.cols() != static_cast<Eigen::Index>(scene.nodes.size())) {
    throw std::runtime_error("the scene has another number of nodes");
  }
  Nodes x(3, world->state().x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    for (int c = 0; c < 3; ++c) x(c, k) = scene.nodes[static_cast<size_t>(k)].x[static_cast<size_t>(c)];
  }
  const auto reply = world->apply(deformable_sim::command::SetBodyState{"body", x, Nodes::Zero(3, x.cols())});
  if (reply.status.code != deformable_sim::Code::kOk) throw std::runtime_error(reply.status.message);
  return world;
}

/// Forces of the links and of gravity, in the plainest way.
Nodes link_forces(const Scene& scene, const Nodes& x) {
  Nodes f = Nodes::Zero(3, x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k) f(2, k) = -kGravity * scene.nodes[static_cast<size_t>(k)].mass;
  for (const Link& link : scene.links) {
    const Eigen::Vector3d d = x.col(link.b) - x.col(link.a);
    const Eigen::Vector3d pull = link.stiffness * (d.norm() - link.rest) * d.normalized();
    f.col(link.a) += pull;
    f.col(link.b) -= pull;
  }
  return f;
}

/// Masses, held nodes and, at a crumpled state, all forces are those of the scene.
void check_world(const Scene& scene, const World& world) {
  const auto& model = world.model();
  deformable_sim::State crumpled = world.state();
  for (Eigen::Index k = 0; k < crumpled.x.cols(); ++k) {
    if (std::abs(model.mass[k] - scene.nodes[static_cast<size_t>(k)].mass) > 1e-12 * model.mass[k]) {
      throw std::runtime_error("masses differ");
    }
    for (int c = 0; c < 3; ++c) crumpled.x(c, k) += 1e-3 * std::sin(1.7 * static_cast<double>(3 * k + c));
  }
  std::vector<bool> held(scene.nodes.size(), false);
  for (const auto& grasp : world.grasp_reports()) {
    for (const int node : grasp.nodes) held[static_cast<size_t>(node)] = true;
  }
  for (size_t k = 0; k < held.size(); ++k) {
    if (held[k] != scene.nodes[k].held) throw std::runtime_error("other nodes are held");
  }
  Nodes f = Nodes::Zero(3, crumpled.x.cols());
  for (const auto& energy : model.energies) energy->add_force(crumpled, &f);
  const Nodes expected = link_forces(scene, crumpled.x);
  if (!((f - expected).norm() <= kSameForce * expected.norm())) {
    throw std::runtime_error("forces differ: the links of the scene are not those of the model");
  }
}

Outcome run(const Scene& scene, const std::string& step, double limit) {
  const auto world = build(scene, step);
  check_world(scene, *world);
  const auto steps = static_cast<int>(std::lround(scene.seconds / world->settings().dt));
  if (std::abs(steps * world->settings().dt - scene.seconds) > 1e-9)
    throw std::runtime_error("dt is no part of the run");
  Outcome outcome;
  long evaluations = 0, linear = 0;
  const double start = deformable_sim::thread_cpu_time();
  int done = 0;
  for (; done < steps && deformable_sim::thread_cpu_time() - start < limit; ++done) {
    const auto result = world->step();
    if (!result.ok) break;
    evaluations += result.report.force_evaluations;
    linear += result.report.linear_iterations;
  }
  outcome.cpu_seconds = deformable_sim::thread_cpu_time() - start;
  outcome.finished = done == steps;
  outcome.detail = std::to_string(done) + " of " + std::to_string(steps) + " steps, " + std::to_string(evaluations) +
                   " force evaluations, " + std::to_string(linear) + " linear iterations";
  for (Eigen::Index k = 0; k < world->state().x.cols(); ++k) {
    outcome.x.push_back({{world->state().x(0, k), world->state().x(1, k), world->state().x(2, k)}});
  }
  return outcome;
}

void copy_links(const SpringNetwork& network, Scene* scene) {
  for (const auto* list : {&network.stretch, &network.shear, &network.bend}) {
    for (const auto& l : *list) scene->links.push_back({l.a, l.b, l.rest_length, l.stiffness});
  }
}

/// Half the angle (rad) of an arc with chord kSpan whose `segments` chords are 1 m together.
double half_angle(int segments) {
  double low = 1e-3, high = kPi;
  for (int k = 0; k < 100; ++k) {
    const double a = 0.5 * (low + high), span = std::sin(a) / (segments * std::sin(a / segments));
    (span > kSpan ? low : high) = a;
  }
  return 0.5 * (low + high);
}

/// Masses, links and the start.
Scene make_scene(const std::string& name) {
  Scene scene;
  scene.name = name;
  scene.gravity = kGravity;
  scene.seconds = name == "rope_rest" ? 5.0 : 0.5;
  scene.drag = name == "rope_rest" ? 4.0 : 0.0;
  Nodes x;
  Eigen::VectorXd mass;
  if (const int cells = cells_of(name)) {
    const auto mesh = deformable_sim::make_grid(1.0, 1.0, cells, cells);
    deformable_sim::SheetStiffness stiffness;
    stiffness.membrane = kMembrane;
    stiffness.poissons_ratio = kPoisson;
    stiffness.bend = 0.0;
    copy_links(deformable_sim::sheet_network(mesh, stiffness), &scene);
    mass = deformable_sim::sheet_masses(mesh, kArealDensity);
    x = mesh.rest;
  } else {
    const auto line = deformable_sim::make_line(1.0, kRopeNodes - 1);
    deformable_sim::LineStiffness stiffness;
    stiffness.axial = kAxial;
    stiffness.bend = 0.0;
    copy_links(deformable_sim::line_network(line, stiffness), &scene);
    mass = deformable_sim::line_masses(line, kLinearDensity);
    x = line.rest;
    if (name == "rope_rest") {
      const int segments = kRopeNodes - 1;
      const double half = half_angle(segments), radius = 0.5 * kSpan / std::sin(half);
      for (int k = 0; k <= segments; ++k) {
        const double angle = half * (2.0 * k / segments - 1.0);
        x.col(k) << radius * std::sin(angle), 0.0, radius * (std::cos(half) - std::cos(angle));
      }
    }
  }
  for (Eigen::Index k = 0; k < x.cols(); ++k) scene.nodes.push_back({{{x(0, k), x(1, k), x(2, k)}}, mass[k], false});
  const auto world = deformable_sim::bench::build("bodies:\n" + body_text(name));
  const auto& features = world->model().bodies.front().features;
  const bool cloth = cells_of(name) > 0;
  for (const int k : features.at(cloth ? "corner_2" : "end_0")) scene.nodes[static_cast<size_t>(k)].held = true;
  if (cloth || name == "rope_rest") {
    for (const int k : features.at(cloth ? "corner_3" : "end_1")) scene.nodes[static_cast<size_t>(k)].held = true;
  }
  const double nominal = cloth ? kArealDensity : kLinearDensity;
  if (std::abs(total_mass(scene) - nominal) > 1e-12) throw std::runtime_error("the mass is not that of the body");
  scene.solution.resize(scene.nodes.size());
  return scene;
}

/// Explicit steps at the limit of stability, halved again and again; the last differs by what is printed.
void solve_in_time(Scene* scene) {
  const std::string frame = "{dt: " + text(1.0 / kFrameRate) + ", integrator: substepped_verlet}";
  const int parts = build(*scene, frame)->step().report.force_evaluations - 1;
  double before = 0.0;
  for (int k = 0; k <= kHalvings; ++k) {
    const double dt = 1.0 / (kFrameRate * static_cast<double>(parts << k));
    if (dt < kShortest) break;
    const Outcome outcome = run(*scene, "{dt: " + text(dt) + ", integrator: substepped_verlet}", 1e9);
    if (!outcome.finished) throw std::runtime_error("the reference failed");
    const double change = rms_distance(outcome.x, scene->solution);
    scene->solution = outcome.x;
    if (k > 0) std::printf("  %.4g s: %.3g mm from the one before", dt, 1e3 * change);
    std::printf(k > 1 ? " (%.2f times less)\n" : k > 0 ? "\n" : "", before / change);
    before = change;
  }
  // Another scheme: its error is of fourth order, so that the difference is what is left in the solution.
  const double dt = 1.0 / (kFrameRate * static_cast<double>(2 * parts));
  const Outcome other = run(*scene, "{dt: " + text(dt) + ", integrator: rk4}", 1e9);
  std::printf("  rk4 at %.4g s: %.3g mm from the last\n", dt, 1e3 * rms_distance(other.x, scene->solution));
}

/// The chain in balance: tension is (H, V), V what hangs below; each segment is stretched by |tension| / k. H is found
/// from the span.
std::vector<Point> hanging_chain(const Scene& scene, double horizontal) {
  double below = -0.5 * kGravity * total_mass(scene);
  std::vector<Point> x{{{0.0, 0.0, 0.0}}};
  for (size_t k = 0; k < scene.links.size(); ++k) {
    below += kGravity * scene.nodes[k].mass;
    const double tension = std::hypot(horizontal, below);
    const double length = scene.links[k].rest + tension / scene.links[k].stiffness;
    x.push_back({{x.back()[0] + length * horizontal / tension, 0.0, x.back()[2] + length * below / tension}});
  }
  for (Point& p : x) p[0] -= 0.5 * kSpan;
  return x;
}

void solve_at_rest(Scene* scene) {
  double low = 1e-6, high = 10.0;  // N
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (low + high);
    (hanging_chain(*scene, middle).back()[0] < 0.5 * kSpan ? low : high) = middle;
  }
  scene->solution = hanging_chain(*scene, low);
  double worst = 0.0;
  // The inextensible catenary z = a (cosh(x / a) - cosh(s / a)) with 2 a sinh(s / a) = 1, s half the span.
  double a_low = 1e-2, a_high = 10.0;
  for (int k = 0; k < 200; ++k) {
    const double a = 0.5 * (a_low + a_high);
    (2.0 * a * std::sinh(0.5 * kSpan / a) > 1.0 ? a_low : a_high) = a;
  }
  for (const Point& p : scene->solution) {
    const double z = a_low * (std::cosh(p[0] / a_low) - std::cosh(0.5 * kSpan / a_low));
    worst = std::max(worst, std::abs(p[2] - z));
  }
  std::printf("  exact balance of the chain; at most %.3g mm from the inextensible catenary\n", 1e3 * worst);
  const Outcome settled =
      run(*scene, "{dt: 0.002, integrator: tr_bdf2, linear_solver: banded, tolerance: 1.0e-6, newton_iterations: 100}",
          1e9);
  std::printf("  tr_bdf2 after %g s: %.3g mm from it\n", scene->seconds,
              1e3 * rms_distance(settled.x, scene->solution));
}

void write(const std::string& name, const std::string& path) {
  Scene scene = make_scene(name);
  std::printf("%s: %zu nodes, %zu links, %.4g kg\n", name.c_str(), scene.nodes.size(), scene.links.size(),
              total_mass(scene));
  if (name == "rope_rest") {
    solve_at_rest(&scene);
  } else {
    solve_in_time(&scene);
  }
  write_scene(scene, path);
}

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: peers_own --write NAME FILE | peers_own FILE STEP [LIMIT]\n");
    return 2;
  }
  try {
    if (std::strcmp(argv[1], "--write") == 0 && argc == 4) {
      peers::write(argv[2], argv[3]);
      return 0;
    }
    const peers::Scene scene = peers::read_scene(argv[1]);
    const peers::Outcome outcome = peers::run(scene, argv[2], argc > 3 ? std::stod(argv[3]) : 60.0);
    std::printf("%s\n", peers::json_line(scene, outcome).c_str());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "peers_own: %s\n", e.what());
    return 1;
  }
  return 0;
}
