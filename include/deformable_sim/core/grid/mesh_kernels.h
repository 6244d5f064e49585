// The loops of explicit steps over nodes that any springs and constant links join. Plain pointers only, see
// sheet_kernels.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "deformable_sim/core/grid/motion_kernels.h"

namespace deformable_sim {

/// Nodes in packets, one a lane. Every node of a packet has as many entries as its longest row: those of packet p lie
/// at [start[p], start[p + 1]), each a register of numbers. `place` is four times the index of the node at the other
/// end, in the order of packets.
template <class Real>
struct MeshEntries {
  const int* start;
  const int* place;
  const Real* value;    // springs: stiffness, N/m; links: entry of the force's derivative, N/m
  const Real* rest;     // springs: stiffness times length at rest, N
  const Real* damping;  // springs: N s/m; null: none has any
};

template <class Real>
struct MeshShape {
  int packets;
  MeshEntries<Real> springs, fast_links, slow_links;  // see LinkSplit
  Real links_damping;                                 // s
};

/// Numbers of nodes by packets: of each packet x of all lanes, then y, then z. What `points` are: four numbers a node,
/// the fourth 0. Units and the meaning of y, start and bent as in MotionLeap.
template <class Real>
struct MeshLeap {
  using Position = typename MotionPosition<Real>::Type;
  Position *x, *x_points;
  Real unit, per_unit;    // m, 1/m
  Real *v, *v_points;     // v_points: only where springs are damped
  const Position* start;  // single precision only
  Real* y_points;         // units
  const Real* bent;       // N, single precision only
  const Real* gain;       // 1/kg by node: 0 at held nodes and where there is none
  Real lost, kick, drift;
  Real gravity[3];
  const Real* more;            // N; null: none
  Real* force;                 // N, written in the packets that ...
  const unsigned char* keeps;  // ... this marks
  Real* rate;                  // m/s^2 of slow links, last time in this step; null: of no account
  Real ahead;                  // s
  const unsigned char* leans;  // packets whose y is wanted; null: all
};

template <class Real>
struct MeshKernels {
  int width;  // nodes a packet
  /// x_points and v_points, from x and v.
  void (*begin)(const MeshShape<Real>&, const MeshLeap<Real>&);
  /// y_points of x and v, or of x and v + ahead * rate, for bend() later on.
  void (*lean)(const MeshShape<Real>&, const MeshLeap<Real>&);
  /// v += kick (gravity + gain (springs + bent + more)) - lost v where gain is not 0.
  void (*pull)(const MeshShape<Real>&, const MeshLeap<Real>&);
  /// v += kick rate, rate = gain links, of these links on y.
  void (*bend)(const MeshShape<Real>&, const MeshEntries<Real>& links, const MeshLeap<Real>&);
  /// x += drift v.
  void (*drift)(const MeshShape<Real>&, const MeshLeap<Real>&);
};

const MeshKernels<float>& mesh_kernels(SimdLevel level, float);
const MeshKernels<double>& mesh_kernels(SimdLevel level, double);

}  // namespace deformable_sim
