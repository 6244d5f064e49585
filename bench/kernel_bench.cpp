// Kernels of sheets on grids: what a node costs, and how far the result is from that of the terms they stand for.
//
// A crumpled square of 1 m, 0.2 kg/m2, E h = 1e3 N/m and B = 1e-5 N m, at every instruction set that this machine has.
// error: largest difference over the largest value, against the same in double precision from terms and matrices that
// are assembled. A preconditioned iteration has none: it is a preconditioner and a product.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "deformable_sim/core/grid/sheet_system.h"
#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/core/integrator/sheet_motion.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kBetweenClocks = 2e-3;  // s
constexpr int kRepeats = 40;             // the fastest counts
constexpr double kTau = 1.0 / 180.0;     // s, of the matrix: BDF2 at 120 Hz
constexpr double kCrumple = 0.05;        // of a cell

/// The sheet as terms, as a grid, and crumpled.
struct Sheet {
  explicit Sheet(int cells) {
    std::ostringstream text;
    text << "bodies:\n  - cloth: {name: sheet, size: [1, 1], cells: [" << cells << ", " << cells
         << "], bending: quadratic, material: {areal_density: 0.2, membrane_stiffness: 1.0e3, "
            "bending_rigidity: 1.0e-5, damping: 0, bending_damping: 0.01}}\n";
    world = build(text.str());
    grid = &world->model().grids.front();
    state = world->state();
    std::mt19937 random(7);
    std::normal_distribution<double> some(0.0, kCrumple / cells);
    for (Eigen::Index i = 0; i < state.x.size(); ++i) {
      state.x.data()[i] += some(random);
      state.v.data()[i] += 10.0 * some(random);
    }
  }
  const Eigen::VectorXd& mass() const { return world->model().mass; }
  int nodes() const { return grid->node_count(); }

  Nodes force() const {
    Nodes f = Nodes::Zero(3, state.x.cols());
    for (const Energy* term : grid->replaces) term->add_force(state, &f);
    return f;
  }
  /// (M / tau^2 - df/dx - (1 / tau) df/dv) p.
  Nodes product(const Nodes& p) const {
    std::vector<std::array<int, 2>> pairs;
    const std::vector<std::unique_ptr<Energy>>& all = world->model().energies;
    for (const auto& term : all) term->add_pattern(&pairs);
    BlockMatrix a(nodes(), pairs);
    for (const auto& term : all) {
      if (std::find(grid->replaces.begin(), grid->replaces.end(), term.get()) == grid->replaces.end()) continue;
      term->bind(a);
      term->add_jacobian(state, 1.0, 1.0 / kTau, Jacobian::kProjected, &a);
    }
    for (int i = 0; i < nodes(); ++i) a.block(a.diagonal_slot(i)).diagonal().array() += mass()[i] / (kTau * kTau);
    Nodes y;
    a.multiply(p, &y);
    return y;
  }

  std::unique_ptr<World> world;
  const GridSheet* grid;
  State state;
};

double relative(const Nodes& found, const Nodes& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

/// s for one call, the fastest of kRepeats groups.
double seconds(const std::function<void()>& work) {
  int count = 1;
  double best = 1e9;
  for (int k = 0; k < kRepeats; ++k) {
    const double start = thread_cpu_time();
    for (int i = 0; i < count; ++i) work();
    const double spent = thread_cpu_time() - start;
    best = std::min(best, spent / count);
    count = std::max(1, static_cast<int>(kBetweenClocks / best));
  }
  return best;
}

void report(benchmark::State& state, const Sheet& sheet, double seconds, double error) {
  state.counters["nodes"] = sheet.nodes();
  state.counters["ns_per_node"] = 1e9 * seconds / sheet.nodes();
  if (error >= 0.0) state.counters["error"] = error;
}

/// Force, kick and drift of an explicit part.
template <class Real>
void sub_step(benchmark::State& state, const Sheet& sheet, SimdLevel level) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(sheet.nodes());
  for (auto _ : state) {
    SheetMotion<Real> kicked(*sheet.grid, ones, {}, level);
    Nodes x = sheet.state.x, v = sheet.state.v;
    kicked.load(x, v, 1.0);
    kicked.leap(1.0, 0.0, MassForce(), nullptr);
    kicked.store(&x, &v);
    SheetMotion<Real> motion(*sheet.grid, sheet.mass(), {}, level);
    motion.load(sheet.state.x, sheet.state.v, 1.0);
    const double time = seconds([&] { motion.leap(1e-9, 1e-9, MassForce(), nullptr); });
    report(state, sheet, time, relative(v - sheet.state.v, sheet.force()));
  }
}

