file(GLOB_RECURSE sources
  ${SOURCE}/core/*.h ${SOURCE}/core/*.cc
  ${SOURCE}/solvers/*.h ${SOURCE}/solvers/*.cc
  ${SOURCE}/apps/*.h ${SOURCE}/apps/*.cc
  ${SOURCE}/include/*.h ${SOURCE}/examples/*.cc ${SOURCE}/python/*.cc
  ${SOURCE}/tests/*.h ${SOURCE}/tests/*.cc)
if(NOT sources)
  message(FATAL_ERROR "no sources in ${SOURCE}")
endif()
execute_process(COMMAND ${CLANG_FORMAT} --dry-run --Werror ${sources}
  RESULT_VARIABLE result ERROR_VARIABLE errors)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "format differs from .clang-format (clang-format-14 -i "
    "fixes it):\n${errors}")
endif()
