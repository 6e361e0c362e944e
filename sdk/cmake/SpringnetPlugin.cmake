# springnet_add_plugin(name SOURCES a.cpp … [LIBRARIES target …])
#
# Builds the plugin <name>.springnet.so (.dylib, .dll) and installs it where springnet looks for plugins. Works in
# springnet's own tree and, after find_package(springnet), in any other project.
#
# The plugin exports its entry alone, not what LIBRARIES bring along. LIBRARIES must not lead to the library
# springnet::springnet: a program would have it twice.
#
# Variables, all optional:
#   SPRINGNET_PLUGIN_OUTPUT_DIRECTORY   folder the build writes the plugin to
#   SPRINGNET_PLUGIN_INSTALL_DIRECTORY  folder it is installed to, default <libdir>/springnet/plugins
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
  if(CMAKE_EXECUTABLE_FORMAT STREQUAL "ELF")  # whose linkers all know version scripts
    set(exports ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/springnet_plugin.map)
    target_link_options(${name} PRIVATE LINKER:--version-script=${exports})
    set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS ${exports})
  endif()
  # The run path is that of the installed plugin from the start: to make room for another one, CMake appends empty entries,
  # for which the loader looks into the working directory. Libraries are found beside the plugin and where they are
  # linked from.
  set_property(TARGET ${name} APPEND PROPERTY INSTALL_RPATH "$ORIGIN")
  set_target_properties(${name} PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON BUILD_WITH_INSTALL_RPATH ON)
  # At the end of the folder, when all that the plugin links is known.
  cmake_language(EVAL CODE "cmake_language(DEFER CALL _springnet_check_plugin [[${name}]])")
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
  endif()
endfunction()

# springnet_add_law_flags(target): compiles a program's own laws (springnet/host_laws.hpp) as those of plugins are.
function(springnet_add_law_flags target)
  # Without contraction a kernel gives the same bits for every instruction set and tile size. The loops of laws vectorise
  # only if a square root need not set errno and what is computed for a branch not taken need not be hidden, and if a
  # long formula is compiled into them: gnu::flatten keeps to the limits of GCC for inlined functions and their files.
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno -fno-trapping-math
    $<$<CXX_COMPILER_ID:GNU>:--param=max-inline-insns-single=20000 --param=inline-unit-growth=10000>)
endfunction()

function(_springnet_plugin_flags target)
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  springnet_add_law_flags(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O3> $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
  target_link_libraries(${target} PRIVATE springnet::sdk ${ARGN} $<TARGET_NAME_IF_EXISTS:springnet_build_flags>)
endfunction()

# Refuses a plugin that links springnet::springnet, directly or through what it links. The library comes with the program
# that loads the plugin; a copy of the plugin's own would have other types, errors and state.
function(_springnet_check_plugin name)
  _springnet_find_library(chain ${name} "")
  if(chain)
    list(JOIN chain " -> " chain)
    message(FATAL_ERROR "springnet_add_plugin(${name}): the plugin links the springnet library (${chain}). A plugin "
      "calls the program that loads it only through the host table of the SDK. Take the library out of LIBRARIES, or "
      "out of the link interface of the target that brings it along; what is needed of it has to come through "
      "springnet::sdk.")
  endif()
endfunction()

# The chain of targets from `item` to the library; empty if none leads there. `seen`: targets on the way.
function(_springnet_find_library result item seen)
  set(${result} "" PARENT_SCOPE)
  set(library FALSE)
  if(item MATCHES "^springnet(::springnet|_objects|_internals)?$" OR item MATCHES "(^-l|/lib)springnet([.]|$)")
    set(library TRUE)
  elseif(TARGET ${item})
    get_target_property(aliased ${item} ALIASED_TARGET)
    if(aliased MATCHES "^springnet(_objects|_internals)?$")
      set(library TRUE)
    elseif(aliased)
      _springnet_find_library(chain ${aliased} "${seen}")
      set(${result} ${chain} PARENT_SCOPE)
      return()
    endif()
  endif()
  if(library)
    set(${result} ${item} PARENT_SCOPE)
    return()
  endif()
  if(NOT TARGET ${item} OR item IN_LIST seen)
    return()
  endif()
  list(APPEND seen ${item})
  set(links "")
  foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
    get_target_property(value ${item} ${property})
    if(value)
      list(APPEND links ${value})
    endif()
  endforeach()
  # Names within generator expressions count, whatever their condition.
  string(REGEX MATCHALL "[A-Za-z0-9_.+/-]+(::[A-Za-z0-9_.+-]+)*" links "${links}")
  list(REMOVE_DUPLICATES links)
  foreach(link IN LISTS links)
    _springnet_find_library(chain ${link} "${seen}")
    if(chain)
      set(${result} ${item} ${chain} PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()
