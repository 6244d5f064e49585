// Closed loops and wrapped ropes: the spinning ring and the capstan.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "support/small_worlds.h"
#include "support/system.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

TEST(SpinningRing, HasTheRadiusOfItsPolygon) {
  // R = 2 k l0 s / (4 k s^2 - m omega^2), s = sin(pi / n): springs and centrifugal force balance exactly.
  const double radius0 = 0.4, axial = 60.0, density = 0.2;
  for (const TableRow& row : read_rows("B11_spinning_ring.csv")) {
    const int n = static_cast<int>(row("n_springs"));
    const double l0 = 2.0 * M_PI * radius0 / n, m = density * l0,
                 omega = std::sqrt(row("mu R0^2 w^2/EA") * axial / density) / radius0;
    const double radius = radius0 * row("R_vertex/R0 discrete (l0 = 2 pi R0/n)");
    Nodes x(3, n), v(3, n);
    std::vector<SpringLink> links;
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * M_PI * i / n;
      x.col(i) = radius * Vec3(std::cos(angle), std::sin(angle), 0);
      v.col(i) = omega * Vec3(-x(1, i), x(0, i), 0);
      links.push_back({i, (i + 1) % n, l0, axial / l0, 0.0});
    }
    System ring(x, Eigen::VectorXd::Constant(n, m));
    ring.add(make_springs("ring", links, 0));
    ring.state.v = v;
    const std::string name = "ring of " + std::to_string(n) + ", mu R0^2 w^2/EA = " + row.text("mu R0^2 w^2/EA");
    check("B11", name + ", spring force towards the centre over m omega^2 R",
          -ring.forces().col(0).dot(x.col(0)) / (m * omega * omega * radius * radius), 1.0, 1e-8);
    const auto integrator = make_integrator("rk4", {});
    const int steps = 4000;  // of two turns: (omega dt)^4 / 120 < 1e-12
    for (int k = 0; k < steps; ++k) ring.step(*integrator, 4.0 * M_PI / omega / steps);
    check("B11", name + ", R / R0 after two turns", ring.state.x.colwise().norm().mean() / radius0, radius / radius0,
          1e-8);
  }
}

/// Pull t2 (N) that balances t1 = 1 N over one contact that a rope turns around by `angle` while it slides: t2 cos = t1
/// cos + F, cos of angle / 2, F the friction that the scheme finds under both pulls.
double balance_over_contact(const std::string& scheme, double friction, double angle) {
  const double along = std::cos(0.5 * angle), down = std::sin(0.5 * angle), mass = 1.0;
  const double t1 = 1.0;
  double t2 = t1;
  for (int k = 0; k < 200; ++k) {
    System node(Nodes::Zero(3, 1), Eigen::VectorXd::Constant(1, mass));
    node.add(make_gravity(node.mass, Vec3((t2 - t1) * along, 0.0, -(t1 + t2) * down) / mass));
    node.state.v(0, 0) = 1.0;
    ContactConstraint contact;
    contact.node[0] = 0;
    contact.friction = friction;
    node.dynamics.contacts.assign(1, contact);
    // A penalty gives way by a hundredth of what is still missing, each step.
    const auto integrator = make_integrator(scheme, exact_settings(1e-9));
    for (int step = 0; step < 20; ++step) node.step(*integrator, 1e-5);
    const double next = t1 - node.dynamics.contacts[0].force.x() / along;
    const bool settled = std::abs(next - t2) <= 1e-14 * next;
    t2 = next;
    if (settled) break;
  }
  return t2;
}

