# cmake --install: commands, libraries, headers, configurations, and a package
# that find_package(kinegraph) finds.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The umbrella: every library but what belongs to the commands.
get_property(libraries GLOBAL PROPERTY KINEGRAPH_LIBRARIES)
list(FILTER libraries EXCLUDE REGEX "^kinegraph_apps_")
add_library(kinegraph_kinegraph INTERFACE)
add_library(kinegraph::kinegraph ALIAS kinegraph_kinegraph)
set_target_properties(kinegraph_kinegraph PROPERTIES EXPORT_NAME kinegraph)
target_link_libraries(kinegraph_kinegraph INTERFACE ${libraries})

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/kinegraph)
install(TARGETS ${libraries} kinegraph_kinegraph EXPORT kinegraphTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kinegraphTargets NAMESPACE kinegraph::
  DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kinegraphConfig.cmake.in
  ${PROJECT_BINARY_DIR}/kinegraphConfig.cmake
  INSTALL_DESTINATION ${package_folder})
# Before 1.0 a minor version may break what stood before.
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/kinegraphConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kinegraphConfig.cmake
  ${PROJECT_BINARY_DIR}/kinegraphConfigVersion.cmake
  DESTINATION ${package_folder})

install(DIRECTORY ${PROJECT_SOURCE_DIR}/core ${PROJECT_SOURCE_DIR}/solvers
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kinegraph
  FILES_MATCHING PATTERN "*.h")

get_property(commands GLOBAL PROPERTY KINEGRAPH_COMMANDS)
if(commands)
  install(TARGETS ${commands} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(EXISTS ${PROJECT_SOURCE_DIR}/configs)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs
    DESTINATION ${CMAKE_INSTALL_DATADIR}/kinegraph)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE
  ${PROJECT_SOURCE_DIR}/third_party_notes.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
