// What is studied: something that becomes a World with any scheme and step.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/solver_choice.h"
#include "work_precision.h"

namespace deformable_sim::work_precision {

class Case {
 public:
  virtual ~Case() = default;
  virtual std::unique_ptr<World> make(double dt, const std::string& integrator, const SolverSettings& solver) const = 0;
  /// Its positions at the quarters, where a table has them.
  virtual Trajectory table() const { return {}; }
  /// The same with cells and segments half as large, or with the other model of cloth. Null where there is none, then
  /// `why` says so.
  virtual std::unique_ptr<Case> refined(std::string* why) const;
  virtual std::unique_ptr<Case> other_model(std::string* why) const;

  std::string name, title;
  std::string digest;     // of everything the solution depends on
  double seconds = 1.0;   // T
  SolverSettings solver;  // what the scene says beyond what is swept
  bool jacobian_given = false;
  Features features;  // explicit_steps may not be known yet

  bool on_grid() const { return features.bodies == kSheetOnGrid; }
  double quarter() const { return seconds / kQuarters; }
};

/// A scene by name (of the suite or of the shipped scenes) or file. Throws InputError.
std::unique_ptr<Case> scene_case(const std::string& name_or_file, const std::vector<Override>& overrides,
                                 double seconds);

/// One of the trajectories of test/verify/data by the name of its table without ending (golden_chain10_soft). Throws
/// InputError.
std::unique_ptr<Case> golden_case(const std::string& name);
std::vector<std::string> golden_names();

/// One study of the suite.
struct SuiteEntry {
  std::string name, scene;
  std::vector<Override> overrides;
};
/// The scenes of config/suite, the stiffnesses from 1e2 to 1e6 N/m of its smallest sheet (hang_20_200, three a decade),
/// shipped scenes with other bodies and contacts, and the golden trajectories.
std::vector<SuiteEntry> suite();
/// Where those scenes lie.
std::string suite_dir();

/// 64 bits of FNV-1a, 16 hexadecimal digits.
std::string digest_of(const std::string& text);
/// Whole content. Throws InputError.
std::string content_of(const std::string& path);

}  // namespace deformable_sim::work_precision
