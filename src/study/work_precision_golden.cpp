// The bodies of test/verify/data/golden_*.csv, whose trajectories an independent program has computed; README.md there
// says what they are.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "deformable_sim/core/energy/terms.h"
#include "work_precision_case.h"

namespace deformable_sim::work_precision {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

struct Masses {
  Nodes x, v;
  double mass = 0.01;  // kg, each
  std::vector<SpringLink> links;
  std::vector<int> held;
  double gravity = kGravity;
  double seconds = 1.0;  // of the table
  BodyKind kind = BodyKind::kRope;
};

Masses chain(double stiffness, double damping, double seconds) {
  Masses m;
  m.x = m.v = Nodes::Zero(3, 10);
  m.held = {0};
  m.seconds = seconds;
  for (int i = 0; i < 10; ++i) {
    m.x(0, i) = 0.1 * i;
    if (i > 0) m.links.push_back({i - 1, i, 0.1, stiffness, damping});
  }
  return m;
}

Masses ring() {
  constexpr int n = 16;
  constexpr double kRadius = 0.3, kPi = 3.14159265358979323846;
  Masses m;
  m.x.resize(3, n);
  m.v.resize(3, n);
  m.gravity = 0.0;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * kPi * i / n;
    m.x.col(i) = 1.1 * kRadius * Vec3(std::cos(angle), std::sin(angle), 0.0);
    m.v.col(i) = 5.0 * Vec3(-m.x(1, i), m.x(0, i), 0.0) + Vec3(0, 0, 0.2 * std::cos(2.0 * angle));
    m.links.push_back({i, (i + 1) % n, 2.0 * kRadius * std::sin(kPi / n), 500.0, 0.0});
  }
  return m;
}

Masses provot_sheet() {
  constexpr int n = 6;
  constexpr double a = 0.05;
  Masses m;
  m.kind = BodyKind::kCloth;
  m.mass = 0.001;
  m.seconds = 0.5;
  m.x.resize(3, n * n);
  m.v = Nodes::Zero(3, n * n);
  m.held = {0, n - 1};
  const auto link = [&m](int i, int j, int di, int dj, double stiffness) {
    if (i + di >= n || j + dj < 0 || j + dj >= n) return;
    m.links.push_back({i * n + j, (i + di) * n + j + dj, a * std::hypot(di, dj), stiffness, 0.0});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      m.x.col(i * n + j) = Vec3(a * i, a * j, 0.002 * std::sin(3.0 * i + 2.0 * j));
      for (const auto& [di, dj] : {std::array<int, 2>{1, 0}, {0, 1}}) {
        link(i, j, di, dj, 100.0);
        link(i, j, 2 * di, 2 * dj, 10.0);
      }
      link(i, j, 1, 1, 50.0);
      link(i, j, 1, -1, 50.0);
    }
  }
  return m;
}

Masses lattice() {
  constexpr int n = 3;
  constexpr double a = 0.1;
  constexpr std::array<double, 4> kStiffness = {0.0, 500.0, 250.0, 125.0};
  Masses m;
  m.kind = BodyKind::kSoft;
  m.seconds = 0.5;
  m.x.resize(3, n * n * n);
  m.v = Nodes::Zero(3, n * n * n);
  for (int node = 0; node < n * n * n; ++node) {
    const int i = node / (n * n), j = node / n % n, k = node % n;
    const double angle = 0.3 * i / (n - 1.0), y = a * (j - 1), z = a * (k - 1);
    m.x.col(node) =
        Vec3(a * i, a + std::cos(angle) * y - std::sin(angle) * z, a + std::sin(angle) * y + std::cos(angle) * z);
    if (i == 0) m.held.push_back(node);
    for (int to = node + 1; to < n * n * n; ++to) {
      const int di = to / (n * n) - i, dj = to / n % n - j, dk = to % n - k;
      if (std::max({std::abs(di), std::abs(dj), std::abs(dk)}) > 1) continue;
      const int axes = di * di + dj * dj + dk * dk;
      m.links.push_back({node, to, a * std::sqrt(axes), kStiffness[static_cast<size_t>(axes)], 0.0});
    }
  }
  return m;
}

