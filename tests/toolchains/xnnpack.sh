#!/usr/bin/env bash
# Where the build finds XNNPACK, each way by a configuration of its own, without a network.
#   xnnpack.sh fetched|prefix|refused SOURCE_FOLDER OUTPUT_FOLDER GENERATOR [CMAKE_OPTION...]
# fetched: nothing is installed, and a stand-in lies where FetchContent would have downloaded to; its header is of the generation
# since 2023, the adapter compiles against it and the archive asks for its functions. prefix: an app's own, beside the stand-in's
# header. refused: nothing is there and nothing may be downloaded; without the option nothing is looked for.
set -euo pipefail
how=$1 source=$2 output=$3/$1 generator=$4
shift 4
stand_in=$source/tests/toolchains/stand_ins/xnnpack
none=(-DSANDGLASS_XNNPACK_INCLUDE=OFF -DSANDGLASS_XNNPACK_LIBRARY=OFF -DSANDGLASS_PTHREADPOOL_LIBRARY=OFF)
rm -rf "$output"
mkdir -p "$output"
fail() { echo "$*"; exit 1; }
configure() {
  cmake -S "$source" -B "$output/build" -G "$generator" -DCMAKE_BUILD_TYPE=Debug -DSANDGLASS_DEVELOPER=OFF \
    -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "$@" >"$output/log" 2>&1
}
build() { cmake --build "$output/build" --target "$@" >>"$output/log" 2>&1 || { cat "$output/log"; fail "does not build"; }; }
# What the objects of the back ends ask of XNNPACK.
asked() { find "$output/build" -name '*xnnpack.cpp.o' -exec nm -u {} + | grep -oE 'xnn_[a-z0-9_]+' | sort -u; }

pin=$(sed -nE 's/.*GIT_TAG ([0-9a-f]+)\)?.*/\1/p' "$source/toolchains/cmake/SandglassXnnpack.cmake")
[[ ${#pin} == 40 ]] || fail "XNNPACK is pinned by '$pin', which is not the whole hash of a commit"

case $how in
  fetched)
    configure -DSANDGLASS_XNNPACK=ON "${none[@]}" -DFETCHCONTENT_SOURCE_DIR_SANDGLASS_XNNPACK="$stand_in" "$@" ||
      { cat "$output/log"; fail "does not configure"; }
    grep -q "API of 2023" "$output/log" || fail "the header's generation was not seen"
    build sandglass_lighting_xnnpack XNNPACK
    [[ $(asked) == *xnn_reshape_convolution2d_nhwc_f32*xnn_reshape_convolution2d_nhwc_qs8_qc8w* ]] || fail "asks for: $(asked)"
    find "$output/build" -name libXNNPACK.a | grep -q . || fail "the stand-in was not built" ;;
  prefix)
    mkdir -p "$output/prefix/lib"
    cp -r "$stand_in/include" "$output/prefix"
    : >"$output/prefix/lib/libXNNPACK.so"
    : >"$output/prefix/lib/libpthreadpool.so"
    configure -DSANDGLASS_XNNPACK=ON -DSANDGLASS_FETCH=OFF -DCMAKE_PREFIX_PATH="$output/prefix" "$@" ||
      { cat "$output/log"; fail "does not configure"; }
    grep -q "XNNPACK: $output/prefix/include/xnnpack.h, API of 2023" "$output/log" || fail "the prefix was not seen" ;;
  refused)
    if configure -DSANDGLASS_XNNPACK=ON -DSANDGLASS_FETCH=OFF "${none[@]}" "$@"; then fail "not refused"; fi
    tr -s ' \n' '  ' <"$output/log" | grep -q "XNNPACK was not found and SANDGLASS_XNNPACK is ON: install it" || { cat "$output/log"; fail "no sentence"; }
    rm -rf "$output/build"
    if configure -DSANDGLASS_XNNPACK=ON -DFETCHCONTENT_FULLY_DISCONNECTED=ON "${none[@]}" "$@"; then fail "an empty folder was taken for XNNPACK"; fi
    tr -s ' \n' '  ' <"$output/log" | grep -q "XNNPACK is not in $output/build/_deps/sandglass_xnnpack-src: install it" || { cat "$output/log"; fail "no sentence"; }
    rm -rf "$output/build"
    configure "$@" || { cat "$output/log"; fail "does not configure without the option"; }
    ! grep -q XNNPACK "$output/log" || fail "XNNPACK was looked for" ;;
esac
