#!/usr/bin/env bash
# toolchains/engines.md's way to a first frame: with an installed package it builds and runs, from sources it configures.
#   first_frame.sh SOURCE_FOLDER PREFIX OUTPUT_FOLDER [CMAKE_OPTION...]
set -euo pipefail
source=$1 prefix=$2 output=$3
shift 3
rm -rf "$output" && mkdir -p "$output"
awk '/^```cmake$/ {on = 1; next} /^```$/ {on = 0} on' "$source/toolchains/engines.md" >"$output/CMakeLists.txt"
awk '/^```cpp$/ {on = 1; next} /^```$/ && on {exit} on' "$source/README.md" >"$output/first.cpp"
cmake -S "$output" -B "$output/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" "$@" >/dev/null
cmake --build "$output/build" >/dev/null
"$output/build/first" | grep -E '^[1-9][0-9]* particles under [1-9]'
cmake -S "$output" -B "$output/sources" -DFETCHCONTENT_SOURCE_DIR_SANDGLASS="$source" -DFETCHCONTENT_TRY_FIND_PACKAGE_MODE=NEVER "$@" >/dev/null
