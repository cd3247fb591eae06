# Finds Eigen's headers, release 3.4 or a later 3, and sets SANDGLASS_EIGEN_INCLUDE. The first of these that fits is
# taken: the folder that the app gave; the target's packages or a prefix; this machine (Eigen is headers alone, the same
# for every target); a download, pinned by hash. -DSANDGLASS_FETCH=OFF forbids the download.
option(SANDGLASS_FETCH "Download what is not found, pinned by hash" ON)
set(SANDGLASS_EIGEN_URL https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.gz
  https://github.com/eigen-mirror/eigen/archive/refs/tags/3.4.0.tar.gz CACHE STRING "Where Eigen 3.4.0 is downloaded from, tried in turn")
mark_as_advanced(SANDGLASS_EIGEN_URL)

# sandglass_eigen_fits(RESULT FOLDER): whether the headers in FOLDER are of such a release.
function(sandglass_eigen_fits result folder)
  set(found "")
  if(EXISTS ${folder}/Eigen/src/Core/util/Macros.h)
    file(STRINGS ${folder}/Eigen/src/Core/util/Macros.h lines REGEX "#define EIGEN_(WORLD|MAJOR)_VERSION ")
    string(REGEX MATCHALL "[0-9]+" numbers "${lines}")
    list(JOIN numbers . found)
  endif()
  set(${result} FALSE PARENT_SCOPE)
  if(found VERSION_GREATER_EQUAL 3.4 AND found VERSION_LESS 4)
    set(${result} TRUE PARENT_SCOPE)
  endif()
endfunction()

find_path(SANDGLASS_EIGEN_INCLUDE Eigen/Core PATH_SUFFIXES eigen3)
find_path(SANDGLASS_EIGEN_INCLUDE Eigen/Core PATH_SUFFIXES eigen3 NO_CMAKE_FIND_ROOT_PATH)
sandglass_eigen_fits(fits "${SANDGLASS_EIGEN_INCLUDE}")
if(NOT fits)
  if(NOT SANDGLASS_FETCH)
    message(FATAL_ERROR "Eigen 3.4 was not found: install its headers, name their folder by SANDGLASS_EIGEN_INCLUDE, or allow the "
      "download by SANDGLASS_FETCH=ON.")
  endif()
  include(FetchContent)
  # Both servers give the same bytes. Should GitLab ever pack its archive anew, the mirror's still fits.
  FetchContent_Declare(sandglass_eigen URL ${SANDGLASS_EIGEN_URL}
    URL_HASH SHA256=8586084f71f9bde545ee7fa6d00288b264a2b7ac3607b974e54d13e7162c1c72 DOWNLOAD_EXTRACT_TIMESTAMP ON)
  FetchContent_GetProperties(sandglass_eigen)
  if(NOT sandglass_eigen_POPULATED)
    FetchContent_Populate(sandglass_eigen)
  endif()
  sandglass_eigen_fits(fits ${sandglass_eigen_SOURCE_DIR})
  if(NOT fits)  # nothing was downloaded: FETCHCONTENT_FULLY_DISCONNECTED is set, or the app named a folder
    message(FATAL_ERROR "Eigen 3.4 is not in ${sandglass_eigen_SOURCE_DIR}: install its headers, name their folder by "
      "SANDGLASS_EIGEN_INCLUDE, or allow the download by FETCHCONTENT_FULLY_DISCONNECTED=OFF.")
  endif()
  set(SANDGLASS_EIGEN_INCLUDE ${sandglass_eigen_SOURCE_DIR} CACHE PATH "Eigen's headers" FORCE)
endif()
