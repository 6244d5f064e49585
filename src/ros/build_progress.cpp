#include "deformable_sim/ros/build_progress.h"

#include <ros/console.h>
#include <ros/time.h>

namespace deformable_sim {

DistanceGrid::Progress build_progress(const std::string& what) {
  return [what, last = ros::WallTime::now()](double done) mutable {
    const ros::WallTime now = ros::WallTime::now();
    if ((now - last).toSec() < 1.0) return;
    last = now;
    ROS_INFO_STREAM_NAMED("mesh", what << ": distance grid " << static_cast<int>(100.0 * done) << " % done");
  };
}

}  // namespace deformable_sim
