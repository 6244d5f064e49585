#include "deformable_sim/core/linear/spring_rows.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {

bool SpringRows::set(const std::vector<SpringElement>& springs) {
  const auto equal = [](const SpringElement& s, const SpringElement& t) {
    return s.a == t.a && s.b == t.b && s.length == t.length && s.stiffness == t.stiffness && s.damping == t.damping;
  };
  if (std::equal(springs.begin(), springs.end(), springs_.begin(), springs_.end(), equal)) return false;
  springs_ = springs;
  return true;
}

void SpringRows::place(const Nodes& x, double dx, double dv, double transverse) {
  x_ = &x;
  dx_ = dx;
  dv_ = dv;
  transverse_ = transverse;
}

void SpringRows::pack(const std::vector<int>& position, const std::vector<char>& held, int width) {
  rows_.clear();
  blocks_.clear();
  if (springs_.empty()) return;
  std::vector<int> length(position.size(), 0);
  const auto for_each_end = [&](const auto& visit) {
    for (const SpringElement& s : springs_) {
      const int a = position[static_cast<size_t>(s.a)], b = position[static_cast<size_t>(s.b)];
      if (held[static_cast<size_t>(a)] == 0) visit(s, a, b);
      if (held[static_cast<size_t>(b)] == 0) visit(s, b, a);
    }
  };
  for_each_end([&](const SpringElement&, int row, int) { ++length[static_cast<size_t>(row)]; });
  rows_.lay_out(length, width);
  for (std::vector<float>* numbers : {&stiffness_, &damping_, &length_, &held_}) numbers->assign(rows_.size(), 0.0f);
  blocks_.assign(4 * rows_.size(), 0.0f);
  for_each_end([&](const SpringElement& s, int row, int column) {
    const int k = --length[static_cast<size_t>(row)];
    const size_t at = rows_.at(row, k);
    rows_.set_column(row, k, column);
    stiffness_[at] = static_cast<float>(s.stiffness);
    damping_[at] = static_cast<float>(s.damping);
    length_[at] = static_cast<float>(s.length);
    held_[at] = held[static_cast<size_t>(column)] != 0 ? 1.0f : 0.0f;
  });
  points_.assign(4 * static_cast<size_t>(rows_.packets() * width), 0.0f);
}

SpringSource SpringRows::source(const std::vector<int>& node) {
  if (!springs_.empty()) {
    const Vec3 origin = x_->col(0);
    float* to = points_.data();
    for (int i : node) {
      const double* from = x_->data() + 3 * static_cast<std::ptrdiff_t>(i);
      for (int d = 0; d < 3; ++d) to[d] = static_cast<float>(from[d] - origin[d]);
      to += 4;
    }
  }
  return {stiffness_.data(), damping_.data(),         length_.data(),          held_.data(),
          points_.data(),    static_cast<float>(dx_), static_cast<float>(dv_), static_cast<float>(transverse_)};
}

double SpringRows::norm_of(const SpringElement& s) const {
  const double length = (x_->col(s.b) - x_->col(s.a)).norm();
  if (!(length > 1e-12)) return 0.0;
  const double across = transverse_ * std::max(0.0, dx_ * s.stiffness * (1.0 - s.length / length));
  const double along = dx_ * s.stiffness + dv_ * s.damping;
  return std::sqrt(along * along + 2.0 * across * across);
}

}  // namespace deformable_sim
