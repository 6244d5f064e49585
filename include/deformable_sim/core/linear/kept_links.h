// Constant links of a matrix that are worth their product, as rows in packets.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/linear/row_packets.h"

namespace deformable_sim {

/// All constant links of a scene, but those below a hundredth of the geometric mean of both rows' sums: Newton's matrix
/// need not be exact, and of a plate on a crooked mesh they are half of all.
class KeptLinks {
 public:
  /// The links must outlive their use.
  void set(const std::vector<const ConstantLinks*>& links) { links_ = links; }
  /// By node: how many links its row keeps.
  std::vector<int> counts(size_t nodes);
  /// Rows in the order of `position`, by node. Nodes that are held take part in neither row nor column.
  void pack(const std::vector<int>& position, const std::vector<char>& held, int width);
  /// Entries k + c / tau, and the sums over rows.
  void scale(double tau);

  /// Without links: a null start and a diagonal of zeros. The diagonal is 1 in rows that do not exist.
  LinkPackets rows() const { return {rows_.rows(), value_.data(), sum_.data()}; }

 private:
  template <class Visit>
  void for_each(const ConstantLinks& links, size_t row, const Visit& visit) const;
  void measure(size_t nodes);

  std::vector<const ConstantLinks*> links_;
  std::vector<double> size_;  // by node: square root of the row's sum
  RowPackets rows_;
  int width_ = 1;
  std::vector<float> stiffness_, damping_, value_;  // k in N/m, c in N s/m, k + c / tau
  std::vector<std::array<float, 2>> to_held_;       // k and c to held nodes, by row
  std::vector<float> sum_;                          // by lanes
};

}  // namespace deformable_sim
