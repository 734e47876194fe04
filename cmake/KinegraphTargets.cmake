# Defines the library of a folder from all its .cc and .h files and links it to the
# libraries of the folders on which it depends. Code that calls functions of a folder
# that is neither listed nor a dependency of a listed one fails to link.
#
#   kinegraph_library(core/geometry DEPENDS core/base LINKS Eigen3::Eigen)
#
# makes the target kinegraph_core_geometry, exported as kinegraph::core_geometry.

set(KINEGRAPH_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
    -Woverloaded-virtual -Wconversion-null)
if(KINEGRAPH_WARNINGS_AS_ERRORS)
  list(APPEND KINEGRAPH_WARNINGS -Werror)
endif()

function(kinegraph_compile_settings target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_compile_options(${target} PRIVATE ${KINEGRAPH_WARNINGS})
  if(KINEGRAPH_UNITY)
    # Files with their own options (kinegraph_lanes) are compiled separately.
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON
      UNITY_BUILD_BATCH_SIZE 12)
    # GCC warns about classes in included files whose members have types from an
    # anonymous namespace; in a unity build these files are sources that nothing else
    # includes.
    target_compile_options(${target} PRIVATE
      $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  # In debug builds Eigen fills memory with NaN, which exposes uninitialised values.
  target_compile_definitions(${target} PRIVATE
    $<$<CONFIG:Debug>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)
endfunction()

# Files whose name ends in _lanes compute with packs (core/base/pack.h): each
# lane must have the same bits on every instruction set, so products and sums must
# not be fused. Files ending in _avx2 or _avx512 compile the same kernel for wider
# registers and must not use Eigen (tests/layering).
function(kinegraph_lanes list)
  foreach(source ${${list}})
    set(options -ffp-contract=off -fno-math-errno -fno-trapping-math)
    if(NOT source MATCHES "_lanes(_avx2|_avx512)?\\.cc$")
      continue()
    elseif(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      # On other architectures the wide files are empty.
    elseif(source MATCHES "_avx2\\.cc$")
      list(APPEND options -mavx2)
    elseif(source MATCHES "_avx512\\.cc$")
      list(APPEND options -mavx512f)
    endif()
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "${options}")
  endforeach()
endfunction()

function(kinegraph_library folder)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LINKS;PRIVATE_LINKS" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  set(target kinegraph_${name})
  file(GLOB sources CONFIGURE_DEPENDS
    ${PROJECT_SOURCE_DIR}/${folder}/*.cc ${PROJECT_SOURCE_DIR}/${folder}/*.h)
  set_property(GLOBAL APPEND PROPERTY KINEGRAPH_LIBRARIES ${target})
  kinegraph_lanes(sources)
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX
    EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  add_library(kinegraph::${name} ALIAS ${target})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:include/kinegraph>)
  kinegraph_compile_settings(${target})
  foreach(dependency ${ARG_DEPENDS})
    string(REPLACE "/" "_" dependency_name ${dependency})
    target_link_libraries(${target} PUBLIC kinegraph::${dependency_name})
  endforeach()
  target_link_libraries(${target} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
endfunction()
