# The tests of what runs on several threads, run by ./run study threads; built by the target thread_tests only.
find_package(GTest REQUIRED)
find_package(Threads REQUIRED)
add_executable(thread_tests EXCLUDE_FROM_ALL test/unit/workers_test.cpp test/scene/threads_test.cpp)
target_include_directories(thread_tests PRIVATE test ${TBB_INCLUDE_DIR})
target_link_libraries(thread_tests PRIVATE ${PROJECT_NAME}_scene GTest::gtest GTest::gtest_main Threads::Threads
  ${TBB_LIBRARY})
if(DEFORMABLE_SIM_ROS)
  target_sources(thread_tests PRIVATE test/ros/request_queue_test.cpp)
  target_link_libraries(thread_tests PRIVATE ${PROJECT_NAME}_ros)
endif()
# rosrun looks for programs by their names in the whole checkout, and is to find one node.
if(TARGET sim_node)
  set_target_properties(sim_node PROPERTIES OUTPUT_NAME watched_sim_node)
endif()
