// Springs as rows of a matrix that is never assembled.
#pragma once

#include <vector>

#include "deformable_sim/core/linear/block_kernels.h"
#include "deformable_sim/core/linear/row_packets.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// What PacketKernels need to know of springs: where rows have them, and how stiff they are.
class SpringRows {
 public:
  /// False where they are those that are known already.
  bool set(const std::vector<SpringElement>& springs);
  const std::vector<SpringElement>& springs() const { return springs_; }
  bool empty() const { return springs_.empty(); }

  /// x: m, to be kept; the matrix is dx dF/dd + dv dF/dw, transverse 0 for that of axial springs, else 1.
  void place(const Nodes& x, double dx, double dv, double transverse);
  /// Rows in the order of `position`, by node; none in rows that are held.
  void pack(const std::vector<int>& position, const std::vector<char>& held, int width);
  /// Copies of the positions, less the first one's, in the order of `node`; what the kernels load from.
  SpringSource source(const std::vector<int>& node);
  /// Frobenius norm of a spring's block (N/m).
  double norm_of(const SpringElement& s) const;

  PacketRows rows() const { return rows_.rows(); }
  float* blocks() { return blocks_.data(); }
  const float* blocks() const { return blocks_.data(); }

 private:
  std::vector<SpringElement> springs_;
  const Nodes* x_ = nullptr;
  double dx_ = 0.0, dv_ = 0.0, transverse_ = 1.0;
  RowPackets rows_;
  std::vector<float> stiffness_, damping_, length_, held_, blocks_;
  std::vector<float> points_;  // four floats a node
};

}  // namespace deformable_sim
