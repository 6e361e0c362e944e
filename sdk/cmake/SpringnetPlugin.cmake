# springnet_add_plugin(name SOURCES a.cpp … [LIBRARIES target …])
#
# Builds the plugin <name>.springnet.so (.dylib, .dll) and installs it where springnet looks for plugins. Works in
# springnet's own tree and, after find_package(springnet), in any other project.
#
# Variables, all optional:
#   SPRINGNET_PLUGIN_OUTPUT_DIRECTORY   folder the build writes the plugin to
#   SPRINGNET_PLUGIN_INSTALL_DIRECTORY  folder it is installed to, default <libdir>/springnet/plugins
#
# In springnet's own tree there is also <name>_static, built on demand: the same sources as an object library whose
# entry is springnet_plugin_entry_<name>, to be linked into a program and registered with PluginHost::add.
function(springnet_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 plugin "" "" "SOURCES;LIBRARIES")
  if(plugin_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "springnet_add_plugin(${name}): unknown argument '${plugin_UNPARSED_ARGUMENTS}'; "
                        "write springnet_add_plugin(name SOURCES a.cpp … [LIBRARIES target …])")
  endif()
  if(NOT plugin_SOURCES)
    message(FATAL_ERROR "springnet_add_plugin(${name}): no SOURCES are given")
  endif()

  add_library(${name} MODULE ${plugin_SOURCES})
  _springnet_plugin_flags(${name} ${plugin_LIBRARIES})
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".springnet${CMAKE_SHARED_LIBRARY_SUFFIX}")
  if(SPRINGNET_PLUGIN_OUTPUT_DIRECTORY)
    # MODULE libraries count as "library" output on every platform, Windows included.
    set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${SPRINGNET_PLUGIN_OUTPUT_DIRECTORY})
  endif()

  if(NOT SPRINGNET_PLUGIN_INSTALL_DIRECTORY)
    include(GNUInstallDirs)
    set(SPRINGNET_PLUGIN_INSTALL_DIRECTORY ${CMAKE_INSTALL_LIBDIR}/springnet/plugins)
  endif()
  install(TARGETS ${name} LIBRARY DESTINATION ${SPRINGNET_PLUGIN_INSTALL_DIRECTORY})

  if(TARGET springnet_plugins)
    add_dependencies(springnet_plugins ${name})
    add_library(${name}_static OBJECT EXCLUDE_FROM_ALL ${plugin_SOURCES})
    _springnet_plugin_flags(${name}_static ${plugin_LIBRARIES})
    string(MAKE_C_IDENTIFIER ${name} identifier)
    target_compile_definitions(${name}_static PRIVATE SPRINGNET_STATIC_PLUGIN=${identifier})
  endif()
endfunction()

function(_springnet_plugin_flags target)
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  # Without contraction a kernel gives the same bits for every instruction set and tile size. The loops of laws vectorise
  # only if a square root need not set errno and what is computed for a branch not taken need not be hidden, and if a
  # long formula is compiled into them: gnu::flatten keeps to GCC's limit for inlined functions.
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno -fno-trapping-math $<$<CONFIG:Release>:-O3>
    $<$<CXX_COMPILER_ID:GNU>:--param=max-inline-insns-single=20000>)
  target_link_libraries(${target} PRIVATE springnet::sdk ${ARGN} $<TARGET_NAME_IF_EXISTS:springnet_build_flags>)
endfunction()
