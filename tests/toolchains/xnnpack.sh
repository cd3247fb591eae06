#!/usr/bin/env bash
# The ways in which the build finds XNNPACK, each with a configuration of its own and without a network.
#   xnnpack.sh fetched|prefix|refused|installed SOURCE_FOLDER OUTPUT_FOLDER GENERATOR [CMAKE_OPTION...]
# fetched    Nothing is installed. A stand-in lies where FetchContent would download to, with a header of the generation
#            since 2023. The adapter compiles against it, and the archive needs its functions.
# prefix     An app's own libraries lie in a prefix, with the stand-in's header.
# refused    Nothing is there and nothing may be downloaded. Without the option nothing is searched.
# installed  A prefix has several archives that need each other, as XNNPACK's do. The installed package links in an app,
#            by CMake and by pkg-config. It finds a prefix that was moved if it is told where, and reports it if not.
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
configured() { configure "$@" || { cat "$output/log"; fail "does not configure"; }; }
# The log has this sentence, whose line breaks do not count.
says() { tr -s ' \n' '  ' <"$output/log" | grep -q "$1" || { cat "$output/log"; fail "no sentence: $1"; }; }
build() { cmake --build "$output/build" --target "$@" >>"$output/log" 2>&1 || { cat "$output/log"; fail "does not build"; }; }
# The functions of XNNPACK that the objects of the back ends need.
asked() { find "$output/build" -name '*xnnpack.cpp.o' -exec nm -u {} + | grep -oE 'xnn_[a-z0-9_]+' | sort -u; }

pin=$(sed -nE 's/.*GIT_TAG ([0-9a-f]+)\)?.*/\1/p' "$source/toolchains/cmake/SandglassXnnpack.cmake")
[[ ${#pin} == 40 ]] || fail "XNNPACK is pinned by '$pin', which is not the whole hash of a commit"

case $how in
  fetched)
    configured -DSANDGLASS_XNNPACK=ON "${none[@]}" -DFETCHCONTENT_SOURCE_DIR_SANDGLASS_XNNPACK="$stand_in" "$@"
    says "API of 2023"
    build sandglass_network_xnnpack XNNPACK
    [[ $(asked) == *xnn_reshape_convolution2d_nhwc_f32*xnn_reshape_convolution2d_nhwc_qs8_qc8w* ]] || fail "asks for: $(asked)"
    find "$output/build" -name libXNNPACK.a | grep -q . || fail "the stand-in was not built"
    ! cmake --install "$output/build" --prefix "$output/installed" >"$output/log" 2>&1 || fail "installed without its XNNPACK"
    says "Sandglass is not installed: its XNNPACK was built with it"
    [[ ! -e $output/installed ]] || fail "a part was installed" ;;
  prefix)
    mkdir -p "$output/prefix/lib"
    cp -r "$stand_in/include" "$output/prefix"
    : >"$output/prefix/lib/libXNNPACK.so"
    : >"$output/prefix/lib/libpthreadpool.so"
    configured -DSANDGLASS_XNNPACK=ON -DSANDGLASS_FETCH=OFF -DCMAKE_PREFIX_PATH="$output/prefix" "$@"
    says "XNNPACK: $output/prefix/include/xnnpack.h, API of 2023" ;;
  installed)
    mkdir -p "$output"/{xnnpack/lib,app}
    cp -r "$stand_in/include" "$output/xnnpack"
    archive() { "$1" -O1 -I "$stand_in/include" "${@:3}" -c -o "$output/$2.o" && ar qc "$output/xnnpack/lib/lib$2.a" "$output/$2.o"; }
    echo 'int cpuinfo_initialize(void) { return 0; }' >"$output/cpuinfo.c"
    echo 'int cpuinfo_initialize(void); int kernels(void) { return cpuinfo_initialize(); }' >"$output/kernels.c"
    echo 'void pthreadpool_destroy(void* pool) { (void)pool; }' >"$output/pthreadpool.c"
    echo 'extern "C" int kernels(void); int g_kernels = kernels();' >"$output/needs.h"
    archive cc cpuinfo "$output/cpuinfo.c"
    archive cc xnnpack-microkernels-prod "$output/kernels.c"
    archive cc pthreadpool "$output/pthreadpool.c"
    archive c++ XNNPACK -std=c++20 -include "$output/needs.h" "$stand_in/xnnpack.cpp"
    configured -DSANDGLASS_XNNPACK=ON -DSANDGLASS_SCALAR_ONLY=ON -DSANDGLASS_FETCH=OFF -DCMAKE_PREFIX_PATH="$output/xnnpack" "$@"
    build sandglass
    cmake --install "$output/build" --prefix "$output/installed" >>"$output/log"
    cp "$source/tests/package/footprint/estimate.c" "$output/app/app.c"
    printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(app)' 'find_package(sandglass CONFIG REQUIRED)' 'add_executable(app app.c)' \
      'target_link_libraries(app PRIVATE sandglass::sandglass)' 'set_target_properties(app PROPERTIES LINKER_LANGUAGE CXX)' >"$output/app/CMakeLists.txt"
    # app FOLDER [CMAKE_OPTION...]: builds the app and keeps the log.
    app() {
      { cmake -S "$output/app" -B "$output/$1" -G "$generator" -DCMAKE_PREFIX_PATH="$output/installed;${2-}" && cmake --build "$output/$1"; } \
        >"$output/log" 2>&1
    }
    app as_it_was || { cat "$output/log"; fail "the package does not link"; }
    flags=$(PKG_CONFIG_LIBDIR=$(dirname "$(find "$output/installed" -name sandglass.pc)") pkg-config --define-prefix --cflags --libs sandglass)
    # shellcheck disable=SC2086 # a list of words
    cc -c "$output/app/app.c" $flags -o "$output/app.o" && c++ "$output/app.o" $flags -o "$output/by_pkg_config"
    for program in "$output"/{as_it_was/app,by_pkg_config}; do
      [[ $(nm "$program") == *" T xnn_create_convolution2d_nhwc_f32"* ]] || fail "$program carries no XNNPACK"
    done
    mv "$output/xnnpack" "$output/moved"
    ! app lost || fail "linked without XNNPACK"
    says "built with XNNPACK, of which the library [A-Za-z-]* was not found: name its prefix"
    app moved "$output/moved" || { cat "$output/log"; fail "does not link with the prefix that was moved"; } ;;
  refused)
    if configure -DSANDGLASS_XNNPACK=ON -DSANDGLASS_FETCH=OFF "${none[@]}" "$@"; then fail "not refused"; fi
    says "XNNPACK was not found and SANDGLASS_XNNPACK is ON: install it"
    rm -rf "$output/build"
    if configure -DSANDGLASS_XNNPACK=ON -DFETCHCONTENT_FULLY_DISCONNECTED=ON "${none[@]}" "$@"; then fail "an empty folder was taken for XNNPACK"; fi
    says "XNNPACK is not in $output/build/_deps/sandglass_xnnpack-src: install it"
    rm -rf "$output/build"
    configured "$@"
    ! grep -q XNNPACK "$output/log" || fail "XNNPACK was looked for" ;;
esac
