// Names of ROS nodes as text that a person types.
#pragma once

#include <QString>

namespace deformable_sim {

/// What a node's name may look like: letters, digits and underscores between slashes.
QString node_name_pattern();
bool is_node_name(const QString& name);

}  // namespace deformable_sim
