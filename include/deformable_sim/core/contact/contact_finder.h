// Finds the contacts of one step: which material points may meet which collider surfaces, as planes.
#pragma once

#include <cstdint>
#include <vector>

#include "deformable_sim/core/contact/collider_set.h"
#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/contact/contact_points.h"
#include "deformable_sim/core/contact/stick.h"
#include "deformable_sim/core/contact/stick_memory.h"
#include "deformable_sim/core/contact/surface_query.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// What a node is to the contacts of a step.
enum class NodeRole : char {
  kFree,
  kHeld,        // its motion is prescribed: no contact
  kBesideHeld,  // next to a held node: none with colliders attached to a frame, one of which is the gripper that fills
                // its place
};

/// Speculative contact planes (doc/theory/contact.md).
///
/// Every point whose surface distance is within its reach, contact radius + relative motion expected in the step, gets
/// the tangent plane at its nearest surface point, carried along with the collider to the end of the step. A point on
/// the outer side of that plane is outside a convex shape, however thin it is and however fast it moves. A mesh that is
/// not convex gives a point one plane for every triangle in reach that no other plane has below it. A point that moves
/// further than expected is told by missed_motion(): the step is repeated with a wider reach.
///
/// Not good at: surfaces poking between the points of a coarse mesh (but convex ones, where the body is
/// contact_anywhere); contact of a body with itself.
class ContactFinder {
 public:
  explicit ContactFinder(const Model* model);

  /// Takes over shapes and friction. A collider that was there before, wherever it is now, is the same one: points
  /// remember on which side of it they were, and where they stuck.
  void set_colliders(const std::vector<Collider>& colliders);
  /// Points were put elsewhere from outside: they forget sides and where they stuck.
  void forget_sides();

  /// A step begins: what is known of sticking now is what it begins with, should it be repeated.
  void begin_step() { memory_.begin_step(); }
  /// The step since begin_step() is made again from its start.
  void restart_step();

  /// Appends planes for the step from `s` to s.time + dt. `roles`, one a node, tells who gets contacts.
  /// `extra_reach` (m) widens the search. Order: by shape, then by point; the same state gives the same list.
  void find(const State& s, double dt, const std::vector<PoseStep>& poses, const std::vector<NodeRole>& roles,
            double extra_reach, ContactConstraints* contacts);

  /// extra_reach with which the step has to be repeated because a node moved further than its reach allowed and came
  /// near a collider (m); 0 when every contact was seen.
  double missed_motion(const Nodes& before, const Nodes& after);

  /// The step, or part of one, that find() was asked for is accepted: remembers where `contacts` stick.
  void keep_stuck(const ContactConstraints& contacts, const std::vector<PoseStep>& poses);

  /// How far the worst point ended behind the surface it was to stay in front of, m: what the time scheme left undone.
  double violation(const Nodes& x, const ContactConstraints& contacts) const;

  /// Deepest contact point inside a surface at the end of the step, m; contact radius not counted.
  double penetration(const Nodes& x, const std::vector<PoseStep>& poses, const ContactConstraints& contacts);

  /// Saved states, with the colliders they were saved with.
  void pass(Archive* archive);

  int shape_count() const { return static_cast<int>(shapes_.size()); }
  int point_count() const { return static_cast<int>(points_.size() + between_.size()); }

 private:
  struct PlacedShape {
    PlacedShape(const Shape& shape, int collider_index, const Collider& owner)
        : query(shape),
          collider_from_shape(shape.collider_from_shape),
          collider(collider_index),
          friction(owner.friction),
          attached(!owner.frame.empty()) {}

