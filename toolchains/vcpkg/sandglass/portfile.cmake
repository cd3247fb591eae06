# An overlay port over this checkout:  vcpkg install sandglass --overlay-ports=<checkout>/toolchains/vcpkg
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
vcpkg_check_linkage(ONLY_STATIC_LIBRARY)
# FlatBuffers' headers, of the release whose compiler wrote runtime/asset/*_generated.h; vcpkg's own port has another
# release. The archive is the one that toolchains/cmake/SandglassFlatBuffers.cmake pins by SHA-256. A port must not let
# CMake download.
vcpkg_from_github(OUT_SOURCE_PATH FLATBUFFERS REPO google/flatbuffers REF v2.0.8
  SHA512 005066ec08691fcc49e398ce29e07b3a92f12482d79933e027ab343ca44bc2ea9a0fd69690e98414363c1290640fe97c2a64fd98611464ac3fb62912fb91ce1b)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS -DSANDGLASS_DEVELOPER=OFF -DSANDGLASS_INSTALL=ON
  -DSANDGLASS_FETCH=OFF "-DSANDGLASS_FLATBUFFERS_INCLUDE=${FLATBUFFERS}/include")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/sandglass)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
