# Tests of the ROS layer: parts without a master, then the node, each test with a master of its own.
find_package(GTest REQUIRED)
add_executable(ros_tests test/ros/camera_test.cpp test/ros/careful_messages_test.cpp test/ros/drawing_test.cpp
  test/ros/extra_markers_test.cpp test/ros/force_plugins_test.cpp test/ros/pacer_test.cpp test/ros/request_queue_test.cpp
  test/ros/sheet_look_test.cpp test/ros/tube_test.cpp)
target_include_directories(ros_tests PRIVATE test)
target_compile_definitions(ros_tests PRIVATE DEFORMABLE_SIM_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
target_link_libraries(ros_tests PRIVATE ${PROJECT_NAME}_ros GTest::gtest GTest::gtest_main)
# The example's plugin, where pluginlib looks for libraries.
add_library(force_plugin SHARED examples/force_plugin/src/magnet.cpp)
target_include_directories(force_plugin SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(force_plugin PRIVATE ${PROJECT_NAME}_core ${catkin_LIBRARIES})
add_dependencies(ros_tests force_plugin)
add_test(NAME ros COMMAND ros_tests)

find_package(rostest REQUIRED)
file(GLOB ros_test_files CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} test/ros/*.test)
foreach(file ${ros_test_files})
  add_rostest(${file} DEPENDENCIES sim_node simulate robot_demo ${${PROJECT_NAME}_EXPORTED_TARGETS})
endforeach()
