#include "deformable_sim/core/contact/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "deformable_sim/core/contact/deepest_place.h"

namespace deformable_sim {
namespace {

constexpr int kBlockSize = 32;
/// Reach beyond the motion expected from speed and gravity: room for what springs add to the speed in one step.
constexpr double kSlack = 0.002;  // m
constexpr double kSpeedMargin = 1.25;
/// Points found inside a surface leave it no faster than this, so that they come out without being thrown.
constexpr double kExitSpeed = 0.3;  // m/s
/// Points between nodes are left out while they cannot come deeper than this share of the radius behind the nodes'
/// planes.
constexpr double kCoveredShare = 0.9;
/// Deeper than this behind its last plane a point leaves by the nearest surface instead.
constexpr double kKeepSideDepth = 0.02;  // m

Vec3 motion_at(const Pose& end_from_begin, const Vec3& p) {
  return end_from_begin * p - p;
}

}  // namespace

ContactFinder::ContactFinder(const Model* model) : model_(model) {
  for (int b = 0; b < static_cast<int>(model->bodies.size()); ++b) {
    add_node_points(*model, b, &points_);
    if (model->bodies[static_cast<size_t>(b)].contact_at_faces) add_between_points(*model, b, &between_);
  }
  blocks_ = sort_into_blocks(model->initial.x, kBlockSize, &points_);
  between_blocks_ = sort_into_blocks(model->initial.x, kBlockSize, &between_);
  placed_.resize(points_.size());
  placed_between_.resize(between_.size());
  node_reach_.resize(static_cast<size_t>(model->node_count()));
  contact_of_node_.assign(static_cast<size_t>(model->node_count()), -1);
}

void ContactFinder::set_colliders(const std::vector<Collider>& colliders) {
  std::vector<PlacedShape> before;
  std::swap(before, shapes_);
  std::int64_t last_key = -1;
  bool ascending = true;
  for (int c = 0; c < static_cast<int>(colliders.size()); ++c) {
    const Collider& collider = colliders[static_cast<size_t>(c)];
    std::vector<char> through;
    if (!collider.lets_through.empty())
      for (const Body& body : model_->bodies) through.push_back(lets_through(collider, body.name) ? 1 : 0);
    const auto known = std::find_if(known_.begin(), known_.end(),
                                    [&collider](const Collider& other) { return same_but_for_pose(collider, other); });
    const int old_index = known == known_.end() ? -1 : static_cast<int>(known - known_.begin());
    auto old = std::find_if(before.begin(), before.end(),
                            [old_index](const PlacedShape& shape) { return shape.collider == old_index; });
    for (const Shape& s : collider.shapes) {
      if (old_index >= 0) {
        shapes_.push_back(std::move(*old++));
        shapes_.back().collider = c;
      } else {
        shapes_.emplace_back(s, c, collider);
        PlacedShape& added = shapes_.back();
        added.keys_per_point = std::max(1, added.query.concave_pieces());
        added.first_key = next_key_;
        next_key_ += added.keys_per_point * point_count();
      }
      shapes_.back().lets_through = through;
      ascending = ascending && shapes_.back().first_key > last_key;
      last_key = shapes_.back().first_key;
    }
  }
  known_ = colliders;
  if (ascending) return;
  // Another order of the same colliders: what is remembered by keys is of no use.
  forget_sides();
  next_key_ = 0;
  for (PlacedShape& shape : shapes_) {
    shape.first_key = next_key_;
    next_key_ += shape.keys_per_point * point_count();
  }
}

void ContactFinder::forget_sides() {
  planes_.clear();
  memory_.forget();
}

void ContactFinder::restart_step() {
  planes_.clear();
  memory_.restart();
}

void ContactFinder::place_shape(PlacedShape* shape, const PoseStep& pose) const {
  shape->query.place(pose.begin * shape->collider_from_shape);
  shape->end_from_begin = pose.end * pose.begin.inverse();
  shape->moves = !(pose.end.matrix() == pose.begin.matrix());
  shape->travel = 0.0;
  shape->swept = shape->query.box();
  if (!shape->moves || !shape->query.bounded()) return;
  shape->travel = FrameMotion::travel(pose.begin * shape->collider_from_shape, pose.end * shape->collider_from_shape,
                                      shape->query.bounding_radius());
  shape->swept = Eigen::AlignedBox3d(shape->query.box().min() - Vec3::Constant(shape->travel),
                                     shape->query.box().max() + Vec3::Constant(shape->travel));
}

void ContactFinder::place_points(const std::vector<ContactPoint>& points, const State& s,
                                 const std::vector<NodeRole>& roles, std::vector<Point>* placed) const {
  for (size_t i = 0; i < points.size(); ++i) {
    const ContactPoint& point = points[i];
    Point& out = (*placed)[i];
    out.p = position(point, s.x);
    out.reach = 0.0;
    out.active = false;
    out.beside_held = true;
    for (int k = 0; k < point.count; ++k) {
      const auto node = static_cast<size_t>(point.node[static_cast<size_t>(k)]);
      out.reach = std::max(out.reach, node_reach_[node]);
      out.active = out.active || roles[node] != NodeRole::kHeld;
      out.beside_held = out.beside_held && roles[node] != NodeRole::kFree;
    }
    if (point.count > 1 && model_->bodies[static_cast<size_t>(point.body)].contact_anywhere)
      out.reach += extent_of(point, out.p, s.x);
  }
}

/// `placed`, or a copy in which the points of bodies that the shape lets through are not active.
const std::vector<ContactFinder::Point>& ContactFinder::stopped(const PlacedShape& shape,
                                                                const std::vector<ContactPoint>& points,
                                                                const std::vector<Point>& placed,
                                                                std::vector<Point>* kept) const {
  if (shape.lets_through.empty()) return placed;
  *kept = placed;
  for (size_t i = 0; i < points.size(); ++i)
    if (shape.lets_through[static_cast<size_t>(points[i].body)] != 0) (*kept)[i].active = false;
  return *kept;
}

void ContactFinder::find(const State& s, double dt, const std::vector<PoseStep>& poses,
                         const std::vector<NodeRole>& roles, double extra_reach, ContactConstraints* contacts) {
  std::swap(planes_, last_planes_);
  planes_.clear();
  last_plane_ = 0;
  memory_.rewind();

  const double common = model_->gravity.norm() * dt * dt + kSlack + extra_reach;
  for (size_t i = 0; i < node_reach_.size(); ++i)
    node_reach_[i] = kSpeedMargin * s.v.col(static_cast<Eigen::Index>(i)).norm() * dt + common;
  positions_ = &s.x;
  place_points(points_, s, roles, &placed_);
  place_points(between_, s, roles, &placed_between_);

  for (int k = 0; k < shape_count(); ++k) {
    PlacedShape& shape = shapes_[static_cast<size_t>(k)];
    const PoseStep& pose = poses[static_cast<size_t>(shape.collider)];
    place_shape(&shape, pose);
    const std::vector<Point>& placed = stopped(shape, points_, placed_, &stopped_);
    const std::vector<Point>& placed_between = stopped(shape, between_, placed_between_, &stopped_between_);
    const size_t first_contact = contacts->size();
    const std::int64_t between_key = shape.first_key + shape.keys_per_point * static_cast<std::int64_t>(points_.size());
    if (shape.keys_per_point > 1) {
      find_on_shape<true>(k, points_, blocks_, placed, shape.first_key, pose, dt, contacts);
      find_on_shape<true>(k, between_, between_blocks_, placed_between, between_key, pose, dt, contacts);
      continue;
    }
    find_on_shape<false>(k, points_, blocks_, placed, shape.first_key, pose, dt, contacts);
    if (between_.empty()) continue;
    for (size_t c = first_contact; c < contacts->size(); ++c)
      contact_of_node_[static_cast<size_t>((*contacts)[c].node[0])] = static_cast<int>(c);
    const size_t node_contacts = contacts->size();
    find_on_shape<false>(k, between_, between_blocks_, placed_between, between_key, pose, dt, contacts);
    for (size_t c = first_contact; c < node_contacts; ++c)
      contact_of_node_[static_cast<size_t>((*contacts)[c].node[0])] = -1;
  }
}

template <bool kConcave>
void ContactFinder::find_on_shape(int k, const std::vector<ContactPoint>& points, const std::vector<PointBlock>& blocks,
                                  const std::vector<Point>& placed, std::int64_t first_key, const PoseStep& pose,
                                  double dt, ContactConstraints* contacts) {
  PlacedShape& shape = shapes_[static_cast<size_t>(k)];
  const bool bounded = shape.query.bounded();
  const Eigen::AlignedBox3d& box = shape.query.box();
  for (const PointBlock& block : blocks) {
    if (bounded) {
      Eigen::AlignedBox3d block_box;
      double reach = 0.0;
      for (int i = block.first; i < block.last; ++i) {
        const auto index = static_cast<size_t>(i);
        block_box.extend(placed[index].p);
        reach = std::max(reach,
                         placed[index].reach + model_->bodies[static_cast<size_t>(points[index].body)].contact_radius);
      }
      reach += shape.travel;
      if (box.squaredExteriorDistance(block_box) > reach * reach) continue;
    }
    for (int i = block.first; i < block.last; ++i) {
      const auto index = static_cast<size_t>(i);
      const Point& at = placed[index];
      if (!at.active || (shape.attached && at.beside_held)) continue;
      const ContactPoint& point = points[index];
      double reach = at.reach + model_->bodies[static_cast<size_t>(point.body)].contact_radius;
      if (shape.moves) reach += motion_at(shape.end_from_begin, at.p).norm();
      if (bounded && box.squaredExteriorDistance(at.p) > reach * reach) continue;
      if (!kConcave && point.count > 1) {
        if (model_->bodies[static_cast<size_t>(point.body)].contact_anywhere) {
          add_deepest_place(k, point, reach, first_key + i, pose, dt, contacts);
          continue;
        }
        if (implied_by_nodes(point, *contacts)) continue;
      }
      SurfacePoint surface;
      if (!shape.query.find(at.p, reach, &surface)) continue;
      if constexpr (kConcave) {
        add_planes_of_mesh(k, point, at.p, reach, surface, first_key + i * shape.keys_per_point, pose, dt, contacts);
      } else {
        keep_side(first_key + i, at.p, pose.begin, &surface);
        add_plane(k, point, at.p, surface, first_key + i, pose, dt, contacts);
      }
    }
  }
}

void ContactFinder::add_plane(int k, const ContactPoint& point, const Vec3& p, SurfacePoint surface, std::int64_t key,
                              const PoseStep& pose, double dt, ContactConstraints* contacts) {
  const PlacedShape& shape = shapes_[static_cast<size_t>(k)];
  const Body& body = model_->bodies[static_cast<size_t>(point.body)];
  const Vec3 begin = p - surface.distance * surface.normal;
  Vec3 end = begin;
  ContactConstraint c;
  c.normal = surface.normal;
  if (shape.moves) {
    end = shape.end_from_begin * begin;
    c.normal = shape.end_from_begin.linear() * surface.normal;
    // Not that of the surface point: where a collider turns, what lies on it half a thickness away turns with it.
    c.surface_velocity = motion_at(shape.end_from_begin, p) / dt;
  }
  const double gap = surface.distance - body.contact_radius;
  const double surface_offset = c.normal.dot(end);
  c.offset = surface_offset + body.contact_radius + std::min(0.0, gap + kExitSpeed * dt);
  c.count = point.count;
  for (size_t j = 0; j < static_cast<size_t>(point.count); ++j) {
    c.node[j] = point.node[j];
    c.weight[j] = 1.0 / point.count;
  }
  c.friction = std::sqrt(body.friction * shape.friction);
  c.collider = shape.collider;
  const Vec3 stuck = pose.end.linear() * memory_.recall(key);
  c.stuck = stuck - c.normal.dot(stuck) * c.normal;
  contacts->push_back(c);

  const Mat3 collider_from_world = pose.begin.linear().transpose();
  planes_.push_back({key, k, collider_from_world * surface.normal,
                     collider_from_world * (begin - pose.begin.translation()), surface_offset,
                     c.offset - body.contact_radius});
}

void ContactFinder::add_deepest_place(int k, const ContactPoint& point, double reach, std::int64_t key,
                                      const PoseStep& pose, double dt, ContactConstraints* contacts) {
  if (implied_anywhere(point, *contacts)) return;
  Place place;
  if (!find_deepest_place(point, *positions_, reach, &shapes_[static_cast<size_t>(k)].query, &place)) return;
  keep_side(key, place.p, pose.begin, &place.surface);
  add_plane(k, point, place.p, place.surface, key, pose, dt, contacts);
  for (size_t j = 0; j < static_cast<size_t>(point.count); ++j) contacts->back().weight[j] = place.weight[j];
}

void ContactFinder::add_planes_of_mesh(int k, const ContactPoint& point, const Vec3& p, double reach,
                                       SurfacePoint surface, std::int64_t first_key, const PoseStep& pose, double dt,
                                       ContactConstraints* contacts) {
  PlacedShape& shape = shapes_[static_cast<size_t>(k)];
  while (last_plane_ < last_planes_.size() && last_planes_[last_plane_].key < first_key) ++last_plane_;
  for (size_t i = last_plane_; i < last_planes_.size() && last_planes_[i].key < first_key + shape.keys_per_point; ++i)
    if (take_back_to(last_planes_[i], p, pose.begin, &surface)) break;
  const double clearance = model_->bodies[static_cast<size_t>(point.body)].contact_radius;
  for (const SurfacePlane& plane : shape.query.planes(p, surface, reach, clearance))
    add_plane(k, point, p, plane.surface, first_key + plane.triangle, pose, dt, contacts);
}

void ContactFinder::keep_side(std::int64_t key, const Vec3& p, const Pose& world_from_collider, SurfacePoint* surface) {
  // Both lists ascend, so the place in the last one only moves on.
  while (last_plane_ < last_planes_.size() && last_planes_[last_plane_].key < key) ++last_plane_;
  if (last_plane_ == last_planes_.size() || last_planes_[last_plane_].key != key) return;
  take_back_to(last_planes_[last_plane_], p, world_from_collider, surface);
}

bool ContactFinder::take_back_to(const Plane& last, const Vec3& p, const Pose& world_from_collider,
                                 SurfacePoint* surface) {
  const Vec3 normal = world_from_collider.linear() * last.normal;
  // Normals more than a right angle apart: a straight way between the two sides leads through the shape, so a point
  // behind its last plane was pushed in, or even all the way through a thin one.
  if (normal.dot(surface->normal) >= 0.0) return false;
  const double distance = normal.dot(p - world_from_collider * last.point);
  if (distance > 0.0 || distance < -kKeepSideDepth) return false;
  surface->distance = distance;
  surface->normal = normal;
  return true;
}

bool ContactFinder::planes_of_nodes(const ContactPoint& point, const ContactConstraints& contacts,
                                    const Plane* planes[3]) const {
  const double radius = model_->bodies[static_cast<size_t>(point.body)].contact_radius;
  for (int k = 0; k < point.count; ++k) {
    const int index = contact_of_node_[static_cast<size_t>(point.node[static_cast<size_t>(k)])];
    if (index < 0) return false;
    const auto i = static_cast<size_t>(index);
    // A node that is still on its way out does not hold its neighbourhood off the surface.
    if (contacts[i].offset < planes_[i].end_offset + radius - 1e-12) return false;
    planes[k] = &planes_[i];
  }
  return true;
}

bool ContactFinder::implied_anywhere(const ContactPoint& point, const ContactConstraints& contacts) const {
  const Plane* planes[3] = {nullptr, nullptr, nullptr};
  if (!planes_of_nodes(point, contacts, planes)) return false;
  // As below, of the corner that may sink deepest below one of the planes: no mean of the nodes sinks deeper.
  double depth = std::numeric_limits<double>::infinity();
  for (int k = 0; k < point.count; ++k) {
    double deepest = 0.0;
    for (int j = 0; j < point.count; ++j) {
      const double reach = node_reach_[static_cast<size_t>(point.node[static_cast<size_t>(j)])];
      deepest = std::max(deepest, planes[k]->normal.dot(planes[k]->point - planes[j]->point) +
                                      (planes[k]->normal - planes[j]->normal).norm() * reach);
    }
    depth = std::min(depth, deepest);
  }
  return depth <= kCoveredShare * model_->bodies[static_cast<size_t>(point.body)].contact_radius + 1e-12;
}

bool ContactFinder::implied_by_nodes(const ContactPoint& point, const ContactConstraints& contacts) const {
  const Plane* planes[3] = {nullptr, nullptr, nullptr};
  if (!planes_of_nodes(point, contacts, planes)) return false;
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < point.count; ++k) mean += planes[k]->point / point.count;
  const double radius = model_->bodies[static_cast<size_t>(point.body)].contact_radius;
  // The mean p of the nodes at the end of the step lies above plane k, n_k . p >= n_k . q_k, by all but
  // n_k . (q_k - mean q) and what the other nodes may sink below plane k while they slide along their own. The shape is
  // wholly below every one of the planes.
  double depth = std::numeric_limits<double>::infinity();
  for (int k = 0; k < point.count; ++k) {
    double below = planes[k]->normal.dot(planes[k]->point - mean);
    for (int j = 0; j < point.count; ++j) {
      const double reach = node_reach_[static_cast<size_t>(point.node[static_cast<size_t>(j)])];
      below += (planes[k]->normal - planes[j]->normal).norm() * reach / point.count;
    }
    depth = std::min(depth, below);
  }
  return depth <= kCoveredShare * radius + 1e-12;
}

