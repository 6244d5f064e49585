// Error against run time of hanging sheets: what a frame of 1/60 s costs, and how far the sheet is from the converged
// solution of the same mesh.
//
// A square of 1 m, 0.2 kg/m2, B = 1e-5 N m, two corners pinned, released flat; air drag 3 1/s, bending damping 0.01 s
// (with less the motion is chaotic, and an error below 0.5 % has no meaning). Reference: substepped Verlet in double
// precision. The same square as a crooked triangle mesh of as many nodes (scripts/make_sheet_mesh.py): there references
// with other steps differ by 1e-3 to 2e-3. Error: RMS distance of the nodes over 1 m, the largest of t = 0.25, 0.5,
// 0.75 and 1 s.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/scene/load.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr int kLargest = 316;  // cells
constexpr int kRepeats = 3;    // the fastest counts

enum class Mesh { kGrid, kCrooked };
struct Sheet {
  int cells;
  double stiffness;  // E h, N/m
  Mesh mesh = Mesh::kGrid;
  bool operator<(const Sheet& other) const {
    return std::tie(cells, stiffness, mesh) < std::tie(other.cells, other.stiffness, other.mesh);
  }
};
using References = std::map<Sheet, std::vector<Nodes>>;

/// Makes the file when it is first asked for; throws where python3 cannot.
std::string crooked_mesh(int side) {
  const char* folder = std::getenv("TMPDIR");
  const std::string path =
      std::string(folder != nullptr ? folder : "/tmp") + "/crooked_sheet_" + std::to_string(side) + ".obj";
  if (std::ifstream(path).good()) return path;
  const std::string command = "python3 '" + package_dir() + "/scripts/make_sheet_mesh.py' " + std::to_string(side) +
                              " '" + path + "' > /dev/null";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
  return path;
}

std::string scene(const Sheet& sheet, const std::string& step) {
  const bool grid = sheet.mesh == Mesh::kGrid;
  std::ostringstream text;
  text.precision(17);
  text << "bodies:\n  - cloth: {name: sheet, ";
  if (grid) {
    text << "size: [1, 1], cells: [" << sheet.cells << ", " << sheet.cells << "], pins: [corner_2, corner_3], ";
  } else {
    text << "mesh: " << crooked_mesh(sheet.cells + 1) << ", rest_shape: flat, ";
  }
  text << "pose: {position: [0, 0, 1]}, bending: quadratic, material: {areal_density: 0.2, thickness: 0.001, "
       << "youngs_modulus: " << 1e3 * sheet.stiffness << (grid ? ", poissons_ratio: 0.2" : "")
       << ", bending_rigidity: [1.0e-5, 1.0e-5], damping: 0, bending_damping: 0.01}}\n"
       << "air: {damping: 3}\nstep: {" << step << "}\n";
  if (!grid) {
    text << "grasps:\n  - {name: left, body: sheet, select: {nearest: [-0.5, 0.5, 1]}}\n"
         << "  - {name: right, body: sheet, select: {nearest: [0.5, 0.5, 1]}}\n";
  }
  return text.str();
}

struct Run {
  double seconds = 0.0, newton = 0.0, linear = 0.0;  // thread CPU time; iterations a step
  std::vector<Nodes> x;                              // at the quarters of a second
};

Run simulate(const Sheet& sheet, const std::string& step) {
  const std::unique_ptr<World> world = build(scene(sheet, step));
  const int steps = static_cast<int>(std::lround(1.0 / world->settings().dt));
  Run run;
  for (int k = 1; k <= steps; ++k) {
    const double start = thread_cpu_time();
    const StepOutcome outcome = world->step();
    run.seconds += thread_cpu_time() - start;
    if (!outcome.ok) return Run();
    run.newton += 1.0 * outcome.report.newton_iterations / steps;
    run.linear += 1.0 * outcome.report.linear_iterations / steps;
    if (4 * k % steps == 0) run.x.push_back(world->state().x);
  }
  return run;
}

std::string dt(int per_second) {
  std::ostringstream text;
  text.precision(17);
  text << "dt: " << 1.0 / per_second;
  return text.str();
}

/// Made once for each sheet. Steps of half the length and less move it by 3e-5 to 4e-4 at 1 s, 9e-4 for 20 x 20 and 5e3
/// N/m: that is what an error can be told to.
const std::vector<Nodes>& reference(const Sheet& sheet, References* known) {
  auto& x = (*known)[sheet];
  if (x.empty()) x = simulate(sheet, dt(60) + ", integrator: substepped_verlet").x;
  return x;
}

