# What `cmake --install` puts where: library, headers, tool, documentation, examples, the template of a plugin and the
# CMake package. Plugins install themselves, where the library looks for them (springnet_add_plugin).
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/springnet)

# Apart, because authors of plugins need nothing that the library needs.
install(TARGETS springnet_sdk EXPORT springnetSdkTargets)
install(TARGETS springnet EXPORT springnetTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET springnet_tool)
  install(TARGETS springnet_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(FILES ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_MANDIR}/man1/springnet.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions/springnet
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions)
endif()
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include/ ${PROJECT_SOURCE_DIR}/sdk/include/
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
set(documentation_folder ${CMAKE_INSTALL_DATAROOTDIR}/doc/springnet)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${documentation_folder})
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/docs/ DESTINATION ${documentation_folder} PATTERN "*.md" EXCLUDE)
install(CODE "
  set(core \"${CMAKE_CURRENT_SOURCE_DIR}\")
  set(sdk \"${PROJECT_SOURCE_DIR}/sdk\")
  set(folder \"${documentation_folder}\")
  set(include_folder \"${CMAKE_INSTALL_INCLUDEDIR}\")
  set(data_folder \"${CMAKE_INSTALL_DATAROOTDIR}/springnet\")")
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/documentation.cmake)
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/fuzzy/soft_tissue.fcl DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/springnet)
# `springnet new --example` copies from here. What sets up the sources' tree stays there.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/springnet/examples
  USE_SOURCE_PERMISSIONS
  PATTERN quickstart EXCLUDE PATTERN setup.bash EXCLUDE PATTERN picture EXCLUDE PATTERN three.png EXCLUDE)

# A plugin to begin with.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/sdk/template/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/springnet/template
  USE_SOURCE_PERMISSIONS)

install(EXPORT springnetSdkTargets NAMESPACE springnet:: DESTINATION ${package_folder})
install(EXPORT springnetTargets NAMESPACE springnet:: DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/springnetConfig.cmake.in
  ${PROJECT_BINARY_DIR}/springnetConfig.cmake INSTALL_DESTINATION ${package_folder}
  PATH_VARS CMAKE_INSTALL_BINDIR)
# Before version 1.0 the C++ interface may change with every minor version. Plugins have a version of their own (the
# ABI's), which the host checks when it loads them.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/springnetConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/springnetConfig.cmake ${PROJECT_BINARY_DIR}/springnetConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/sdk/cmake/SpringnetPlugin.cmake ${PROJECT_SOURCE_DIR}/sdk/cmake/springnet_plugin.map
  DESTINATION ${package_folder})
