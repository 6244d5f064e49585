// One run of Bullet on a scene of the comparison: its position-based or its deformable world, as Debian ships it.
//
// Built twice, against the single and the double precision libraries. Nothing here knows the other simulator: masses,
// links and held nodes come from the scene file, and are checked against it again once Bullet has them.
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "peer_scene.h"

namespace peers {
namespace {

constexpr double kRounding = 1e-5;  // relative, of single precision
constexpr double kSdfVoxel = 0.02;  // m: only matters beside colliders, where other sizes let nodes through
constexpr int kStepsPerLook = 16;   // between two looks at the limit of time

double thread_cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Settings {
  std::string world = "position";   // or: deformable
  int rate = 960;                   // steps a second
  int iterations = 10;              // position: passes over all links a step
  std::string stiffness = "rigid";  // position: kLST = 1; or: matched
  std::string order = "natural";    // position: of the links; or: random, spread
  std::string scheme = "implicit";  // deformable; or: line_search, explicit
  double limit = 60.0;              // s of CPU time, then the run is given up
};

Settings settings_from(int argc, char** argv) {
  Settings s;
  std::map<std::string, std::string*> texts{
      {"--world", &s.world}, {"--stiffness", &s.stiffness}, {"--order", &s.order}, {"--scheme", &s.scheme}};
  for (int k = 2; k + 1 < argc; k += 2) {
    const std::string key = argv[k], value = argv[k + 1];
    if (texts.count(key) > 0) {
      *texts[key] = value;
    } else if (key == "--rate") {
      s.rate = std::stoi(value);
    } else if (key == "--iterations") {
      s.iterations = std::stoi(value);
    } else if (key == "--limit") {
      s.limit = std::stod(value);
    } else {
      throw std::runtime_error("unknown option " + key);
    }
  }
  return s;
}

/// kLST with which `iterations` passes over a link alone take the step that its real stiffness takes in implicit Euler:
/// a pass removes the part kLST of the elongation, all passes together a / (1 + a), a = k dt^2 (1/m_a + 1/m_b).
double matched_kLST(double stiffness, double inverse_masses, double dt, int iterations) {
  const double a = stiffness * inverse_masses * dt * dt;
  return 1.0 - std::pow(1.0 + a, -1.0 / iterations);
}

/// Masses and links of the scene. Faces are left out: they cost time and only contact needs them.
std::unique_ptr<btSoftBody> make_body(const Scene& scene, const Settings& s, btSoftBodyWorldInfo* info) {
  const int n = static_cast<int>(scene.nodes.size());
  std::vector<btVector3> x;
  std::vector<btScalar> mass;
  for (const Node& node : scene.nodes) {
    x.emplace_back(static_cast<btScalar>(node.x[0]), static_cast<btScalar>(node.x[1]),
                   static_cast<btScalar>(node.x[2]));
    mass.push_back(static_cast<btScalar>(node.mass));
  }
  auto body = std::make_unique<btSoftBody>(info, n, x.data(), mass.data());
  for (int k = 0; k < n; ++k) {
    if (scene.nodes[static_cast<size_t>(k)].held) body->setMass(k, 0);
  }
  body->m_materials[0]->m_kLST = 1;
  std::map<double, btSoftBody::Material*> materials;
  for (const Link& link : scene.links) {
    btSoftBody::Material* material = body->m_materials[0];
    if (s.stiffness == "matched") {
      const double inverse_masses = body->m_nodes[link.a].m_im + body->m_nodes[link.b].m_im;
      btSoftBody::Material*& own = materials[link.stiffness * inverse_masses];
      if (own == nullptr) {
        own = body->appendMaterial();
        own->m_kLST = static_cast<btScalar>(matched_kLST(link.stiffness, inverse_masses, 1.0 / s.rate, s.iterations));
      }
      material = own;
    }
    body->appendLink(link.a, link.b, material);
  }
  // Bullet takes rest lengths from positions in its first step unless told that this was done.
  body->updateConstants();
  for (int k = 0; k < body->m_links.size(); ++k) {
    body->m_links[k].m_rl = static_cast<btScalar>(scene.links[static_cast<size_t>(k)].rest);
  }
  body->updateLinkConstants();
  body->m_bUpdateRtCst = false;
  body->m_cfg.piterations = s.iterations;
  body->m_cfg.collisions = 0;
  body->m_cfg.drag = 0;
  body->m_cfg.kDP = static_cast<btScalar>(1.0 - std::exp(-scene.drag / s.rate));
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

void agree(double expected, double found, const char* what) {
  if (!(std::abs(found - expected) <= kRounding * std::abs(expected))) {
    throw std::runtime_error(std::string(what) + " differs: " + std::to_string(expected) + " in the scene, " +
                             std::to_string(found) + " in Bullet");
  }
}

/// Mass, held nodes and links are those of the scene.
void check_body(const Scene& scene, const btSoftBody& body) {
  agree(static_cast<double>(scene.nodes.size()), body.m_nodes.size(), "number of nodes");
  agree(static_cast<double>(scene.links.size()), body.m_links.size(), "number of links");
  double free_mass = 0.0, bullet_mass = 0.0;
  for (size_t k = 0; k < scene.nodes.size(); ++k) {
    const btSoftBody::Node& node = body.m_nodes[static_cast<int>(k)];
    if (scene.nodes[k].held != (node.m_im == 0)) throw std::runtime_error("other nodes are held in Bullet");
    if (scene.nodes[k].held) continue;
    free_mass += scene.nodes[k].mass;
    bullet_mass += 1.0 / static_cast<double>(node.m_im);
  }
  agree(free_mass, bullet_mass, "mass of the free nodes");
  for (size_t k = 0; k < scene.links.size(); ++k) {
    const btSoftBody::Link& link = body.m_links[static_cast<int>(k)];
    const Link& wanted = scene.links[k];
    if (link.m_n[0] != &body.m_nodes[wanted.a] || link.m_n[1] != &body.m_nodes[wanted.b]) {
      throw std::runtime_error("link " + std::to_string(k) + " has other ends in Bullet");
    }
    agree(wanted.rest, link.m_rl, "rest length");
  }
}

/// Steps `world` to the end of the scene, after each step calling `after`.
template <class World, class After>
Outcome run(const Scene& scene, const Settings& s, World* world, const btSoftBody& body, After after) {
  const auto dt = static_cast<btScalar>(1.0 / s.rate);
  const auto steps = static_cast<int>(std::lround(scene.seconds * s.rate));
  Outcome outcome;
  const double start = thread_cpu_time();
  int done = 0;
  for (; done < steps; ++done) {
    if (done % kStepsPerLook == 0 && thread_cpu_time() - start > s.limit) break;
    world->stepSimulation(dt, 0);  // 0: one step of exactly dt
    after();
  }
  outcome.cpu_seconds = thread_cpu_time() - start;
  outcome.finished = done == steps;
  outcome.detail = std::to_string(done) + " of " + std::to_string(steps) + " steps";
  for (int k = 0; k < body.m_nodes.size(); ++k) {
    const btVector3& x = body.m_nodes[k].m_x;
    outcome.x.push_back({{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])}});
  }
  return outcome;
}

void set_environment(const Scene& scene, btSoftBodyWorldInfo* info, btDiscreteDynamicsWorld* world) {
  const btVector3 gravity(0, 0, static_cast<btScalar>(-scene.gravity));
  world->setGravity(gravity);
  info->m_gravity = gravity;
  info->m_sparsesdf.setDefaultVoxelsz(static_cast<btScalar>(kSdfVoxel));
}

Outcome run_position(const Scene& scene, const Settings& s) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  set_environment(scene, &world.getWorldInfo(), &world);
  const auto body = make_body(scene, s, &world.getWorldInfo());
  check_body(scene, *body);
  if (s.order == "random") body->randomizeConstraints();
  if (s.order == "spread") btSoftBodyHelpers::ReoptimizeLinkOrder(body.get());
  world.addSoftBody(body.get());
  const Outcome outcome = run(scene, s, &world, *body, [] {});
  world.removeSoftBody(body.get());
  return outcome;
}