void measure(benchmark::State& state, const Sheet& sheet, const std::string& step, References* known) {
  const std::vector<Nodes>& expected = reference(sheet, known);
  Run best;
  for (auto _ : state) {
    for (int k = 0; k < kRepeats; ++k) {
      Run run = simulate(sheet, step);
      if (run.x.size() != expected.size()) {
        state.SkipWithError("diverged");
        return;
      }
      if (k == 0 || run.seconds < best.seconds) best = std::move(run);
    }
  }
  double error = 0.0;
  for (size_t k = 0; k < expected.size(); ++k) {
    error = std::max(error, std::sqrt((best.x[k] - expected[k]).squaredNorm() / static_cast<double>(best.x[k].cols())));
  }
  state.counters["nodes"] = (sheet.cells + 1) * (sheet.cells + 1);
  state.counters["ms_per_frame"] = 1e3 / 60.0 * best.seconds;
  state.counters["error"] = error;
  state.counters["newton_per_step"] = best.newton;
  state.counters["linear_per_step"] = best.linear;
}

/// A scheme with multigrid at so many steps a second, Newton steps, and the relative residual and most iterations of
/// each.
struct Setting {
  const char* integrator;
  int per_second, newton;
  double tolerance;
  int linear;
};

// Of a sweep the cheapest for one or several of the sheets, at 1 % and below: of grids and of meshes.
constexpr Setting kOfGrids[] = {
    {"bdf2", 60, 1, 0.1, 1},     {"bdf2", 60, 1, 0.3, 2},     {"bdf2", 60, 1, 0.1, 2},     {"bdf2", 60, 2, 0.3, 2},
    {"bdf2", 60, 2, 0.1, 2},     {"bdf2", 80, 1, 0.1, 2},     {"bdf2", 80, 2, 0.3, 2},     {"bdf2", 100, 2, 0.3, 5},
    {"bdf2", 100, 2, 0.1, 3},    {"tr_bdf2", 60, 1, 0.3, 2},  {"tr_bdf2", 60, 2, 0.3, 2},  {"tr_bdf2", 80, 2, 0.3, 2},
    {"tr_bdf2", 120, 2, 0.1, 2}, {"tr_bdf2", 160, 3, 0.3, 3}, {"tr_bdf2", 240, 2, 0.1, 3}, {"tr_bdf2", 480, 2, 0.1, 3},
};
constexpr Setting kOfMeshes[] = {
    {"bdf2", 60, 1, 0.1, 5},   {"bdf2", 60, 2, 0.1, 5},      {"bdf2", 60, 1, 0.1, 8},      {"bdf2", 80, 1, 0.1, 3},
    {"bdf2", 80, 1, 0.15, 8},  {"tr_bdf2", 60, 1, 0.1, 5},   {"bdf2", 60, 2, 1e-4, 2},     {"bdf2", 80, 2, 0.15, 8},
    {"bdf2", 80, 2, 0.1, 8},   {"bdf2", 80, 3, 0.3, 8},      {"bdf2", 100, 2, 1e-4, 2},    {"bdf2", 100, 2, 0.15, 8},
    {"bdf2", 100, 2, 1e-4, 8}, {"tr_bdf2", 120, 2, 1e-4, 3}, {"tr_bdf2", 240, 2, 1e-4, 3}, {"tr_bdf2", 480, 2, 1e-4, 3},
};
// Of grids the first ones: for the largest, of which each run takes seconds.
constexpr int kOfLargest = 3;

void register_sheet(const Sheet& sheet, References* known) {
  const auto add = [&](const std::string& name, const std::string& step) {
    std::ostringstream whole;
    whole << (sheet.mesh == Mesh::kGrid ? "sheet_" : "crooked_") << sheet.cells << "_" << sheet.stiffness << "/"
          << name;
    benchmark::RegisterBenchmark(whole.str().c_str(),
                                 [=](benchmark::State& state) { measure(state, sheet, step, known); })
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  };
  const bool largest = sheet.cells >= kLargest;
  for (const char* precision : {"double", "single"}) {
    if (largest) break;
    add(std::string("substepped_verlet_") + precision,
        dt(60) + ", integrator: substepped_verlet, precision: " + precision);
  }
  const std::vector<Setting> settings = sheet.mesh == Mesh::kGrid
                                            ? std::vector<Setting>(std::begin(kOfGrids), std::end(kOfGrids))
                                            : std::vector<Setting>(std::begin(kOfMeshes), std::end(kOfMeshes));
  for (const Setting& s : settings) {
    if (largest && &s - settings.data() == kOfLargest) break;
    std::ostringstream name, step;
    name << s.integrator << "_" << s.per_second << "Hz_" << s.newton << "x" << s.linear << "_" << s.tolerance;
    step << dt(s.per_second) << ", integrator: " << s.integrator
         << ", linear_solver: multigrid, tolerance: 1.0e-4, linear_tolerance: " << s.tolerance
         << ", newton_iterations: " << s.newton << ", linear_iterations: " << s.linear;
    add(name.str(), step.str());
  }
}

void register_all(References* known) {
  for (const double stiffness : {1e3, 5e3}) {
    for (const int cells : {20, 40, 80, 160}) register_sheet({cells, stiffness}, known);
    for (const int cells : {19, 39, 79}) register_sheet({cells, stiffness, Mesh::kCrooked}, known);
  }
  register_sheet({kLargest, 1e3}, known);  // 100,489 nodes
}

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  deformable_sim::bench::References references;
  deformable_sim::bench::register_all(&references);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
