// Multigrid on aggregates: groups, the coarse correction, the kernels, and what conjugate gradients need with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/linear/aggregation_multigrid.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/linear/multigrid_solver.h"
#include "deformable_sim/core/linear/packet_kernels.h"
#include "support/crooked_sheet.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

Nodes noise(int n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, size);
  return Nodes::NullaryExpr(3, n, [&] { return normal(generator); });
}

PaddedNodes padded_noise(int n, unsigned seed) {
  PaddedNodes x = PaddedNodes::Zero(4, n);
  x.topRows<3>() = noise(n, 1.0, seed).cast<float>();
  return x;
}

double dot(const PaddedNodes& a, const PaddedNodes& b) {
  return a.cast<double>().cwiseProduct(b.cast<double>()).sum();
}

GraphMatrix laplacian_of(const TriangleMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [a, b] : edges_of(mesh)) {
    for (const auto& [i, j] : {std::array<int, 2>{a, b}, std::array<int, 2>{b, a}}) {
      entries.emplace_back(i, j, -100.0);
      entries.emplace_back(i, i, 100.0);
    }
  }
  GraphMatrix laplacian(mesh.rest.cols(), mesh.rest.cols());
  laplacian.setFromTriplets(entries.begin(), entries.end());
  return laplacian;
}

/// 5 to 15 N/m, other values on each axis.
AxisValues sums(int n) {
  AxisValues sum = AxisValues::Zero(4, n);
  sum.topRows<3>() = noise(n, 1.0, 5).cast<float>().cwiseMin(2.0f).cwiseMax(-2.0f) * 2.5f;
  sum.topRows<3>().array() += 10.0f;
  return sum;
}

TEST(Aggregates, PartTheNodesIntoGroupsOfNeighbours) {
  // A group is a node with all its neighbours, or has more that are linked to one of those; a lone node is in none.
  const TriangleMesh mesh = crooked_sheet(12);
  const GraphMatrix laplacian = laplacian_of(mesh);
  GraphMatrix links(145, 145);  // one node more, alone
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 144; ++i) {
    for (GraphMatrix::InnerIterator it(laplacian, i); it; ++it) {
      if (it.col() != i) entries.emplace_back(i, static_cast<int>(it.col()), -it.value());
    }
  }
  links.setFromTriplets(entries.begin(), entries.end());
  int count = 0, again = 0;
  const std::vector<int> group = aggregates(links, &count);
  EXPECT_EQ(group, aggregates(links, &again));
  EXPECT_EQ(group[144], -1);
  EXPECT_LT(count, 144 / 4);
  EXPECT_GT(count, 144 / 16);
  std::vector<int> size(static_cast<size_t>(count), 0);
  for (int i = 0; i < 144; ++i) {
    ASSERT_GE(group[static_cast<size_t>(i)], 0);
    ++size[static_cast<size_t>(group[static_cast<size_t>(i)])];
    int friends = 0;
    for (GraphMatrix::InnerIterator it(links, i); it; ++it) {
      friends += group[static_cast<size_t>(it.col())] == group[static_cast<size_t>(i)] ? 1 : 0;
    }
    EXPECT_GT(friends, 0);
  }
  EXPECT_GT(*std::min_element(size.begin(), size.end()), 2);
}

TEST(AggregationMultigrid, IsSymmetricAndPositive) {
  // <C r, s> = <r, C s> and <r, C r> > 0 for smooth r; single precision.
  const TriangleMesh mesh = crooked_sheet(40);
  const int n = static_cast<int>(mesh.rest.cols());
  for (const SimdLevel level : {SimdLevel::kSse2, simd_level()}) {
    AggregationMultigrid coarse(block_kernels(level));
    coarse.prepare(laplacian_of(mesh));
    ASSERT_GE(coarse.sizes().size(), 2U);
    ASSERT_TRUE(coarse.refresh(sums(n)));
    PaddedNodes cr(4, n), cs(4, n);
    for (unsigned seed = 1; seed < 5; ++seed) {
      const PaddedNodes r = padded_noise(n, seed), s = padded_noise(n, seed + 50);
      coarse.correct(r, &cr);
      coarse.correct(s, &cs);
      const double size = std::sqrt(dot(cr, r) * dot(cs, s));
      EXPECT_NEAR(dot(cr, s), dot(r, cs), 1e-5 * size);
      EXPECT_GT(dot(cr, r), 0.0);
      EXPECT_EQ(cr.row(3).cwiseAbs().maxCoeff(), 0.0f);
    }
  }
}

