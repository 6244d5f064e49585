#include "deformable_sim/core/contact/slabs.h"

namespace deformable_sim {
namespace {

Eigen::Matrix<double, 8, 3> make_directions() {
  Eigen::Matrix<double, 8, 3> d;
  d << 1, 0, 0,  //
      0, 1, 0,   //
      0, 0, 1,   //
      1, 1, 1,   //
      1, 1, -1,  //
      1, -1, 1,  //
      -1, 1, 1,  //
      1, -1, 0;
  return d.rowwise().normalized();
}

}  // namespace

const Eigen::Matrix<double, 8, 3>& unit_directions() {
  static const Eigen::Matrix<double, 8, 3> directions = make_directions();
  return directions;
}

}  // namespace deformable_sim
