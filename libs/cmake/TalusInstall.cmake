include(CMakePackageConfigHelpers)

get_property(TALUS_COMPONENTS GLOBAL PROPERTY TALUS_COMPONENTS)
configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/talusConfig.cmake.in" "${PROJECT_BINARY_DIR}/talusConfig.cmake"
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/talus)
write_basic_package_version_file(
  "${PROJECT_BINARY_DIR}/talusConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/talusConfig.cmake" "${PROJECT_BINARY_DIR}/talusConfigVersion.cmake"
  "${CMAKE_CURRENT_LIST_DIR}/TalusMrpt.cmake"
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/talus COMPONENT dev)
if(TALUS_WITH_MRPT)
  set(batch "${CMAKE_INSTALL_DATADIR}/talus/batch")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/datasets/configs" "${PROJECT_SOURCE_DIR}/datasets/worlds" DESTINATION ${CMAKE_INSTALL_DATADIR}/talus COMPONENT commands)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/apps/talus-batch/" DESTINATION ${batch} COMPONENT commands USE_SOURCE_PERMISSIONS
    PATTERN __pycache__ EXCLUDE)
  file(RELATIVE_PATH from_bin "/${CMAKE_INSTALL_BINDIR}" "/${batch}/talus-batch")
  install(CODE "file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
    file(CREATE_LINK ${from_bin} \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}/talus-batch\" SYMBOLIC)"
    COMPONENT commands)
  talus_add_manual(talus-batch "${PROJECT_SOURCE_DIR}/apps/talus-batch/talus-batch")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/apps/examples" DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)
endif()

include(TalusPackages)
