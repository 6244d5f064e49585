#include "work_precision_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace deformable_sim::work_precision {
namespace {

constexpr double kSamePlace = 1e-7;  // of the extent

using Cell = std::array<long, 3>;

Nodes start_of(const Case& c) {
  return c.make(c.quarter(), "implicit_euler", c.solver)->state().x;
}

/// Runs `other` as `with`. False: `part` says why there is nothing.
bool solve(const Case& other, const Row& with, double tight, double most, Run* found, Part* part) {
  try {
    *found = run(other, with.configuration, tight, most);
  } catch (const InputError& error) {  // a scheme that does not know the other model's terms
    part->how = error.what();
    return false;
  }
  part->uncertain = with.errors.position;
  part->how = with.configuration.family() + ", dt " + std::to_string(with.dt) + " s";
  if (found->status == Status::kDone) return true;
  part->how += ": " + found->note;
  return false;
}

}  // namespace

std::vector<int> common_nodes(const Nodes& coarse, const Nodes& fine, int points) {
  const double extent = (fine.rowwise().maxCoeff() - fine.rowwise().minCoeff()).maxCoeff();
  const double side = kSamePlace * (extent > 0.0 ? extent : 1.0);
  const auto cell_of = [side](const Vec3& x) {
    return Cell{std::lround(x[0] / side), std::lround(x[1] / side), std::lround(x[2] / side)};
  };
  std::map<Cell, int> at;
  for (Eigen::Index k = 0; k < fine.cols(); ++k) at.emplace(cell_of(fine.col(k)), static_cast<int>(k));
  std::vector<int> nodes;
  for (int k = 0; k < points; ++k) {
    const Cell cell = cell_of(coarse.col(k));
    // Rounding may put the two on either side of a border.
    auto found = at.end();
    for (int n = 0; n < 27 && found == at.end(); ++n) {
      found = at.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
    }
    if (found == at.end()) return {};
    nodes.push_back(found->second);
  }
  return nodes;
}

Part mesh_part(const Case& c, const Yardstick& yardstick, const Reference& reference, const Row& with, double tight,
               double most) {
  Part part;
  const std::unique_ptr<Case> fine = c.refined(&part.how);
  if (!fine) return part;
  const std::vector<int> nodes =
      common_nodes(start_of(c), start_of(*fine).leftCols(fine->features.nodes), c.features.nodes);
  if (nodes.empty()) {
    part.how = "the finer mesh does not contain the nodes of this one";
    return part;
  }
  Run found;
  if (!solve(*fine, with, tight, most, &found, &part)) return part;
  Trajectory restricted = reference.trajectory;
  for (size_t k = 0; k < restricted.size(); ++k) {
    for (size_t i = 0; i < nodes.size(); ++i) {
      restricted[k].x.col(static_cast<Eigen::Index>(i)) = found.trajectory[k].x.col(nodes[i]);
    }
  }
  part.position = yardstick.position(restricted, reference.trajectory);
  return part;
}

Part model_part(const Case& c, const Yardstick& yardstick, const Reference& reference, const Row& with, double tight,
                double most) {
  Part part;
  const std::unique_ptr<Case> other = c.other_model(&part.how);
  if (!other) return part;
  Run found;
  if (solve(*other, with, tight, most, &found, &part)) {
    part.position = yardstick.position(found.trajectory, reference.trajectory);
  }
  return part;
}

}  // namespace deformable_sim::work_precision
