// Whether the library and the baseline find the same contacts, so that their costs may be compared.
#pragma once

#include <string>

#include "contact_baseline.h"
#include "deformable_sim/core/world.h"

namespace deformable_sim {
namespace bench {

/// What two searches found in the world's state, at rest there: pairs of bodies' nodes and triangles, edges and edges,
/// nearer than their contact radii together, and nodes nearer to a collider than their own.
///
/// Both lists are brought to what the library makes of them: nodes of no weight are left out and each set of nodes
/// counts once. What is nearer to the limit than 1e-9 m may be in either.
struct ContactComparison {
  int between_bodies = 0, on_colliders = 0;  // the baseline's
  int missed = 0, surplus = 0;               // not in the library's, not in the baseline's
  std::string first;                         // one of those, in words
};
ContactComparison compare_contacts(const World& world, ContactBaseline* baseline);

/// Least distance of two pieces in the world's state over the one they keep (contact.md, 9: the sum of the radii, at
/// most 0.9 of their distance at rest where they are of one body); 1 when none is nearer.
double least_distance_share(const World& world, ContactBaseline* baseline);

}  // namespace bench
}  // namespace deformable_sim
