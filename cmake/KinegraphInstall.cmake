# cmake --install: commands, libraries, headers, configurations, examples,
# licences, and a package that find_package(kinegraph) finds.
include(CMakePackageConfigHelpers)

# kinegraph::kinegraph, all libraries except those of the commands.
get_property(libraries GLOBAL PROPERTY KINEGRAPH_LIBRARIES)
list(FILTER libraries EXCLUDE REGEX "^kinegraph_apps_")
add_library(kinegraph_kinegraph INTERFACE)
add_library(kinegraph::kinegraph ALIAS kinegraph_kinegraph)
set_target_properties(kinegraph_kinegraph PROPERTIES EXPORT_NAME kinegraph)
target_link_libraries(kinegraph_kinegraph INTERFACE ${libraries})
target_include_directories(kinegraph_kinegraph INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/kinegraph)
install(TARGETS ${libraries} kinegraph_kinegraph EXPORT kinegraphTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kinegraphTargets NAMESPACE kinegraph::
  DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kinegraphConfig.cmake.in
  ${PROJECT_BINARY_DIR}/kinegraphConfig.cmake
  INSTALL_DESTINATION ${package_folder})
# Before 1.0 minor versions may be incompatible.
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/kinegraphConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kinegraphConfig.cmake
  ${PROJECT_BINARY_DIR}/kinegraphConfigVersion.cmake
  DESTINATION ${package_folder})

# The public headers: include/kinegraph, and those of the library that they
# include. Other headers are not installed.
function(kinegraph_collect_headers header)
  get_property(known GLOBAL PROPERTY KINEGRAPH_PUBLIC_HEADERS)
  if(header IN_LIST known)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY KINEGRAPH_PUBLIC_HEADERS ${header})
  # Configure again when a header changes, as its includes may have changed.
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY
    CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  file(STRINGS ${PROJECT_SOURCE_DIR}/${header} lines
    REGEX "^#include \"(core|solvers)/")
  foreach(line ${lines})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
    kinegraph_collect_headers(${included})
  endforeach()
endfunction()

file(GLOB faces RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
  ${PROJECT_SOURCE_DIR}/include/kinegraph/*.h)
foreach(face ${faces})
  kinegraph_collect_headers(${face})
endforeach()
get_property(headers GLOBAL PROPERTY KINEGRAPH_PUBLIC_HEADERS)
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  if(NOT folder MATCHES "^include/")
    set(folder include/kinegraph/${folder})
  endif()
  string(REGEX REPLACE "^include" ${CMAKE_INSTALL_INCLUDEDIR} folder ${folder})
  install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${folder})
endforeach()

get_property(commands GLOBAL PROPERTY KINEGRAPH_COMMANDS)
install(TARGETS ${commands} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs
  DESTINATION ${CMAKE_INSTALL_DATADIR}/kinegraph)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE
  ${PROJECT_SOURCE_DIR}/third_party_notes.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
