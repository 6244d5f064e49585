// Contact of bodies with each other and with themselves.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/box_tree.h"
#include "deformable_sim/core/contact/closest_points.h"
#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/contact/stick_memory.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// Vertices against triangles and edges against edges, of every body whose Body::touches asks for it (doc/theory/
/// contact.md, 9). Sheets, skins of soft bodies and ropes (edges alone) keep the sum of their contact radii apart.
///
/// Nothing crosses, by construction. Two pieces apart at the start of a step have a plane between them, across their
/// shortest connection, of normal n. If some plane of the same normal lies between them at the end, then one that moves
/// evenly lay between them all the while, as their corners moved along straight lines. keep_apart() sees to that for
/// every two pieces that came near enough in the step, whatever the time scheme has made of the contacts.
///
/// Not good at: pieces that cross at the start (they are not seen until they have come apart); sheets finer than they
/// are thick, which stay what they are at rest, 0.9 of the distance between their pieces; long steps of fast rotation,
/// in which a plane stands in the way that turned with nobody.
class BodyContacts {
 public:
  explicit BodyContacts(const Model* model);

  /// Appends what may touch in the step of dt (s) from `s`, in which the nodes `held` go to `targets` (3 x their
  /// number, m). Order: by nodes, so that the same state gives the same list.
  void find(const State& s, double dt, const std::vector<int>& held, const Nodes& targets,
            ContactConstraints* contacts);
  /// By how much more than a fifth of their distance the worst of `contacts` still gave way in the step, m: what the
  /// time scheme left undone.
  static double violation(const Nodes& before, const Nodes& x, const ContactConstraints& contacts);
  /// A new step begins; the step begins anew; bodies were put elsewhere: what is known of where contacts stick.
  void begin_step() { memory_.begin_step(); }
  void restart_step() { memory_.restart(); }
  void forget() { memory_.forget(); }
  /// A part of the step is accepted: remembers ContactConstraint::stuck of contacts between bodies.
  void keep_stuck(const ContactConstraints& contacts);
  /// After the step: moves nodes, by inverse mass, until every two pieces are on their own sides; their
  /// velocities become those of the ways they made. Returns by how much the worst pair fails to be, m; 0 when all are.
  double keep_apart(const Nodes& before, const Eigen::VectorXd& inverse_mass, double dt, State* s);

  /// Names the bodies of an edge and a triangle that cross at x, and where; empty when none do.
  std::string find_crossing(const Nodes& x);
  int piece_count() const { return tree_.piece_count(); }

 private:
  /// A triangle or a segment, with the corners and edges that it answers for: each is one piece's only.
  struct Piece {
    std::array<int, 3> node{{-1, -1, -1}};  // world node indices
    int count = 3;
    int body = 0;
    unsigned own_nodes = 0, own_edges = 0;  // bit k: node k, edge k to k + 1
    double reach = 0.0;                     // m, of its corners, with the radius
  };
  /// Two pieces' parts: one node and three, or two and two.
  struct Pair {
    std::array<int, 4> node;
    int first;  // how many are of the first part
    Vec3 normal;
    double least;  // m that they have to be apart along it at the end
  };
  /// What may touch: nodes of non-zero weight alone, the first side's before the second's.
  struct Touch {
    std::array<int, 4> node;
    std::array<double, 4> weight;
    int count;
    Vec3 apart;
    int body_a, body_b;
  };
  struct Extent {
    double reach;  // m
    Vec3 motion;   // m, foreseen in the step
  };

  void add_pieces(int body);
  void foresee(const State& s, double dt, const std::vector<int>& held, const Nodes& targets);
  void fit_boxes(const Nodes& x);
  void find_pairs(const Nodes& x, std::vector<Touch>* touches);
  void test(const Piece& p, const Piece& q, const Nodes& x, std::vector<Touch>* touches);
  void test_nodes(const Piece& p, const Piece& triangle, const Nodes& x, std::vector<Touch>* touches);
  void test_edges(const Piece& p, const Piece& q, const Nodes& x, std::vector<Touch>* touches);
  void keep(const std::array<int, 4>& node, int first, const ClosestPoints& found, const Piece& p, const Piece& q,
            std::vector<Touch>* touches);
  double foreseen_way(const std::array<int, 4>& node, int first) const;
  void add_constraint(const Touch& touch, double dt, ContactConstraints* contacts);
  double rest_distance(const Touch& touch) const;
  bool widen(const Nodes& before, const Nodes& x);
  double separate(const Pair& pair, const Eigen::VectorXd& inverse_mass, Nodes* x);
  double radius_of(int body) const { return model_->bodies[static_cast<size_t>(body)].contact_radius; }

  const Model* model_;
  Nodes rest_;
  std::vector<Piece> pieces_;
  std::vector<char> on_surface_;  // by node
  BoxTree tree_;
  std::vector<Extent> extent_;  // by node
  Vec3 common_ = Vec3::Zero();  // m, mean of the motions
  double margin_ = 0.0;         // m, of what may touch
  std::vector<Pair> pairs_;
  std::vector<Touch> touches_;
  using Place = std::array<int, 5>;  // nodes, and how many are of the first side
  StickMemoryBy<Place> memory_;      // in world axes
  std::vector<char> moved_;          // by keep_apart(), by node
};

}  // namespace deformable_sim
