#include "scheme_parts.h"

namespace deformable_sim {

void take_up_speed(double dt, const Kinematics& kinematics, State* s) {
  for (size_t i = 0; i < kinematics.node.size(); ++i) {
    const int node = kinematics.node[i];
    s->v.col(node) = (kinematics.target.col(static_cast<Eigen::Index>(i)) - s->x.col(node)) / dt;
  }
}

void average_reactions(double dt, const Nodes& v0, const Nodes& v1, const Nodes& mean_force, Dynamics* d) {
  take_reactions(mean_force, &d->kinematics);
  Kinematics& k = d->kinematics;
  for (size_t i = 0; i < k.node.size(); ++i) {
    const int node = k.node[i];
    auto reaction = k.reaction.col(static_cast<Eigen::Index>(i));
    if (d->mass_matrix == nullptr) {
      reaction = ((*d->mass)[node] / dt) * (v1.col(node) - v0.col(node)) - reaction;
      continue;
    }
    reaction = -reaction;
    for (Eigen::SparseMatrix<double>::InnerIterator it(*d->mass_matrix, node); it; ++it) {
      reaction += (it.value() / dt) * (v1.col(it.row()) - v0.col(it.row()));
    }
  }
}

}  // namespace deformable_sim
