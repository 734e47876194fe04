# UNTESTED. Builds the source tree that contains this file; a registry's port
# would download a release and verify its checksum instead.
set(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../..")

vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DKINEGRAPH_TESTS=OFF -DKINEGRAPH_PYTHON=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME kinegraph CONFIG_PATH lib/cmake/kinegraph)

# vcpkg expects programs in tools/ and headers only in the release tree.
file(GLOB commands RELATIVE "${CURRENT_PACKAGES_DIR}/bin"
  "${CURRENT_PACKAGES_DIR}/bin/kinegraph-*")
vcpkg_copy_tools(TOOL_NAMES ${commands} AUTO_CLEAN)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include"
  "${CURRENT_PACKAGES_DIR}/debug/share" "${CURRENT_PACKAGES_DIR}/debug/bin")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE"
  "${SOURCE_PATH}/third_party_notes.md")
