# Messages and services, and everything of ROS that the node and the demo are built with.
find_package(catkin REQUIRED COMPONENTS
  actionlib
  actionlib_msgs
  diagnostic_msgs
  diagnostic_updater
  dynamic_reconfigure
  geometry_msgs
  interactive_markers
  kdl_parser
  message_generation
  nodelet
  pluginlib
  resource_retriever
  roscpp
  rosgraph_msgs
  roslib
  sensor_msgs
  shape_msgs
  std_msgs
  std_srvs
  tf2_eigen
  tf2_msgs
  tf2_ros
  urdf
  visualization_msgs
)
find_package(orocos_kdl REQUIRED)
find_package(rosbag_storage REQUIRED)

# python/deformable_sim beside the generated deformable_sim.msg and .srv; before generate_messages().
catkin_python_setup()

add_message_files(DIRECTORY msg FILES
  BodyMesh.msg
  BodyState.msg
  Contact.msg
  ContactArray.msg
  GraspCommand.msg
  GraspSelection.msg
  GraspState.msg
  GraspStateArray.msg
  GraspTrajectory.msg
  GraspTrajectoryPoint.msg
  Obstacle.msg
  Octomap.msg
  RolloutPlan.msg
  RolloutResult.msg
  RolloutSample.msg
  SegmentLabels.msg
  SessionRecord.msg
  SimStatus.msg
  Status.msg
  TimedGraspCommand.msg
)
add_service_files(DIRECTORY srv FILES
  AddBody.srv
  AddObstacle.srv
  GetDistance.srv
  GetState.srv
  Grasp.srv
  LetThrough.srv
  LoadScene.srv
  MoveGrasp.srv
  Release.srv
  RemoveBody.srv
  RemoveObstacle.srv
  RestoreState.srv
  Rollout.srv
  SaveState.srv
  SetMaterial.srv
  SetState.srv
  Step.srv
)
add_action_files(DIRECTORY action FILES FollowGraspTrajectory.action)
generate_dynamic_reconfigure_options(cfg/Live.cfg)
generate_messages(DEPENDENCIES actionlib_msgs geometry_msgs shape_msgs std_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES ${PROJECT_NAME}_core ${PROJECT_NAME}_scene ${PROJECT_NAME}_ros
  CATKIN_DEPENDS
    actionlib actionlib_msgs diagnostic_msgs diagnostic_updater dynamic_reconfigure geometry_msgs interactive_markers message_runtime nodelet pluginlib resource_retriever roscpp rosgraph_msgs roslib
    sensor_msgs shape_msgs std_msgs std_srvs tf2_eigen tf2_msgs tf2_ros urdf visualization_msgs
  DEPENDS EIGEN3
  CFG_EXTRAS ${PROJECT_NAME}-targets.cmake
)