/// The one force of a soft body has two stiffnesses: that of links, and that of links marked as bending.
std::pair<double, double> two_stiffnesses(const Scene& scene, btSoftBody* body) {
  const double first = scene.links.front().stiffness;
  double second = first;
  for (size_t k = 0; k < scene.links.size(); ++k) {
    const double stiffness = scene.links[k].stiffness;
    if (std::abs(stiffness - first) <= kRounding * first) continue;
    if (second == first) second = stiffness;
    if (std::abs(stiffness - second) > kRounding * second) {
      throw std::runtime_error("the deformable world knows two stiffnesses; the scene has more");
    }
    body->m_links[static_cast<int>(k)].m_bbending = 1;
  }
  return {first, second};
}

Outcome run_deformable(const Scene& scene, const Settings& s) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btDeformableBodySolver body_solver;
  btDeformableMultiBodyConstraintSolver solver;
  solver.setDeformableSolver(&body_solver);
  btDeformableMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &body_solver);
  set_environment(scene, &world.getWorldInfo(), &world);
  const bool implicit = s.scheme != "explicit";
  world.setImplicit(implicit);
  world.setLineSearch(s.scheme == "line_search");
  world.setUseProjection(true);  // without it the implicit mode does not hold what is held
  const auto body = make_body(scene, s, &world.getWorldInfo());
  check_body(scene, *body);
  world.addSoftBody(body.get());
  const auto [first, second] = two_stiffnesses(scene, body.get());
  btDeformableMassSpringForce springs(static_cast<btScalar>(first), 0, true, second);
  btDeformableGravityForce gravity(btVector3(0, 0, static_cast<btScalar>(-scene.gravity)));
  world.addForce(body.get(), &springs);
  world.addForce(body.get(), &gravity);
  const auto keep = static_cast<btScalar>(std::exp(-scene.drag / s.rate));
  const Outcome outcome = run(scene, s, &world, *body, [&] {
    if (keep == 1) return;
    for (int k = 0; k < body->m_nodes.size(); ++k) body->m_nodes[k].m_v *= keep;
  });
  world.removeSoftBody(body.get());
  return outcome;
}

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: peers_bullet SCENE [--world position|deformable] [--rate HZ] [--iterations N] ...\n");
    return 2;
  }
  try {
    const peers::Scene scene = peers::read_scene(argv[1]);
    const peers::Settings settings = peers::settings_from(argc, argv);
    const peers::Outcome outcome =
        settings.world == "position" ? peers::run_position(scene, settings) : peers::run_deformable(scene, settings);
    std::printf("%s\n", peers::json_line(scene, outcome).c_str());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "peers_bullet: %s\n", e.what());
    return 1;
  }
  return 0;
}
