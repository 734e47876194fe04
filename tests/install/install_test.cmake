# The path has a blank, as paths of users may.
set(prefix "${FOLDER}/a prefix")
set(consumer "${FOLDER}/consumer build")
file(REMOVE_RECURSE ${prefix} ${consumer})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result
    OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${prefix})
run(${prefix}/bin/kinegraph-adapters --list)
foreach(header kinegraph.h core/geometry/camera.h solvers/session/session.h)
  if(NOT EXISTS ${prefix}/include/kinegraph/${header})
    message(FATAL_ERROR "include/kinegraph/${header} is missing")
  endif()
endforeach()
# Headers that no public header includes are not installed.
foreach(header core/io/files/atomic_file.h apps/common/app.h)
  if(EXISTS ${prefix}/include/kinegraph/${header})
    message(FATAL_ERROR "the internal header ${header} was installed")
  endif()
endforeach()
# Public headers are few and do not include Ceres or nlohmann/json.
file(GLOB_RECURSE headers ${prefix}/include/kinegraph/*.h)
list(LENGTH headers count)
if(count GREATER 60)
  message(FATAL_ERROR "found ${count} public headers, expected at most 60")
endif()
foreach(header ${headers})
  file(STRINGS ${header} lines REGEX "#include <(ceres|nlohmann/json.hpp)")
  if(lines)
    message(FATAL_ERROR "${header}: ${lines}")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${consumer} -G ${GENERATOR}
  -D CMAKE_BUILD_TYPE=${CONFIG} -D CMAKE_CXX_COMPILER=${COMPILER}
  -D CMAKE_CXX_FLAGS=${FLAGS}
  -D CMAKE_PREFIX_PATH=${prefix} -D KINEGRAPH_VERSION_WANTED=${VERSION})
run(${CMAKE_COMMAND} --build ${consumer})
run(${consumer}/consumer)

# Builds the examples as a user would, and runs them.
set(examples "${FOLDER}/examples build")
set(take "${FOLDER}/take")
file(REMOVE_RECURSE ${examples} ${take})
run(${CMAKE_COMMAND} -S ${SOURCE}/../../../examples -B ${examples} -G ${GENERATOR}
  -D CMAKE_BUILD_TYPE=${CONFIG} -D CMAKE_CXX_COMPILER=${COMPILER}
  -D CMAKE_CXX_FLAGS=${FLAGS} -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${examples})
file(GLOB sources ${SOURCE}/../../../examples/*.cc)
foreach(source ${sources})
  get_filename_component(example ${source} NAME_WE)
  if(NOT EXISTS ${examples}/${example})
    message(FATAL_ERROR "examples/CMakeLists.txt does not build ${example}")
  endif()
  if(NOT example STREQUAL track_take)
    run(${examples}/${example})
  endif()
endforeach()
run(${prefix}/bin/kinegraph-synthesize --out=${take}
  --config=${prefix}/share/kinegraph/configs/synthetic/demo.toml
  "--set=scene.duration=2")
run(${examples}/track_take ${take}/cameras.json ${take}/detections.jsonl
  ${take}/tracks.jsonl)
if(NOT EXISTS ${take}/tracks.jsonl)
  message(FATAL_ERROR "track_take wrote nothing")
endif()
