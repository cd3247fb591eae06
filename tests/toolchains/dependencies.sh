#!/usr/bin/env bash
# The ways in which a dependency of headers is found, each with stand-ins for the headers: in a folder that is given, in
# a prefix, or in a source folder that the app names instead of a download. Another release must not be taken, nor an
# archive with other bytes than the pinned ones. A forbidden download must be reported as such.
#   dependencies.sh Eigen|FlatBuffers SOURCE_FOLDER OUTPUT_FOLDER GENERATOR
set -euo pipefail
dependency=$1 source=$2 output=$3 generator=$4
upper=${dependency^^}
rm -rf "$output"
mkdir -p "$output"

# headers FOLDER NUMBER NUMBER NUMBER: writes the part of the headers that tells the release.
headers() {
  case $dependency in
    Eigen)
      mkdir -p "$1/Eigen/src/Core/util"
      : >"$1/Eigen/Core"
      printf '#define EIGEN_WORLD_VERSION %d\n#define EIGEN_MAJOR_VERSION %d\n#define EIGEN_MINOR_VERSION %d\n' "${@:2}" >"$1/Eigen/src/Core/util/Macros.h" ;;
    FlatBuffers)
      mkdir -p "$1/flatbuffers"
      : >"$1/flatbuffers/flatbuffers.h"
      printf '#define FLATBUFFERS_VERSION_MAJOR %d\n#define FLATBUFFERS_VERSION_MINOR %d\n#define FLATBUFFERS_VERSION_REVISION %d\n' "${@:2}" >"$1/flatbuffers/base.h" ;;
  esac
}
case $dependency in
  Eigen) right=(3 4 0) wrong=(3 3 9) in_prefix=include/eigen3 in_source=. ;;
  FlatBuffers) right=(2 0 8) wrong=(23 5 26) in_prefix=include in_source=include ;;
esac
headers "$output/given" "${right[@]}"
headers "$output/wrong" "${wrong[@]}"
headers "$output/prefix/$in_prefix" "${right[@]}"
headers "$output/source/$in_source" "${right[@]}"
(cd "$output/source" && cmake -E tar czf "$output/other.tar.gz" .)

# expect CASE TEXT [CMAKE_OPTION...]: CMake must print TEXT; its line breaks do not count.
expect() {
  local said
  said=$(cmake -S "$source/tests/toolchains/dependencies" -B "$output/build_$1" -G "$generator" -DDEPENDENCY="$dependency" \
    -DSANDGLASS_MODULES="$source/toolchains/cmake" "${@:3}" 2>&1 | tr -s ' \n' ' ') || true
  [[ $said == *"$2"* ]] || { echo "$dependency, $1: expected \"$2\", CMake said: $said"; exit 1; }
  echo "$1: $2"
}
# Any download that is tried fails, because there is no such archive.
nowhere=-DSANDGLASS_${upper}_URL=$output/nowhere.tar.gz
other_release=-DSANDGLASS_${upper}_INCLUDE=$output/wrong
expect given "found $output/given" "-DSANDGLASS_${upper}_INCLUDE=$output/given" "$nowhere"
expect prefix "found $output/prefix/$in_prefix" -DCMAKE_PREFIX_PATH="$output/prefix" "$nowhere"
expect other_release "was not found: install its headers" "$other_release" -DSANDGLASS_FETCH=OFF
expect source "found $output/source" "$other_release" "-DFETCHCONTENT_SOURCE_DIR_SANDGLASS_${upper}=$output/source" "$nowhere"
expect disconnected "is not in $output/build_disconnected/_deps/sandglass_${dependency,,}-src: install its headers" "$other_release" \
  -DFETCHCONTENT_FULLY_DISCONNECTED=ON
expect other_bytes "does not match expected value" "$other_release" "-DSANDGLASS_${upper}_URL=$output/other.tar.gz"
! find "$output/build_other_bytes" -name '*.h' | grep . || { echo "an archive of other bytes was unpacked"; exit 1; }
