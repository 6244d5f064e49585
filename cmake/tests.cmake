# gtest binaries, one a folder of test/; ROS tests are in ros_targets.cmake.
find_package(GTest CONFIG REQUIRED)
find_package(Threads REQUIRED)
enable_testing()
foreach(group unit verify regression scene)
  file(GLOB group_sources CONFIGURE_DEPENDS test/${group}/*.cpp)
  if(group_sources)
    add_executable(${group}_tests ${group_sources})
    target_include_directories(${group}_tests PRIVATE test)
    target_compile_definitions(${group}_tests PRIVATE
      DEFORMABLE_SIM_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}" SIMULATE_PATH="$<TARGET_FILE:simulate>"
      STUDY_PATH="$<TARGET_FILE:study>")
    target_link_libraries(${group}_tests PRIVATE ${PROJECT_NAME}_scene GTest::gtest GTest::gtest_main Threads::Threads yaml-cpp)
    add_dependencies(${group}_tests simulate study)
    add_test(NAME ${group} COMMAND ${group}_tests)
  endif()
endforeach()
