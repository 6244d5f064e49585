# Installation without ROS: find_package(deformable_sim) gives deformable_sim::core and deformable_sim::scene.
include(GNUInstallDirs)
set(PLAIN_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})

set_target_properties(${PROJECT_NAME}_core PROPERTIES EXPORT_NAME core)
set_target_properties(${PROJECT_NAME}_scene PROPERTIES EXPORT_NAME scene)
set_target_properties(simulate study PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
install(TARGETS ${PROJECT_NAME}_core ${PROJECT_NAME}_scene EXPORT ${PROJECT_NAME}-exports
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
)
install(EXPORT ${PROJECT_NAME}-exports NAMESPACE ${PROJECT_NAME}:: DESTINATION ${PLAIN_CMAKE_DIR})
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}Config.cmake
  "include(CMakeFindDependencyMacro)\n"
  "find_dependency(Eigen3)\n"
  "find_dependency(fcl)\n"
  "include(\"\${CMAKE_CURRENT_LIST_DIR}/${PROJECT_NAME}-exports.cmake\")\n")
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}Config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
  DESTINATION ${PLAIN_CMAKE_DIR})

install(TARGETS simulate study RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${PROJECT_NAME}
  PATTERN ros EXCLUDE)
install(DIRECTORY config meshes DESTINATION ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})