TEST(Capstan, IsExactOverThePolygonOfItsContacts) {
  // T2 / T1 = ((1 + mu t) / (1 - mu t))^N, t = tan(phi / 2N): Coulomb's law at each of N contacts.
  for (const TableRow& row : read_rows("B13_capstan.csv")) {
    const double friction = row("mu"), wrap = 2.0 * M_PI * row("turns");
    for (const char* column : {"polygon N=8 contacts", "N=16", "N=32", "N=64"}) {
      const int n = std::atoi(std::strchr(column, '=') + 1);
      for (const std::string scheme : {"symplectic_euler", "implicit_euler"}) {
        const double tension = std::pow(balance_over_contact(scheme, friction, wrap / n), n);
        check("B13",
              "mu " + row.text("mu") + ", " + row.text("turns") + " turns, " + column + ", " + scheme + ", T2 / T1",
              tension, row(column), 1e-8);
      }
    }
  }
}

/// Tension at the pulled end over that at the other one of a rope that slides over a cylinder, wrapped by `turns`. The
/// other end is held by a soft grasp, which its own tension has drawn out.
double capstan_ratio(double friction, double turns, int segments) {
  const double radius = 0.1, gap = 0.002, r = radius + gap, wrapped = 2.0 * M_PI * turns * r, l = wrapped / segments;
  const int tails = static_cast<int>(std::lround(0.05 / l)), n = segments + 2 * tails;
  Nodes x(3, n + 1);
  for (int i = 0; i <= n; ++i) {
    const double s = (i - tails) * l, angle = std::min(std::max(s, 0.0), wrapped) / r;
    const double beyond = s < 0.0 ? s : std::max(0.0, s - wrapped);
    x.col(i) =
        Vec3(r * std::cos(angle) - beyond * std::sin(angle), 0.0, r * std::sin(angle) + beyond * std::cos(angle));
  }
  auto model = points_model(x, 2e-4, Vec3::Zero());
  model->bodies[0].contact_radius = gap;
  model->bodies[0].friction = friction;
  std::vector<SpringLink> links;
  for (int i = 0; i < n; ++i) links.push_back({i, i + 1, l, 2e3, 2.0});
  model->energies.push_back(make_springs("stretch springs", links, 0));

  WorldSettings settings;
  settings.dt = 1e-3;
  settings.solver = exact_settings(1e-3);
  Collider drum = collider("drum", Shape::Type::kCylinder, Vec3(radius, 0.2, 0), at(0, 0, 0, M_PI / 2, Vec3::UnitX()));
  drum.friction = friction;
  GraspRequest slack = grasp_nodes("slack", "points", {0});
  slack.stiffness = 20.0;
  World world(model, settings, {drum}, {slack, grasp_nodes("pull", "points", {n})});
  Pose target = Pose::Identity();
  target.translation() = Vec3(x.col(n)) + 0.08 * Vec3(x.col(n) - x.col(n - 1)).normalized();
  EXPECT_TRUE(world.apply(command::MoveGrasp{"pull", target, 4.0}).status.ok());  // 2 cm/s
  for (int k = 0; k < 3900; ++k) EXPECT_TRUE(world.step().ok);
  const Snapshot s = world.snapshot();
  return s.grasps[1].force.norm() / s.grasps[0].force.norm();
}

TEST(Capstan, AmplifiesTheTensionByTheAngleOfWrap) {
  // T2 / T1 = exp(mu phi) within 2 %; 24 contacts in half a turn. Up to 25: beyond, the soft grasp gives way so little
  // that the rope's slack end slides no faster than the creep of regularised friction, which then is not all there.
  for (const TableRow& row : read_rows("B13_capstan.csv")) {
    const double friction = row("mu"), turns = row("turns");
    const bool fast = (friction == 0.3 && turns == 0.5) || (friction == 0.1 && turns == 0.25);
    if (!(fast || verify_all()) || turns > 1.0 || row("T2/T1 = exp(mu phi)") > 25.0) continue;
    check("B13", "rope on a drum, mu " + row.text("mu") + ", " + row.text("turns") + " turns, T2 / T1",
          capstan_ratio(friction, turns, static_cast<int>(48 * turns)), row("T2/T1 = exp(mu phi)"), 0.02);
  }
}

}  // namespace
}  // namespace deformable_sim::test