Masses masses_of(const std::string& name) {
  if (name == "golden_chain10_soft") return chain(1e3, 0.0, 1.0);
  if (name == "golden_chain10_soft_damped") return chain(1e3, 0.05, 1.0);
  if (name == "golden_chain10_stiff") return chain(1e5, 0.0, 0.5);
  if (name == "golden_ring16") return ring();
  if (name == "golden_provot6") return provot_sheet();
  return lattice();
}

std::shared_ptr<const Model> model_of(const Masses& m) {
  auto model = std::make_shared<Model>();
  const auto count = m.x.cols();
  Body body;
  body.name = "masses";
  body.kind = m.kind;
  body.node_count = static_cast<int>(count);
  for (const SpringLink& link : m.links) body.strain_edges.push_back({{link.a, link.b}, link.rest_length});
  model->bodies.push_back(std::move(body));
  model->mass = Eigen::VectorXd::Constant(count, m.mass);
  model->gravity = Vec3(0, 0, -m.gravity);
  model->energies.push_back(make_springs("springs", m.links, 0));
  if (m.gravity > 0.0) model->energies.push_back(make_gravity(model->mass, model->gravity));
  model->initial.x = m.x;
  model->initial.v = m.v;
  return model;
}

class GoldenCase : public Case {
 public:
  explicit GoldenCase(const std::string& table) : masses_(masses_of(table)), model_(model_of(masses_)) {
    name = table;
    title = "Trajectory of an independent program";
    seconds = masses_.seconds;
    path_ = package_dir() + "/test/verify/data/" + table + ".csv";
    digest = digest_of(content_of(path_));
    features.kind = masses_.kind == BodyKind::kRope ? "rope" : masses_.kind == BodyKind::kSoft ? "soft" : "cloth";
    features.nodes = static_cast<int>(masses_.x.cols());
    const double extent = (masses_.x.rowwise().maxCoeff() - masses_.x.rowwise().minCoeff()).maxCoeff();
    const SpringLink& link = masses_.links.front();
    features.stiffness_ratio =
        link.stiffness * link.rest_length / (masses_.mass * kGravity * extent / link.rest_length);
  }

  std::unique_ptr<World> make(double dt, const std::string& integrator, const SolverSettings& settings) const override {
    WorldSettings world;
    world.dt = dt;
    world.integrator = integrator;
    world.solver = settings;
    std::vector<GraspRequest> grasps;
    if (!masses_.held.empty()) {
      GraspRequest held;
      held.name = "held";
      held.body = "masses";
      held.selection.method = SelectionMethod::kNodes;
      held.selection.nodes = masses_.held;
      grasps.push_back(held);
    }
    return std::make_unique<World>(model_, world, std::vector<Collider>(), grasps);
  }

  Trajectory table() const override {
    Trajectory quarters(kQuarters);
    std::vector<State> states(kQuarters);
    for (State& s : states) s.x = s.v = Nodes::Zero(3, masses_.x.cols());
    std::ifstream stream(path_);
    std::string line;
    std::getline(stream, line);
    while (std::getline(stream, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      double t = 0.0;
      Eigen::Index node = 0;
      Vec3 x, v;
      words >> t >> node >> x[0] >> x[1] >> x[2] >> v[0] >> v[1] >> v[2];
      if (!words || node < 0 || node >= masses_.x.cols()) throw InputError(path_ + ": '" + line + "' is no row");
      const double quarter = t / this->quarter();
      const auto k = static_cast<size_t>(std::lround(quarter));
      if (k < 1 || k > kQuarters || std::abs(quarter - static_cast<double>(k)) > 1e-9) continue;
      states[k - 1].x.col(node) = x;
      states[k - 1].v.col(node) = v;
    }
    for (size_t k = 0; k < kQuarters; ++k) {
      quarters[k].x = states[k].x;
      quarters[k].kinetic = 0.5 * masses_.mass * states[k].v.squaredNorm();
      for (const auto& energy : model_->energies) quarters[k].stored += energy->value(states[k]);
    }
    return quarters;
  }

 private:
  Masses masses_;
  std::shared_ptr<const Model> model_;
  std::string path_;
};

}  // namespace

std::vector<std::string> golden_names() {
  return {"golden_chain10_soft",  "golden_chain10_soft_damped",
          "golden_chain10_stiff", "golden_lattice3",
          "golden_provot6",       "golden_ring16"};
}

std::unique_ptr<Case> golden_case(const std::string& name) {
  return std::make_unique<GoldenCase>(name);
}

}  // namespace deformable_sim::work_precision
