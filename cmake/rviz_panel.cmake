# The rviz panel: a library of its own, never linked by the node. Left out where rviz's development files are missing.
find_package(rviz QUIET)
find_package(Qt5Widgets QUIET)
if(rviz_FOUND AND Qt5Widgets_FOUND)
  file(GLOB RVIZ_SOURCES CONFIGURE_DEPENDS src/rviz/*.cpp include/${PROJECT_NAME}/rviz/*.h)
  add_library(${PROJECT_NAME}_rviz SHARED ${RVIZ_SOURCES})
  set_target_properties(${PROJECT_NAME}_rviz PROPERTIES AUTOMOC ON)
  # Boost has names of its own for what Qt calls signals and slots.
  target_compile_definitions(${PROJECT_NAME}_rviz PUBLIC QT_NO_KEYWORDS)
  target_include_directories(${PROJECT_NAME}_rviz PUBLIC include)
  #catkin_lint: ignore_once external_interface_path
  target_include_directories(${PROJECT_NAME}_rviz SYSTEM PUBLIC ${catkin_INCLUDE_DIRS} ${rviz_INCLUDE_DIRS})
  target_link_libraries(${PROJECT_NAME}_rviz PUBLIC Qt5::Widgets ${catkin_LIBRARIES} ${rviz_LIBRARIES})
  add_dependencies(${PROJECT_NAME}_rviz ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
  install(TARGETS ${PROJECT_NAME}_rviz
    ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    RUNTIME DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION}
  )
  if(CATKIN_ENABLE_TESTING)
    find_package(GTest REQUIRED)
    foreach(name panel_widget_tests panel_plugin_tests)
      add_executable(${name} test/rviz/${name}.cpp)
      target_link_libraries(${name} PRIVATE ${PROJECT_NAME}_rviz GTest::gtest)
    endforeach()
    add_test(NAME panel COMMAND panel_widget_tests)
  endif()
else()
  message(STATUS "rviz panel: left out, librviz-dev or qtbase5-dev is missing")
  add_custom_target(${PROJECT_NAME}_rviz)
endif()
install(FILES plugin_description.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
