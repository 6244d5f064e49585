// In what positions of explicit steps are counted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// In single precision positions are counted from the middle of a body, in 2^31 units for what a node can reach within
/// a step; in double precision they are metres.
template <class Real>
class PositionUnit {
 public:
  using Position = typename MotionPosition<Real>::Type;
  static constexpr bool kCounts = std::is_integral<Position>::value;

  /// For a step of dt (s) from x (m) and v (m/s). longest: m, of the springs at rest.
  template <class X, class Rate>
  void choose(const X& x, const Rate& v, double dt, double longest) {
    if constexpr (kCounts) {
      const Vec3 low = x.rowwise().minCoeff(), high = x.rowwise().maxCoeff();
      origin_ = 0.5 * (low + high);
      const double half = 0.5 * (high - low).maxCoeff();
      const double range =
          std::max(kRoom * (half + dt * kFaster * (v.cwiseAbs().maxCoeff() + kSlow)), kStretched * longest);
      fastest_ = (range - half) / dt;
      unit_ = static_cast<double>(static_cast<Real>(range / kLargest));  // what the kernels reckon with
      per_unit_ = 1.0 / unit_;
    }
  }

  /// To the nearest.
  Position counted(double x, int d) const {
    if constexpr (kCounts) {
      constexpr std::int64_t kShift = std::int64_t(1) << 40;  // what is positive is cut off downwards
      return static_cast<std::int32_t>(
          static_cast<std::int64_t>((x - origin_[d]) * per_unit_ + (static_cast<double>(kShift) + 0.5)) - kShift);
    } else {
      return x;
    }
  }
  double position(Position x, int d) const { return origin_[d] + unit_ * static_cast<double>(x); }

  double unit() const { return unit_; }          // m
  double per_unit() const { return per_unit_; }  // 1/m
  /// m/s, at the end of the step: nothing slower has left the range.
  bool may_have_left(double fastest) const { return kCounts && fastest > fastest_; }

 private:
  static constexpr double kLargest = 2147483646.0;  // 2^31 - 2
  static constexpr double kRoom = 1.5;              // of the range of positions, over what a step is thought to need
  static constexpr double kFaster = 2.0;            // a node at its end, than the fastest at its start
  static constexpr double kStretched = 8.0;  // a spring, over its length: differences must not leave the range either
  static constexpr double kSlow = 1.0;       // m/s, that no body is thought to be slower than

  Vec3 origin_ = Vec3::Zero();
  double unit_ = 1.0, per_unit_ = 1.0;
  double fastest_ = 0.0;
};

}  // namespace deformable_sim
