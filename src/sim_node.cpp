// The ROS node: cloth and rope as a service.
#include "deformable_sim/ros/node.h"

int main(int argc, char** argv) {
  return deformable_sim::run_node(argc, argv);
}
