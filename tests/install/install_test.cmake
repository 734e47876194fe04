# A blank in the path, because somebody will have one.
set(prefix "${FOLDER}/a prefix")
set(consumer "${FOLDER}/consumer build")
file(REMOVE_RECURSE ${prefix} ${consumer})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result
    OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nfound exit ${result}:\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${prefix})
if(NOT EXISTS ${prefix}/include/kinegraph/core/geometry/camera.h)
  message(FATAL_ERROR "the headers are not in include/kinegraph")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${consumer} -G ${GENERATOR}
  -D CMAKE_BUILD_TYPE=${CONFIG} -D CMAKE_CXX_COMPILER=${COMPILER}
  -D CMAKE_CXX_FLAGS=${FLAGS}
  -D CMAKE_PREFIX_PATH=${prefix} -D KINEGRAPH_VERSION_WANTED=${VERSION})
run(${CMAKE_COMMAND} --build ${consumer})
run(${consumer}/consumer)
