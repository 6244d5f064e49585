// What all bodies together add to a model, and the builders of each kind of body.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/energy/rod_terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/model.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// A refusal that names its own file, line and key.
class PlacedError : public InputError {
 public:
  using InputError::InputError;
};

/// 1 / cos(30 degrees) = 1.155: the linear strain of a rotation.
constexpr char kHookeNote[] =
    "law hooke is for small rotations: a part turned by 30 degrees swells by 15 %; st_venant_kirchhoff and "
    "corotational "
    "turn freely";

/// Node indices are world indices.
struct Parts {
  struct Line {
    std::vector<std::array<int, 2>> segments;
    double diameter;
  };
  /// A rod becomes terms once the number of all points is known: its angles come behind them.
  struct Rod {
    size_t body;
    Polyline line;  // in the world, as it starts
    RodSection section;
    RodRest rest;
    double initial_twist;  // rad/m
  };
  std::vector<SpringNetwork> springs;               // of cloth and ropes, body by body
  std::vector<std::unique_ptr<Energy>> terms;       // all others, body by body
  std::vector<std::array<int, 3>> sheet_triangles;  // in the air on both sides
  std::vector<std::array<int, 3>> solid_triangles;  // in the air on one side
  std::vector<Line> lines;
  std::vector<Rod> rods;
  /// A sheet on a grid beside the network and the terms it stands for.
  struct Grid {
    GridSheet sheet;
    size_t network;                       // of `springs`
    std::vector<const Energy*> replaces;  // among `terms`
  };
  std::vector<Grid> grids;
  std::vector<StrainLimit> strain_limits;
  std::vector<Eigen::Triplet<double>> mass_entries;  // of bodies with a consistent mass
  std::vector<std::string> notes;                    // where a model cannot represent what was asked
  std::vector<Nodes> positions;
  std::vector<Eigen::VectorXd> masses;
  int node_count = 0;
};

/// Springs in world indices.
void append_network(const SpringNetwork& network, int first_node, Parts* parts);
/// Links as the edges whose strain is reported.
void add_strain_edges(const std::vector<SpringLink>& links, Body* body);
/// Puts the nodes of a body into the world.
void place_nodes(const Nodes& rest, const Pose& world_from_body, const Eigen::VectorXd& mass, Body* body, Parts* parts);
/// Triangles in world indices.
void append_triangles(const std::vector<std::array<int, 3>>& triangles, int first_node,
                      std::vector<std::array<int, 3>>* out);

void add_cloth(const BodySpec& spec, Body* body, Parts* parts);
void add_rope(const BodySpec& spec, Body* body, Parts* parts);
/// Segments of a rope that a wave of tension passes in a second: sqrt(EA / linear_density) / segment length, 1/s.
double segments_per_second(const BodySpec& rope);
void add_soft(const BodySpec& spec, Body* body, Parts* parts);

/// The surface of its own that a body carries, where the scene names one.
void add_visual(const VisualSpec& spec, Body* body);

/// How it is drawn, where the scene says more than its colour. After add_visual().
void add_look(const BodySpec& spec, Body* body);

/// How this cloth bends: what the scene says, else by hinges where there is a rigidity, else by springs.
ClothBending bending_of(const BodySpec& spec);

/// What this solid is made of: what the scene says, else quadratic tetrahedra for a box and linear ones for a mesh.
SoftElement element_of(const SoftModelSpec& soft);

/// Cells of a box: those of the scene, else near to cubes, so many that 4 elements or 2 quadratic ones go through the
/// thinnest side, but at most 20 or 10 along any.
std::array<int, 3> cells_of(const SoftModelSpec& soft);

}  // namespace deformable_sim