    SurfaceQuery query;
    Pose collider_from_shape;
    int collider;
    double friction;
    std::int64_t first_key = 0;
    std::int64_t keys_per_point = 1;         // pieces of a mesh that is not convex, of voxels
    bool attached;                           // to a frame
    std::vector<char> lets_through;          // of each body, whether it is let through; empty: none is
    Pose end_from_begin = Pose::Identity();  // the collider's motion in this step, in world axes
    bool moves = false;
    double travel = 0.0;        // m, upper bound for its surface
    Eigen::AlignedBox3d swept;  // contains it during the whole step; means nothing for a plane
  };
  /// A plane of this or the last step in collider coordinates, to keep points on their side of thin plates.
  struct Plane {
    std::int64_t key = 0;  // shape, point and (concave meshes) triangle, ascending
    int shape = 0;
    Vec3 normal, point;       // collider frame
    double end_offset = 0.0;  // normal . p of the surface at the end of the step, world frame
    double asked_offset =
        0.0;  // the same where the point is asked to be; lower than the surface for one on its way out
  };
  struct Point {
    Vec3 p;
    double reach;  // m, of expected motion, without the contact radius
    bool active;
    bool beside_held;  // none of its nodes is free
  };

  void place_shape(PlacedShape* shape, const PoseStep& pose) const;
  void place_points(const std::vector<ContactPoint>& points, const State& s, const std::vector<NodeRole>& roles,
                    std::vector<Point>* placed) const;
  const std::vector<Point>& stopped(const PlacedShape& shape, const std::vector<ContactPoint>& points,
                                    const std::vector<Point>& placed, std::vector<Point>* kept) const;
  template <bool kConcave>
  void find_on_shape(int shape, const std::vector<ContactPoint>& points, const std::vector<PointBlock>& blocks,
                     const std::vector<Point>& placed, std::int64_t first_key, const PoseStep& pose, double dt,
                     ContactConstraints* contacts);
  void add_plane(int shape, const ContactPoint& point, const Vec3& p, SurfacePoint surface, std::int64_t key,
                 const PoseStep& pose, double dt, ContactConstraints* contacts);
  void add_planes_of_mesh(int shape, const ContactPoint& point, const Vec3& p, double reach, SurfacePoint surface,
                          std::int64_t first_key, const PoseStep& pose, double dt, ContactConstraints* contacts);
  /// The plane of an edge or face where it comes nearest to a convex shape. reach: of its middle, m.
  void add_deepest_place(int shape, const ContactPoint& point, double reach, std::int64_t key, const PoseStep& pose,
                         double dt, ContactConstraints* contacts);
  void keep_side(std::int64_t key, const Vec3& p, const Pose& world_from_collider, SurfacePoint* surface);
  static bool take_back_to(const Plane& last, const Vec3& p, const Pose& world_from_collider, SurfacePoint* surface);
  bool planes_of_nodes(const ContactPoint& point, const ContactConstraints& contacts, const Plane* planes[3]) const;
  bool implied_anywhere(const ContactPoint& point, const ContactConstraints& contacts) const;
  bool implied_by_nodes(const ContactPoint& point, const ContactConstraints& contacts) const;

  const Model* model_;
  const Nodes* positions_ = nullptr;            // of find(), while it runs
  std::vector<ContactPoint> points_, between_;  // nodes; edge middles and face centroids
  std::vector<PointBlock> blocks_, between_blocks_;
  std::vector<PlacedShape> shapes_;
  std::vector<Collider> known_;  // whose shapes these are
  std::int64_t next_key_ = 0;    // of a shape that is added; keys are never given twice
  std::vector<Point> placed_, placed_between_;
  std::vector<Point> stopped_, stopped_between_;  // of shapes that let some bodies through
  std::vector<double> node_reach_;
  std::vector<int> contact_of_node_;  // index of the node's plane on the shape at hand, or -1
  std::vector<Plane> planes_, last_planes_;
  size_t last_plane_ = 0;  // how far last_planes_ has been searched in this step
  StickMemory memory_;     // by key of planes, in collider coordinates
};

/// Deepest node, edge middle or face centroid of any body inside a collider, m; 0 when none is inside. For tests and
/// summaries: it looks at every point, not only where contact is enforced.
double measure_penetration(const Model& model, const std::vector<Collider>& colliders, const Nodes& x);

}  // namespace deformable_sim