/// Forces of an implicit stage.
void force(benchmark::State& state, const Sheet& sheet, SimdLevel level) {
  for (auto _ : state) {
    SheetRows<double> rows(*sheet.grid);
    auto x = rows.make_xyz(), v = rows.make_xyz(), y = rows.make_xyz(), f = rows.make_xyz();
    rows.load(sheet.state.x, x.data());
    rows.load(sheet.state.v, v.data());
    rows.load(sheet.state.x + sheet.grid->bending_damping * sheet.state.v, y.data());
    const double time = seconds(
        [&] { sheet_kernels(level).forces(rows.shape(), x.data(), v.data(), y.data(), f.data(), rows.scratch()); });
    Nodes found = Nodes::Zero(3, sheet.nodes());
    rows.store(f.data(), &found);
    report(state, sheet, time, relative(found, sheet.force()));
  }
}

/// The linear system of a stage at the state of the sheet.
struct System {
  explicit System(const Sheet& sheet)
      : system(*sheet.grid, {sheet.mass().data(), sheet.mass().data() + sheet.nodes()},
               std::vector<char>(static_cast<size_t>(sheet.nodes()), 1)),
        fine(*sheet.grid) {
    const double rate = 1.0 / (kTau * kTau);
    for (int k = 0; k < sheet.nodes(); ++k) {
      system.inertia()[system.rows().place(k)] = static_cast<float>(rate * sheet.mass()[k]);
    }
    system.set_step(kTau, rate, Jacobian::kProjected);
    auto x = fine.make_xyz();
    fine.load(sheet.state.x, x.data());
    system.linearise(x.data(), fine.shape());
    p = system.rows().make_xyz();
    y = system.rows().make_xyz();
  }
  SheetSystem system;
  SheetRows<double> fine;
  XyzArray<float> p, y;
};

void product(benchmark::State& state, const Sheet& sheet) {
  for (auto _ : state) {
    System s(sheet);
    XyzArray<float> z = s.system.rows().make_xyz();
    s.system.rows().load(sheet.state.v, z.data());
    s.system.multiply(z.data(), 0.0f, s.p.data(), s.y.data());
    Nodes found = Nodes::Zero(3, sheet.nodes());
    s.system.rows().store(s.y.data(), &found);
    const double time = seconds([&] { s.system.multiply(z.data(), 0.0f, s.p.data(), s.y.data()); });
    report(state, sheet, time, relative(found, sheet.product(sheet.state.v)));
  }
}

void preconditioned_iteration(benchmark::State& state, const Sheet& sheet) {
  for (auto _ : state) {
    System s(sheet);
    const double time = seconds([&] {
      s.system.rows().load(sheet.state.v, s.system.residual());
      LinearReport report;
      s.system.solve({0.0, 0.0, 10}, 1.0, sheet.nodes(), &report);
    });
    const double loading = seconds([&] { s.system.rows().load(sheet.state.v, s.system.residual()); });
    report(state, sheet, (time - loading) / 10.0, -1.0);
  }
}

using Kernel = std::function<void(benchmark::State&, const Sheet&, SimdLevel)>;

void register_all() {
  const std::vector<std::pair<std::string, Kernel>> kernels = {
      {"sub_step_double", &sub_step<double>},
      {"sub_step_single", &sub_step<float>},
      {"force_double", &force},
      {"product_single", [](benchmark::State& s, const Sheet& sheet, SimdLevel) { product(s, sheet); }},
      {"iteration_single",
       [](benchmark::State& s, const Sheet& sheet, SimdLevel) { preconditioned_iteration(s, sheet); }},
  };
  const SimdLevel widest = simd_level();
  for (const int cells : {20, 40, 80, 160}) {
    const auto sheet = std::make_shared<Sheet>(cells);
    for (const auto& [name, kernel] : kernels) {
      for (const SimdLevel level : {SimdLevel::kSse2, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
        if (level > widest) continue;
        const std::string whole = "kernel/" + name + "/" + name_of(level) + "/" + std::to_string(cells);
        benchmark::RegisterBenchmark(whole.c_str(),
                                     [kernel = kernel, sheet, level](benchmark::State& state) {
                                       // What asks for the level itself looks here.
                                       setenv("DEFORMABLE_SIM_SIMD", name_of(level), 1);
                                       kernel(state, *sheet, level);
                                     })
            ->Iterations(1)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  deformable_sim::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
