# std::from_chars for floating point came with GCC 11; Clang 14 is the oldest that
# is tested.
if((CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 11)
   OR (CMAKE_CXX_COMPILER_ID STREQUAL Clang
       AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 14))
  message(FATAL_ERROR "${CMAKE_CXX_COMPILER} is ${CMAKE_CXX_COMPILER_ID} \
${CMAKE_CXX_COMPILER_VERSION}, but GCC 11 or Clang 14 is needed: set CXX=/path/to/a/newer/one")
endif()

# All libraries that the project links directly (third_party_notes.md), except
# those of the Python module (KinegraphPython.cmake).
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(glog REQUIRED)
find_package(gflags REQUIRED COMPONENTS shared)
find_package(Ceres 2.1 REQUIRED COMPONENTS SuiteSparse)
find_package(tomlplusplus REQUIRED)
find_package(simdjson REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(pugixml REQUIRED)
find_package(fmt REQUIRED)
find_package(ZLIB REQUIRED)

if(KINEGRAPH_TESTS)
  find_package(GTest REQUIRED)
endif()
