#!/usr/bin/env bash
# Builds the library by one of the presets android, ios, visionos and those for simulators, with this machine's clang and the stand-in
# headers, and checks which symbols it needs from that system.
#   build.sh PRESET OUTPUT_FOLDER [CMAKE_OPTION...]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source=$(cd "$here/../.." && pwd)
preset=$1 output=$2
shift 2
rm -rf "$output"
mkdir -p "$output"
fail() { echo "$*"; exit 1; }

# For iOS too the C++ headers are those of the cross compiler. The SDK's own come first.
cross=/usr/aarch64-linux-gnu/include
cxx=$(echo "$cross"/c++/*)
apple_cxx="-nostdinc++ -isystem $cxx -isystem $cxx/aarch64-linux-gnu -isystem $cross -D_GNU_SOURCE -U__nonnull -include stdint.h"

case $preset in
  android)
    # A sysroot with the libraries that the plug-in links, so that it links as it would for a phone.
    cp -r "$here/stand_ins/ndk" "$output/ndk"
    lib=$(echo "$output"/ndk/toolchains/llvm/prebuilt/*/sysroot)/usr/lib
    mkdir -p "$lib"
    # JNI's header is the real one.
    [[ ! -x $(command -v javac) ]] || cp "$(dirname "$(readlink -f "$(command -v javac)")")"/../include/{jni.h,linux/jni_md.h} "$lib/../include"
    shared=(clang --target=aarch64-linux-android24 -shared -nostdlib -fuse-ld=lld -x c -)
    echo 'void ATrace_beginSection(const char* n) { (void)n; } void ATrace_endSection(void) {}' | "${shared[@]}" -o "$lib/libandroid.so"
    echo 'int m;' | "${shared[@]}" -o "$lib/libm.so"
    # The stand-in's C library: functions for memory and strings, the clock, the auxiliary vector.
    printf '#define F(f) void f(void) {}\nF(memcpy) F(memset) F(memmove) F(memcmp) F(strncmp) F(clock_gettime) F(getauxval)\n' |
      "${shared[@]}" -fno-builtin -o "$lib/libc.so"
    set -- -DANDROID_NDK="$output/ndk" "$@" ;;
  ios) set -- -DCMAKE_OSX_SYSROOT="$here/stand_ins/iPhoneOS.sdk" -DCMAKE_CXX_FLAGS="-isystem $here/stand_ins/iPhoneOS.sdk/usr/include $apple_cxx" "$@" ;;
  ios-simulator | visionos*)
    sdk=$output/iPhoneSimulator.sdk  # by its name CMake knows for which system
    [[ $preset == ios* ]] || sdk=$output/XR.sdk
    cp -r "$here/stand_ins/iPhoneOS.sdk" "$sdk"
    set -- -DCMAKE_OSX_SYSROOT="$sdk" -DCMAKE_CXX_FLAGS="-isystem $sdk/usr/include $apple_cxx" "$@" ;;
  *) fail "no preset $preset" ;;
esac

cmake -S "$source" --preset "$preset" -B "$output/build" --log-level=WARNING -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "$@" >/dev/null
cmake --build "$output/build" -j "${CMAKE_BUILD_PARALLEL_LEVEL:-2}" -- --quiet
archive=$output/build/runtime/libsandglass.a
members=$(ar t "$archive" | wc -l)
echo "$members objects in the archive"
NM=$(command -v llvm-nm) READELF=$(command -v llvm-readobj) bash "$source/tests/package/symbols.sh" archive "$archive"

# Symbols that an app's own library would export without being asked, and therefore keep.
if [[ $preset == android ]]; then
  visible=$(llvm-readelf -sW "$archive" | awk '$5 == "GLOBAL" && $6 == "DEFAULT" && $7 != "UND" {print $8}')
else
  visible=$(llvm-nm -m "$archive" | grep ' external ' | grep -vE '\(undefined\)|private external' || true)
fi
[[ -z $visible ]] || fail "not hidden in the archive: $visible"

if [[ $preset == android ]]; then
  cmake --build "$output/build" --target sandglass_unity -- --quiet
  plugin=$output/build/unity/libsandglass.so
  python3 "$here/package_layout.py" pages "$plugin"
  NM=nm bash "$source/tests/package/symbols.sh" exported "$plugin" "$source/runtime/include"
  cmake --build "$output/build" --target aar -- --quiet
  python3 "$here/package_layout.py" aar "$output"/build/sandglass-*.aar "$source/runtime/include"
  # A library of an app is aligned too, by what the installed package and Prefab's module.json tell the linker, and not without it.
  cmake --install "$output/build" --prefix "$output/prefix" >/dev/null
  module=$output/build/toolchains/android/aar/prefab/modules/sandglass/module.json
  told=$(python3 -c 'import json, sys; print(*json.load(open(sys.argv[1]))["export_libraries"])' "$module")
  option=$(sed -n 's/.*INTERFACE_LINK_OPTIONS "\(.*\)"/\1/p' "$output/prefix/lib/cmake/sandglass/sandglassTargets.cmake")
  for options in "$told" "${option:?the installed package tells the linker nothing}" ""; do
    # shellcheck disable=SC2086  # several options
    clang --target=aarch64-linux-android24 -shared -nostdlib -fuse-ld=lld -Wl,-u,sandglass_version -L "$lib" "$archive" $options -o "$output/libapp.so"
    aligned=$(python3 "$here/package_layout.py" pages "$output/libapp.so" 2>&1 && echo yes) || true
    [[ ${aligned:-no} == yes || -z $options ]] || fail "$options: $aligned"
  done
  [[ $aligned == *"not aligned"* ]] || fail "the control is aligned"
else
  # Every object says for which system and which oldest version it is.
  case $preset in ios) expected=ios ;; ios-simulator) expected=iossimulator ;; visionos) expected='xros|0x00000B' ;; *) expected='xrossimulator|0x00000C' ;; esac
  llvm-objdump --macho --private-headers "$archive" | awk -v expected="$expected" '
    $1 == "platform" {++n; if ($2 !~ "^(" expected ")$") ++wrong} $1 == "minos" && $2 != (expected ~ /^xr/ ? "1.0" : "15.0") {++wrong}
    END {printf "%d objects for %s\n", n, expected; exit (wrong > 0 || n == 0)}' || fail "an object is for another system"
fi
