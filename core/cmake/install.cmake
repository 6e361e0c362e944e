# What `cmake --install` puts where: library, headers, tool and the CMake package. Plugins install themselves, where the
# library looks for them (springnet_add_plugin).
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/springnet)

install(TARGETS springnet springnet_sdk EXPORT springnetTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET springnet_tool)
  install(TARGETS springnet_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include/ ${PROJECT_SOURCE_DIR}/sdk/include/
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/springnet)

install(EXPORT springnetTargets NAMESPACE springnet:: DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/springnetConfig.cmake.in
  ${PROJECT_BINARY_DIR}/springnetConfig.cmake INSTALL_DESTINATION ${package_folder})
# Before version 1.0 the C++ interface may change with every minor version. Plugins have a version of their own (the
# ABI's), which the host checks when it loads them.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/springnetConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/springnetConfig.cmake ${PROJECT_BINARY_DIR}/springnetConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/sdk/cmake/SpringnetPlugin.cmake DESTINATION ${package_folder})
