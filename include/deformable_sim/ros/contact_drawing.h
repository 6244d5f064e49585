// Forces of contacts as arrows.
#pragma once

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// m/N: outputs.contact_scale, or what makes the longest arrow a fifth of the box around the bodies as they start.
double contact_arrow_scale(const Snapshot& snapshot, const OutputSpec& outputs);

/// LINE_LIST of six points a contact: from where it touches along the force on the body, scale (m/N) times as long, and
/// the two barbs of the tip. Of two bodies each has its own, opposite one. Shows Snapshot::contacts.
visualization_msgs::Marker contact_marker(const Snapshot& snapshot, int body, double scale);

}  // namespace deformable_sim