double ContactFinder::missed_motion(const Nodes& before, const Nodes& after) {
  double missed = 0.0;
  for (size_t i = 0; i < points_.size(); ++i) {
    // A held node meets nothing itself, but the points between it and its neighbours do.
    if (!placed_[i].active && between_.empty()) continue;
    const int node = points_[i].node[0];
    const Vec3 end = after.col(node);
    const double moved = (end - before.col(node)).norm();
    const double excess = moved - node_reach_[static_cast<size_t>(node)];
    if (excess <= missed) continue;
    const double near = model_->bodies[static_cast<size_t>(points_[i].body)].contact_radius + moved;
    SurfacePoint surface;
    for (PlacedShape& shape : shapes_) {
      if (!shape.lets_through.empty() && shape.lets_through[static_cast<size_t>(points_[i].body)] != 0) continue;
      if (shape.query.bounded() ? shape.swept.squaredExteriorDistance(end) < near * near
                                : shape.query.find(end, near + motion_at(shape.end_from_begin, end).norm(), &surface))
        missed = excess;
    }
  }
  return 1.5 * missed;
}

void ContactFinder::keep_stuck(const ContactConstraints& contacts, const std::vector<PoseStep>& poses) {
  for (size_t i = 0; i < planes_.size(); ++i) {
    const ContactConstraint& c = contacts[i];
    const Pose& end = poses[static_cast<size_t>(c.collider)].end;
    memory_.store(planes_[i].key, end.linear().transpose() * c.stuck);
  }
  memory_.end_part();
}

