# cpack -G DEB: one package with commands, library, headers, Python module,
# configurations, manual pages and completion.
set(KINEGRAPH_PAGES ${PROJECT_BINARY_DIR}/pages)
get_property(commands GLOBAL PROPERTY KINEGRAPH_COMMANDS)
set(programs "")
foreach(command ${commands})
  string(APPEND programs "$<TARGET_FILE:${command}> ")
endforeach()
add_custom_command(OUTPUT ${KINEGRAPH_PAGES}/kinegraph.bash
  COMMAND ${CMAKE_COMMAND} -D "PROGRAMS=${programs}" -D OUT=${KINEGRAPH_PAGES}
    -D VERSION=${PROJECT_VERSION} -D TASKS=${PROJECT_SOURCE_DIR}/apps/commands.txt
    -P ${PROJECT_SOURCE_DIR}/cmake/package/make_pages.cmake
  DEPENDS ${commands} ${PROJECT_SOURCE_DIR}/apps/commands.txt
    ${PROJECT_SOURCE_DIR}/cmake/package/make_pages.cmake
    ${PROJECT_SOURCE_DIR}/cmake/package/kinegraph.sh.in
  COMMENT "Manual pages and completion" VERBATIM)
add_custom_target(kinegraph_pages ALL
  DEPENDS ${KINEGRAPH_PAGES}/kinegraph.bash)

add_dependencies(kinegraph_commands kinegraph_pages)

install(PROGRAMS ${KINEGRAPH_PAGES}/kinegraph
  DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${KINEGRAPH_PAGES}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
  FILES_MATCHING PATTERN "*.1")
install(FILES ${KINEGRAPH_PAGES}/kinegraph.bash
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME kinegraph)
install(FILES ${KINEGRAPH_PAGES}/_kinegraph
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kinegraph)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The kinegraph developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY
  "3D motion of people from 2D poses of calibrated cameras")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# Dependencies on the libraries that the programs link, by dpkg-shlibdeps.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# The module works only with the minor version of Python that it was built for.
if(TARGET kinegraph_python)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor})")
endif()
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "gnuplot-nox, python3-numpy")
# For programs that link the library, and for the programs that read other
# formats (docs/adapters.md).
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "g++, cmake, make, libceres-dev, libeigen3-dev,\
 libgoogle-glog-dev, libgflags-dev, libtomlplusplus-dev, libsimdjson-dev,\
 nlohmann-json3-dev, libyaml-cpp-dev, libpugixml-dev, libfmt-dev,\
 python3-h5py, python3-scipy, ffmpeg")
include(CPack)
