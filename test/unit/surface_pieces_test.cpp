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

TEST(SurfacePieces, RememberWhatIsNearWithoutMissingAnybody) {
  // A sheet of 6 x 6 cells of 0.1 m, rolled up and shaken for 60 steps, slowly and fast: what is left out because of
  // what earlier steps have found never comes within reach at any time of its step.
  Random random;
  const auto mesh = std::make_shared<const TriangleMesh>(make_grid(0.6, 0.6, 6, 6));
  auto model = test::points_model(mesh->rest, 0.01, Vec3::Zero());
  Body& body = model->bodies[0];
  body.surface = mesh;
  body.contact_radius = 0.01;
  body.touches = BodyContact::kAll;
  SurfacePieces kept(model.get());
  Nodes x = mesh->rest;
  int tested = 0, all = 0, close = 0;
  for (int k = 0; k < 60; ++k) {
    const double turns = 0.1 * k;  // of the roll, per m
    Nodes end(3, x.cols());
    for (int i = 0; i < x.cols(); ++i) {
      const double s = mesh->rest(0, i), angle = 2.0 * turns * s, radius = turns > 0.0 ? 0.5 / turns : 0.0;
      end.col(i) = turns > 0.0
                       ? Vec3(radius * std::sin(angle), mesh->rest(1, i) + 0.1 * s, radius * (1.0 - std::cos(angle)))
                       : Vec3(mesh->rest.col(i));
      if (k % 7 == 3) end.col(i) += 0.03 * random.vector();
    }
    if (k % 3 == 1) end = x + 0.0005 * Nodes::Random(3, x.cols());
    const SurfacePieces::Reach near{1.0, 0.002};
    std::set<std::pair<int, std::array<int, 4>>> found;
    kept.for_each_meeting({x, end, near, near}, [&](const Meeting& m) { found.insert({m.first, m.node}); });
    SurfacePieces fresh(model.get());
    fresh.for_each_meeting({x, end, {1.0, 1e3}, {1.0, 1e3}}, [&](const Meeting& m) {
      ++all;
      if (found.count({m.first, m.node}) == 1) {
        ++tested;
        return;
      }
      for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const double distance = closest_points(m, x + t * (end - x)).apart.norm();
        if (distance < 0.022) ++close;
      }
    });
    // The next, shorter question, as after a step: the same step, less far.
    found.clear();
    kept.for_each_meeting({x, end, {0.0, 0.0}, {0.1, 0.0}}, [&](const Meeting& m) { found.insert({m.first, m.node}); });
    fresh.for_each_meeting({x, end, {1.0, 1e3}, {1.0, 1e3}}, [&](const Meeting& m) {
      if (found.count({m.first, m.node}) == 0 && closest_points(m, end).apart.norm() < 0.002) ++close;
    });
    x = end;
  }
  EXPECT_EQ(close, 0);
  EXPECT_GT(tested, 1000);
  EXPECT_LT(tested, all / 10);
}

TEST(SurfacePieces, SeeWhoComesSlowlyNear) {
  // A sheet folded over itself closes by 0.4 mm a step, or is foreseen to by ever more, or to open: what was near for
  // many steps no longer is all that is.
  const auto mesh = std::make_shared<const TriangleMesh>(make_grid(0.6, 0.6, 6, 6));
  auto model = test::points_model(mesh->rest, 0.01, Vec3::Zero());
  Body& body = model->bodies[0];
  body.surface = mesh;
  body.contact_radius = 0.01;
  body.touches = BodyContact::kAll;
  const auto folded = [&](double height) {
    Nodes x = mesh->rest;
    for (int i = 0; i < x.cols(); ++i) {
      if (x(0, i) > 0.01) x.col(i) = Vec3(-x(0, i) + 0.013, x(1, i) + 0.017, height);
    }
    return x;
  };
  for (const auto& [closes, foreseen] : {std::pair(true, true), std::pair(false, true), std::pair(true, false)}) {
    SurfacePieces kept(model.get());
    size_t last = 0;
    for (int k = 0; k < 100; ++k) {
      const double height = 0.05 - 0.0004 * k;
      const Nodes x = folded(closes ? height : 0.05), end = folded(foreseen ? height : 0.05);
      const auto count = [&](SurfacePieces* pieces) {
        size_t found = 0;
        pieces->for_each_meeting({x, end, {1.0, 0.002}, {1.0, 0.002}}, [&](const Meeting& m) {
          found += std::min(closest_points(m, x).apart.norm(), closest_points(m, end).apart.norm()) < 0.022 ? 1 : 0;
        });
        return found;
      };
      SurfacePieces fresh(model.get());
      last = count(&kept);
      ASSERT_EQ(last, count(&fresh)) << k << " " << closes << foreseen;
    }
    EXPECT_GT(last, 100u);
  }
}

}  // namespace
}  // namespace deformable_sim
