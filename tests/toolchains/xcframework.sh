#!/usr/bin/env bash
# Makes the XCFramework from the two archives that toolchains.ios and toolchains.ios-simulator built, and checks its
# layout.
#   xcframework.sh FOLDER_OF_THE_BUILDS INCLUDE_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cmake -S "$here/../.." -B "$1/ios/build" -DSANDGLASS_SIMULATOR_ARCHIVE="$1/ios-simulator/build/runtime/libsandglass.a" >/dev/null
cmake --build "$1/ios/build" --target xcframework -- --quiet
python3 "$here/package_layout.py" xcframework "$1/ios/build/Sandglass.xcframework" "$2"
