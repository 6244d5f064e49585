// A scene as plain structs: defaults, units and ranges in one place. Filled by load_scene(), read by build_world().
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "deformable_sim/core/command.h"
#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/force_plugin.h"
#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/world.h"

namespace deformable_sim {

struct YamlValue;

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
/// Of all visual surfaces of a scene together.
constexpr int kMaxSkinVertices = 1000000;

/// Rigid placement: position (m) and either rpy (rad, fixed axes x y z) or a quaternion orientation [x, y, z, w].
struct PoseSpec {
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Pose pose() const;
};

/// Sheet material, as measured on the textile. Membrane stiffness comes from youngs_modulus and thickness unless given
/// per length; bending is a parameter of its own, because woven cloth bends some ten times more stiffly than its
/// thickness and modulus say.
struct ClothMaterialSpec {
  std::string name;                                         // of the table this started from; empty = none
  double areal_density = 0.15;                              // kg/m^2
  double thickness = 0.0003;                                // m, > 0
  std::array<double, 2> youngs_modulus{{8.2e5, 8.2e5}};     // Pa, > 0, warp (x) and weft (y)
  double poissons_ratio = 0.25;                             // pulled along warp; springs: grids only
  std::optional<std::array<double, 2>> membrane_stiffness;  // E h, N/m, warp and weft; replaces youngs_modulus
  std::optional<double> shear_rigidity;                     // G h, N/m
  std::optional<std::array<double, 2>> bending_rigidity;    // N m, warp and weft
  std::optional<double> stretch_stiffness;                  // springs: N/m each; replaces youngs_modulus
  std::optional<double> shear_stiffness;                    // springs: N/m each (grids)
  std::optional<double> bend_stiffness;                     // springs: N/m each
  double damping = 0.002;                                   // s: viscous over elastic stiffness
  std::optional<double> bending_damping;                    // s: the same of bending; none: damping
  std::optional<double> elastic_limit;                      // strain beyond which the law is said not to hold

