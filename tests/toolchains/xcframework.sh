#!/usr/bin/env bash
# Makes the Swift package from the four archives that the tests toolchains.ios to toolchains.visionos-simulator built, and
# checks its layout. The control: an archive for the simulator is not taken for the device's.
#   xcframework.sh FOLDER_OF_THE_BUILDS INCLUDE_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cmake -S "$here/../.." -B "$1/ios/build" -DSANDGLASS_ARCHIVE="$1/PRESET/build/runtime/libsandglass.a" >/dev/null
cmake --build "$1/ios/build" --target xcframework -- --quiet
python3 "$here/package_layout.py" xcframework "$1/ios/build/swift" "$2"
if refused=$(python3 "$here/../../toolchains/ios/xcframework.py" "$1/ios-simulator/build/runtime/libsandglass.a" "$2" "$1/refused" 2>&1) ||
  [[ $refused != *"is not for ios on arm64"* ]]; then echo "a simulator's archive was taken for a device's: $refused"; exit 1; fi
