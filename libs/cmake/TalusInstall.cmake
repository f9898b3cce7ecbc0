include(CMakePackageConfigHelpers)

get_property(TALUS_COMPONENTS GLOBAL PROPERTY TALUS_COMPONENTS)
configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/talusConfig.cmake.in" "${PROJECT_BINARY_DIR}/talusConfig.cmake"
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/talus)
write_basic_package_version_file(
  "${PROJECT_BINARY_DIR}/talusConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/talusConfig.cmake" "${PROJECT_BINARY_DIR}/talusConfigVersion.cmake"
  "${CMAKE_CURRENT_LIST_DIR}/TalusMrpt.cmake"
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/talus)