  /// E h, N/m.
  std::array<double, 2> membrane() const;
};

enum class ClothModel { kSprings, kProvot, kMembrane };
enum class ClothBending { kSprings, kHinges, kQuadratic };
enum class RestShape { kFlat, kAsMeshed };

/// A fold line that keeps an angle: hinges on the straight line between two points of the sheet.
struct CreaseSpec {
  Location where;
  std::string path;                                // of the key
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  // m, in the sheet's own x-y plane
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double angle = 0.0;  // rad at rest, -pi ... pi; positive: the sides rise towards the sheet's outer side (+z)
};

struct ClothModelSpec {
  ClothModel model = ClothModel::kSprings;
  std::string law = "st_venant_kirchhoff";  // of the membrane
  std::optional<ClothBending> bending;      // none: hinges when a bending rigidity is known or needed, else springs
  RestShape rest_shape = RestShape::kAsMeshed;
  std::vector<CreaseSpec> creases;
  std::optional<double> strain_limit;  // largest strain of the structural springs or edges
  double pressure = 0.0;               // Pa, gauge, inside a closed mesh, outwards > 0
  double pressure_rise = 0.0;          // s from time 0 on, until it is there
  int upsample = 1;                    // drawn so many times finer along each side of a cell; grids
};

/// Rope material. Axial stiffness comes from youngs_modulus and the section unless given directly.
struct RopeMaterialSpec {
  std::string name;                                       // of the table this started from; empty = none
  double linear_density = 0.05;                           // kg/m
  double diameter = 0.008;                                // m, > 0
  std::optional<std::array<double, 2>> section;           // m, width (across the director) and height: a rectangle
  double youngs_modulus = 5.0e7;                          // Pa, > 0
  std::optional<double> shear_modulus;                    // Pa; none: E / 2.6
  std::optional<double> axial_stiffness;                  // E A, N; replaces youngs_modulus for stretch
  std::optional<std::array<double, 2>> bending_rigidity;  // E I, N m^2, in the plane of the director and across it
  std::optional<double> twist_rigidity;                   // G J, N m^2
  std::optional<double> stretch_stiffness;                // springs: N/m per segment; replaces youngs_modulus
  std::optional<double> bend_stiffness;                   // springs: N/m each (over two segments)
  double damping = 0.002;                                 // s
  std::optional<double> elastic_limit;                    // strain beyond which the law is said not to hold
};

enum class RopeModel { kSprings, kUntwisted, kRod };
enum class RopeStart { kNatural, kStraight };

struct RopeModelSpec {
  RopeModel model = RopeModel::kSprings;
  std::array<double, 2> natural_curvature{{0.0, 0.0}};  // 1/m, about y and z of the body at its start
  double natural_twist = 0.0;                           // rad/m
  double initial_twist = 0.0;                           // rad/m at the start, beyond the natural one
  RopeStart start = RopeStart::kNatural;
};

/// Isotropic solid.
struct SoftMaterialSpec {
  std::string name;                        // of the table this started from; empty = none
  double youngs_modulus = 5.0e4;           // Pa, > 0
  double poissons_ratio = 0.45;            // -1 ... 1/2, both excluded
  double density = 1000.0;                 // kg/m^3
  double damping = 0.01;                   // s: viscous over elastic stiffness
  std::string law = "stable_neo_hookean";  // that suits it
  double mooney_rivlin_share = 0.5;        // C10 / (C10 + C01)
  std::optional<double> elastic_limit;     // strain beyond which the law is said not to hold
};

enum class SoftMass { kLumped, kConsistent };
enum class SoftElement { kTetrahedron, kQuadraticTetrahedron, kSprings };

struct SoftModelSpec {
  std::optional<Vec3> box_size;             // m: a box, cut into ...
  std::optional<std::array<int, 3>> cells;  // ... so many along x, y and z; none: see default_cells()
  std::optional<double> lattice_cell;       // m: the mesh is a closed surface in a lattice of such cells
  std::optional<SoftElement> element;       // none: quadratic for a box, linear for a mesh
  SoftMass mass = SoftMass::kLumped;
  int neighbours = 18;  // of a spring lattice's inner node: 6, 18 or 26
  std::string law;      // empty: the material's
  SoftMaterialSpec material;
};

/// A surface of its own that a cloth or soft body carries, drawn and published as points in place of its nodes.
struct VisualSpec {
  std::string mesh;  // OBJ, STL, PLY or DAE file in the frame of the body; resolved path; empty: none
  Location where;
  std::string path;         // of the key
  double mesh_scale = 1.0;  // file units to m
};

/// How a body is drawn beyond its colour. No part of it touches the simulation.
struct LookSpec {
  Location where;
  std::string path;                                    // of the key
  double checker = 0.0;                                // m: edge of the squares of a cloth; 0 = plain
  std::optional<std::array<double, 3>> checker_color;  // rgb 0..1; none: the body's, much lighter
  double seams = 0.0;                                  // m: width of the darker band along hems and seams; 0 = none
  std::optional<double> thickness{0.0};  // m: distance of the two faces; 0 = one face; none: the material's
  double stripe = 0.25;                  // of the circumference of a rod with twist: width of its stripe; 0 = none
};

struct BodySpec {
  Location where;
  BodyKind kind = BodyKind::kCloth;
  std::string name;                            // lower case letters, digits, underscores
  PoseSpec pose;                               // world from body
  std::optional<std::array<double, 3>> color;  // rgb 0..1
  double friction = 0.5;
  BodyContact touches = BodyContact::kNone;
  std::vector<std::string> pins;  // features held where they start: corner_0, edge_2, end_1 ...; each
                                  // becomes a rigid grasp named pin_<body>_<feature>
  Location pins_where;
  std::optional<double> contact_radius;  // m, > 0: gap kept to colliders; default half the thickness or diameter,
                                         // at least kMinContactRadius

  std::string mesh;  // cloth: OBJ, STL, PLY or DAE file instead of a grid; soft: those, or tetrahedra; resolved path
  Location mesh_where;
  double mesh_scale = 1.0;        // file units to m
  bool contact_at_faces = false;  // also hold face centroids off colliders, not only nodes
  bool contact_anywhere = false;  // and where edges and faces come nearest to them, in place of their middles
  VisualSpec visual;
  LookSpec look;

