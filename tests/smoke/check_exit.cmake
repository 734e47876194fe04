# Runs what follows "--" and checks the exit code. Success prints on stdout
# alone; bad usage prints one line on stderr alone, "NAME: error: ...".
set(command)
set(in_command FALSE)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(i RANGE ${last})
  if(in_command)
    list(APPEND command "${CMAKE_ARGV${i}}")
  elseif("${CMAKE_ARGV${i}}" STREQUAL "--")
    set(in_command TRUE)
  endif()
endforeach()

execute_process(COMMAND ${command} RESULT_VARIABLE result
  OUTPUT_VARIABLE output ERROR_VARIABLE errors)
set(seen "exit ${result}\nstdout:\n${output}\nstderr:\n${errors}")
if(NOT "${result}" STREQUAL "${EXIT}")
  message(FATAL_ERROR "expected exit ${EXIT}, found ${seen}")
endif()
if(EXIT EQUAL 0)
  if("${output}" STREQUAL "" OR NOT "${errors}" STREQUAL "")
    message(FATAL_ERROR "expected text on stdout alone, found ${seen}")
  endif()
else()
  if(NOT "${output}" STREQUAL "" OR
     NOT "${errors}" MATCHES "^kinegraph[a-z_-]*: error: [^\n]+\n$")
    message(FATAL_ERROR "expected one line of error on stderr, found ${seen}")
  endif()
endif()
