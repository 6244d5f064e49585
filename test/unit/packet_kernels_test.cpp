// Kernels over rows in packets, and over links, against plain loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/linear/packet_kernels.h"
#include "support/crooked_system.h"

namespace deformable_sim::test {
namespace {

TEST(BlockKernels, AddLinksAsTheirPlainTwinDoes) {
  // f_i += sum k_ij (y_j - y_i).
  const Sheet sheet(9);
  const int n = sheet.blocks.rows();
  const ConstantLinks& links = *sheet.links[0];
  Eigen::Matrix4Xd y = Eigen::Matrix4Xd::Zero(4, n);
  y.topRows<3>() = noise(n, 1.0, 1);
  Nodes expected = Nodes::Ones(3, n);
  for (size_t row = 0; row < links.sum.size(); ++row) {
    const int i = links.node[row];
    for (int e = links.row_start[row]; e < links.row_start[row + 1]; ++e) {
      const auto k = static_cast<size_t>(e);
      expected.col(i) += links.stiffness[k] * (y.col(links.place[k] / 4) - y.col(i)).head<3>();
    }
  }
  for (const SimdLevel level : {SimdLevel::kSse2, simd_level()}) {
    Nodes f = Nodes::Ones(3, n);
    block_kernels(level).add_links(
        {n, links.row_start.data(), links.place.data(), links.stiffness.data(), links.sum.data()}, links.node.data(),
        y.data(), f.data());
    EXPECT_LT((f - expected).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// Lists of entries by rows in packets: put(place among all lanes, entry).
template <class Entry, class Put>
std::vector<int> pack(const std::vector<std::vector<Entry>>& rows, int width, const Put& put) {
  std::vector<int> start{0};
  const int n = static_cast<int>(rows.size());
  for (int first = 0; first < n; first += width) {
    size_t longest = 0;
    for (int i = first; i < std::min(n, first + width); ++i) {
      const auto& row = rows[static_cast<size_t>(i)];
      longest = std::max(longest, row.size());
      for (size_t k = 0; k < row.size(); ++k) {
        put((start.back() + static_cast<int>(k)) * width + packet_lane(i - first, width), row[k]);
      }
    }
    start.push_back(start.back() + static_cast<int>(longest));
  }
  return start;
}

/// A matrix of blocks, springs and links in packets, for the kernels of one level.
struct Packed {
  struct Block {
    int column, slot;
  };
  struct Link {
    int column;
    float value;
  };
  Packed(const Sheet& sheet, const std::vector<SpringLink>& springs, int w)
      : width(w), packets((sheet.blocks.rows() + w - 1) / w) {
    const BlockMatrix& a = sheet.blocks;
    const auto n = static_cast<size_t>(a.rows());
    std::vector<std::vector<Block>> of_blocks(n);
    std::vector<std::vector<std::pair<int, const SpringLink*>>> of_springs(n);
    for (int i = 0; i < a.rows(); ++i) {
      auto& row = of_blocks[static_cast<size_t>(i)];
      row.push_back({i, a.diagonal_slot(i)});
      for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
        if (a.column()[static_cast<size_t>(k)] != i) row.push_back({a.column()[static_cast<size_t>(k)], k});
      }
    }
    for (const SpringLink& s : springs) {
      of_springs[static_cast<size_t>(s.a)].push_back({s.b, &s});
      of_springs[static_cast<size_t>(s.b)].push_back({s.a, &s});
    }
    const size_t most = n * 40;
    block_place.assign(most, 0);
    slot.assign(most, -1);
    block_start = pack(of_blocks, width, [&](int at, const Block& b) {
      block_place[static_cast<size_t>(at)] = 4 * b.column;
      slot[static_cast<size_t>(at)] = b.slot;
    });
    spring_place.assign(most, 0);
    for (auto* numbers : {&stiffness, &damping, &length, &held}) numbers->assign(most, 0.0f);
    spring_start = pack(of_springs, width, [&](int place, const std::pair<int, const SpringLink*>& s) {
      const auto at = static_cast<size_t>(place);
      spring_place[at] = 4 * s.first;
      stiffness[at] = static_cast<float>(s.second->stiffness);
      damping[at] = static_cast<float>(s.second->damping);
      length[at] = static_cast<float>(s.second->rest_length);
      held[at] = s.first == 3 ? 1.0f : 0.0f;
    });
    const ConstantLinks& links = *sheet.links[0];
    std::vector<std::vector<Link>> of_links(n);
    link_sum.assign(most, 1.0f);
    for (size_t row = 0; row < n; ++row) {
      const int i = links.node[row];
      link_sum[static_cast<size_t>(i - i % width + packet_lane(i % width, width))] = static_cast<float>(links.sum[row]);
      for (int e = links.row_start[row]; e < links.row_start[row + 1]; ++e) {
        const auto k = static_cast<size_t>(e);
        of_links[static_cast<size_t>(i)].push_back(
            {static_cast<int>(links.place[k] / 4), static_cast<float>(links.stiffness[k])});
      }
    }
    link_place.assign(3 * most, 0);
    link_value.assign(3 * most, 0.0f);
    link_start = pack(of_links, width, [&](int at, const Link& link) {
      link_place[static_cast<size_t>(at)] = 4 * link.column;
      link_value[static_cast<size_t>(at)] = link.value;
    });
    blocks.assign(9 * most, 0.0f);
    spring_blocks.assign(4 * most, 0.0f);
  }
  PacketMatrix matrix() const {
    return {packets,
            {block_start.data(), block_place.data()},
            {spring_start.data(), spring_place.data()},
            blocks.data(),
            spring_blocks.data()};
  }
  LinkPackets links() const { return {{link_start.data(), link_place.data()}, link_value.data(), link_sum.data()}; }

  int width, packets;
  std::vector<int> block_start, block_place, slot, spring_start, spring_place, link_start, link_place;
  std::vector<float> stiffness, damping, length, held, link_value, link_sum, blocks, spring_blocks;
};

TEST(PacketKernels, EqualTheirPlainTwins) {
  // Rounding of single precision: some 60 products a row, and differences of positions of 1 m at 0.1 m. Springs are
  // Spring::stiffness; those beside node 3 count in the rows' sums as if it were held.
  const Sheet sheet(9);
  const int n = sheet.blocks.rows();
  std::vector<SpringLink> springs;
  for (const auto& [a, b] : edges_of(sheet.mesh)) {
    springs.push_back({a, b, 0.12, 300.0 + a, 0.5 + 0.01 * b});
  }
  BlockMatrix with_springs = sheet.blocks;
  Eigen::MatrixXf sums = Eigen::MatrixXf::Zero(3, n);
  for (int i = 0; i < n; ++i) {
    for (int k = sheet.blocks.row_start()[static_cast<size_t>(i)];
         k < sheet.blocks.row_start()[static_cast<size_t>(i) + 1]; ++k) {
      sums.col(i) += sheet.blocks.block(k).diagonal().cast<float>();
    }
  }
  for (const SpringLink& s : springs) {
    const Vec3 d = sheet.body.state.x.col(s.b) - sheet.body.state.x.col(s.a);
    const Mat3 h =
        Spring::stiffness(d, Vec3::Zero(), {s.rest_length, s.stiffness, s.damping}, 1.0, 180.0, Jacobian::kProjected);
    with_springs.block(with_springs.diagonal_slot(s.a)) += h;
    with_springs.block(with_springs.diagonal_slot(s.b)) += h;
    with_springs.block(with_springs.slot(s.a, s.b)) -= h;
    with_springs.block(with_springs.slot(s.b, s.a)) -= h;
    if (s.a == 3) sums.col(s.b) += h.diagonal().cast<float>();
    if (s.b == 3) sums.col(s.a) += h.diagonal().cast<float>();
  }
  for (const SimdLevel level : {SimdLevel::kSse2, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (level > simd_level()) continue;
    const PacketKernels& kernels = packet_kernels(level);
    Packed packed(sheet, springs, kernels.width);
    const int room = packed.packets * kernels.width;
    const auto padded = [&](const Nodes& x) {
      PaddedNodes to = PaddedNodes::Zero(4, room);
      to.topLeftCorner(3, n) = x.cast<float>();
      return to;
    };
    const auto unpadded = [&](const PaddedNodes& x) { return Nodes(x.topLeftCorner(3, n).cast<double>()); };
    const PaddedNodes x = padded(sheet.body.state.x), p = padded(noise(n, 1.0, 1)), r = padded(noise(n, 1.0, 2)),
                      z = padded(noise(n, 1.0, 3));
    PaddedNodes row_sum(4, room), q(4, room), t(4, room), s = PaddedNodes::Zero(4, room), corrected = z;
    std::vector<float> inverse(static_cast<size_t>(6 * room));
    kernels.load(packed.matrix(), {packed.slot.data(), sheet.blocks.block(0).data()},
                 {packed.stiffness.data(), packed.damping.data(), packed.length.data(), packed.held.data(), x.data(),
                  1.0f, 180.0f, 1.0f},
                 packed.link_sum.data(), 0.6f, packed.blocks.data(), packed.spring_blocks.data(), inverse.data(),
                 row_sum.data());
    EXPECT_LT((row_sum.topLeftCorner(3, n) - sums).cwiseAbs().maxCoeff(), 1e-5 * sums.cwiseAbs().maxCoeff());

    Nodes ap, bp = Nodes::Zero(3, n), swept(3, n), expected(3, n), az;
    with_springs.multiply(unpadded(p), &ap);
    const ConstantLinks& links = *sheet.links[0];
    Eigen::VectorXd link_sum(n);
    for (size_t row = 0; row < links.sum.size(); ++row) {
      const int i = links.node[row];
      link_sum[i] = links.sum[row];
      bp.col(i) = links.sum[row] * unpadded(p).col(i);
      for (int e = links.row_start[row]; e < links.row_start[row + 1]; ++e) {
        const auto k = static_cast<size_t>(e);
        bp.col(i) -= links.stiffness[k] * unpadded(p).col(links.place[k] / 4);
      }
    }
    const auto sweep = [&](const Nodes& of, int i) {
      const Mat3 d = with_springs.block(with_springs.diagonal_slot(i)) + link_sum[i] * Mat3::Identity();
      return Vec3(0.6 * d.inverse() * of.col(i));
    };
    const double size = ap.norm() / std::sqrt(n);
    const double pq = kernels.product(packed.matrix(), packed.links(), p.data(), q.data());
    EXPECT_LT((unpadded(q) - ap - bp).cwiseAbs().maxCoeff(), 1e-5 * size) << name_of(level);
    EXPECT_NEAR(pq, dot(p, q), 1e-5 * std::abs(pq));
    EXPECT_EQ(q.row(3).cwiseAbs().maxCoeff(), 0.0f);
    kernels.residue(packed.matrix(), r.data(), p.data(), t.data());
    EXPECT_LT((unpadded(t) - unpadded(r) + ap).cwiseAbs().maxCoeff(), 1e-5 * size) << name_of(level);
    kernels.sweep(packed.packets, inverse.data(), r.data(), s.data());
    for (int i = 0; i < n; ++i) swept.col(i) = sweep(unpadded(r), i);
    EXPECT_LT((unpadded(s) - swept).cwiseAbs().maxCoeff(), 1e-5 * swept.cwiseAbs().maxCoeff()) << name_of(level);
    const double rz = kernels.correct(packed.matrix(), inverse.data(), r.data(), p.data(), r.data(), corrected.data());
    const Nodes left = unpadded(r) - ap;
    for (int i = 0; i < n; ++i) expected.col(i) = unpadded(z).col(i) + unpadded(p).col(i) + sweep(left, i);
    EXPECT_LT((unpadded(corrected) - expected).cwiseAbs().maxCoeff(), 1e-4 * expected.cwiseAbs().maxCoeff());
    EXPECT_NEAR(rz, dot(r, corrected), 1e-5 * std::abs(r.norm() * corrected.norm()));
  }
}

}  // namespace
}  // namespace deformable_sim::test
