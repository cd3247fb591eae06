# Finds Eigen's headers, release 3.4 or a later 3, and sets SANDGLASS_EIGEN_INCLUDE. Both servers give the same bytes. Should
# GitLab ever pack its archive anew, the mirror's still fits.
include(SandglassHeaders)
set(SANDGLASS_EIGEN_URL https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.gz
  https://github.com/eigen-mirror/eigen/archive/refs/tags/3.4.0.tar.gz CACHE STRING "Where Eigen 3.4.0 is downloaded from, tried in turn")
mark_as_advanced(SANDGLASS_EIGEN_URL)
sandglass_find_headers(Eigen Eigen/Core SUFFIX eigen3 VERSION 3.4 BELOW 4
  TOLD_BY Eigen/src/Core/util/Macros.h REGEX "#define EIGEN_(WORLD|MAJOR)_VERSION "
  SHA256 8586084f71f9bde545ee7fa6d00288b264a2b7ac3607b974e54d13e7162c1c72)
