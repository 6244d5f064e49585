// The inner loops of implicit steps of ropes: forces, matrix, factors and solution in one walk along the line.
#pragma once

#include "deformable_sim/core/simd_level.h"

namespace deformable_sim {

/// One number for each half of a rope. A rope of 2 h nodes is walked from both ends at once: place k is node k in the
/// first lane and node 2 h - 1 - k in the second, so that both lanes do the same and meet in the middle.
using Two = double __attribute__((vector_size(16)));

/// A node, what ties it to the next one (the link), and what bends at the next one (the joint). Behind the middle, at
/// places h and h + 1, lie copies of the other lane's nodes.
struct RopePlace {
  Two x[3];               // m
  Two mass;               // kg
  Two target[3];          // N: see RopeSystem
  Two inertia;            // N/m
  Two band[3];            // N/m: constant multiples of I in the matrix, with this place and the two behind it
  Two stiffness, length;  // k, N/m, and L, m, of the link
  Two tension;            // T, N/m: its transverse stiffness, that of the start of the step
  Two before, behind;     // a, b, 1/m^2: curvature = a d + b d_next
  Two moment;             // N m^3: bending stiffness of the joint, viscous part included
};

/// A spring over two links, from a place to the second one behind it.
struct RopeSpan {
  Two stiffness, length, tension;
  Two direction[3];  // see RopeFactor
  Two second[9];     // block of L of the second place behind
};

/// What depends on velocities, v = (x - x_base) / tau.
struct RopeDamping {
  Two link, span;                  // c / tau, N/m
  Two link_base[3], span_base[3];  // m: the link and the span at x_base
  Two bending;                     // N m^3: viscous part of RopePlace::moment
  Two moment[3];                   // N m: the share of x_base in the moment
};

/// L D L^T of one place's three rows and what it leaves below. Without spans the block of the second place behind is
/// a multiple of I times L^-T D^-1, and not kept.
struct RopeFactor {
  Two lower[3], inverse[3];  // l10, l20, l21; 1 / D
  Two next[9];               // block of L, row by row, of the next place
  Two rest[3];               // right side; after a move, the move
  Two direction[3];          // of the link, where it was linearised
};

/// r = target - inertia x + forces of links, spans and joints. Held nodes have an inertia in `band` beside which
/// nothing else counts.
struct RopeSystem {
  int half = 0;  // h >= 2
  RopePlace* place = nullptr;
  RopeSpan* span = nullptr;              // null: none
  const RopeDamping* damping = nullptr;  // null: nothing is damped
  RopeFactor* factor = nullptr;
  double middle[6][6];       // factors of the two nodes in the middle, lower part
  double middle_inverse[6];  // of D
  double middle_rest[6];
};

struct RopeKernels {
  /// Residual, matrix and factors at x; false where a pivot is not positive.
  bool (*factorise)(RopeSystem*);
  /// The residual at x against the factors at hand, after a move along them. A link that has turned by phi is longer by
  /// phi^2 L / 2 than the factors know; the force of that, k times as much, is gone after a motion along the link, but
  /// its share phi across looks to factors of the old direction like a load that nothing holds. So it acts along the
  /// direction n0 of the factors: f = (t - s) n + s n0, s = k (r - n0.d), t the tension at x.
  void (*resume)(RopeSystem*);
  /// x += A^-1 r; returns the sum of |A^-1 r|^2.
  double (*move)(RopeSystem*);
  /// Undoes the last move.
  void (*take_back)(RopeSystem*);
  /// The rest of each factor := target + forces of links, spans and joints.
  void (*find_forces)(RopeSystem*);
};

const RopeKernels& rope_kernels(SimdLevel level);

}  // namespace deformable_sim