TEST(AggregationMultigrid, SolvesExactlyForATranslationWithOneCoarseLevel) {
  // (L + S) 1 = S 1, and coarse diagonals are P^T S 1 with P 1 = 1: the correction of it is 1.
  const TriangleMesh mesh = crooked_sheet(12);
  const int n = static_cast<int>(mesh.rest.cols());
  AggregationMultigrid coarse(block_kernels(simd_level()));
  coarse.prepare(laplacian_of(mesh));
  ASSERT_EQ(coarse.sizes().size(), 1U);
  const AxisValues sum = sums(n);
  ASSERT_TRUE(coarse.refresh(sum));
  PaddedNodes found(4, n);
  coarse.correct(sum, &found);
  EXPECT_LT((found.topRows<3>().array() - 1.0f).abs().maxCoeff(), 1e-5f);
}

TEST(AggregationMultigrid, GivesUpWhereALevelIsNotDefinite) {
  const TriangleMesh mesh = crooked_sheet(12);
  const int n = static_cast<int>(mesh.rest.cols());
  AggregationMultigrid coarse(block_kernels(simd_level()));
  coarse.prepare(laplacian_of(mesh));
  EXPECT_FALSE(coarse.refresh(-sums(n)));
  PaddedNodes found = padded_noise(n, 1);
  coarse.correct(padded_noise(n, 2), &found);
  EXPECT_EQ(found.cwiseAbs().maxCoeff(), 0.0f);
}

/// An implicit step's matrix of a crooked sheet of springs, 1 m wide, 0.2 kg/m^2, E h = 1e3 N/m, crumpled, one corner
/// held, and quadratic bending apart from it.
struct Sheet {
  enum class Shape { kCrumpled, kStretched };
  explicit Sheet(int side, Shape shape = Shape::kCrumpled)
      : mesh(crooked_sheet(side)), body(mesh.rest, sheet_masses(mesh, 0.2)) {
    SheetStiffness stiffness;
    stiffness.membrane = 1e3;
    body.add_springs(sheet_network(mesh, stiffness));
    body.add(
        make_quadratic_links("bending", quadratic_bending_weights(mesh, isotropic_bending(1e-5, 0.3)), kDamping, 0));
    body.build_pattern();
    if (shape == Shape::kCrumpled) {
      body.state.x += noise(side * side, 0.05 / side, 3);
    } else {
      body.state.x *= 1.02;
    }
    blocks = whole = body.pattern;
    for (const Energy* term : body.dynamics.energies) {
      term->add_jacobian(body.state, 1.0, 1.0 / kTau, Jacobian::kProjected, &whole);
      if (term->constant_links() == nullptr) {
        term->add_jacobian(body.state, 1.0, 1.0 / kTau, Jacobian::kProjected, &blocks);
      } else {
        links.push_back(term->constant_links());
      }
    }
    for (BlockMatrix* a : {&blocks, &whole}) {
      for (int i = 0; i < a->rows(); ++i) {
        a->block(a->diagonal_slot(i)).diagonal().array() += body.mass[i] / (kTau * kTau);
      }
      hold_first(a);
    }
    right_side = noise(side * side, 1.0, 7).array().rowwise() * body.mass.transpose().array();
    right_side.col(0).setZero();
    weight = body.mass.cwiseInverse();
    weight[0] = 0.0;
  }
  static void hold_first(BlockMatrix* a) {
    for (int k = a->row_start()[0]; k < a->row_start()[1]; ++k) {
      const int j = a->column()[static_cast<size_t>(k)];
      a->block(k).setZero();
      a->block(a->slot(j, 0)).setZero();
    }
    a->block(a->diagonal_slot(0)).setIdentity();
  }
  LinearReport solve(double tolerance, Nodes* x) const {
    const auto solver = make_multigrid_solver();
    solver->set_links(links, kTau, {0});
    solver->prepare(blocks);
    x->setZero(3, blocks.rows());
    LinearTolerance asked;
    asked.relative = tolerance;
    return solver->solve(blocks, right_side, weight, asked, x);
  }

  static constexpr double kTau = 1.0 / 180.0, kDamping = 0.01;  // s
  TriangleMesh mesh;
  System body;
  BlockMatrix blocks, whole;
  std::vector<const ConstantLinks*> links;
  Nodes right_side;
  Eigen::VectorXd weight;
};

Nodes exact(const BlockMatrix& a, const Sheet& sheet) {
  Nodes x = Nodes::Zero(3, a.rows());
  const auto direct = make_direct_solver();
  direct->prepare(a);
  direct->solve(a, sheet.right_side, sheet.weight, {}, &x);
  return x;
}

