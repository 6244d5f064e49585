// A scene as plain structs: defaults, units and ranges in one place. Filled by load_scene(), read by build_world().
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/world.h"

namespace deformable_sim {

/// Where a value stands, for messages: file:line; line 0 = not in a file (an override), `file` says it all.
struct Location {
  std::string file;
  int line = 0;
};

/// Nodes keep at least this distance (m) from collider surfaces. Real cloth is thinner (half of 0.3 mm); 1 mm hides the
/// sagitta of a 20 mm edge on a 5 cm radius, and is too small to see.
constexpr double kMinContactRadius = 0.001;

/// Nodes of all bodies of one scene, at most.
constexpr int kMaxNodes = 200000;

/// Rigid placement: position (m) and either rpy (rad, fixed axes x y z) or a quaternion orientation [x, y, z, w].
struct PoseSpec {
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Pose pose() const;
};

/// Sheet material, as measured on the textile. Stiffness comes from youngs_modulus and thickness unless given directly.
struct ClothMaterialSpec {
  double areal_density = 0.15;              // kg/m^2
  double thickness = 0.0003;                // m, > 0
  double youngs_modulus = 8.2e5;            // Pa, > 0
  double poissons_ratio = 0.25;             // 0 ... 0.5; grids only, a triangle mesh of springs has 1/3
  std::optional<double> stretch_stiffness;  // N/m per structural spring; replaces youngs_modulus
  std::optional<double> shear_stiffness;    // N/m per shear spring (grids)
  std::optional<double> bend_stiffness;     // N/m per bend spring
  double damping = 0.002;                   // s: viscous coefficient of each spring over its stiffness
};

/// Rope material. Axial stiffness comes from youngs_modulus and diameter unless given directly.
struct RopeMaterialSpec {
  double linear_density = 0.05;             // kg/m
  double diameter = 0.008;                  // m, > 0
  double youngs_modulus = 5.0e7;            // Pa, > 0
  std::optional<double> stretch_stiffness;  // N/m per segment spring; replaces youngs_modulus
  std::optional<double> bend_stiffness;     // N/m per bend spring (over two segments)
  double damping = 0.002;                   // s
};

struct BodySpec {
  Location where;
  BodyKind kind = BodyKind::kCloth;
  std::string name;                            // lower case letters, digits, underscores
  PoseSpec pose;                               // world from body
  std::optional<std::array<double, 3>> color;  // rgb 0..1
  double friction = 0.5;
  std::vector<std::string> pins;  // features held where they start: corner_0, edge_2, end_1 ...; each
                                  // becomes a rigid grasp named pin_<body>_<feature>
  Location pins_where;
  std::optional<double> contact_radius;  // m, > 0: gap kept to colliders; default half the thickness or diameter,
                                         // at least kMinContactRadius

  // cloth
  std::array<double, 2> size{{0.5, 0.5}};  // m, x and y
  std::array<int, 2> cells{{20, 20}};      // along x and y: (cells + 1) nodes each
  std::string mesh;                        // OBJ, STL, PLY or DAE file instead of a grid; resolved path
  Location mesh_where;
  double mesh_scale = 1.0;        // file units to m
  bool contact_at_faces = false;  // also hold face centroids off colliders, not only nodes
  ClothMaterialSpec cloth_material;

  // rope
  double length = 1.0;  // m
  int segments = 50;
  bool closed = false;
  RopeMaterialSpec rope_material;
};

struct ColliderSpec {
  Location where;
  Collider collider;
};

struct GraspSpec {
  Location where;
  GraspRequest request;  // pose in the world frame
};

/// Collide with links of the robot described by the ROS parameter robot_description, posed by tf. ROS only.
struct RobotSpec {
  bool present = false;
  std::vector<std::string> links;  // empty = all links with primitive collision shapes
  double friction = 0.5;
};

struct AirSpec {
  double density = 1.2;           // kg/m^3
  double drag_coefficient = 0.0;  // 0 = no aerodynamic force at all
  Vec3 wind = Vec3::Zero();       // m/s
  double gust_amplitude = 0.0;    // fraction of the wind speed, 0 ... 1
  double gust_frequency = 0.5;    // Hz
  double damping = 0.0;           // 1/s: linear drag per unit mass
};

struct StepSpec {
  double dt = 0.01;  // s
  std::string integrator = "implicit_euler";
  SolverSettings
      solver;  // keys: linear_solver (direct | cg), newton_iterations, tolerance, linear_tolerance, linear_iterations
};

struct OutputSpec {
  double rate_markers = 30.0;     // Hz
  double rate_points = 30.0;      // Hz
  double rate_state = 30.0;       // Hz
  std::string color_by = "body";  // body | strain | velocity | contact
  double strain_range = 0.05;     // strain shown as full colour
  bool wireframe = false;
};

struct SceneSpec {
  std::string file;           // as given; empty for text
  std::string title;          // one line
  Vec3 gravity{0, 0, -9.81};  // m/s^2
  AirSpec air;
  StepSpec step;
  double grasp_max_speed = 1.0;  // m/s
  std::vector<BodySpec> bodies;
  std::vector<ColliderSpec> colliders;
  std::vector<GraspSpec> grasps;
  RobotSpec robot;
  OutputSpec outputs;
};

}  // namespace deformable_sim
