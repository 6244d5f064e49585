// The bodies that are mapped: small, with one number for each thing that makes a step hard.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/model.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim::stability {

/// Where in the map a body stands.
struct Point {
  double stiffness = 1e7;   // Pa, Young's modulus; of a scene of the user's: the factor on all its stiffnesses
  double damping = 0.0;     // s, viscous over elastic stiffness
  double mass_ratio = 1.0;  // of what hangs at the free end to a node of the rope
  double aspect = 1.0;      // long over short side of a cell
};

/// A body, what holds it, and what a choice of solver rests on.
struct Subject {
  std::string name;
  SceneSpec spec;
  std::shared_ptr<const Model> model;
  std::vector<int> held;  // world nodes, ascending
  double size = 0.0;      // m, longest side of the bounds at the start
  /// Colliders, contacts of bodies and strain limits are the world's work, soft and moving grasps, too: a scheme by
  /// itself cannot be shown.
  bool has_scheme_alone = true;
};

/// A chain of 10 links, 1 m, 1 cm^2, 1000 kg/m^3, held at one end and let go straight, 45 degrees off the vertical;
/// drag of 1/s. Springs alone: the highest frequency is 2 sqrt(k / m), k = 1e-3 m E, m = 0.01 kg.
Subject make_rope(const Point& at);
/// A membrane of 5 x 5 cells held along one edge, 1.2 m long, 1 mm thick, 200 kg/m^3 and as wide as `aspect` leaves it
/// (1.2 m / aspect); drag of 1/s.
Subject make_sheet(const Point& at);
/// A cantilever of 4 x 1 x 1 cells, 0.4 m x 0.1 m x 0.1 m of a foam of 100 kg/m^3, linear tetrahedra, nu = 0.3; drag of
/// 1/s.
Subject make_solid(const Point& at);
/// A scene with its stiffnesses `at.stiffness` times as large; nothing else of `at` is taken.
Subject make_scaled(const SceneSpec& scene, const Point& at);

/// Any number of subjects by name: rope, sheet, solid. Throws InputError.
Subject make_subject(const std::string& name, const Point& at);

/// The equations of motion of a subject for a scheme by itself: nothing but its terms, pins hold it.
class Plain {
 public:
  /// with_matrix: builds what schemes with a Jacobian need, and binds the model's terms to it. Only the last Plain or
  /// World made of a model may step.
  Plain(const Subject& subject, bool with_matrix);
  Plain(const Plain&) = delete;
  Plain& operator=(const Plain&) = delete;

  StepReport step(Integrator* integrator, double dt);
  Dynamics& dynamics() { return dynamics_; }

  State state;

 private:
  Dynamics dynamics_;
  BlockMatrix pattern_;
};

/// Highest frequency (rad/s) and damping rate (1/s) at the start: what theory draws its limits from.
struct Fastest {
  double omega = 0.0, rate = 0.0;
};
Fastest fastest_of(const Subject& subject);

}  // namespace deformable_sim::stability
