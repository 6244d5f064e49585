// The loops of sparse products over packets of rows, one row a lane, once for each instruction set.
#pragma once

#include "deformable_sim/core/simd_level.h"

namespace deformable_sim {

/// Rows in packets of as many lanes as a register has floats. Every row of a packet has as many entries as its longest:
/// those of packet p lie at [start[p], start[p + 1]), each a register of numbers. `place` is four times the column.
/// Vectors have four floats a node, the fourth 0, in the order of rows; their length is that of all packets. Which lane
/// a row has: packet_lane(). Entries that do not exist have the row itself as their column, and are 0.
struct PacketRows {
  const int* start;
  const int* place;
};

/// Blocks and springs, one sum. Of each entry of `blocks` nine registers, by columns; the first entry of a row is the
/// diagonal. Of each entry of `springs` q and t, four registers: q q^T + t on the diagonal, its opposite off it, so
/// that nothing is lost where a row's sum is small; a null start: none.
struct PacketMatrix {
  int packets;
  PacketRows blocks, springs;
  const float *block, *spring;
};

/// Scalars k_ij off the diagonal; the diagonal is apart, by lanes.
struct LinkPackets : PacketRows {
  const float* value;
  const float* diagonal;
};

/// Where blocks come from: nine doubles each, by columns; `slot` which of them, -1: nowhere.
struct PacketSource {
  const int* slot;
  const double* block;
};

/// Of the entries of springs: k and c (N/m, N s/m; 0 in rows that are held) and L (m), `held` 1 where the other end is,
/// else 0. x: vector of positions (m). The matrix is dx dF/dd + dv dF/dw as Spring::stiffness, projected, with
/// `transverse` 1, axial with 0.
struct SpringSource {
  const float *stiffness, *damping, *length, *held;
  const float* x;
  float dx, dv, transverse;
};

/// Lane of the row at `offset` within its packet: so that a packet's vectors are loaded as they lie.
inline int packet_lane(int offset, int width) {
  const int quarter = width / 4;
  return 4 * (offset % quarter) + offset / quarter;
}

/// Not good at: rows of very unequal length; results that are the same to the last bit at all levels.
struct PacketKernels {
  int width;  // rows a packet
  /// Writes a.block and a.spring, as `blocks` and `springs`; of each row weight (D + extra)^-1 of the diagonal block D
  /// (xx, yy, zz, xy, xz, yz, by lanes; extra by lanes), and as a vector the sum of the row's blocks' diagonals,
  /// nothing in the columns of held nodes.
  void (*load)(const PacketMatrix& a, const PacketSource& from, const SpringSource& of_springs, const float* extra,
               float weight, float* blocks, float* springs, float* inverse, float* row_sum);
  /// z = D r, D as load() has it.
  void (*sweep)(int packets, const float* d, const float* r, float* z);
  /// t = r - A z.
  void (*residue)(const PacketMatrix& a, const float* r, const float* z, float* t);
  /// z += c + D (t - A c); returns r.z.
  double (*correct)(const PacketMatrix& a, const float* d, const float* t, const float* c, const float* r, float* z);
  /// q = (A + links' diagonal - links) p, without links where their start is null; returns p.q.
  double (*product)(const PacketMatrix& a, const LinkPackets& k, const float* p, float* q);
};

const PacketKernels& packet_kernels(SimdLevel level);

}  // namespace deformable_sim
