// A sheet on a grid whose springs are solved line by line, in rows.
#pragma once

#include <vector>

#include "deformable_sim/core/grid/line_kernels.h"
#include "deformable_sim/core/grid/sheet_rows.h"

namespace deformable_sim {

/// How the springs of a line are solved: together, or one by one, every other one first.
enum class LineSolve { kWhole, kSpringBySpring };

/// Positions x that answer to forces by x = y + weight f, with the tensions of all springs and implicit bending: block
/// Gauss-Seidel over bending, warp lines, weft lines and both families of diagonals. A line is solved exactly for the
/// directions its springs have (LineKernels::solve), bending by a Chebyshev iteration to a twentieth.
///
///   f = -sum t n - K (x + bending_damping (x - base) / tau),   t = k (|d| - L) + k damping_time n.((d - d_base) / tau)
///
/// Cost of a sweep, AVX-512, springs and bending: see doc/theory/integrators.md.
template <class Real>
class SheetLines {
 public:
  /// held: world nodes, ascending.
  SheetLines(const GridSheet& sheet, const std::vector<int>& held, LineSolve how = LineSolve::kWhole);

  /// y, base: 3 x all nodes, m; base is read where something is damped. weight: m/N, one a node, 0 at held ones; tau:
  /// s.
  void begin(const Nodes& y, const Nodes& base, const Eigen::VectorXd& weight, double tau);
  /// Bending, then every line. Tensions are kept for another sweep unless this is the last.
  enum class Last { kNo, kYes };
  void sweep(Last last);
  /// Positions into the columns of the sheet's nodes.
  void store(Nodes* x) { rows_.store(plain_.x.data(), x); }
  bool contains(int node) const { return node >= rows_.first_node() && node < rows_.first_node() + rows_.node_count(); }
  Vec3 position(int node);
  void move_to(int node, const Vec3& x);
  /// Goes on from other positions (3 x all nodes, m).
  void move_to(const Nodes& x) { rows_.load(x, plain_.x.data()); }
  /// forces += the force (N) on held nodes that the sweeps have ended with; columns as in `held`.
  void add_held_forces(Nodes* forces);
  /// forces (3 x all nodes) += what springs and bending exert at the positions of the end.
  void add_forces(Nodes* forces);

 private:
  struct Held {
    Eigen::Index column;
    int node;                      // of the sheet
    std::ptrdiff_t place, turned;  // in rows, and with rows and columns changed
    Vec3 bending;                  // N
  };
  /// Positions and what moves them, in rows or in columns.
  struct Layout {
    XyzArray<Real> x, base, pull;
    RowArray<Real> weight;
    std::ptrdiff_t stride = 0;
    std::vector<unsigned char> keeps;  // by row: has a held node
  };
  /// Springs from row to row of a layout, over `apart` rows.
  struct Straight {
    int family, apart, nodes, lines;
    const Real *along, *across;
    Real length;
  };
  void set_weights(const Eigen::VectorXd& weight);
  void turn(Layout* from, int rows, int cols, Layout* to);
  LineMotion<Real> motion(Layout* layout);
  void bend();
  int bending_steps(double most) const;
  Vec3 bending_at(int node, const Xyz<Real>& z, double factor) const;
  void solve(const Straight& springs, Layout* layout, Last last);
  void solve_diagonals(Last last);
  void solve(const GridLines<Real>& lines, const LineMotion<Real>& moved, std::ptrdiff_t at, int first, int last) const;
  Real* tension(int family, Last last);

  SheetRows<Real> rows_;
  SheetRows<double> exact_rows_;  // for forces, which have no kernels in single precision
  const SheetKernels& forces_;
  const LineKernels<Real>& kernels_;
  LineSolve how_;
  bool damped_, bends_;
  Layout plain_, turned_;                       // turned: rows and columns changed
  std::vector<double> weights_;                 // as given last, by node of the sheet
  XyzArray<Real> y_, bent_, wr_, step_, next_;  // of bending; bent_: what it has moved
  double stiffest_ = 0.0;                       // N/m, of any row of K
  double largest_weight_ = 0.0;
  XyzArray<Real> v_;
  XyzArray<double> force_, wide_x_, wide_v_, wide_y_;
  std::vector<RowArray<Real>> tensions_;  // N, one a family of lines
  RowArray<Real> space_;
  std::vector<Held> held_;
  double tau_ = 0.0;
  bool fresh_ = true;  // no tensions yet
};

extern template class SheetLines<float>;
extern template class SheetLines<double>;

}  // namespace deformable_sim
