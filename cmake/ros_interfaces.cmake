# Messages and services, and everything of ROS that the node and the demo are built with.
find_package(catkin REQUIRED COMPONENTS
  diagnostic_msgs
  diagnostic_updater
  dynamic_reconfigure
  geometry_msgs
  interactive_markers
  kdl_parser
  message_generation
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

add_message_files(DIRECTORY msg FILES
  BodyMesh.msg
  BodyState.msg
  Contact.msg
  ContactArray.msg
  GraspCommand.msg
  GraspSelection.msg
  GraspState.msg
  GraspStateArray.msg
  Obstacle.msg
  Octomap.msg
  SimStatus.msg
  Status.msg
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
  SaveState.srv
  SetMaterial.srv
  SetState.srv
  Step.srv
)
generate_dynamic_reconfigure_options(cfg/Live.cfg)
generate_messages(DEPENDENCIES geometry_msgs shape_msgs std_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES ${PROJECT_NAME}_core ${PROJECT_NAME}_scene ${PROJECT_NAME}_ros
  CATKIN_DEPENDS
    diagnostic_msgs diagnostic_updater dynamic_reconfigure geometry_msgs interactive_markers message_runtime pluginlib resource_retriever roscpp rosgraph_msgs roslib
    sensor_msgs shape_msgs std_msgs std_srvs tf2_eigen tf2_msgs tf2_ros urdf visualization_msgs
  DEPENDS EIGEN3
  CFG_EXTRAS ${PROJECT_NAME}-targets.cmake
)
