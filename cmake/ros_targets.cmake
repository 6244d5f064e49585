# Layer 3: the node, the robot demo, ROS tests, installation.
file(GLOB_RECURSE ROS_SOURCES CONFIGURE_DEPENDS src/ros/*.cpp)
add_library(${PROJECT_NAME}_ros ${ROS_SOURCES})
add_dependencies(${PROJECT_NAME}_ros ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
#catkin_lint: ignore_once external_interface_path
target_include_directories(${PROJECT_NAME}_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_link_libraries(${PROJECT_NAME}_ros PUBLIC ${PROJECT_NAME}_scene ${catkin_LIBRARIES})

add_executable(sim_node src/sim_node.cpp)
target_link_libraries(sim_node PRIVATE ${PROJECT_NAME}_ros)

add_library(${PROJECT_NAME}_nodelet src/nodelet.cpp)
target_link_libraries(${PROJECT_NAME}_nodelet PRIVATE ${PROJECT_NAME}_ros)

# What `simulate --replay` runs: simulate itself knows no ROS.
file(GLOB REPLAY_SOURCES CONFIGURE_DEPENDS src/replay/*.cpp)
add_executable(replay_session ${REPLAY_SOURCES})
target_include_directories(replay_session SYSTEM PRIVATE ${rosbag_storage_INCLUDE_DIRS})
target_link_libraries(replay_session PRIVATE ${PROJECT_NAME}_ros ${rosbag_storage_LIBRARIES})

# The example robot: uses the public ROS interface only, so it links nothing of this package.
file(GLOB ROBOT_SOURCES CONFIGURE_DEPENDS src/robot/*.cpp)
add_executable(robot_demo ${ROBOT_SOURCES})
add_dependencies(robot_demo ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
target_include_directories(robot_demo SYSTEM PRIVATE ${catkin_INCLUDE_DIRS} ${orocos_kdl_INCLUDE_DIRS})
target_link_libraries(robot_demo PRIVATE ${catkin_LIBRARIES} ${orocos_kdl_LIBRARIES} Eigen3::Eigen)

install(TARGETS ${PROJECT_NAME}_core ${PROJECT_NAME}_nodelet ${PROJECT_NAME}_ros ${PROJECT_NAME}_scene
  ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  RUNTIME DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION}
)
install(TARGETS replay_session robot_demo sim_node simulate study RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
file(GLOB PYTHON_EXAMPLES CONFIGURE_DEPENDS examples/python/*.py)
catkin_install_python(PROGRAMS scripts/demo ${PYTHON_EXAMPLES} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION ${CATKIN_PACKAGE_INCLUDE_DESTINATION})
install(FILES nodelet_plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(DIRECTORY config launch meshes urdf DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})

if(CATKIN_ENABLE_TESTING)
  include(cmake/ros_tests.cmake)
endif()
