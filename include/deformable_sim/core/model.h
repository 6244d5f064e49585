// What does not change while the simulation runs: bodies, masses, forces. Const after build.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/state.h"
#include "deformable_sim/core/topology/polyline.h"
#include "deformable_sim/core/topology/skin.h"
#include "deformable_sim/core/topology/tet_mesh.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// Values equal BodyState.kind.
enum class BodyKind { kCloth = 0, kRope = 1, kSoft = 2 };

/// Which deformable bodies a body feels, of those that feel others at all.
enum class BodyContact { kNone, kOthers, kAll };  // kAll: itself, too

/// An edge whose relative elongation is reported as strain.
struct StrainEdge {
  std::array<int, 2> node;  // world node indices
  double rest_length;       // m
};

/// Two nodes that may come no further apart (core/strain_limit.h).
struct StrainLimit {
  std::array<int, 2> node;  // world node indices
  double longest;           // m, > 0
  /// N/m of the body between the two, about: how hard an implicit step pulls back. Speed of convergence only; may be 0.
  double stiffness;
};

struct SheetLook;

struct Body {
  std::string name;
  BodyKind kind = BodyKind::kCloth;
  int first_node = 0;
  int node_count = 0;
  std::shared_ptr<const TriangleMesh> surface;  // cloth; soft body: its boundary; body-local indices
  std::shared_ptr<const TetMesh> volume;        // soft body; body-local indices
  std::shared_ptr<const Polyline> line;         // rope; body-local indices
  double contact_radius = 0.0;                  // m: distance kept between nodes and collider surfaces
  bool contact_at_faces = false;                // also hold face centroids / segment midpoints off colliders
  bool contact_anywhere = false;  // those where edges and faces come nearest to a collider, not in the middle
  BodyContact touches = BodyContact::kNone;
  double friction = 0.5;
  double draw_radius = 0.0;  // m, rope tube
  // A rod with twist: its segments are those of `line`, starting here among all rod segments of the model (State keeps
  // their frames in that order; their angles are the columns point_count() + segment). -1: no twist.
  int first_segment = -1;
  double radius_of_gyration = 0.0;  // m, polar, of a rod's section: angle (rad) = column's x / radius_of_gyration
  std::array<double, 4> color{{0.8, 0.8, 0.8, 1.0}};
  std::vector<StrainEdge> strain_edges;              // structural edges
  std::array<double, 2> valid_strain{{-1e9, 1e9}};   // of those edges: where the material's law holds
  std::map<std::string, std::vector<int>> features;  // corner_0..3, edge_0..3, end_0, end_1, center -> body-local nodes
  std::shared_ptr<const Skin> skin;                  // drawn and published as points in place of the nodes; may be null
  std::shared_ptr<const SheetLook> look;             // cloth that is drawn with more than its colour; else null
  double stripe = 0.25;                              // of the circumference of a rod with twist: width of its stripe
  /// Stress (Pa) at the nodes for the body's own columns of x: von Mises in solids, of the largest magnitude in sheets.
  /// Evaluated only to be shown. Empty: the model has no stress.
  std::function<Eigen::VectorXf(const Nodes&)> stress;
};

struct Model {
  std::shared_ptr<const void> plugins;  // whose code some of the energies are: it outlives them
  std::vector<Body> bodies;
  Eigen::VectorXd mass;                     // kg per node
  Eigen::SparseMatrix<double> mass_matrix;  // n x n, kg, consistent; empty: the masses above, lumped
  Vec3 gravity{0, 0, -9.81};                // m/s^2; also present as an Energy when not zero
  std::vector<std::unique_ptr<Energy>> energies;
  std::vector<GridSheet> grids;  // the sheets on regular grids, as fast kernels see them
  std::vector<StrainLimit> strain_limits;
  std::vector<std::string> notes;  // where a model cannot represent what was asked: shown among the warnings
  State initial;

  /// Rods with twist have an angle for each segment, kept as the x coordinate (m: angle times radius of gyration) of a
  /// column behind all points, so that every scheme and solver moves it like any other: columns [point_count(),
  /// node_count()). Those have no place in space.
  int angle_count = 0;

  int node_count() const { return static_cast<int>(mass.size()); }
  int point_count() const { return node_count() - angle_count; }
  /// Index of a body by name, or -1.
  int find_body(const std::string& name) const;
};

}  // namespace deformable_sim
