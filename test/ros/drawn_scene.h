// Snapshots made by hand, for tests of what is drawn.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// A snapshot of bodies added one by one, at rest where they were added.
struct DrawnScene {
  std::shared_ptr<Model> model = std::make_shared<Model>();
  Snapshot snapshot;

  Body& add(const std::string& name, const Nodes& x) {
    const Eigen::Index first = snapshot.x.cols();
    snapshot.x.conservativeResize(3, first + x.cols());
    snapshot.x.rightCols(x.cols()) = x;
    snapshot.v = Nodes::Zero(3, snapshot.x.cols());
    model->mass = Eigen::VectorXd::Ones(snapshot.x.cols());
    Body body;
    body.name = name;
    body.first_node = static_cast<int>(first);
    body.node_count = static_cast<int>(x.cols());
    model->bodies.push_back(body);
    snapshot.model = model;
    return model->bodies.back();
  }

  Body& add_sheet(int cells) {
    const TriangleMesh grid = make_grid(1.0, 1.0, cells, cells);
    Body& body = add("sheet", grid.rest);
    body.surface = std::make_shared<TriangleMesh>(grid);
    for (const auto& [a, b] : edges_of(grid)) {
      body.strain_edges.push_back(
          {{a + body.first_node, b + body.first_node}, (grid.rest.col(b) - grid.rest.col(a)).norm()});
    }
    return body;
  }

  /// Along x, first directors turned by `turn` (rad) from +y towards +z. Add it last: its angles follow all nodes.
  Body& add_rod(int segments, double turn) {
    const Polyline line = make_line(1.0, segments);
    Body& body = add("rod", line.rest);
    body.kind = BodyKind::kRope;
    body.line = std::make_shared<Polyline>(line);
    body.draw_radius = 0.01;
    body.first_segment = 0;
    body.radius_of_gyration = 0.005;
    snapshot.tangents = Vec3(Vec3::UnitX()).replicate(1, segments);
    snapshot.directors = Vec3(0.0, std::cos(turn), std::sin(turn)).replicate(1, segments);
    model->angle_count = segments;
    model->mass = Eigen::VectorXd::Ones(snapshot.x.cols() + segments);
    snapshot.x.conservativeResize(3, snapshot.x.cols() + segments);
    snapshot.x.rightCols(segments).setConstant(1e9);
    snapshot.v = Nodes::Zero(3, snapshot.x.cols());
    return body;
  }
};

}  // namespace deformable_sim
