// Occupied space of OctoMap trees: files (.bt, .ot) and what messages carry of them.
#pragma once

#include <string>

#include "deformable_sim/core/contact/collider.h"

namespace deformable_sim {

/// A tree without its file's header: the fields of octomap_msgs/Octomap.
struct OctomapTree {
  bool binary = true;         // occupied or free by two bits a child; else every node's log odds
  std::string id = "OcTree";  // OcTree, OcTreeStamped or ColorOcTree
  double resolution = 0.0;    // m
  std::string data;
};

/// A shape of voxels: leaves whose log odds are 0 or more (probability 0.5, OctoMap's own threshold), or which the
/// binary form calls occupied. Free and unknown space is empty.
///
/// Read without OctoMap's library, which trusts what it reads: a tree that ends early, goes deeper than 16 levels or
/// has bytes left over is refused, as are other ids, log odds that are no numbers, and what VoxelSolid refuses
/// (InputError; kOutOfRange for sizes).
Shape octomap_shape(const OctomapTree& tree);

/// The same from a whole .bt or .ot file; `name` is for messages.
Shape octomap_from_bytes(const std::string& bytes, const std::string& name);
Shape load_octomap(const std::string& path);

}  // namespace deformable_sim
