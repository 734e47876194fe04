# The target `reference`: HTML pages of the public headers, by Doxygen. Any warning
# of Doxygen fails the target.
find_package(Doxygen QUIET)
find_package(Python3 COMPONENTS Interpreter QUIET)
if(NOT DOXYGEN_FOUND OR NOT Python3_FOUND)
  message(STATUS "doxygen or Python was not found: no target `reference`")
  return()
endif()

set(KINEGRAPH_REFERENCE ${PROJECT_BINARY_DIR}/reference)
get_property(headers GLOBAL PROPERTY KINEGRAPH_PUBLIC_HEADERS)
set(KINEGRAPH_REFERENCE_INPUT ${PROJECT_SOURCE_DIR}/cmake/reference/main.md)
foreach(header ${headers})
  string(APPEND KINEGRAPH_REFERENCE_INPUT " \"${PROJECT_SOURCE_DIR}/${header}\"")
endforeach()
configure_file(${CMAKE_CURRENT_LIST_DIR}/reference/Doxyfile.in
  ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
add_custom_target(reference
  COMMAND ${CMAKE_COMMAND} -E make_directory ${KINEGRAPH_REFERENCE}
  COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/Doxyfile
  COMMENT "reference -> ${KINEGRAPH_REFERENCE}/index.html"
  VERBATIM)
if(KINEGRAPH_TESTS)
  add_test(NAME reference.builds
    COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/Doxyfile)
  set_tests_properties(reference.builds PROPERTIES TIMEOUT 300)
endif()