TEST(MultigridSolver, SolvesWhatTheSparseFactorisationSolves) {
  // A x = b to four digits of the residual, the most that single precision gives.
  Sheet sheet(14);
  sheet.links.clear();
  Nodes found;
  EXPECT_TRUE(sheet.solve(1e-9, &found).solved);
  const Nodes expected = exact(sheet.blocks, sheet);
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

TEST(MultigridSolver, SeesLinksApartAsIfTheyWereInTheMatrix) {
  // Left out are links of less than a hundredth of the rows' sums: of what the links change, less than a tenth is
  // wrong.
  const Sheet sheet(14);
  Nodes found;
  EXPECT_TRUE(sheet.solve(1e-4, &found).solved);
  const Nodes expected = exact(sheet.whole, sheet), without = exact(sheet.blocks, sheet);
  EXPECT_LT((found - expected).norm(), 0.1 * (without - expected).norm());
}

TEST(MultigridSolver, NeedsFewMoreIterationsOnLargerMeshes) {
  // Of a sheet whose stiffness spreads far in a step; at most a half more for four times the nodes, and twice for
  // sixteen times. With block Jacobi alone the number doubles with each, from 40 on.
  std::vector<int> iterations;
  for (const int side : {16, 32, 64}) {
    Nodes x;
    const LinearReport report = Sheet(side, Sheet::Shape::kStretched).solve(1e-3, &x);
    EXPECT_TRUE(report.solved);
    iterations.push_back(report.iterations);
  }
  EXPECT_LE(iterations[1], 1.5 * iterations[0]);
  EXPECT_LE(iterations[2], 2.0 * iterations[0]);
  EXPECT_LE(iterations[2], 20);
}

TEST(ConstantLinks, OfHingesAreTheJacobianAcrossAFlatSheet) {
  // -df_z/dz - (1 / tau) df_z/dv_z at rest is what quadratic bending has along all axes; by hinges it is 0 in the
  // plane.
  const TriangleMesh mesh = crooked_sheet(7);
  BendingMaterial material = isotropic_bending(1e-3, 0.3);
  material.damping = 0.02;
  const double tau = 0.01;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add(make_bending(mesh, material, 0)).build_pattern();
  const Energy* term = body.dynamics.energies[0];
  BlockMatrix a = body.pattern;
  term->add_jacobian(body.state, 1.0, 1.0 / tau, Jacobian::kProjected, &a);
  const ConstantLinks* links = term->constant_links();
  ASSERT_NE(links, nullptr);
  const double scale = 1.0 + links->damping / tau, largest = scale * links->sum[24];
  for (size_t row = 0; row < links->sum.size(); ++row) {
    const int i = links->node[row];
    EXPECT_NEAR(a.block(a.diagonal_slot(i))(2, 2), scale * links->sum[row], 1e-6 * largest);
    for (int k = links->row_start[row]; k < links->row_start[row + 1]; ++k) {
      const auto at = static_cast<size_t>(k);
      if (links->stiffness[at] == 0.0) continue;
      const int slot = a.slot(i, static_cast<int>(links->place[at] / 4));
      ASSERT_GE(slot, 0);
      EXPECT_NEAR(a.block(slot)(2, 2), -scale * links->stiffness[at], 1e-6 * largest);
    }
  }
}

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

TEST(MultigridSolver, SeesSpringsApartAsIfTheyWereInTheMatrix) {
  // The same matrix to single precision, node 0 held: the same solution to what the tolerance leaves.
  Sheet sheet(14);
  std::vector<const Energy*> terms = sheet.body.dynamics.energies;
  std::vector<SpringElement> springs;
  for (const KnownSpring& s : take_springs(&terms).springs) {
    springs.push_back({s.a, s.b, s.length, s.stiffness, s.damping});
  }
  ASSERT_FALSE(springs.empty());
  Nodes whole, apart = Nodes::Zero(3, sheet.blocks.rows());
  const LinearReport expected = sheet.solve(1e-4, &whole);
  BlockMatrix rest(sheet.blocks.rows(), {});
  for (int i = 1; i < rest.rows(); ++i) {
    rest.block(rest.diagonal_slot(i)).diagonal().setConstant(sheet.body.mass[i] / (Sheet::kTau * Sheet::kTau));
  }
  rest.block(rest.diagonal_slot(0)).setIdentity();
  const auto solver = make_multigrid_solver();
  solver->set_links(sheet.links, Sheet::kTau, {0});
  solver->set_springs(springs);
  solver->place_springs(sheet.body.state.x, 1.0, 1.0 / Sheet::kTau, MultigridSolver::Transverse::kProjected);
  solver->prepare(rest);
  LinearTolerance asked;
  asked.relative = 1e-4;
  const LinearReport report = solver->solve(rest, sheet.right_side, sheet.weight, asked, &apart);
  EXPECT_TRUE(report.solved);
  EXPECT_NEAR(report.iterations, expected.iterations, 2);
  EXPECT_LT((apart - whole).norm(), 2e-3 * whole.norm());
  EXPECT_EQ(apart.col(0), Vec3::Zero());
}

}  // namespace
}  // namespace deformable_sim::test
