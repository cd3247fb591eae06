# Finds FlatBuffers' headers, of the release whose compiler made runtime/asset/*_generated.h, and sets
# SANDGLASS_FLATBUFFERS_INCLUDE. The first of these that fits is taken: the folder that the app gave; the target's
# packages or a prefix; this machine (FlatBuffers is used by its headers alone, the same for every target); a download,
# pinned by hash. -DSANDGLASS_FETCH=OFF forbids the download.
option(SANDGLASS_FETCH "Download what is not found, pinned by hash" ON)
set(sandglass_flatbuffers_version 2.0.8)
set(SANDGLASS_FLATBUFFERS_URL https://github.com/google/flatbuffers/archive/refs/tags/v${sandglass_flatbuffers_version}.tar.gz
  CACHE STRING "Where FlatBuffers ${sandglass_flatbuffers_version} is downloaded from")
mark_as_advanced(SANDGLASS_FLATBUFFERS_URL)

# sandglass_flatbuffers_fits(RESULT FOLDER): whether the headers in FOLDER are of that release.
function(sandglass_flatbuffers_fits result folder)
  set(found "")
  if(EXISTS ${folder}/flatbuffers/base.h)
    file(STRINGS ${folder}/flatbuffers/base.h lines REGEX "#define FLATBUFFERS_VERSION_(MAJOR|MINOR|REVISION) ")
    string(REGEX MATCHALL "[0-9]+" numbers "${lines}")
    list(JOIN numbers . found)
  endif()
  string(COMPARE EQUAL "${found}" ${sandglass_flatbuffers_version} fits)
  set(${result} ${fits} PARENT_SCOPE)
endfunction()

find_path(SANDGLASS_FLATBUFFERS_INCLUDE flatbuffers/flatbuffers.h)
find_path(SANDGLASS_FLATBUFFERS_INCLUDE flatbuffers/flatbuffers.h NO_CMAKE_FIND_ROOT_PATH)
sandglass_flatbuffers_fits(fits "${SANDGLASS_FLATBUFFERS_INCLUDE}")
if(NOT fits)
  if(NOT SANDGLASS_FETCH)
    message(FATAL_ERROR "FlatBuffers ${sandglass_flatbuffers_version} was not found: install its headers, name their folder by "
      "SANDGLASS_FLATBUFFERS_INCLUDE, or allow the download by SANDGLASS_FETCH=ON.")
  endif()
  include(FetchContent)
  FetchContent_Declare(sandglass_flatbuffers URL ${SANDGLASS_FLATBUFFERS_URL}
    URL_HASH SHA256=f97965a727d26386afaefff950badef2db3ab6af9afe23ed6d94bfb65f95f37e DOWNLOAD_EXTRACT_TIMESTAMP ON)
  FetchContent_GetProperties(sandglass_flatbuffers)
  if(NOT sandglass_flatbuffers_POPULATED)
    FetchContent_Populate(sandglass_flatbuffers)
  endif()
  sandglass_flatbuffers_fits(fits ${sandglass_flatbuffers_SOURCE_DIR}/include)
  if(NOT fits)  # nothing was downloaded: FETCHCONTENT_FULLY_DISCONNECTED is set, or the app named a folder
    message(FATAL_ERROR "FlatBuffers ${sandglass_flatbuffers_version} is not in ${sandglass_flatbuffers_SOURCE_DIR}: install its headers, "
      "name their folder by SANDGLASS_FLATBUFFERS_INCLUDE, or allow the download by FETCHCONTENT_FULLY_DISCONNECTED=OFF.")
  endif()
  set(SANDGLASS_FLATBUFFERS_INCLUDE ${sandglass_flatbuffers_SOURCE_DIR}/include CACHE PATH "FlatBuffers' headers" FORCE)
elseif((ANDROID OR APPLE OR EMSCRIPTEN OR WIN32) AND SANDGLASS_FLATBUFFERS_INCLUDE MATCHES "^/usr/")
  # The headers of this machine's C library lie beside them, so the compiler gets a folder with FlatBuffers' alone.
  set(alone ${PROJECT_BINARY_DIR}/flatbuffers_alone)
  file(MAKE_DIRECTORY ${alone})
  file(CREATE_LINK ${SANDGLASS_FLATBUFFERS_INCLUDE}/flatbuffers ${alone}/flatbuffers SYMBOLIC)
  set(SANDGLASS_FLATBUFFERS_INCLUDE ${alone} CACHE PATH "FlatBuffers' headers" FORCE)
endif()
