#include "deformable_sim/ros/publishers/registry.h"

#include "deformable_sim/ros/publishers/makers.h"

namespace deformable_sim {

const std::vector<PublisherEntry>& publisher_registry() {
  static const std::vector<PublisherEntry> registry{
      {Rate::kMarkers, false, make_markers_publisher},
      {Rate::kPoints, false, make_body_points_publisher},
      {Rate::kPoints, false, make_all_points_publisher},
      {Rate::kState, false, make_body_state_publisher},
      {Rate::kState, false, make_mesh_publisher},
      {Rate::kState, false, make_grasps_publisher},
      {Rate::kState, false, make_wrench_publisher},
      {Rate::kState, false, make_contacts_publisher},
      {Rate::kState, false, make_contact_wrench_publisher},
      {Rate::kState, true, make_status_publisher},
      {Rate::kDiagnostics, true, make_diagnostics_publisher},
      {Rate::kState, false, make_transforms_publisher},
      {Rate::kHandles, false, make_handles_publisher},
  };
  return registry;
}

}  // namespace deformable_sim
