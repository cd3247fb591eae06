#!/usr/bin/env bash
# build_type.sh PROJECT APP FOLDER CMAKE_OPTIONS...: configured without a build type, the library is compiled as Release. Inside an app,
# which chooses for itself, CMake warns and leaves the choice alone.
set -euo pipefail
project=$1 app=$2 folder=$3
shift 3
rm -rf "$folder"
unset CMAKE_BUILD_TYPE
type_of() { sed -n 's/^CMAKE_BUILD_TYPE:[A-Z]*=//p' "$1/CMakeCache.txt"; }

cmake -G Ninja -S "$project" -B "$folder/alone" -DSANDGLASS_DEVELOPER=OFF "$@" >"$folder.log" 2>&1
[[ $(type_of "$folder/alone") == Release ]] || { echo "alone, the build type is '$(type_of "$folder/alone")'"; exit 1; }

cmake -G Ninja -S "$app" -B "$folder/app" -DSANDGLASS_SOURCE_DIR="$project" "$@" >"$folder.log" 2>&1
grep -q 'Sandglass is compiled without optimisation' "$folder.log" || { echo "inside an app, there is no warning"; exit 1; }
[[ -z $(type_of "$folder/app") ]] || { echo "the app's build type was changed"; exit 1; }

cmake -G Ninja -S "$app" -B "$folder/app" -DSANDGLASS_SOURCE_DIR="$project" -DCMAKE_BUILD_TYPE=Debug "$@" >"$folder.log" 2>&1
! grep -q 'without optimisation' "$folder.log" || { echo "the warning comes although there is a build type"; exit 1; }
