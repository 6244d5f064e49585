// The virtual test bench: a material, a model of it, and what a testing machine finds.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deformable_sim/core/material/real_materials.h"
#include "report.h"
#include "specimen.h"

namespace deformable_sim::study {

/// How much is run: everything, or the coarsest meshes without the drape, for a test of the program itself.
enum class Effort { kQuick, kFull };

std::vector<std::string> cloth_models();
std::vector<std::string> rope_models();
std::vector<std::string> solid_models();

/// `tell` (or none) hears of every measurement before it is made: which test.
struct Bench {
  Effort effort = Effort::kFull;
  std::function<void(const std::string& test)> tell;
};

/// Throw InputError listing the models.
Report study_cloth(const FabricData& fabric, const std::string& model, const Bench& bench);
Report study_rope(const RopeData& rope, const std::string& model, const Bench& bench);
Report study_solid(const SolidData& solid, const std::string& model, const Bench& bench);

/// Runs `measure` at each size and times it.
Row row_of(const Bench& bench, const std::string& test, const std::string& quantity, const std::string& unit,
           std::optional<double> put_in, const std::vector<int>& sizes, const std::function<Measurement(int)>& measure);

/// Throws InputError "no model 'x' for cloth; there is ...".
void check_model(const std::string& model, const std::vector<std::string>& models, const std::string& kind);

/// The overhang at which the chord of a strip or rod reaches 41.5 degrees (ASTM D1388) has this rho g L^3 / B.
constexpr double kGammaAt41_5 = 8.004197;
constexpr double kStandardGravity = 9.80665;  // m/s^2
constexpr double kPi = 3.14159265358979323846;

/// A shape at the end of a cantilever test.
struct Overhang {
  int nodes = 0;
  double chord = 0.0;                        // rad below the horizontal, from the clamp line to the tip
  std::vector<std::array<double, 2>> shape;  // x, z (m) from the clamp line
  bool settled = false;
};
/// Lengthens the overhang until its chord reaches 41.5 degrees; `hang(length)` clamps and settles one. NaN when no
/// length between a fiftieth and twenty times the first guess does.
double overhang_at_41_5(double first_guess, const std::function<Overhang(double)>& hang, Overhang* last);

}  // namespace deformable_sim::study
