// Contact of bodies with each other and with themselves.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/contact/crossing_guard.h"
#include "deformable_sim/core/contact/stick_memory.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// The nodes of a contact, -1 where there is none, and how many are of its first side: what contacts of the same place
/// have in common. Ordered by nodes.
class ContactPlace {
 public:
  ContactPlace() = default;
  ContactPlace(const std::array<int, 4>& node, int first)
      : low_(pack(node[0], node[1])), high_(pack(node[2], node[3])), first_(first) {}
  void pass(Archive* archive) {
    archive->pass(&low_);
    archive->pass(&high_);
    archive->pass(&first_);
  }
  bool operator==(const ContactPlace& o) const { return low_ == o.low_ && high_ == o.high_ && first_ == o.first_; }
  bool operator<(const ContactPlace& o) const {
    if (low_ != o.low_) return low_ < o.low_;
    return high_ != o.high_ ? high_ < o.high_ : first_ < o.first_;
  }

 private:
  static std::uint64_t pack(int a, int b) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a + 1)) << 32 | static_cast<std::uint32_t>(b + 1);
  }
  std::uint64_t low_ = 0, high_ = 0;
  int first_ = 0;
};

/// Vertices against triangles and edges against edges, of every body whose Body::touches asks for it (doc/theory/
/// contact.md, 9). Sheets, skins of soft bodies and ropes (edges alone) keep the sum of their contact radii apart; what
/// a time scheme leaves undone of that is CrossingGuard's.
///
/// Not good at: sheets finer than they are thick, which stay what they are at rest, 0.9 of the distance between their
/// pieces.
class BodyContacts {
 public:
  explicit BodyContacts(const Model* model);

  /// Appends what may touch in the step of dt (s) from `s`, in which the nodes `held` go to `targets` (3 x their
  /// number, m). Order: by nodes, so that the same state gives the same list.
  void find(const State& s, double dt, const std::vector<int>& held, const Nodes& targets,
            ContactConstraints* contacts);
  /// In how many parts a step of dt (s) is best made: contacts have one direction for the whole of a part, so what
  /// touches should not move by more than a quarter of an edge on what it touches, root mean square. From the last
  /// find().
  int parts_for(double dt) const;
  /// By how much more than a fifth of their distance the worst of `contacts` still gave way in the step, m: what the
  /// time scheme left undone.
  static double violation(const Nodes& before, const Nodes& x, const ContactConstraints& contacts);
  /// A new step begins; the step begins anew; bodies were put elsewhere: what is known of where contacts stick.
  void begin_step() { memory_.begin_step(); }
  void restart_step() { memory_.restart(); }
  void forget() {
    memory_.forget();
    pieces_.forget();
    rate_ = 0.0;
  }
  /// A part of the step is accepted: remembers ContactConstraint::stuck of contacts between bodies.
  void keep_stuck(const ContactConstraints& contacts);
  /// After the step: CrossingGuard::keep_apart().
  double keep_apart(const Nodes& before, const Eigen::VectorXd& inverse_mass, double dt, State* s) {
    return guard_.keep_apart(before, inverse_mass, dt, s);
  }
  /// CrossingGuard::find_crossing().
  std::string find_crossing(const Nodes& x) { return guard_.find_crossing(x); }
  /// Saved states. What is known of which pieces are near is forgotten, in the world that is saved as well.
  void pass(Archive* archive);
  int piece_count() const { return pieces_.piece_count(); }

 private:
  /// What may touch: nodes of non-zero weight alone, the first side's before the second's.
  struct Touch {
    std::array<int, 4> node;
    std::array<double, 4> weight;
    int count;
    Vec3 normal;      // towards the first side
    double distance;  // m, at the start of the step
    int body_a, body_b;
  };

  struct Ordered {
    ContactPlace place;
    int touch;
    bool operator<(const Ordered& o) const { return place < o.place || (place == o.place && touch < o.touch); }
  };

  void foresee(const State& s, double dt, const std::vector<int>& held, const Nodes& targets);
  void add_touch(const Meeting& meeting, const Nodes& x);
  double ahead(const Meeting& meeting, const ClosestPoints& now, double distance) const;
  static void sort_sides(Touch* touch);
  void add_constraint(const Touch& touch, const ContactPlace& place, double dt, ContactConstraints* contacts);
  double rest_distance(const Touch& touch) const;

  const Model* model_;
  Nodes rest_;
  SurfacePieces pieces_;
  CrossingGuard guard_;
  std::vector<double> size_;  // m, by body: mean edge
  double rate_ = 0.0;         // 1/s, edges that what touches moves, root mean square
  Nodes foreseen_;            // m, at the end of the step
  double margin_ = 0.0;       // m, of what may touch
  std::vector<Touch> touches_;
  std::vector<Ordered> order_;
  StickMemoryBy<ContactPlace> memory_;  // in world axes
};

}  // namespace deformable_sim
