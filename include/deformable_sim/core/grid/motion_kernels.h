// The loop of explicit steps over a sheet on a grid. Plain pointers only, see sheet_kernels.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "deformable_sim/core/grid/sheet_kernels.h"

namespace deformable_sim {

/// Positions of explicit steps. Single precision counts units (MotionLeap::unit) in 32 bits, so that what a position
/// loses in a step, and the difference of two neighbours, do not depend on how far the sheet is from the origin.
template <class Real>
struct MotionPosition;
template <>
struct MotionPosition<double> {
  using Type = double;
};
template <>
struct MotionPosition<float> {
  using Type = std::int32_t;
};

/// A sheet whose columns are dealt out to the lanes of registers: of a row of `registers` registers, column c lies in
/// lane c / registers of register c % registers. Neighbours of a register are the registers beside it, so that nothing
/// is loaded across a boundary and nothing has to move from lane to lane; but for the ends of rows, where kHalo more
/// registers on either side repeat what comes before the first and after the last, a lane further [Henretty 2011].
///
/// Points lie as x, y and z of a register side by side: number(row, register, coordinate) =
/// row * stride + (3 * register + coordinate) * width. Numbers by node lie at a third of that. Two rows above and below
/// exist and are finite.
template <class Real>
struct MotionShape {
  static constexpr int kHalo = 2;

  int rows, registers;
  std::ptrdiff_t stride;
  Real damping_time;  // s

  // As in SheetShape, columns dealt out, with kHalo registers on both sides.
  Real warp_length, weft_length, shear_length, warp_bend_length, weft_bend_length;  // m
  const Real *warp_along, *warp_across, *weft_along, *weft_across;
  const Real *shear, *shear_rows;
  bool has_flexion;
  const Real *warp_bend_along, *warp_bend_across, *weft_bend_along, *weft_bend_across;

  bool has_bending;
  Real bending_damping;        // s
  const Real* const* bending;  // by row: of each register the 13 coefficients side by side
};

/// One part of an explicit step: kick, then drift.
/// Bending acts on x + bending_damping v = start + y; what start contributes is reckoned once a step, by differences of
/// neighbours, so that single precision sums small numbers only.
///   v += kick (g + gain f) - lost v where gain is not 0,   x += drift v,   y = x - start + bending_damping v
template <class Real>
struct MotionLeap {
  using Position = typename MotionPosition<Real>::Type;
  Position* x;
  Real unit;               // m, of x
  Position* start;         // x when the step began; double precision: null, the origin instead
  Real *v, *y;             // y: units
  Real* bent;              // N, of bending at start; null likewise
  const Real* gain;        // 1/kg by node: 0 at held nodes and where there is none
  Real lost, kick, drift;  // lost: the share that drag takes; s; s
  Real gravity[3];
  const Real* more;            // N, further forces; null: none
  Real* force;                 // N, written in the rows that ...
  const unsigned char* keeps;  // ... this marks
  Real* rows[3];               // space for a row of points each, with a register on either side
  Real* passed;                // space for another
};

template <class Real>
struct MotionKernels {
  int width;  // numbers a register
  /// start, y, bent and the registers beside rows, from x and v.
  void (*begin)(const MotionShape<Real>&, const MotionLeap<Real>&);
  void (*leap)(const MotionShape<Real>&, const MotionLeap<Real>&);
  /// The same by bands of at least four rows, in two loops, to the same bits: forces of all bands, each with its own
  /// `rows` and `passed`, which moves all nodes but those that other bands look at and leaves the forces on these in
  /// `force`; then these move.
  void (*leap_band)(const MotionShape<Real>&, const MotionLeap<Real>&, const RowBand&);
  void (*move_edges)(const MotionShape<Real>&, const MotionLeap<Real>&, const RowBand&);
};

const MotionKernels<float>& motion_kernels(SimdLevel level, float);
const MotionKernels<double>& motion_kernels(SimdLevel level, double);

}  // namespace deformable_sim
