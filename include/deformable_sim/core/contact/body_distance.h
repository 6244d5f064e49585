// How far a body is from colliders: asked for now and then, no part of a step.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

struct BodyDistance {
  double distance = 0.0;            // m, between the surfaces, contact radius counted; negative where they overlap
  Vec3 on_body = Vec3::Zero();      // m, world; on the body's surface, contact radius counted
  Vec3 on_collider = Vec3::Zero();  // m, world
  int collider = -1;                // index among those given; -1: none
};

/// The least signed distance of any point of the body's triangles or segments,
///
///   min over points x and shapes s of d_s(x)  -  contact radius,
///
/// to 1e-8 m. Signed distances to convex shapes are convex functions: their tangents at the corners of a piece bound
/// them from below on all of it, and a piece whose bound does not tell is cut in four (two). At meshes that are not
/// convex and at voxels the tangents are those of their triangles and squares, which holds outside; a body that
/// overlaps one is as deep as its deepest node, and at -(contact radius) where no node is inside.
///
/// x   3 x n of the model, m. At least one collider; of equals the first counts.
BodyDistance body_distance(const Model& model, int body, const Nodes& x, const std::vector<Collider>& colliders);

}  // namespace deformable_sim
