// What contact keeps from step to step, in saved states.
#include <algorithm>
#include <utility>

#include "deformable_sim/core/contact/body_contacts.h"
#include "deformable_sim/core/contact/collider_set.h"
#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/contact/voxel_solid.h"

namespace deformable_sim {
namespace {

/// The first thing `of` gives for a shape of `known` that `same` says yes to; null when there is none.
template <class Solid, class Same>
std::shared_ptr<const Solid> find_known(const std::vector<Collider>& known, std::shared_ptr<const Solid> Shape::*member,
                                        const Same& same) {
  for (const Collider& collider : known)
    for (const Shape& shape : collider.shapes)
      if (shape.*member && same(*(shape.*member))) return shape.*member;
  return nullptr;
}

void check_indices(const std::array<int, 3>& indices, size_t count) {
  for (const int i : indices)
    if (i < 0 || static_cast<size_t>(i) >= count) Archive::refuse("a triangle that is none");
}

void pass_triples(std::vector<std::array<int, 3>>* triples, Archive* archive) {
  archive->pass_each(triples, 3 * sizeof(int), [archive](std::array<int, 3>* triple) {
    for (int& i : *triple) archive->pass(&i);
  });
}

void pass_mesh(const std::vector<Collider>& known, Archive* archive, std::shared_ptr<const ColliderMesh>* mesh) {
  SolidPart part;
  if (!archive->reads()) part = (*mesh)->part();
  archive->pass_each(&part.vertices, sizeof(Vec3), [archive](Vec3* v) { archive->pass(v); });
  pass_triples(&part.triangles, archive);
  pass_triples(&part.neighbours, archive);
  if (!archive->reads()) return;
  if (part.triangles.empty() || part.neighbours.size() != part.triangles.size() ||
      part.triangles.size() > kMostColliderTriangles)
    Archive::refuse("a mesh that is none");
  for (const auto& t : part.triangles) check_indices(t, part.vertices.size());
  for (const auto& n : part.neighbours) check_indices(n, part.triangles.size());
  *mesh = find_known(known, &Shape::mesh, [&part](const ColliderMesh& other) {
    return other.vertices() == part.vertices && other.triangles() == part.triangles;
  });
  if (!*mesh) *mesh = std::make_shared<ColliderMesh>(std::move(part));
}

void pass_voxels(const std::vector<Collider>& known, Archive* archive, std::shared_ptr<const VoxelSolid>* voxels) {
  std::vector<VoxelCube> cubes;
  double resolution = 0.0;
  if (!archive->reads()) {
    cubes = (*voxels)->cubes();
    resolution = (*voxels)->resolution();
  }
  archive->pass(&resolution);
  archive->pass_each(&cubes, 4 * sizeof(int), [archive](VoxelCube* cube) {
    for (std::uint16_t& k : cube->key) {
      int key = k;
      archive->pass(&key);
      if (key < 0 || key > 2 * kVoxelOrigin - 1) Archive::refuse("a cube that is none");
      k = static_cast<std::uint16_t>(key);
    }
    archive->pass(&cube->level);
    if (cube->level < 0 || cube->level > kVoxelLevels) Archive::refuse("a cube that is none");
  });
  if (!archive->reads()) return;
  const auto same = [&](const VoxelSolid& other) {
    const auto same_cube = [](const VoxelCube& a, const VoxelCube& b) { return a.key == b.key && a.level == b.level; };
    return other.resolution() == resolution &&
           std::equal(cubes.begin(), cubes.end(), other.cubes().begin(), other.cubes().end(), same_cube);
  };
  *voxels = find_known(known, &Shape::voxels, same);
  if (!*voxels) *voxels = std::make_shared<VoxelSolid>(std::move(cubes), resolution);
}

void pass_shape(const std::vector<Collider>& known, Archive* archive, Shape* shape) {
  archive->pass_enum(&shape->type, Shape::Type::kVoxels);
  archive->pass(&shape->size);
  archive->pass(&shape->collider_from_shape);
  if (shape->type == Shape::Type::kMesh) pass_mesh(known, archive, &shape->mesh);
  if (shape->type == Shape::Type::kVoxels) pass_voxels(known, archive, &shape->voxels);
}

}  // namespace

void pass_collider(const std::vector<Collider>& known, Archive* archive, Collider* c) {
  archive->pass(&c->name);
  archive->pass_each(&c->shapes, sizeof(Vec3), [&](Shape* shape) { pass_shape(known, archive, shape); });
  archive->pass(&c->world_from_collider);
  archive->pass(&c->friction);
  archive->pass(&c->frame);
  archive->pass(&c->frame_from_collider);
  archive->pass(&c->lets_through);
}

void ColliderSet::pass(const std::vector<Collider>& known, Archive* archive) {
  std::vector<Collider> colliders = colliders_;
  archive->pass_each(&colliders, sizeof(Pose), [&](Collider* c) { pass_collider(known, archive, c); });
  if (archive->reads()) {
    *this = ColliderSet(max_speed_);
    for (const Collider& c : colliders) add(c);
  }
  for (FrameMotion& motion : motions_) motion.pass(archive);
  if (archive->reads()) restore_motions(std::vector<FrameMotion>(motions_));
}

void ContactFinder::pass(Archive* archive) {
  archive->pass(&next_key_);
  for (PlacedShape& shape : shapes_) archive->pass(&shape.first_key);
  archive->pass_each(&planes_, sizeof(std::int64_t), [&](Plane* plane) {
    archive->pass(&plane->key);
    archive->pass(&plane->shape);
    archive->pass(&plane->normal);
    archive->pass(&plane->point);
    archive->pass(&plane->end_offset);
    archive->pass(&plane->asked_offset);
    if (plane->shape < 0 || plane->shape >= shape_count()) Archive::refuse("a contact with a shape that is not there");
  });
  memory_.pass(archive, [archive](std::int64_t* key) { archive->pass(key); });
}

void BodyContacts::pass(Archive* archive) {
  if (!archive->looks_on()) pieces_.forget();
  archive->pass(&rate_);
  memory_.pass(archive, [archive](ContactPlace* place) { place->pass(archive); });
}

}  // namespace deformable_sim