double ContactFinder::violation(const Nodes& x, const ContactConstraints& contacts) const {
  double worst = 0.0;
  for (size_t i = 0; i < planes_.size(); ++i)
    worst = std::max(worst, planes_[i].asked_offset - contacts[i].normal.dot(contact_position(contacts[i], x)));
  return worst;
}

double ContactFinder::penetration(const Nodes& x, const std::vector<PoseStep>& poses,
                                  const ContactConstraints& contacts) {
  double deepest = 0.0;
  int placed = -1;
  for (size_t i = 0; i < planes_.size(); ++i) {
    const ContactConstraint& c = contacts[i];
    const Plane& plane = planes_[i];
    const Vec3 p = contact_position(c, x);
    // On the outer side of a tangent plane of a convex shape: outside.
    if (c.normal.dot(p) >= plane.end_offset) continue;
    PlacedShape& shape = shapes_[static_cast<size_t>(plane.shape)];
    if (placed != plane.shape) {
      shape.query.place(poses[static_cast<size_t>(shape.collider)].end * shape.collider_from_shape);
      placed = plane.shape;
    }
    SurfacePoint surface;
    if (shape.query.find(p, 0.0, &surface)) deepest = std::max(deepest, -surface.distance);
  }
  return deepest;
}

double measure_penetration(const Model& model, const std::vector<Collider>& colliders, const Nodes& x) {
  std::vector<ContactPoint> points;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    add_node_points(model, b, &points);
    add_between_points(model, b, &points);
  }
  double deepest = 0.0;
  for (const Collider& collider : colliders) {
    for (const Shape& s : collider.shapes) {
      SurfaceQuery query(s);
      query.place(collider.world_from_collider * s.collider_from_shape);
      SurfacePoint surface;
      for (const ContactPoint& point : points)
        if (!lets_through(collider, model.bodies[static_cast<size_t>(point.body)].name) &&
            query.find(position(point, x), 0.0, &surface))
          deepest = std::max(deepest, -surface.distance);
    }
  }
  return deepest;
}

}  // namespace deformable_sim