  // cloth
  std::array<double, 2> size{{0.5, 0.5}};  // m, x and y
  std::array<int, 2> cells{{20, 20}};      // along x and y: (cells + 1) nodes each
  ClothMaterialSpec cloth_material;
  ClothModelSpec cloth;

  // rope
  double length = 1.0;  // m
  int segments = 50;
  bool closed = false;
  std::vector<Vec3> path;  // m, in the body's frame: a rope lies along it at the start; empty: straight, or a loop
  RopeMaterialSpec rope_material;
  RopeModelSpec rope;

  // soft
  SoftModelSpec soft;
};

struct ColliderSpec {
  Location where;
  Collider collider;
};

struct GraspSpec {
  Location where;
  GraspRequest request;  // pose in the world frame
};

/// A term that a plugin makes.
struct ForceSpec {
  Location where;
  ForceRequest request;
};

/// A command that is given by itself once the simulated time is reached.
struct ScriptEvent {
  Location where;
  std::string path;   // of the key
  double time = 0.0;  // s
  Command command;
};

/// Collide with links of the robot described by the ROS parameter robot_description, posed by tf. ROS only.
struct RobotSpec {
  bool present = false;
  std::vector<std::string> links;    // empty = all links with collision elements
  std::vector<std::string> exclude;  // of those
  double padding = 0.0;              // m, by which every shape is larger than it is in the URDF
  double friction = 0.5;
  std::map<std::string, std::vector<std::string>> lets_through;  // bodies that a link does not touch
};

struct AirSpec {
  double density = 1.2;           // kg/m^3
  double drag_coefficient = 0.0;  // 0 = no aerodynamic force at all
  Vec3 wind = Vec3::Zero();       // m/s
  double gust_amplitude = 0.0;    // fraction of the wind speed, 0 ... 1
  double gust_frequency = 0.5;    // Hz
  double damping = 0.0;           // 1/s: linear drag per unit mass
};

enum class SolverMode { kAuto, kManual };

struct StepSpec {
  /// Auto: build_world() chooses integrator, solver and, unless it is given, dt.
  SolverMode mode = SolverMode::kAuto;
  StepControl control = StepControl::kFixed;
  double floor = 0.1;   // with a budget to keep to: error up to which accuracy gives way
  double error = 0.01;  // auto: of the positions, relative to the body's size, that is asked for
  double budget = 0.8;  // auto: CPU s per simulated s that it may take
  double dt = 0.01;     // s
  bool dt_given = false;
  std::string integrator = "implicit_euler";
  SolverSettings solver;
  // linear_solver, newton_iterations, jacobian: else build_world() decides
  bool solver_given = false, iterations_given = false, jacobian_given = false;
};

struct OutputSpec {
  double rate_markers = 30.0;     // Hz
  double rate_points = 30.0;      // Hz
  double rate_state = 30.0;       // Hz
  std::string color_by = "body";  // body | strain | stress | velocity | contact
  double strain_range = 0.05;     // strain shown as full colour
  double stress_range = 1.0e5;    // Pa, stress shown as full colour
  bool wireframe = false;
  bool frames = false;  // draw the frames of rods: tangent and the two directors of each segment
  bool shadows = false;
  bool contact_arrows = false;
  double contact_scale = 0.0;           // m/N; 0: the longest arrow is a fifth of the scene
  bool legend = true;                   // where color_by is not body
  std::optional<Vec3> legend_position;  // m, of the foot of its bar; none: beside the bodies as they start
  double legend_height = 0.0;           // m; 0: by the size of the scene
};

struct SceneSpec {
  std::string file;                         // as given; empty for text
  std::string origin;                       // of messages, and base of relative paths
  std::shared_ptr<const YamlValue> source;  // what was read, for scene/edit.h; null in a scene made by hand
  std::string title;                        // one line
  Vec3 gravity{0, 0, -9.81};                // m/s^2
  AirSpec air;
  StepSpec step;
  double grasp_max_speed = 1.0;  // m/s
  std::vector<BodySpec> bodies;
  std::vector<ColliderSpec> colliders;
  std::vector<GraspSpec> grasps;
  std::vector<ForceSpec> forces;
  std::vector<ScriptEvent> script;  // in the order of time
  RobotSpec robot;
  OutputSpec outputs;
};

}  // namespace deformable_sim
