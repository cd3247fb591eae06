# Finds FlatBuffers' headers, of the release whose compiler made runtime/asset/*_generated.h, and sets
# SANDGLASS_FLATBUFFERS_INCLUDE.
include(SandglassHeaders)
set(sandglass_flatbuffers_version 2.0.8)
set(SANDGLASS_FLATBUFFERS_URL https://github.com/google/flatbuffers/archive/refs/tags/v${sandglass_flatbuffers_version}.tar.gz
  CACHE STRING "Where FlatBuffers ${sandglass_flatbuffers_version} is downloaded from")
mark_as_advanced(SANDGLASS_FLATBUFFERS_URL)
sandglass_find_headers(FlatBuffers flatbuffers/flatbuffers.h VERSION ${sandglass_flatbuffers_version} BELOW 2.0.9 IN /include
  TOLD_BY flatbuffers/base.h REGEX "#define FLATBUFFERS_VERSION_(MAJOR|MINOR|REVISION) "
  SHA256 f97965a727d26386afaefff950badef2db3ab6af9afe23ed6d94bfb65f95f37e)
if((ANDROID OR APPLE OR EMSCRIPTEN OR WIN32) AND SANDGLASS_FLATBUFFERS_INCLUDE MATCHES "^/usr/")
  # The headers of this machine's C library lie beside them, so the compiler gets a folder with FlatBuffers' alone.
  set(alone ${PROJECT_BINARY_DIR}/flatbuffers_alone)
  file(MAKE_DIRECTORY ${alone})
  file(CREATE_LINK ${SANDGLASS_FLATBUFFERS_INCLUDE}/flatbuffers ${alone}/flatbuffers SYMBOLIC)
  set(SANDGLASS_FLATBUFFERS_INCLUDE ${alone} CACHE PATH "FlatBuffers' headers" FORCE)
endif()
