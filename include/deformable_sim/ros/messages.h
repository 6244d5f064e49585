// The messages and services of this package, in namespace msg.
//
// gencpp puts them into a namespace called like the package, which is also the namespace of the library: Status and
// GraspRequest would be two things each. Only the C++ name is moved; names on the wire are not.
#pragma once

#define deformable_sim deformable_sim_msgs
#include <deformable_sim/AddBody.h>
#include <deformable_sim/AddObstacle.h>
#include <deformable_sim/BodyMesh.h>
#include <deformable_sim/ContactArray.h>
#include <deformable_sim/FollowGraspTrajectoryAction.h>
#include <deformable_sim/GetDistance.h>
#include <deformable_sim/GetState.h>
#include <deformable_sim/Grasp.h>
#include <deformable_sim/GraspCommand.h>
#include <deformable_sim/GraspStateArray.h>
#include <deformable_sim/LetThrough.h>
#include <deformable_sim/LoadScene.h>
#include <deformable_sim/MoveGrasp.h>
#include <deformable_sim/Release.h>
#include <deformable_sim/RemoveBody.h>
#include <deformable_sim/RemoveObstacle.h>
#include <deformable_sim/RestoreState.h>
#include <deformable_sim/Rollout.h>
#include <deformable_sim/SaveState.h>
#include <deformable_sim/SegmentLabels.h>
#include <deformable_sim/SessionRecord.h>
#include <deformable_sim/SetMaterial.h>
#include <deformable_sim/SetState.h>
#include <deformable_sim/SimStatus.h>
#include <deformable_sim/Step.h>
#undef deformable_sim

namespace deformable_sim {
namespace msg = ::deformable_sim_msgs;
}
