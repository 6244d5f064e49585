// The loops of sparse products and of conjugate gradients, once for each instruction set.
#pragma once

#include "deformable_sim/core/simd_level.h"

namespace deformable_sim {

/// A spring between nodes a and b: rest length (m), stiffness (N/m), damping (N s/m).
struct SpringElement {
  int a, b;
  double length, stiffness, damping;
};

/// A scalar matrix by compressed rows, off-diagonal entries k_ij and a diagonal of its own. Rows are filled up with
/// zeros to a multiple of four entries. `place` as above.
template <class Real>
struct LinkRows {
  int rows;
  const int* start;
  const unsigned* place;
  const Real* value;
  const Real* diagonal;
};

/// Nodes are x, y, z and a fourth float that stays 0, unless it is said otherwise.
///
/// Not good at: results that are the same to the last bit at all levels.
struct BlockKernels {
  /// f += K y, K = k_ij - diagonal, row i being that of node[i]; y has four doubles a node, f three.
  void (*add_links)(const LinkRows<double>& k, const int* node, const double* y, double* f);
  /// Of `count` springs: blocks += dx dF/dd + dv dF/dw as Spring::stiffness, projected; four slots (aa, ab, ba, bb)
  /// each.
  void (*add_springs)(int count, const SpringElement* springs, const int* slots, const double* x, double dx, double dv,
                      double* blocks);
  /// p = z + beta p.
  void (*direct)(int n, const float* z, float beta, float* p);
  /// sum += alpha p, r -= alpha q; returns sum of w^2 |r|^2, w one float a node.
  double (*advance)(int n, float alpha, const float* p, const float* q, const float* w, float* sum, float* r);
  /// y = P x: rows of weights.
  void (*interpolate)(const LinkRows<float>& p, const float* x, float* y);
  /// t = r - L z, L = diagonal (four floats a node, one an axis) - k_ij.
  void (*coarse_residue)(const LinkRows<float>& l, const float* r, const float* z, float* t);
  /// z += D (r - L z) into y, D four floats a node.
  void (*coarse_sweep)(const LinkRows<float>& l, const float* d, const float* r, const float* z, float* y);
};

const BlockKernels& block_kernels(SimdLevel level);

}  // namespace deformable_sim
