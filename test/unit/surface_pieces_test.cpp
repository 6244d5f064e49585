// Which parts of surfaces may meet in a step: none that does is left out.
#include "deformable_sim/core/contact/surface_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

class Random {
 public:
  int lane() { return static_cast<int>(engine_() % 401) - 200; }
  Vec3 vector() { return Vec3(normal_(engine_), normal_(engine_), normal_(engine_)); }

 private:
  std::mt19937 engine_{11};
  std::normal_distribution<double> normal_;
};

Slabs random_slabs(Random* random, int size) {
  Slabs s;
  for (int d = 0; d < 8; ++d) {
    s.low_start[d] = static_cast<std::int16_t>(random->lane());
    s.low_end[d] = static_cast<std::int16_t>(random->lane());
    s.high_start[d] = static_cast<std::int16_t>(s.low_start[d] + size);
    s.high_end[d] = static_cast<std::int16_t>(s.low_end[d] + size);
  }
  return s;
}

/// apart(), lane by lane.
bool apart_plainly(const Slabs& a, const Slabs& b, int start, int end) {
  for (int d = 0; d < 8; ++d) {
    if (a.low_start[d] - b.high_start[d] > start && a.low_end[d] - b.high_end[d] > end) return true;
    if (b.low_start[d] - a.high_start[d] > start && b.low_end[d] - a.high_end[d] > end) return true;
  }
  return false;
}

TEST(Slabs, AreApartWhereOneLaneIsAtBothEndsOnOneSide) {
  Random random;
  int found = 0;
  for (int k = 0; k < 5000; ++k) {
    const Slabs a = random_slabs(&random, 80 + k % 100), b = random_slabs(&random, 80);
    const int start = k % 70, end = k % 110;
    const bool expected = apart_plainly(a, b, start, end);
    EXPECT_EQ(apart(a, b, {all_lanes(start), all_lanes(end)}), expected);
    EXPECT_EQ(apart(b, a, {all_lanes(start), all_lanes(end)}), expected);
    found += expected ? 1 : 0;
  }
  EXPECT_GT(found, 500);
  EXPECT_LT(found, 4500);
}

TEST(PieceTree, VisitsEveryTwoPiecesThatAreNotApartOnce) {
  Random random;
  for (const int count : {1, 2, 7, 150}) {
    std::vector<Vec3> centers(static_cast<size_t>(count));
    for (Vec3& c : centers) c = random.vector();
    PieceTree tree(centers);
    std::vector<Slabs> slabs;
    for (int i = 0; i < count; ++i) {
      slabs.push_back(random_slabs(&random, 120));
      tree.slabs_of(i) = slabs.back();
    }
    tree.refit();
    std::set<std::pair<int, int>> found;
    tree.for_each_pair({all_lanes(20), all_lanes(50)}, [&](int i, int j) {
      EXPECT_TRUE(found.insert({std::min(i, j), std::max(i, j)}).second) << i << " " << j;
    });
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < i; ++j) {
        const bool meet = !apart_plainly(slabs[static_cast<size_t>(i)], slabs[static_cast<size_t>(j)], 20, 50);
        EXPECT_EQ(found.count({j, i}) == 1, meet) << i << " " << j;
      }
    }
  }
}

/// A sheet of 5 x 5 cells and a rope of ten segments, at random, which all touch.
std::shared_ptr<Model> tangle(Random* random) {
  const auto mesh = std::make_shared<const TriangleMesh>(make_grid(0.5, 0.5, 5, 5));
  Nodes x(3, 47);
  for (int k = 0; k < 47; ++k) x.col(k) = 0.2 * random->vector();
  auto model = test::points_model(x, 0.01, Vec3::Zero());
  Body body = model->bodies[0];
  model->bodies.clear();
  body.node_count = 36;
  body.surface = mesh;
  body.contact_radius = 0.004;
  body.touches = BodyContact::kAll;
  model->bodies.push_back(body);
  body.first_node = 36;
  body.node_count = 11;
  body.surface = nullptr;
  Polyline line;
  line.rest = x.rightCols<11>();
  body.line = std::make_shared<const Polyline>(line);
  body.contact_radius = 0.01;
  model->bodies.push_back(body);
  return model;
}

TEST(SurfacePieces, LeaveOutNobodyWhoComesWithinReachAtAnyTimeOfTheStep) {
  // Places far from the origin, steps of a few millimetres and of a metre: all vertices and triangles, all edges.
  for (const double way : {0.0, 0.01, 1.0}) {
    Random random;
    const auto model = tangle(&random);
    SurfacePieces pieces(model.get());
    Nodes start = model->initial.x, end = start;
    start.colwise() += Vec3(30, -20, 10);
    for (int k = 0; k < end.cols(); ++k) end.col(k) = start.col(k) + way * random.vector();
    std::set<std::pair<int, std::array<int, 4>>> found;
    const auto key = [](std::array<int, 4> node, int first) {
      std::sort(node.begin(), node.begin() + first);
      std::sort(node.begin() + first, node.end());
      if (first == 2 && node[2] < node[0]) std::swap_ranges(node.begin(), node.begin() + 2, node.begin() + 2);
      return std::pair(first, node);
    };
    const SurfacePieces::Reach near{1.0, 0.003};
    std::set<std::pair<int, std::array<int, 4>>> all;
    pieces.for_each_meeting({start, end, {1.0, 1e3}, {1.0, 1e3}},
                            [&](const Meeting& m) { EXPECT_TRUE(all.insert(key(m.node, m.first)).second); });
    pieces.for_each_meeting({start, end, near, near}, [&](const Meeting& m) { found.insert(key(m.node, m.first)); });
    int near_ones = 0, left_out = 0;
    pieces.for_each_meeting({start, end, {1.0, 1e3}, {1.0, 1e3}}, [&](const Meeting& m) {
      const double reach = pieces.radius_of(m.a->body) + pieces.radius_of(m.b->body) + 0.003;
      bool comes_near = false;
      for (int k = 0; k <= 20; ++k) {
        const Nodes x = start + 0.05 * k * (end - start);
        comes_near = comes_near || closest_points(m, x).apart.norm() < reach;
      }
      near_ones += comes_near ? 1 : 0;
      const bool has = found.count(key(m.node, m.first)) == 1;
      if (comes_near) EXPECT_TRUE(has) << m.node[0] << " " << m.node[1] << " " << m.node[2] << " " << m.node[3];
      left_out += has ? 0 : 1;
    });
    EXPECT_GT(near_ones, 50);
    EXPECT_GT(left_out, 1000);
    // 33 other vertices of the sheet and 11 of the rope at each of 50 triangles; two of 85 + 10 edges.
    auto edges = edges_of(*model->bodies[0].surface);
    for (int k = 0; k < 10; ++k) edges.push_back({{36 + k, 37 + k}});
    size_t expected = 50 * 44;
    for (size_t i = 0; i < edges.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        const auto &a = edges[i], &b = edges[j];
        expected += a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1] ? 1 : 0;
      }
    }
    EXPECT_EQ(all.size(), expected);
  }
}

}  // namespace
}  // namespace deformable_sim
