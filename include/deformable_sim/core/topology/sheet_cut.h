// A sheet cut along the squares and seams that are painted on it, so that both are sharp on coarse cells.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

enum class Paint : unsigned char { kPlain, kChecker, kSeam };

/// What is painted, in the rest shape of the mesh.
struct SheetPattern {
  double checker = 0.0;  // m: edge of the squares along x and y, counted from the least x and y; 0 = none
  double seams = 0.0;    // m: width of the band along borders and folds, on each side of a fold; 0 = none
};

/// Triangles and border edges of a mesh, each of one paint. Corners are points of the mesh or, from their number on,
/// `extras`.
struct SheetCut {
  struct Extra {
    std::array<int, 3> point;
    Eigen::Vector3d weight;  // sums to 1
  };
  struct Piece {
    std::array<int, 3> corner;  // wound as the triangle it is of
    Paint paint;
  };
  struct Rim {
    std::array<int, 2> end;  // in the direction of the triangle beside it
    Paint paint;
  };
  std::vector<Extra> extras;
  std::vector<Piece> pieces;
  std::vector<Rim> rims;

  /// Values given at the points of the mesh, one column each, at those and the extras.
  template <class Columns>
  Eigen::Matrix<typename Columns::Scalar, 3, Eigen::Dynamic> extended(const Columns& at_points) const {
    using Scalar = typename Columns::Scalar;
    Eigen::Matrix<Scalar, 3, Eigen::Dynamic> all(3, at_points.cols() + static_cast<Eigen::Index>(extras.size()));
    all.leftCols(at_points.cols()) = at_points;
    Eigen::Index next = at_points.cols();
    for (const Extra& extra : extras) {
      all.col(next++) = static_cast<Scalar>(extra.weight[0]) * at_points.col(extra.point[0]) +
                        static_cast<Scalar>(extra.weight[1]) * at_points.col(extra.point[1]) +
                        static_cast<Scalar>(extra.weight[2]) * at_points.col(extra.point[2]);
    }
    return all;
  }
};

/// Pieces a sheet may be cut into, beyond the triangles it has.
constexpr int kMaxCuts = 100000;

/// Squares alternate by the sum of their numbers along x and y, so a mesh that is no sheet in x and y should not have
/// them. A fold is an edge where the faces of the rest shape turn by more than 60 degrees. A mesh without a pattern
/// keeps its triangles. Throws InputError (kOutOfRange) when there would be more than kMaxCuts pieces more.
SheetCut cut_sheet(const TriangleMesh& mesh, const SheetPattern& pattern);

/// How a cloth is drawn with more than its colour.
struct SheetLook {
  SheetCut cut;  // of what is shown: the body's surface, or its skin's
  std::array<double, 3> checker_color{{1, 1, 1}};
  double thickness = 0.0;  // m: distance of the two faces; 0 = one
};

}  // namespace deformable_sim
